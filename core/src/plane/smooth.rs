//! Smoothing of a whole plane by a separable kernel, mirrored at the borders.

use crate::arithmetic::machine::Task;
use crate::arithmetic::{Level, Real};
use crate::plane::crew::Crew;
use crate::plane::grid::Grid;
use crate::plane::mask::{MaskMut, WORD, bits_of};
use crate::plane::rows::{row_of, row_of_mut};
use core::ops::Range;

/// The most weights of a kernel on one side of its centre.
pub const RADIUS: usize = 12;
/// Rows that smoothing needs for a band: those around a row, as many behind it, and one of what comes out.
pub const ROOM_ROWS: usize = 3 * RADIUS + 2;

/// A symmetric kernel: the weight of the centre, then outwards; sums to 1 over both sides.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    weights: [f32; RADIUS + 1],
    radius: usize,
}

impl Weights {
    /// The cubic spline of the a trous transform (Starck and Murtagh 2006, Astronomical Image and
    /// Data Analysis): 1, 4, 6, 4, 1 over 16.
    pub const SPLINE: Weights = Weights {
        weights: [6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        radius: 2,
    };

    /// A Gaussian of standard deviation `scale` in pixels, at most 3.4, cut at 3.5 of them.
    pub fn gauss(scale: f32) -> Weights {
        let radius = (libm::ceilf(3.5 * scale) as usize).clamp(1, RADIUS);
        let mut weights = [0.0; RADIUS + 1];
        let mut total = 0.0;
        for (index, weight) in weights.iter_mut().enumerate().take(radius + 1) {
            let distance = index as f32 / scale;
            *weight = libm::expf(-0.5 * distance * distance);
            total += if index == 0 { *weight } else { 2.0 * *weight };
        }
        weights.iter_mut().for_each(|weight| *weight /= total);
        Weights { weights, radius }
    }

    /// Smooths `from` into `to`, both W x H, row by row: `room` has [`ROOM_ROWS`] for one band at least, and for
    /// each of several. Each sum
    /// begins with the centre and goes outwards. Cost: `4 radius` additions per pixel.
    pub fn apply<L: Level>(&self, from: &[L], room: &mut [L], to: &mut [L], grid: Grid, crew: &impl Crew) {
        self.apply_rows(0..grid.height, from, room, to, grid, crew);
    }

    /// The same for all rows, or for some that go on where others ended.
    pub(crate) fn apply_rows<L: Level>(
        &self,
        part: Range<usize>,
        from: &[L],
        room: &mut [L],
        to: &mut [L],
        grid: Grid,
        crew: &impl Crew,
    ) {
        self.each_row(part, (from, to), room, (grid, crew), |ring, y, out| ring.add(y, out, None, crew));
    }

    /// Sharpens `from` into `to` as [`Weights::sharpen`] does in one plane: all rows, or some that go on where others
    /// ended.
    pub(crate) fn sharpen_into<L: Level>(
        &self,
        part: Range<usize>,
        from: &[L],
        room: &mut [L],
        (to, strength): (&mut [L], f32),
        grid: Grid,
        crew: &impl Crew,
    ) {
        let gain = L::Weight::of(1.0 + strength);
        self.each_row(part, (from, to), room, (grid, crew), |ring, y, out| {
            let own = row_of(from, grid.width.get(), y);
            out.iter_mut().zip(own).for_each(|(out, value)| *out = value.scaled(gain));
            ring.add(y, out, Some(-strength), crew);
        });
    }

    /// Makes rows of `to` from those around them in `from`.
    fn each_row<L: Level>(
        &self,
        part: Range<usize>,
        (from, to): (&[L], &mut [L]),
        room: &mut [L],
        (grid, crew): (Grid, &impl Crew),
        make: impl Fn(&Ring<'_, L>, usize, &mut [L]) + Sync,
    ) {
        let (width, rows) = (grid.width.get(), rows_of_part(&part, rows_of_band(room.len(), grid, crew), grid));
        let bands = (0..).step_by(rows).zip(to.chunks_mut((rows * width).max(1))).zip(room.chunks_mut(kept(grid)));
        crew.each(bands, |((first, to), room)| {
            let (mut ring, start) = (Ring::new(self, room, first + rows, grid), part.start.max(first));
            let mut next = ring.next(first, start);
            let out = to.chunks_exact_mut(width).skip(start - first);
            for (y, out) in (start..part.end).zip(out) {
                ring.follow(y, &mut next, |y| row_of(from, width, y), crew);
                make(&ring, y, out);
            }
        });
    }

    /// Marks the pixels of `from` that are above `level` once smoothed, and no others.
    pub fn mark<L: Level>(&self, from: &[L], level: L, room: &mut [L], to: MaskMut<'_>, grid: Grid, crew: &impl Crew) {
        self.mark_rows(0..grid.height, (from, level), room, to, grid, crew);
    }

    /// The same for all rows, or for some that go on where others ended.
    pub(crate) fn mark_rows<L: Level>(
        &self,
        part: Range<usize>,
        (from, level): (&[L], L),
        room: &mut [L],
        to: MaskMut<'_>,
        grid: Grid,
        crew: &impl Crew,
    ) {
        // A word of the mask is of one band only.
        let rows = rows_of_part(&part, rows_of_band(room.len(), grid, crew), grid).next_multiple_of(WORD).max(WORD);
        let (width, kept) = (grid.width.get(), kept(grid));
        let bands = (0..).step_by(rows).zip(to.0.chunks_mut((rows / WORD * width).max(1))).zip(room.chunks_mut(kept));
        crew.each(bands, |((first, words), room)| {
            let (out, room) = room.split_at_mut_checked(width).unwrap_or_default();
            let (mut ring, start) = (Ring::new(self, room, first + rows, grid), part.start.max(first));
            let mut next = ring.next(first, start);
            for y in start..part.end.min(first + rows) {
                let row = y - first;
                // The words that begin in this row.
                let begun = (row * width).div_ceil(WORD)..((row + 1) * width).div_ceil(WORD);
                words.get_mut(begun).unwrap_or(&mut []).fill(0);
                let mut mask = MaskMut(words);
                ring.follow(y, &mut next, |y| row_of(from, width, y), crew);
                ring.add(y, out, None, crew);
                crew.wide(Above { values: out, level, first: row * width, mask: &mut mask });
            }
        });
    }

    /// Adds to a plane `strength` times what smoothing takes from it: an unsharp mask. For `room` see
    /// [`Weights::apply`].
    pub fn sharpen<L: Level>(&self, plane: &mut [L], room: &mut [L], grid: Grid, strength: f32, crew: &impl Crew) {
        self.sharpen_rows(0..grid.height, plane, room, grid, strength, crew);
    }

    /// The same for all rows, or for some that go on where others ended.
    pub(crate) fn sharpen_rows<L: Level>(
        &self,
        part: Range<usize>,
        plane: &mut [L],
        room: &mut [L],
        grid: Grid,
        strength: f32,
        crew: &impl Crew,
    ) {
        let (width, radius, kept) = (grid.width.get(), self.radius, kept(grid));
        let rows = rows_of_part(&part, rows_of_band(room.len(), grid, crew), grid);
        // What lies beside a band is smoothed before it changes.
        let before = &*plane;
        let firsts = (0..grid.height).step_by(rows);
        crew.each(firsts.zip(room.chunks_mut(kept)), |(first, room)| {
            let (end, mut ring) = (first + rows, Ring::new(self, room, first + rows, grid));
            for y in (first.saturating_sub(radius)..first).chain(end..grid.height.min(end + radius)) {
                ring.smooth(y, row_of(before, width, y), crew);
            }
        });
        let bands = (0..).step_by(rows).zip(plane.chunks_mut((rows * width).max(1))).zip(room.chunks_mut(kept));
        let gain = L::Weight::of(1.0 + strength);
        crew.each(bands, |((first, plane), room)| {
            let (mut ring, start) = (Ring::new(self, room, first + rows, grid), part.start.max(first));
            let mut next = if start == first { first } else { ring.next(first, start) };
            for y in start..part.end.min(first + plane.len() / grid.width) {
                ring.follow(y, &mut next, |y| row_of(plane, width, y - first), crew);
                let out = row_of_mut(plane, width, y - first);
                out.iter_mut().for_each(|value| *value = value.scaled(gain));
                ring.add(y, out, Some(-strength), crew);
            }
        });
    }

    /// The weights beside the centre with their distances.
    #[inline(always)]
    fn sides(&self) -> impl Iterator<Item = (usize, f32)> {
        self.weights.into_iter().enumerate().take(self.radius + 1).skip(1)
    }

    /// Adds what lies at each distance on both sides, two distances in a pass.
    #[inline(always)]
    fn add_taps<'r, L: Level>(&self, out: &mut [L], tap: impl Fn((usize, f32)) -> Tap<'r, L>) {
        let mut sides = self.sides();
        while let Some(near) = sides.next() {
            match sides.next() {
                Some(far) => add_both(out, tap(near), tap(far)),
                None => add(out, tap(near)),
            }
        }
    }
}

/// Rows around the one at work, smoothed along themselves: those of the band in a ring, those behind it apart, for they
/// are known before the band is.
struct Ring<'a, L> {
    weights: &'a Weights,
    rows: &'a mut [L],
    end: usize,
    grid: Grid,
}

impl<'a, L: Level> Ring<'a, L> {
    /// For a band that ends before row `end`.
    fn new(weights: &'a Weights, rows: &'a mut [L], end: usize, grid: Grid) -> Self {
        Ring { weights, rows, end, grid }
    }

    /// The first row that is still to be smoothed when `start` is the next of a band from `first` on.
    fn next(&self, first: usize, start: usize) -> usize {
        let radius = self.weights.radius;
        if start == first { first.saturating_sub(radius) } else { self.grid.height.min(start + radius) }
    }

    /// Where a row lies.
    fn place(&self, y: usize) -> usize {
        let length = (2 * self.weights.radius + 1).max(1);
        if y < self.end { y % length } else { length + y - self.end }
    }

    /// Smooths row `y` along itself.
    fn smooth(&mut self, y: usize, row: &[L], crew: &impl Crew) {
        let place = self.place(y);
        crew.wide(Along { weights: self.weights, row, out: row_of_mut(self.rows, self.grid.width.get(), place) });
    }

    /// Smooths the rows from `next` on that row `y` needs, of those that the band has.
    fn follow<'r>(&mut self, y: usize, next: &mut usize, row: impl Fn(usize) -> &'r [L], crew: &impl Crew)
    where
        L: 'r,
    {
        while *next < self.grid.height.min(y + self.weights.radius + 1) {
            let source = row(*next);
            if !source.is_empty() {
                self.smooth(*next, source, crew);
            }
            *next += 1;
        }
    }

    /// Adds `gain` times the smoothed columns to row `y`; without a gain these are what it becomes.
    fn add(&self, y: usize, out: &mut [L], gain: Option<f32>, crew: &impl Crew) {
        crew.wide(Across { ring: self, y, out, gain });
    }
}

/// Values of which those above a level are marked, from the first pixel on.
struct Above<'a, 'm, L> {
    values: &'a [L],
    level: L,
    first: usize,
    mask: &'a mut MaskMut<'m>,
}

impl<L: Level> Task for Above<'_, '_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Above { values, level, first, mask } = self;
        for (first, values) in (first..).step_by(WORD).zip(values.chunks(WORD)) {
            mask.set_all(first, bits_of(values, level));
        }
    }
}

/// A row that is smoothed along itself.
struct Along<'a, L> {
    weights: &'a Weights,
    row: &'a [L],
    out: &'a mut [L],
}

impl<L: Level> Task for Along<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Along { weights, row, out } = self;
        let ([centre, ..], radius, width) = (weights.weights, weights.radius, row.len());
        let centre = L::Weight::of(centre);
        out.iter_mut().zip(row).for_each(|(out, value)| *out = value.scaled(centre));
        // Within the row by slices, at its ends by the mirror.
        let inner = width.saturating_sub(2 * radius);
        let end = if inner > 0 { radius } else { width };
        let tap = |(distance, weight): (usize, f32)| {
            let from = |first: usize| row.get(first..first + inner).unwrap_or(&[]);
            (from(end.saturating_sub(distance)), from(end + distance), L::Weight::of(weight))
        };
        weights.add_taps(out.get_mut(end..end + inner).unwrap_or(&mut []), tap);
        for x in (0..end).chain(end + inner..width) {
            let Some(out) = out.get_mut(x) else { break };
            for (distance, weight) in weights.sides() {
                let [below, above] = mirrored(x, distance, width);
                let at = |x: usize| row.get(x).copied().unwrap_or(L::ZERO);
                *out = *out + (at(below) + at(above)).scaled(L::Weight::of(weight));
            }
        }
    }
}

/// A row to which `gain` times the smoothed columns are added, or which becomes these.
struct Across<'a, 'r, L> {
    ring: &'a Ring<'r, L>,
    y: usize,
    out: &'a mut [L],
    gain: Option<f32>,
}

impl<L: Level> Task for Across<'_, '_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Across { ring, y, out, gain } = self;
        let [centre, ..] = ring.weights.weights;
        let row = |y: usize| row_of(ring.rows, ring.grid.width.get(), ring.place(y));
        let (is_new, gain) = (gain.is_none(), gain.unwrap_or(1.0));
        let centre = L::Weight::of(gain * centre);
        let before = |out: L| if is_new { L::ZERO } else { out };
        out.iter_mut().zip(row(y)).for_each(|(out, value)| *out = before(*out) + value.scaled(centre));
        let tap = |(distance, weight): (usize, f32)| {
            let [below, above] = mirrored(y, distance, ring.grid.height);
            (row(below), row(above), L::Weight::of(gain * weight))
        };
        ring.weights.add_taps(out, tap);
    }
}

/// Cells of the room for a band.
fn kept(grid: Grid) -> usize {
    grid.width.get().saturating_mul(ROOM_ROWS).max(1)
}

/// Rows of a band: no more bands than there is room for.
fn rows_of_band(room: usize, grid: Grid, crew: &impl Crew) -> usize {
    let bands = (room / kept(grid)).max(1);
    crew.rows(grid).max(grid.height.div_ceil(bands)).max(1)
}

/// Rows of a band, all there are where only some are to be done.
fn rows_of_part(part: &Range<usize>, of_band: usize, grid: Grid) -> usize {
    if part.len() < grid.height { grid.height.max(1) } else { of_band }
}

/// What lies at a distance on both sides, and its weight.
type Tap<'r, L> = (&'r [L], &'r [L], <L as Level>::Weight);

#[inline(always)]
fn add<L: Level>(out: &mut [L], (left, right, weight): Tap<'_, L>) {
    for ((out, left), right) in out.iter_mut().zip(left).zip(right) {
        *out = *out + (*left + *right).scaled(weight);
    }
}

/// Two taps, one after the other, in one pass.
#[inline(always)]
fn add_both<L: Level>(out: &mut [L], near: Tap<'_, L>, far: Tap<'_, L>) {
    for ((((out, below), above), under), over) in out.iter_mut().zip(near.0).zip(near.1).zip(far.0).zip(far.1) {
        *out = *out + (*below + *above).scaled(near.2) + (*under + *over).scaled(far.2);
    }
}

/// The two places at a distance from `at`, mirrored at the ends of the axis.
fn mirrored(at: usize, distance: usize, length: usize) -> [usize; 2] {
    let below = if at >= distance { at - distance } else { distance - at - 1 };
    let above = if at + distance < length { at + distance } else { (2 * length).saturating_sub(1 + at + distance) };
    [below.min(length.saturating_sub(1)), above]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::crew::Alone;
    use crate::plane::mask::{Mask, mask_words};

    extern crate std;
    use std::vec;
    use std::vec::Vec;

    /// As many bands as three hands have, one after another.
    struct Three;

    impl Crew for Three {
        fn hands(&self) -> usize {
            3
        }

        fn each<T: Send>(&self, items: impl Iterator<Item = T> + Send, work: impl Fn(T) + Sync) {
            items.for_each(work);
        }
    }

    const WIDTH: usize = 37;

    fn plane(height: usize) -> Vec<f32> {
        (0..WIDTH * height).map(|at| (at * at % 1013) as f32 / 64.0).collect()
    }

    /// The plane smoothed, sharpened, and marked above 7, in a room for so many bands.
    fn made(weights: &Weights, height: usize, bands: usize, crew: &impl Crew) -> (Vec<f32>, Vec<f32>, Vec<bool>) {
        let grid = Grid::of(WIDTH * height, WIDTH).expect("there are columns");
        let (from, mut room) = (plane(height), vec![9.0; bands * ROOM_ROWS * WIDTH]);
        let (mut smooth, mut sharp, mut words) = (vec![9.0; from.len()], from.clone(), vec![9; mask_words(from.len())]);
        weights.apply(&from, &mut room, &mut smooth, grid, crew);
        weights.sharpen(&mut sharp, &mut room, grid, 0.5, crew);
        let mut elsewhere = vec![9.0; from.len()];
        weights.sharpen_into(0..height, &from, &mut room, (&mut elsewhere, 0.5), grid, crew);
        assert!(elsewhere == sharp, "in another plane it is the same");
        weights.mark(&from, 7.0, &mut room, MaskMut(&mut words), grid, crew);
        (smooth, sharp, (0..from.len()).map(|at| Mask(&words).has(at)).collect())
    }

    #[test]
    fn bands_change_no_bit() {
        for weights in [Weights::SPLINE, Weights::gauss(0.8), Weights::gauss(3.4)] {
            for height in [1, 2, 5, 33, 100, 300] {
                let one = made(&weights, height, 1, &Alone);
                for bands in [1, 2, 5, 12] {
                    assert!(one == made(&weights, height, bands, &Three), "{height} rows, {bands} bands");
                }
                assert!(one.2.iter().zip(&one.0).all(|(&mark, &value)| mark == (value > 7.0)), "{height} rows");
            }
        }
    }

    #[test]
    fn sharpening_takes_away_what_smoothing_leaves() {
        for weights in [Weights::SPLINE, Weights::gauss(1.5), Weights::gauss(3.4)] {
            let (smooth, sharp, _) = made(&weights, 50, 1, &Alone);
            for ((from, smooth), sharp) in plane(50).iter().zip(smooth).zip(sharp) {
                assert!((1.5 * from - 0.5 * smooth - sharp).abs() < 1e-4, "{from} {smooth} {sharp}");
            }
        }
    }
}
