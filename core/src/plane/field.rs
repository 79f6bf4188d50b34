//! A plane that is read between its pixels and across a centre.

use crate::arithmetic::{Level, Real};
use crate::plane::grid::Grid;
use crate::plane::sort;

/// Parts of a pixel to which centres are known.
const PARTS: f32 = 256.0;

/// A distance that is added to a column or row, in whole parts of a pixel: single precision then holds places up to
/// 2^15 columns and their mirror images without rounding, and a source comes out the same wherever it lies in a frame.
pub fn offset<L: Level>(pixels: f32) -> L {
    L::of(libm::roundf(pixels * PARTS) / PARTS)
}

/// The shape of a source's isophotes: ellipses around its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse<L> {
    /// Second moments along x, of x and y, and along y, as parts of the root of their determinant.
    moments: [L; 3],
}

impl<L: Level> Ellipse<L> {
    /// A circle.
    pub const ROUND: Ellipse<L> = Ellipse { moments: [L::ONE, L::ZERO, L::ONE] };

    /// From the differences of second moments `(xx - yy, 2 xy)` as parts of `xx + yy`; `None` where one axis is longer than
    /// ten of the other.
    pub fn of((along, across): (f32, f32)) -> Option<Ellipse<L>> {
        /// What is left of 1 with axes of 1 to 10.
        const THINNEST: f32 = 0.039;
        let left = 1.0 - along * along - across * across;
        (left > THINNEST).then(|| {
            let root = libm::sqrtf(left);
            Ellipse { moments: [(1.0 + along) / root, across / root, (1.0 - along) / root].map(L::of) }
        })
    }

    /// The seven other places on the ellipse through a place, from the centre; as seen in the circle that the ellipse
    /// becomes when it is stretched, 45 degrees apart.
    fn turned(&self, (x, y): (L, L)) -> [(L, L); 7] {
        let [xx, xy, yy] = self.moments;
        let slanted = |value: L| value.scaled(L::Weight::of(core::f32::consts::FRAC_1_SQRT_2));
        // Those at a quarter of a turn, and half way there.
        let (p, q) = (xy * x - xx * y, yy * x - xy * y);
        let ((a, b), (c, d)) = ((slanted(x + p), slanted(y + q)), (slanted(p - x), slanted(q - y)));
        [(a, b), (p, q), (c, d), (-x, -y), (-a, -b), (-p, -q), (-c, -d)]
    }
}

/// Column and row of the first of four pixels, and how far a place is from it towards the others.
type Corner<L> = ((usize, L), (usize, L));

/// A plane that is read at any place.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a, L> {
    /// Values, row-major.
    pub values: &'a [L],
    /// Its shape.
    pub grid: Grid,
}

impl<L: Level> Field<'_, L> {
    /// The value at an index; 0 beyond the plane.
    #[inline]
    pub fn at(&self, index: usize) -> L {
        self.values.get(index).copied().unwrap_or(L::ZERO)
    }

    /// The vertex of the parabolas through a peak and its neighbours.
    pub fn centre(&self, peak: usize) -> (L, L) {
        let (Grid { width, height }, (x, y)) = (self.grid, self.grid.place(peak));
        let half = L::Weight::of(0.5);
        let most = L::ONE.scaled(half);
        let vertex = |before: usize, after: usize| {
            let (before, own, after) = (self.at(before), self.at(peak), self.at(after));
            let bend = own + own - before - after;
            if bend > L::of(1e-6) {
                (after - before).scaled(half).ratio(bend).least(most).greatest(-most)
            } else {
                L::ZERO
            }
        };
        let inner = |at: usize, length: usize| at > 0 && at + 1 < length;
        let dx = if inner(x, width.get()) { vertex(peak.wrapping_sub(1), peak + 1) } else { L::ZERO };
        let (below, above) = (peak.wrapping_sub(width.get()), peak + width.get());
        let dy = if inner(y, height) { vertex(below, above) } else { L::ZERO };
        (L::whole(x) + offset(dx.to_f32()), L::whole(y) + offset(dy.to_f32()))
    }

    /// The value across a centre, bilinear, not below 0: what a symmetric source has at `index`.
    /// `None` where that is beyond the frame.
    pub fn mirrored(&self, centre: (L, L), index: usize) -> Option<L> {
        self.between(self.across(centre, index))
    }

    /// The median of the values as far from a centre as a place, at the seven others in steps of 45
    /// degrees; 0 counts for what is beyond the frame.
    pub fn around(&self, centre: (L, L), place: (L, L)) -> L {
        let off = (place.0 - centre.0, place.1 - centre.1);
        let turned = Ellipse::ROUND.turned(off);
        let mut values = turned.map(|(x, y)| self.between((centre.0 + x, centre.1 + y)).unwrap_or(L::ZERO));
        sort::few(&mut values, |a, b| a.key() < b.key());
        let [_, _, _, median, ..] = values;
        median
    }

    /// Whether the median of the values as far from a centre as a place is such that `is_low`, as in
    /// [`Field::around`]; what is below a value that `is_low` is so too.
    pub fn is_low_around(&self, centre: (L, L), place: (L, L), is_low: impl Fn(L) -> bool) -> bool {
        let value = |place: (L, L)| Some(self.between(place).unwrap_or(L::ZERO));
        let off = (place.0 - centre.0, place.1 - centre.1);
        median_is_low((centre, Ellipse::ROUND.turned(off)), value, is_low).unwrap_or(false)
    }

    /// Whether the median of the values on an ellipse around a centre `is_low`, at the seven places other than the given
    /// one, as far as they are in the frame and the pixel nearest to them `counts`; `None` where none is. What is below
    /// a value that `is_low` is so too.
    pub fn is_low_on_ellipse(
        &self,
        (centre, shape): ((L, L), Ellipse<L>),
        place: (L, L),
        counts: impl Fn(usize) -> bool,
        is_low: impl Fn(L) -> bool,
    ) -> Option<bool> {
        let value = |place: (L, L)| {
            let cell = self.cell(place)?;
            counts(self.nearest_in(cell)).then(|| self.within(cell))
        };
        let off = (place.0 - centre.0, place.1 - centre.1);
        median_is_low((centre, shape.turned(off)), value, is_low)
    }

    /// The place, (x, y), of a pixel.
    pub fn place(&self, index: usize) -> (L, L) {
        let (x, y) = self.grid.place(index);
        (L::whole(x), L::whole(y))
    }

    /// The place on the other side of a centre.
    pub fn across(&self, centre: (L, L), index: usize) -> (L, L) {
        opposite(centre, self.place(index))
    }

    /// The value at a place between pixels, bilinear, not below 0; `None` beyond the frame.
    pub fn between(&self, place: (L, L)) -> Option<L> {
        self.cell(place).map(|cell| self.within(cell))
    }

    /// The index of the pixel nearest to a place; `None` beyond the frame.
    pub fn nearest(&self, place: (L, L)) -> Option<usize> {
        self.cell(place).map(|cell| self.nearest_in(cell))
    }

    fn within(&self, ((left, part_x), (below, part_y)): Corner<L>) -> L {
        let width = self.grid.width.get();
        let first = below * width + left;
        let row = |first: usize| {
            let pair = self.values.get(first..).and_then(<[L]>::first_chunk);
            let &[left, right] = pair.unwrap_or(&[L::ZERO; 2]);
            left * (L::ONE - part_x) + right * part_x
        };
        (row(first) * (L::ONE - part_y) + row(first + width) * part_y).positive()
    }

    #[inline]
    fn nearest_in(&self, ((left, part_x), (below, part_y)): Corner<L>) -> usize {
        let half = L::of(0.5);
        (below + usize::from(part_y > half)) * self.grid.width.get() + left + usize::from(part_x > half)
    }

    /// The first of the four pixels around a place, by column and row, and how far the place is
    /// from it towards the others.
    fn cell(&self, (x, y): (L, L)) -> Option<Corner<L>> {
        let (last_x, last_y) = (self.grid.width.get().checked_sub(2)?, self.grid.height.checked_sub(2)?);
        if x < L::ZERO || y < L::ZERO || x > L::whole(last_x + 1) || y > L::whole(last_y + 1) {
            return None;
        }
        Some((x.split(last_x), y.split(last_y)))
    }
}

/// Whether the median, of an even number the upper one, of the values at seven places around a centre `is_low`, as far
/// as there is a value; `None` where there is none. Asks for no more values than it takes to know.
fn median_is_low<L: Level>(
    (centre, places): ((L, L), [(L, L); 7]),
    value: impl Fn((L, L)) -> Option<L>,
    is_low: impl Fn(L) -> bool,
) -> Option<bool> {
    let (mut low, mut high) = (0, 0);
    for (left, (x, y)) in (0..places.len()).rev().zip(places) {
        match value((centre.0 + x, centre.1 + y)).map(&is_low) {
            Some(true) => low += 1,
            Some(false) => high += 1,
            None => {}
        }
        if low > high + left {
            return Some(true);
        }
        if high > 0 && low + left <= high {
            return Some(false);
        }
    }
    None
}

/// The place on the other side of a centre.
pub fn opposite<L: Level>(centre: (L, L), place: (L, L)) -> (L, L) {
    (centre.0 + centre.0 - place.0, centre.1 + centre.1 - place.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::Fixed14;

    extern crate std;

    /// Around the centre (3, 3) the values are those of the directions, from the right upwards.
    fn around<L: Level>(light: [f32; 8]) -> f32 {
        let mut values = [L::ZERO; 49];
        // At the corners the distance 3 lies between four pixels.
        let places: [&[usize]; 8] =
            [&[27], &[40, 41, 47, 48], &[45], &[35, 36, 42, 43], &[21], &[0, 1, 7, 8], &[3], &[5, 6, 12, 13]];
        for (place, light) in places.into_iter().zip(light) {
            place.iter().for_each(|&at| values[at] = L::of(light));
        }
        let field = Field { values: &values, grid: Grid::of(49, 7).expect("there are columns") };
        field.around((L::of(3.0), L::of(3.0)), (L::of(6.0), L::of(3.0))).to_f32()
    }

    #[test]
    fn three_of_seven_places_do_not_count() {
        for light in [[90.0, 2.0, 1.0, 3.0, 50.0, 4.0, 60.0, 70.0], [0.0, 50.0, 60.0, 70.0, 4.0, 1.0, 2.0, 3.0]] {
            assert!((around::<f32>(light) - 4.0).abs() < 1e-3, "{}", around::<f32>(light));
            assert!((around::<Fixed14>(light) - 4.0).abs() < 1e-2, "{}", around::<Fixed14>(light));
        }
    }

    /// The median of which only can be asked whether it is low: from 0 to 128, to a thousandth.
    fn median<L: Level>(asked: impl Fn(&dyn Fn(L) -> bool) -> Option<bool>) -> Option<f32> {
        let (mut from, mut to) = (0.0, 128.0);
        while to - from > 0.001 {
            let middle = 0.5 * (from + to);
            let half = if asked(&|value| value.to_f32() < middle)? { &mut to } else { &mut from };
            *half = middle;
        }
        Some(from)
    }

    /// Of as many of seven values as there are, in every order that matters, the upper one in the middle.
    #[test]
    fn a_median_is_low_where_more_than_half_of_the_values_are() {
        for kinds in 0..3usize.pow(7) {
            let kind = |at: usize| kinds / 3usize.pow(at as u32) % 3;
            let places = core::array::from_fn(|at| (at as f32, 0.0));
            let value = |(x, _): (f32, f32)| [None, Some(1.0), Some(2.0)][kind(x as usize)];
            let found = median_is_low(((0.0, 0.0), places), value, |value: f32| value < 1.5);
            let mut values: std::vec::Vec<usize> = (0..7).map(kind).filter(|&kind| kind > 0).collect();
            values.sort_unstable();
            assert_eq!(found, values.get(values.len() / 2).map(|&median| median == 1), "{kinds}");
        }
    }

    #[test]
    fn what_is_around_is_low_where_its_median_is() {
        let values: [f32; 49] = core::array::from_fn(|at| (at * 37 % 50) as f32);
        let field = Field { values: &values, grid: Grid::of(49, 7).expect("there are columns") };
        for place in [(6.0, 3.0), (4.5, 2.0), (1.0, 0.5), (9.0, 9.0)] {
            let around = field.around((3.0, 3.0), place);
            for (bound, is_low) in [(around, false), (around + 0.01, true), (0.5 * around - 0.01, false)] {
                assert_eq!(field.is_low_around((3.0, 3.0), place, |value| value < bound), is_low, "{place:?}");
            }
        }
    }

    /// A plane of 33 x 33 of which the isophotes are ellipses around (16, 16) with axes of 1 and 2, the longer towards
    /// (4, 3); with their shape.
    fn ellipses<L: Level>() -> (std::vec::Vec<L>, Ellipse<L>) {
        let light = |at: usize| {
            let (x, y) = ((at % 33) as f32 - 16.0, (at / 33) as f32 - 16.0);
            let (along, across) = (0.8 * x + 0.6 * y, 0.8 * y - 0.6 * x);
            L::of(40.0 - libm::hypotf(along, 2.0 * across))
        };
        // Moments of 4 and 1 along the axes are (0.28, 0.96) times 3/5 along x and y.
        ((0..33 * 33).map(light).collect(), Ellipse::of((0.6 * 0.28, 0.6 * 0.96)).expect("it is no needle"))
    }

    fn light_is_level_on_ellipses<L: Level>() {
        let (values, shape) = ellipses::<L>();
        let field = Field { values: &values, grid: Grid::of(33 * 33, 33).expect("there are columns") };
        let centre = (L::whole(16), L::whole(16));
        for at in [16 * 33 + 20, 19 * 33 + 20, 12 * 33 + 18, 22 * 33 + 15] {
            let light = |shape, counts: &dyn Fn(usize) -> bool| {
                median(|is_low| field.is_low_on_ellipse((centre, shape), field.place(at), counts, is_low))
            };
            let (own, found) = (field.at(at).to_f32(), light(shape, &|_| true).expect("it lies in the frame"));
            assert!((own - found).abs() < 0.15, "{found}, not {own}");
            let round = light(Ellipse::ROUND, &|_| true).expect("it lies in the frame");
            assert!((own - round).abs() > 0.5, "{round} is hardly another than {own}");
            assert_eq!(light(shape, &|_| false), None);
            let right = light(shape, &|at| at % 33 > 18);
            assert!(right.is_some_and(|found| (own - found).abs() < 0.3), "{right:?}, not {own}");
        }
        // From (34, 34), beyond the frame: the light at 25.2 along the longer axis and 3.6 across it.
        let far = (L::whole(34), L::whole(34));
        let beside = median(|is_low| field.is_low_on_ellipse((centre, shape), far, |_| true, is_low));
        assert!(beside.is_some_and(|light| (light - 13.8).abs() < 0.2), "{beside:?}: only what is in the frame counts");
    }

    #[test]
    fn light_is_level_on_ellipses_in_both_arithmetics() {
        light_is_level_on_ellipses::<f32>();
        light_is_level_on_ellipses::<Fixed14>();
    }

    /// Parabolas through 4, 8 and 6 and through 2, 8 and 6; the frame ends beside the other peak.
    #[test]
    fn a_centre_is_the_vertex_of_the_parabolas_and_the_nearest_pixel_is_its_peak() {
        let values = [0.0f32, 2.0, 0.0, 4.0, 8.0, 6.0, 0.0, 6.0, 0.0, 9.0, 0.0, 0.0];
        let field = Field { values: &values, grid: Grid::of(12, 3).expect("there are columns") };
        // A sixth of a pixel in whole parts of 1/256, and a quarter.
        assert_eq!([field.centre(4), field.centre(9)], [(1.0 + 43.0 / 256.0, 1.25), (0.0, 3.0)]);
        let places = [field.centre(4), (1.6, 0.4), (0.4, 1.6), (2.1, 1.0)];
        assert_eq!(places.map(|place| field.nearest(place)), [Some(4), Some(2), Some(6), None]);
    }

    #[test]
    fn a_needle_has_no_ellipse() {
        assert_eq!(Ellipse::<f32>::of((0.99, 0.0)), None);
        assert_eq!(Ellipse::<f32>::of((0.0, -1.0)), None);
        assert!(Ellipse::<f32>::of((0.0, -0.97)).is_some_and(|shape| shape != Ellipse::ROUND));
    }
}
