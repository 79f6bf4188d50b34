//! The outline by a front: it starts where the smoothed signal-to-noise crosses the threshold, moves
//! outwards where there is more signal than that and inwards where there is less, and bends as
//! little as it can: `u_t = F |grad u| + nu kappa |grad u|`, with the force F the signal-to-noise
//! above the threshold (a region force) and kappa the curvature of u's level sets.
//!
//! The upwind differences are those of Osher and Sethian (1988, doi:10.1016/0021-9991(88)90002-2).
//! Values of u are kept within [`BAND`], so that all but the surroundings of the front is flat:
//! there nothing can move, and nothing is computed.

use crate::arithmetic::machine::Task;
use crate::arithmetic::{Level, Real};
use crate::config::Outline;
use crate::plane::crew::Crew;
use crate::plane::grid::Grid;
use crate::plane::rows::{row_of, row_of_mut, rows_of, rows_of_mut};
use crate::plane::walk::Walk;
use core::num::NonZero;
use core::ops::Range;

/// u is kept between minus and plus this.
pub const BAND: f32 = 0.3;
/// The force is kept between minus and plus this.
pub const FORCE: f32 = 2.0;
/// Time of a step, with pixels of width 1. The force moves the front by at most 0.4 px a step, and
/// `4 STEP nu < 1` for every nu that [`crate::config::Outline`] takes.
pub const STEP: f32 = 0.2;
/// Cells of a row that are looked at together for something that can move.
const PIECE: usize = 16;
/// A gradient below this has no direction.
const FLAT: f32 = 1e-3;

/// Old rows of a band that are kept: its first and last, which its neighbours see, and three around the row at work.
pub const ROWS: usize = BORDERS + RING;
const BORDERS: usize = 2;
const RING: usize = 3;

/// How a front moves.
#[derive(Clone, Copy, Debug)]
pub struct Front<L: Level> {
    /// The threshold, in noise units.
    pub threshold: L,
    /// Weight of the curvature, nu.
    pub curvature: L::Weight,
    /// Steps of [`STEP`].
    pub steps: u32,
}

/// Where a front stands: three rows of the old u around a place.
#[derive(Clone, Copy)]
struct Around<'a, L>([&'a [L]; 3]);

impl<L: Level> Front<L> {
    /// As a configuration has it.
    pub fn new(outline: Outline) -> Self {
        let Outline { threshold, curvature, steps } = outline;
        Front { threshold: L::of(threshold), curvature: L::Weight::of(curvature), steps }
    }

    /// Fills `plane` with the bits of u, above 0 inside: the front starts where `start`, smoothed signal-to-noise, is at
    /// the threshold, and takes its steps. `signal` has the force, less smoothed; `rows` has room for
    /// [`ROWS`], and for as many of each band where more than one works. Cost: a pass per step, which
    /// computes near the front only.
    pub fn outline(&self, [signal, start]: [&[L]; 2], plane: &mut [u32], rows: &mut [L], grid: Grid, crew: &impl Crew) {
        let _ = self.outline_in((&mut Walk::whole(), crew), (signal, Some(start)), plane, rows, grid);
    }

    /// The same in parts; without a `start` from u before the first step, which `plane` has already.
    pub(crate) fn outline_in(
        &self,
        (walk, crew): (&mut Walk, &impl Crew),
        (signal, start): (&[L], Option<&[L]>),
        plane: &mut [u32],
        rows: &mut [L],
        grid: Grid,
    ) -> Option<()> {
        let width = grid.width.get();
        if let Some(start) = start {
            walk.pass(grid.height, width, |part| {
                self.start(rows_of(start, &part, width), rows_of_mut(plane, &part, width));
            })?;
        }
        for _ in 0..self.steps {
            walk.pass(grid.height, width, |part| self.step_rows(part, signal, plane, rows, grid, crew))?;
        }
        Some(())
    }

    /// u before the first step.
    pub fn start(&self, start: &[L], plane: &mut [u32]) {
        plane.iter_mut().zip(start).for_each(|(u, &start)| *u = self.at(start).bits());
    }

    /// u before the first step where smoothed signal-to-noise is `start`.
    #[inline(always)]
    pub fn at(&self, start: L) -> L {
        within(start - self.threshold, BAND)
    }

    /// One step of [`Front::outline`].
    pub fn step(&self, signal: &[L], plane: &mut [u32], rows: &mut [L], grid: Grid, crew: &impl Crew) {
        self.step_rows(0..grid.height, signal, plane, rows, grid, crew);
    }

    /// The same for all rows, or for some that go on where others ended.
    pub(crate) fn step_rows(
        &self,
        part: Range<usize>,
        signal: &[L],
        plane: &mut [u32],
        rows: &mut [L],
        grid: Grid,
        crew: &impl Crew,
    ) {
        let width = grid.width.get();
        let most = if part.len() < grid.height { 1 } else { (rows.len() / grid.width / ROWS).max(1) };
        let band = (crew.rows(grid).max(grid.height.div_ceil(most)) * width).max(1);
        let bands = plane.len().div_ceil(band);
        // The first and the last row of every band, for its neighbours, who see the old ones.
        let Some((borders, rings)) = rows.split_at_mut_checked(BORDERS * width * bands) else { return };
        for (borders, band) in borders.chunks_exact_mut((BORDERS * width).max(1)).zip(plane.chunks(band)) {
            let ends = band.get(..width).into_iter().chain(band.get(band.len().saturating_sub(width)..)).flatten();
            borders.iter_mut().zip(ends).for_each(|(border, &u)| *border = L::from_bits(u));
        }
        let borders = &*borders;
        let border = |row: Option<usize>| row.map_or(&[][..], |row| row_of(borders, width, row));
        let rings = rings.chunks_exact_mut((RING * width).max(1));
        let bands = plane.chunks_mut(band).zip(signal.chunks(band)).zip(rings).enumerate();
        crew.each(bands, |(index, ((plane, signal), ring))| {
            let beside = [border((2 * index).checked_sub(1)), border(Some(2 * index + 2))];
            self.band(part.clone(), signal, plane, ring, beside, (grid.width, crew));
        });
    }

    /// A step of a band, or of a part of the rows that are one, between the old rows beside it; beyond the frame these
    /// are empty.
    fn band(
        &self,
        part: Range<usize>,
        signal: &[L],
        plane: &mut [u32],
        ring: &mut [L],
        [before, after]: [&[L]; 2],
        (columns, crew): (NonZero<usize>, &impl Crew),
    ) {
        let width = columns.get();
        let (mut rows, last) = (ring.chunks_exact_mut(width), (plane.len() / columns).saturating_sub(1));
        let (Some(mut below), Some(mut own), Some(mut above)) = (rows.next(), rows.next(), rows.next()) else { return };
        if part.start == 0 {
            read(plane.get(..width).unwrap_or(&[]), own);
            // Beyond the frame u is what it is at its border.
            copy(if before.is_empty() { own } else { before }, below);
        }
        for _ in 0..part.start % RING {
            (below, own, above) = (own, above, below);
        }
        for (y, signal) in signal.chunks_exact(width).enumerate().take(part.end).skip(part.start) {
            match (y == last, after.is_empty()) {
                (false, _) => read(row_of(plane, width, y + 1), above),
                (true, false) => copy(after, above),
                (true, true) => copy(own, above),
            }
            let old = Around([below, own, above]);
            crew.wide(Row { front: self, old, signal, out: row_of_mut(plane, width, y) });
            (below, own, above) = (own, above, below);
        }
    }

    /// `F |grad u| + nu kappa |grad u|` from the nine values around a pixel.
    #[inline(always)]
    fn change(&self, [below, own, above]: [[L; 3]; 3], force: L) -> L {
        let ([_, down, _], [left, middle, right], [_, up, _]) = (below, own, above);
        // Information comes from inside where the front moves outwards, and from outside else.
        let outwards = force > L::ZERO;
        let steep = |before: L, after: L| {
            let rise = (before - middle).greatest(after - middle);
            let fall = (middle - before).greatest(middle - after);
            (if outwards { rise } else { fall }).positive()
        };
        force * length(steep(left, right), steep(down, up)) + bend(below, own, above).scaled(self.curvature)
    }
}

/// A row that moves, between old ones.
struct Row<'a, L: Level> {
    front: &'a Front<L>,
    old: Around<'a, L>,
    signal: &'a [L],
    out: &'a mut [u32],
}

impl<L: Level> Task for Row<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Row { front, old, signal, out } = self;
        let pieces = (0..).step_by(PIECE).zip(out.chunks_mut(PIECE).zip(signal.chunks(PIECE)));
        let mut beyond = [[L::ZERO; WINDOW]; 3];
        for (first, (out, signal)) in pieces {
            let near = old.window(first, &mut beyond);
            if is_flat(near) {
                continue;
            }
            let mut values = [L::ZERO; PIECE];
            make(&mut values, signal, |value| value);
            let mut moved = [L::ZERO; PIECE];
            // Spelled out: the compiler leaves a map over arrays a loop of calls.
            let [below, own, above] = near;
            for x in 0..PIECE {
                let (Some(moved), Some(&signal)) = (moved.get_mut(x), values.get(x)) else { break };
                let force = within(signal - front.threshold, FORCE);
                let (below, own, above) = (three(below, x), three(own, x), three(above, x));
                let [_, middle, _] = own;
                let change = front.change([below, own, above], force);
                *moved = within(middle + change.scaled(L::Weight::of(STEP)), BAND);
            }
            make(out, &moved, L::bits);
        }
    }
}

/// Makes each element from its like; of whole pieces the compiler knows how many there are.
#[inline(always)]
fn make<T, F: Copy>(to: &mut [T], from: &[F], one: impl Fn(F) -> T) {
    if let (Some(to), Some(from)) = (to.first_chunk_mut::<PIECE>(), from.first_chunk::<PIECE>()) {
        to.iter_mut().zip(from).for_each(|(to, &from)| *to = one(from));
    } else {
        to.iter_mut().zip(from).for_each(|(to, &from)| *to = one(from));
    }
}

/// Reads a row of u from its bits.
fn read<L: Level>(bits: &[u32], row: &mut [L]) {
    row.iter_mut().zip(bits).for_each(|(u, &bits)| *u = L::from_bits(bits));
}

fn copy<L: Level>(from: &[L], to: &mut [L]) {
    to.iter_mut().zip(from).for_each(|(to, &u)| *to = u);
}

/// The length of a vector with parts that are not below 0, to 0.1 %: the greater times a parabola
/// of their squared ratio, in place of a root.
#[inline(always)]
fn length<L: Level>(x: L, y: L) -> L {
    let (greater, smaller) = (x.greatest(y), x.least(y));
    let ratio = smaller.ratio(greater);
    let square = ratio * ratio;
    greater + greater * (square.scaled(L::Weight::of(0.488)) - (square * square).scaled(L::Weight::of(0.0749)))
}

/// `kappa |grad u|`: the second derivative along the level set, by central differences; where there
/// is no direction, the mean of the neighbours less u, as in the paper's degenerate branch. The
/// gradient is divided by its greater part first, so that fixed point keeps its digits.
#[inline(always)]
fn bend<L: Level>(below: [L; 3], own: [L; 3], above: [L; 3]) -> L {
    let ([below_left, down, below_right], [left, middle, right], [above_left, up, above_right]) = (below, own, above);
    let (along, across) = (right - left, up - down);
    let greater = along.magnitude().greatest(across.magnitude());
    let twice = middle + middle;
    let (bend_x, bend_y) = (left + right - twice, down + up - twice);
    let twist = (above_right + below_left - above_left - below_right).scaled(L::Weight::of(0.5));
    let (x, y) = (along.ratio(greater), across.ratio(greater));
    let directed = (bend_x * (y * y) - twist * (x * y) + bend_y * (x * x)).ratio(x * x + y * y);
    let flat = greater < L::of(FLAT);
    if flat { (bend_x + bend_y).scaled(L::Weight::of(0.25)) } else { directed }
}

/// A value kept between minus and plus `most`.
#[inline(always)]
fn within<L: Level>(value: L, most: f32) -> L {
    let most = L::of(most);
    value.least(most).greatest(-most)
}

/// A piece with a column on either side.
const WINDOW: usize = PIECE + 2;

/// Whether a piece of the middle row and all around it has one value: then nothing moves there.
#[inline(always)]
fn is_flat<L: Level>(near: [&[L; WINDOW]; 3]) -> bool {
    let [below, own, above] = near;
    let [_, value, ..] = own;
    is_one(own, value) && is_one(below, value) && is_one(above, value)
}

#[inline(always)]
fn is_one<L: Level>(row: &[L; WINDOW], value: &L) -> bool {
    row.iter().fold(true, |one, u| one & (u == value))
}

/// The values at a column of a window and at the next two.
#[inline(always)]
fn three<L: Level>(row: &[L; WINDOW], x: usize) -> [L; 3] {
    let at = |x: usize| row.get(x).copied().unwrap_or(L::ZERO);
    [at(x), at(x + 1), at(x + 2)]
}

impl<L: Level> Around<'_, L> {
    /// The rows around a piece; what is `beyond` a row has the value of its end.
    #[inline(always)]
    fn window<'w>(&'w self, first: usize, beyond: &'w mut [[L; WINDOW]; 3]) -> [&'w [L; WINDOW]; 3] {
        let ([below, own, above], [under, beside, over]) = (self.0, beyond);
        [window(below, first, under), window(own, first, beside), window(above, first, over)]
    }
}

#[inline(always)]
fn window<'w, L: Level>(row: &'w [L], first: usize, beyond: &'w mut [L; WINDOW]) -> &'w [L; WINDOW] {
    if let Some(inner) = first.checked_sub(1).and_then(|start| row.get(start..)?.first_chunk()) {
        return inner;
    }
    let last = row.len().saturating_sub(1);
    for (index, value) in beyond.iter_mut().enumerate() {
        let x = first.saturating_add(index).saturating_sub(1).min(last);
        *value = row.get(x).copied().unwrap_or(L::ZERO);
    }
    beyond
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::arithmetic::Fixed14;
    use crate::plane::crew::Alone;
    use core::num::NonZero;
    use std::vec;
    use std::vec::Vec;

    const SIDE: usize = 48;

    fn grid() -> Grid {
        Grid { width: NonZero::new(SIDE).expect("not 0"), height: SIDE }
    }

    fn front<L: Level>(curvature: f32, steps: u32) -> Front<L> {
        Front { threshold: L::ONE, curvature: L::Weight::of(curvature), steps }
    }

    fn plane<L: Level>(value: impl Fn(f32, f32) -> f32) -> Vec<L> {
        (0..SIDE * SIDE).map(|at| L::of(value((at % SIDE) as f32, (at / SIDE) as f32))).collect()
    }

    fn moved<L: Level>(front: &Front<L>, signal: &[L], start: Vec<L>) -> Vec<L> {
        let mut plane = vec![0; start.len()];
        front.outline([signal, &start], &mut plane, &mut [L::ZERO; ROWS * SIDE], grid(), &Alone);
        plane.into_iter().map(L::from_bits).collect()
    }

    fn area<L: Level>(u: &[L]) -> usize {
        u.iter().filter(|&&u| u > L::ZERO).count()
    }

    /// Distance inside the border of a disc in the middle.
    fn disc(radius: f32) -> impl Fn(f32, f32) -> f32 {
        let middle = 0.5 * (SIDE - 1) as f32;
        move |x, y| 1.0 + radius - libm::hypotf(x - middle, y - middle)
    }

    #[test]
    fn lengths_are_right_to_a_thousandth() {
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 2.0), (1.0, 1.0), (0.3, 0.4), (0.9, 1.0), (0.01, 0.07), (5.0, 2.0)]
        {
            let expected = libm::hypotf(x, y);
            assert!((length(x, y) - expected).abs() <= 1e-3 * expected, "{x} {y}");
        }
    }

    /// D = (0.3, 0.4), u_xx = 0.2, u_yy = -0.2, u_xy = 0.1.
    #[test]
    fn a_value_changes_by_its_force_and_by_its_curvature() {
        let around = [[0.1, -0.5, 0.3], [-0.2, 0.0, 0.4], [0.2, 0.3, 0.8]];
        // 0.2 * 0.64 - 2 * 0.48 * 0.1 - 0.2 * 0.36; outwards it rises by 0.4 and 0.3, and inwards it falls by 0.2 and 0.5.
        for (force, expected) in [(0.5, 0.25 - 0.25 * 0.04), (-0.5, -0.5 * 0.538_516_5 - 0.25 * 0.04)] {
            let found = front::<f32>(0.25, 1).change(around, force);
            assert!((found - expected).abs() < 1e-3 * expected.abs(), "{found}, not {expected}");
        }
        // Without a direction by the mean of the neighbours less itself.
        let top = front::<f32>(0.25, 1).change([[9.0, 0.8, 9.0], [0.9, 1.0, 0.9], [9.0, 0.8, 9.0]], 0.0);
        assert!((top + 0.25 * 0.15).abs() < 1e-6, "{top}");
    }

    #[test]
    fn without_steps_the_outline_is_the_threshold() {
        let start = plane::<f32>(disc(10.0));
        let u = moved(&front(0.3, 0), &start, start.clone());
        assert!(start.iter().zip(&u).all(|(&start, &u)| (start > 1.0) == (u > 0.0) && u.abs() <= BAND));
    }

    fn a_force_moves_the_front_by_itself_times_the_time<L: Level>() {
        for (force, radius) in [(0.5, 13.0), (-0.5, 7.0), (9.0, 22.0)] {
            let signal = vec![L::of(1.0 + force); SIDE * SIDE];
            let u = moved(&front(0.0, 30), &signal, plane(disc(10.0)));
            let found = libm::sqrtf(area(&u) as f32 / core::f32::consts::PI);
            assert!((found - radius).abs() < 0.6, "{}: force {force}: {found}, not {radius}", L::NAME);
        }
    }

    #[test]
    fn forces_move_fronts() {
        a_force_moves_the_front_by_itself_times_the_time::<f32>();
        a_force_moves_the_front_by_itself_times_the_time::<Fixed14>();
    }

    /// Of `r' = -nu/r` the radius after t is `sqrt(r^2 - 2 nu t)`.
    #[test]
    fn curvature_shrinks_a_disc_as_it_should() {
        let signal = vec![1.0; SIDE * SIDE];
        let u = moved(&front::<f32>(1.0, 100), &signal, plane(disc(10.0)));
        let found = libm::sqrtf(area(&u) as f32 / core::f32::consts::PI);
        let expected = libm::sqrtf(100.0 - 2.0 * 100.0 * STEP);
        assert!((found - expected).abs() < 0.4, "{found}, not {expected}");
    }

    #[test]
    fn curvature_takes_single_pixels_and_straightens_borders() {
        let comb = |x: f32, y: f32| if x < 20.0 || x < 21.0 && (y as u32).is_multiple_of(3) { 1.4 } else { 0.6 };
        let speck = |x: f32, y: f32| if x == 40.0 && y == 40.0 { 1.4 } else { comb(x, y) };
        let signal = vec![1.0; SIDE * SIDE];
        let u = moved(&front::<f32>(0.6, 20), &signal, plane(speck));
        let inside = |x: usize, y: usize| u[y * SIDE + x] > 0.0;
        assert!(!inside(40, 40), "the speck is gone");
        assert!((2..SIDE - 2).all(|y| inside(19, y) && !inside(20, y)), "the teeth are gone");
    }

    #[test]
    fn fixed_point_follows_single_precision() {
        let sky = |x: f32, y: f32| 1.0 + 0.8 * libm::sinf(0.61 * x) * libm::cosf(0.37 * y + 0.2 * x);
        let single = moved(&front::<f32>(0.3, 10), &plane(sky), plane(sky));
        let fixed = moved(&front::<Fixed14>(0.3, 10), &plane(sky), plane(sky));
        let apart = single.iter().zip(&fixed).filter(|(u, v)| (**u > 0.0) != (v.to_f32() > 0.0)).count();
        assert!(apart <= 2, "{apart} pixels differ");
    }

    /// What is flat is skipped, and that changes no bit: a frame whose pieces are all looked at gives the same.
    #[test]
    fn skipping_changes_no_bit() {
        let start = plane::<f32>(disc(6.0));
        let signal = plane::<f32>(|x, y| 1.0 + 0.1 * x - 0.07 * y);
        let moving = front(0.3, 12);
        let skipped = moved(&moving, &signal, start.clone());
        let mut u: Vec<f32> = start.iter().map(|&value| within(value - 1.0, BAND)).collect();
        for _ in 0..moving.steps {
            let old = u.clone();
            let row = |y: usize| &old[y * SIDE..(y + 1) * SIDE];
            for (at, u) in u.iter_mut().enumerate() {
                let (x, y) = (at % SIDE, at / SIDE);
                let rows = [row(y.saturating_sub(1)), row(y), row((y + 1).min(SIDE - 1))];
                let nine = rows.map(|row| [row[x.saturating_sub(1)], row[x], row[(x + 1).min(SIDE - 1)]]);
                let force = within(signal[at] - 1.0, FORCE);
                *u = within(*u + moving.change(nine, force) * STEP, BAND);
            }
        }
        assert!(skipped.iter().zip(&u).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
}
