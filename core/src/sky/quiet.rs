//! The noise of a cell that sources cover: what is left between them is theirs too, but its darkest pixels differ from
//! their neighbours by little else than noise.

use super::Values;
use super::clipped::at_rank;
use crate::arithmetic::Real;
use crate::plane::sort::Keys;
use core::ops::Range;

/// From the median size of a normal value to the standard deviation.
const FROM_MEDIAN: f32 = 1.4826;
/// The second difference along both axes of noise of 1 has this standard deviation: its weights are 1 -2 1 along each.
const SECOND: f32 = 6.0;
/// The ranks of the dark tail: one in so many values is darker.
const TAIL: [usize; 3] = [200, 40, 8];
/// Under light that is spread evenly from the sky upwards, `n(v) = c (1 + erf(v / sqrt 2)) / 2`, the noise is the span of
/// the tail times `0.4 / (R - 0.7)`, R the ratio of its two parts, to 5 percent from [`LEAST_RATIO`] to 2.7.
const TAIL_NOISE: f32 = 0.4;
/// See [`TAIL_NOISE`].
const TAIL_BEND: f32 = 0.7;
/// A steeper tail is taken for one of this ratio.
const LEAST_RATIO: f32 = 1.1;
/// Fewer boxes do not tell their differences.
const LEAST_BOXES: usize = 100;
/// Of fewer values too few are in the tail: a window with one star is not a crowd.
const LEAST_VALUES: usize = 1600;
/// Differences and tail agree within this factor; the tail of a cell is known to a quarter.
const AGREE: f32 = 1.6;

/// A frame by columns and rows.
pub(crate) struct Pixels<D, V> {
    /// Its columns and rows.
    pub size: (usize, usize),
    /// A bit for each of 32 pixels from the given one on along a row: whether it is defined.
    pub defined: D,
    /// The value of a pixel.
    pub value: V,
}

/// The noise of the pixels between the given sides that lie in a box of 3 x 3 pixels whose mean is not above `level`; `None`
/// where they are too few. The mean of a box says nothing of the second difference in it, for noise of which no two pixels
/// know each other. Sharp stars make that too wide, and noise that goes on from pixel to pixel too narrow: where the
/// dark tail of all values does not agree with it, its noise is taken. Cost: two sorts, and six looks at each pixel.
pub(crate) fn quiet<D: Fn(usize, usize) -> u32, V: Fn(usize, usize) -> Option<f32>>(
    pixels: &Pixels<D, V>,
    sides: [usize; 4],
    level: f32,
    values: &Values,
    keys: &mut Keys<'_>,
) -> Option<f32> {
    let [left, right, bottom, top] = sides;
    let differences = (bottom..top).flat_map(|y| pixels.boxes(y, left..right)).filter(|bend| bend.mean <= level);
    let sorted = keys.sorted(differences.map(|bend| bend.difference));
    let is_known = sorted.len() >= LEAST_BOXES;
    let difference = FROM_MEDIAN / SECOND * at_rank(sorted, sorted.len() / 2, values.step);
    let sorted = keys.sorted((bottom..top).flat_map(|y| pixels.row(y, left..right)));
    let is_known = is_known && sorted.len() >= LEAST_VALUES;
    let tail = tail(sorted, values.step);
    let agrees = difference <= AGREE * tail && tail <= AGREE * difference;
    let noise = if agrees { difference } else { tail };
    (is_known && noise > 0.0).then_some(noise)
}

/// The noise by the dark tail of sorted values.
fn tail(sorted: &[u32], step: f32) -> f32 {
    let [first, second, third] = TAIL.map(|parts| at_rank(sorted, sorted.len() / parts.max(1), step));
    let (below, above) = (second - first, third - second);
    let ratio = if below > 0.0 { (above / below).greatest(LEAST_RATIO) } else { LEAST_RATIO };
    (third - first) * TAIL_NOISE / (ratio - TAIL_BEND)
}

/// What a box of 3 x 3 pixels tells.
struct Box3 {
    mean: f32,
    /// The size of the second difference along both axes.
    difference: f32,
}

impl Box3 {
    /// Of three columns of three pixels.
    fn of([before, here, after]: [[f32; 3]; 3]) -> Box3 {
        let bend = |[below, here, above]: [f32; 3]| (below + above) - 2.0 * here;
        let sum = |[below, here, above]: [f32; 3]| (below + above) + here;
        Box3 {
            mean: ((sum(before) + sum(after)) + sum(here)) / 9.0,
            difference: ((bend(before) + bend(after)) - 2.0 * bend(here)).magnitude(),
        }
    }
}

impl<D: Fn(usize, usize) -> u32, V: Fn(usize, usize) -> Option<f32>> Pixels<D, V> {
    /// The boxes around pixels of row `y` that are defined as a whole.
    fn boxes(&self, y: usize, x: Range<usize>) -> impl Iterator<Item = Box3> {
        let (width, height) = self.size;
        let rows =
            y.checked_sub(1).filter(|_| y.saturating_add(1) < height).map(|below| [below, y, y.saturating_add(1)]);
        let columns = x.start.saturating_sub(1)..x.end.saturating_add(1).min(width);
        let mut near = [None; 3];
        let columns = rows.into_iter().flat_map(move |rows| self.columns(rows, columns.clone()));
        columns.filter_map(move |column| {
            let [_, before, here] = near;
            near = [before, here, column];
            let [before, here, after] = near;
            Some(Box3::of([before?, here?, after?]))
        })
    }

    /// Columns of three pixels, where all are defined.
    fn columns(&self, rows: [usize; 3], x: Range<usize>) -> impl Iterator<Item = Option<[f32; 3]>> {
        let mut words = [0; 3];
        let first = x.start;
        x.map(move |x| {
            if (x - first).is_multiple_of(u32::BITS as usize) {
                words = rows.map(|y| (self.defined)(x, y));
            }
            let known = words.iter().all(|word| word & 1 == 1);
            words = words.map(|word| word >> 1);
            let [below, here, above] = rows.map(|y| (self.value)(x, y).filter(|value| value.is_finite()));
            Some([below?, here?, above?]).filter(|_| known)
        })
    }

    /// The defined values of a row.
    fn row(&self, y: usize, x: Range<usize>) -> impl Iterator<Item = f32> {
        let (mut word, first) = (0, x.start);
        x.filter_map(move |x| {
            if (x - first).is_multiple_of(u32::BITS as usize) {
                word = (self.defined)(x, y);
            }
            let known = word & 1 == 1;
            word >>= 1;
            (self.value)(x, y).filter(|_| known).map(|value| value + 0.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sky::noise::tests::normal;

    extern crate std;
    use std::vec::Vec;

    const SIDE: usize = 64;

    /// What is told of a cell of noise of 1 that does not go on from pixel to pixel, under some light.
    fn noise(pixels: &[f32], level: f32) -> Option<f32> {
        let frame =
            Pixels { size: (SIDE, SIDE), defined: |_, _| u32::MAX, value: |x, y| pixels.get(y * SIDE + x).copied() };
        let mut room = [[0; SIDE * SIDE]; 2];
        let [keys, spare] = &mut room;
        quiet(&frame, [0, SIDE, 0, SIDE], level, &Values::UNKNOWN, &mut Keys(keys, spare))
    }

    fn under(seed: u32, light: impl Fn(f32, f32) -> f32) -> Vec<f32> {
        let mut order: Vec<u32> = (0..(SIDE * SIDE) as u32).collect();
        let mixed =
            |n: u32| (n.wrapping_mul(0x9E37_79B1) ^ n.wrapping_mul(0x85EB_CA6B) >> 15).wrapping_mul(0xC2B2_AE35);
        order.sort_by_key(|&n| mixed(mixed(n ^ seed << 20) >> 7));
        let noise = normal(SIDE * SIDE, 0.0, 1.0);
        let lit = |(at, &n): (usize, &u32)| noise[n as usize] + light((at % SIDE) as f32, (at / SIDE) as f32);
        order.iter().enumerate().map(lit).collect()
    }

    /// Of nine cells the middle one counts, as in the mesh.
    #[test]
    fn light_that_bends_little_is_no_noise() {
        for height in [0.0, 3.0, 10.0] {
            let hills = |x: f32, y: f32| height * (2.0 + libm::sinf(x / 5.0) + libm::cosf(y / 4.0));
            let of_cell = |seed| noise(&under(seed, hills), 2.0 * height).expect("half of the pixels are darker");
            let mut cells: Vec<f32> = (1..10).map(of_cell).collect();
            cells.sort_by(f32::total_cmp);
            assert!((cells[4] - 1.0).abs() < 0.06, "{cells:?} under {height}");
        }
    }

    /// Noise of pairs of equal pixels has smaller differences; the tail of its values is the same.
    #[test]
    fn noise_that_goes_on_is_told_by_its_tail() {
        let single = under(0, |_, _| 0.0);
        let smooth: Vec<f32> = (0..single.len()).map(|at| single[at / SIDE / 4 * SIDE + at % SIDE / 4 * 7]).collect();
        let light = |at: usize| (at * 2053 % 4096) as f32 / 100.0;
        let lit: Vec<f32> = smooth.iter().enumerate().map(|(at, noise)| noise + light(at / 9)).collect();
        let noise = noise(&lit, 20.0).expect("half of the pixels are darker");
        assert!((noise - 1.0).abs() < 0.4, "{noise}");
    }

    #[test]
    fn nothing_is_told_of_too_few() {
        let pixels = under(0, |_, _| 0.0);
        assert_eq!(noise(&pixels, -10.0), None, "no pixel is so dark");
        assert_eq!(noise(&[7.0; SIDE * SIDE], 7.0), None, "and a level plane has no noise");
        let frame = Pixels { size: (SIDE, SIDE), defined: |x, _| 0x5555_5555u32 << (x % 2), value: |_, _| Some(1.0) };
        let mut room = [[0; SIDE * SIDE]; 2];
        let [keys, spare] = &mut room;
        let none = quiet(&frame, [0, SIDE, 0, SIDE], 9.0, &Values::UNKNOWN, &mut Keys(keys, spare));
        assert_eq!(none, None, "every second column is undefined");
        let of_side = |side: usize| {
            let value = |x: usize, y: usize| pixels.get(y * SIDE + x).copied();
            let window = Pixels { size: (side, side), defined: |_, _| u32::MAX, value };
            let mut room = [[0; SIDE * SIDE]; 2];
            let [keys, spare] = &mut room;
            quiet(&window, [0, side, 0, side], 9.0, &Values::UNKNOWN, &mut Keys(keys, spare))
        };
        assert!(of_side(39).is_none() && of_side(40).is_some(), "a window is too small");
    }
}
