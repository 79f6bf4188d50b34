//! The noise of a smoothed plane, and how high its peaks reach.
//!
//! Whole counts of little noise leave a plane that is level but for a few patches, a step of the values high. Its
//! quartiles know nothing of these: such noise is measured by the far tail of the lower half, too.
//!
//! Photons and skies that are cut off at the black level have skew noise: more of its peaks are high
//! than in a normal distribution of the same width. The height that noise exceeds as rarely is then
//! that of E. A. Cornish and R. A. Fisher 1938, doi:10.2307/1400905, to the first order.

use crate::arithmetic::codec::Codec;
use crate::arithmetic::{Level, Real};
use crate::plane::grid::Grid;
use crate::plane::mask::Mask;
use crate::plane::part::{self, Question, Whole};
use crate::plane::sort::{Keys, median, ranked};
use crate::plane::walk::Walk;
use core::ops::Range;

/// From the distance between median and quartile to the standard deviation of a normal distribution.
const FROM_QUARTILE: f32 = 1.4826;
/// Of the values of coarse frames, one in so many is farther below the median than so many standard deviations of a normal
/// distribution.
const FAR: [(usize, f32); 3] = [(1000, 3.090_232), (10_000, 3.719_016), (30_000, 3.987_879)];
/// Values so many standard deviations from the mean are clipped.
const CLIP: f64 = 5.0;
/// Rounds of clipping.
const ROUNDS: u32 = 10;
/// Values so many noise units from 0 are those of sources, not of the tail.
const REACH: f32 = 6.0;
/// Less skewness is that of faint sources.
const LEAST: f32 = 0.15;
/// Fewer values do not tell the noise.
const ENOUGH: usize = 16;
/// More is not believed: the expansion ends there.
const MOST: f32 = 2.5;

/// All parts of an image, and the questions for the noise and for its powers.
pub(crate) type Asked<'w> = (&'w dyn Whole, [Question; 2]);

/// How the values of a frame are distributed of which a plane was made; see [`Values`](crate::sky::Values).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shape {
    /// Cut off below.
    pub piled: bool,
    /// Noise of about a step of the values or less.
    pub coarse: bool,
}

/// The noise of a plane where no source is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tail<L> {
    /// Its standard deviation.
    pub noise: L,
    /// Its skewness; 0 for a symmetric distribution.
    pub skewness: f32,
}

impl<L: Level> Tail<L> {
    /// The tail of `value(at)` over the pixels of a plane that are not `masked`. Sources are
    /// positive: the lower half of the values gives the noise. Where the frame is piled up at its least value the
    /// upper half counts as much; where it is coarse the noise is at least the clipped standard deviation, begun with
    /// that of a pixel, 1, and what the far tail of the lower half tells. Of both the skewness is measured. Of large
    /// planes a sample gives the noise. Cost: a sort of the sample; where piled or coarse, two looks at each pixel more.
    pub fn measure(value: impl Fn(usize) -> L, grid: Grid, masked: Mask<'_>, shape: Shape, keys: Keys<'_>) -> Tail<L> {
        let mut tail = Tail::UNKNOWN;
        let _ = tail.step(&mut Walk::whole(), (None, grid), value, (masked, shape), keys);
        tail
    }

    /// The tail of too few values.
    pub(crate) const UNKNOWN: Tail<L> = Tail { noise: L::ONE, skewness: 0.0 };

    /// The same in parts, and of all parts of an image, where the plane belongs to one of them: asked by the
    /// question for the noise and that for the powers. Unknown while others have yet to answer.
    pub(crate) fn step(
        &mut self,
        walk: &mut Walk,
        (whole, grid): (Option<Asked<'_>>, Grid),
        value: impl Fn(usize) -> L,
        (masked, shape): (Mask<'_>, Shape),
        mut keys: Keys<'_>,
    ) -> Option<()> {
        let sky = |at: usize| (!masked.has(at)).then(|| value(at));
        let asked = whole.map(|(whole, [noise, _])| (whole, noise));
        let width = grid.width.get();
        let Some(sorted) = part::sorted(walk, asked, (grid.cells(), width, true), &mut keys, sky)? else {
            *self = Tail::UNKNOWN;
            return Some(());
        };
        walk.once(1, || *self = Tail::of_sample(sorted, shape))?;
        let (noise, is_known) = (self.noise, sorted.len() >= ENOUGH);
        match whole {
            _ if shape == Shape::default() => {}
            None => {
                let rows = if is_known { grid.height } else { 0 };
                let reach = noise.scaled(L::Weight::of(REACH));
                let near = |rows: Range<usize>| {
                    let values = (rows.start * width..rows.end * width).filter_map(sky);
                    values.filter(move |value| value.magnitude() <= reach).map(|value| f64::from(value.to_f32()))
                };
                walk.tally(rows, width, |tally, rows| {
                    let [count, sum, ..] = if rows.start == 0 { [0.0; 4] } else { tally.sums };
                    let (count, sum) = near(rows).fold((count, sum), |(count, sum), value| (count + 1.0, sum + value));
                    tally.sums = [count, sum, 0.0, 0.0];
                })?;
                walk.tally(rows, width, |tally, rows| {
                    let [count, sum, squares, cubes] = tally.sums;
                    let mean = sum / at_least_one(count);
                    let (squares, cubes) =
                        near(rows).map(|value| value - mean).fold((squares, cubes), |(squares, cubes), bend| {
                            (squares + bend * bend, cubes + bend * bend * bend)
                        });
                    tally.sums = [count, sum, squares, cubes];
                })?;
                let sums = walk.tally.sums;
                walk.once(1, || self.skewness = if is_known { skewness(sums) } else { 0.0 })?;
            }
            Some((whole, [_, powers])) if is_known => {
                let reach = noise.scaled(L::Weight::of(REACH));
                let near = |at: usize| sky(at).filter(|value| value.magnitude() <= reach);
                let own = || part_powers(whole.part().own(width).filter_map(near));
                match whole.sums(powers, &mut { own }) {
                    Some(sums) => self.skewness = skewness_of(sums),
                    None => *self = Tail::UNKNOWN,
                }
            }
            Some(_) => {}
        }
        Some(())
    }

    /// The noise of sorted values.
    fn of_sample(sorted: &[u32], shape: Shape) -> Tail<L> {
        if sorted.len() < ENOUGH {
            return Tail::UNKNOWN;
        }
        // The middle of each half's distances from the median.
        let (half, centre) = (sorted.len() / 2, median::<L>(sorted));
        let lower = centre - ranked(sorted, half - 1 - half / 2);
        let upper = ranked::<L>(sorted, sorted.len() - half + half / 2) - centre;
        let both = (lower + upper).scaled(L::Weight::of(0.5));
        let quartile = if shape.piled { lower.greatest(both) } else { lower };
        let mut noise = quartile.scaled(L::Weight::of(FROM_QUARTILE));
        if shape.coarse {
            for (parts, height) in FAR {
                let far = centre - ranked(sorted, sorted.len() / parts.max(1));
                noise = noise.greatest(far.scaled(L::Weight::of(1.0 / height)));
            }
            noise = noise.greatest(L::of(clipped::<L>(sorted)));
        }
        Tail { noise, skewness: 0.0 }
    }

    /// The list of fields, out or in.
    pub(crate) fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        codec.bits(&mut self.noise)?;
        codec.real(&mut self.skewness)
    }

    /// The value that noise exceeds as rarely as normal noise exceeds `height` standard deviations.
    pub fn height(&self, height: f32) -> L {
        self.noise.scaled(L::Weight::of(self.raised(height)))
    }

    /// The same in units of the noise.
    pub fn raised(&self, height: f32) -> f32 {
        height + self.skewness * (height * height - 1.0) / 6.0
    }
}

/// The standard deviation of values by their keys, clipped; at first it is taken for that of a pixel, 1.
fn clipped<L: Level>(sorted: &[u32]) -> f32 {
    let (mut mean, mut noise, mut kept) = (0.0, 1.0, 0.0);
    for _ in 0..ROUNDS {
        let values = sorted.iter().map(|&key| f64::from(L::of_key(key).to_f32()));
        let near = values.map(|value| value - mean).filter(|bend| bend * bend <= CLIP * CLIP * noise * noise);
        let [count, sum, squares] =
            near.fold([0.0; 3], |[count, sum, squares], bend| [count + 1.0, sum + bend, squares + bend * bend]);
        let shift = sum / at_least_one(count);
        let variance = squares / at_least_one(count) - shift * shift;
        noise = libm::sqrt(if variance > 0.0 { variance } else { 0.0 });
        mean += shift;
        if count == kept {
            break;
        }
        kept = count;
    }
    noise as f32
}

fn at_least_one(count: f64) -> f64 {
    if count > 1.0 { count } else { 1.0 }
}

/// The skewness of the values within [`REACH`], of which these are the number, the sum, and the sums of squared and cubed
/// distances from the mean, in the order of the pixels.
fn skewness([count, _, squares, cubes]: [f64; 4]) -> f32 {
    let count = at_least_one(count);
    let variance = squares / count;
    if variance <= 0.0 {
        return 0.0;
    }
    let skewness = (cubes / count / (variance * libm::sqrt(variance))) as f32;
    if skewness < LEAST { 0.0 } else { skewness.least(MOST) }
}

/// The number of values, and the sums of their first three powers.
fn part_powers<L: Level>(values: impl Iterator<Item = L>) -> [f64; 4] {
    values.map(|value| f64::from(value.to_f32())).fold([0.0; 4], |[count, sum, squares, cubes], value| {
        [count + 1.0, sum + value, squares + value * value, cubes + value * value * value]
    })
}

/// The skewness that these sums tell; all but for rounding that of [`skewness`].
fn skewness_of([count, sum, squares, cubes]: [f64; 4]) -> f32 {
    let count = at_least_one(count);
    let (mean, square, cube) = (sum / count, squares / count, cubes / count);
    let variance = square - mean * mean;
    if variance <= 0.0 {
        return 0.0;
    }
    let third = cube - 3.0 * mean * square + 2.0 * mean * mean * mean;
    let skewness = (third / (variance * libm::sqrt(variance))) as f32;
    if skewness < LEAST { 0.0 } else { skewness.least(MOST) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sky::noise::tests::normal;

    extern crate std;
    use std::vec::Vec;

    const EVEN: Shape = Shape { piled: false, coarse: false };
    const PILED: Shape = Shape { piled: true, coarse: false };
    const COARSE: Shape = Shape { piled: false, coarse: true };

    fn tail(values: &[f32], shape: Shape) -> Tail<f32> {
        let (mut keys, mut spare) = (std::vec![0; values.len()], std::vec![0; values.len()]);
        let grid = Grid::of(values.len(), values.len()).expect("there are values");
        Tail::measure(|at| values[at], grid, Mask(&[]), shape, Keys(&mut keys, &mut spare))
    }

    #[test]
    fn normal_noise_reaches_the_height_of_the_table() {
        let values = normal(10_000, 0.0, 2.0);
        for shape in [EVEN, PILED, COARSE] {
            let tail = tail(&values, shape);
            assert!((tail.noise - 2.0).abs() < 0.01 && tail.skewness == 0.0, "{tail:?}");
            assert_eq!(tail.height(4.0), 4.0 * tail.noise);
        }
    }

    /// An exponential distribution has the skewness 2 and exceeds ln(1 / p) with probability p.
    #[test]
    fn skew_noise_reaches_higher() {
        let values: Vec<f32> = (0..10_000).map(|n| -libm::logf((n as f32 + 0.5) / 1e4) - 1.0).collect();
        let skew = tail(&values, PILED);
        assert!((skew.skewness - 1.7).abs() < 0.3, "{skew:?}");
        // Normal noise is above 3 with p = 0.00135.
        let exact = libm::logf(1.0 / 0.00135) - 1.0;
        assert!((skew.raised(3.0) - exact).abs() < 0.6, "{} beside {exact}", skew.raised(3.0));
        let lower = tail(&values, EVEN);
        assert!(lower.skewness == 0.0 && lower.noise < skew.noise, "the lower half is narrow: {lower:?}");
    }

    #[test]
    fn skewness_is_that_around_the_mean() {
        let around = |mean: f32| {
            let values: Vec<f32> = (0..10_000).map(|n| mean - libm::logf((n as f32 + 0.5) / 1e4) - 1.0).collect();
            tail(&values, PILED).skewness
        };
        assert!((around(0.3) - around(0.0)).abs() < 0.2, "{} beside {}", around(0.3), around(0.0));
    }

    #[test]
    fn heights_are_raised_by_a_sixth_of_the_skewness() {
        let tail = Tail { noise: 2.0f32, skewness: 1.5 };
        assert_eq!((tail.raised(3.0), tail.height(3.0)), (5.0, 10.0));
    }

    /// The squares of 0 to 19: the median is 100, and the middle of the halves 16 and 225.
    #[test]
    fn noise_is_told_by_the_middle_of_the_lower_half_or_of_both() {
        let sorted: [u32; 20] = core::array::from_fn(|n| ((n * n) as f32).key());
        for (shape, quartile) in [(EVEN, 84.0), (PILED, 104.5)] {
            assert_eq!(Tail::<f32>::of_sample(&sorted, shape), Tail { noise: quartile * FROM_QUARTILE, skewness: 0.0 });
        }
        assert_eq!(Tail::<f32>::of_sample(&sorted[..15], EVEN), Tail::UNKNOWN);
    }

    #[test]
    fn little_skewness_is_none_and_more_than_is_believed_is_cut() {
        let found = |third: f32| skewness([1.0, 0.0, 1.0, f64::from(third)]);
        assert_eq!([0.149, LEAST, 1.0, 3.0].map(found), [0.0, LEAST, 1.0, MOST]);
        assert_eq!([skewness([4.0, 1.0, 0.0, 0.0]), skewness_of([4.0, 4.0, 4.0, 4.0])], [0.0; 2]);
    }

    #[test]
    fn sums_of_powers_tell_the_same_skewness() {
        let values = [-1.0f32, -0.5, 0.25, 0.5, 1.0, 3.0];
        let mean = values.iter().sum::<f32>() / 6.0;
        let sum = |power: i32| values.iter().map(|value| f64::from(value - mean).powi(power)).sum::<f64>();
        let (found, exact) = (skewness_of(part_powers(values.into_iter())), skewness([6.0, 0.0, sum(2), sum(3)]));
        assert!((found - exact).abs() < 1e-5 && exact > 0.5, "{found}, not {exact}");
    }

    #[test]
    fn sources_do_not_count() {
        let mut values = normal(10_000, 0.0, 1.0);
        values.extend([500.0; 300]);
        let tail = tail(&values, PILED);
        assert!((tail.noise - 1.0).abs() < 0.05 && tail.skewness == 0.0, "{tail:?}");
    }

    /// Nine in ten pixels are level, and one in twenty each is a step of the values, 3 noise units, above and below.
    #[test]
    fn patches_of_coarse_noise_count() {
        let mut values = std::vec![0.0; 9000];
        values.extend([-3.0; 500]);
        values.extend([3.0; 500]);
        assert_eq!(tail(&values, EVEN).noise, 0.0, "quartiles know nothing of them");
        let deviation = libm::sqrtf(0.9);
        let coarse = tail(&values, COARSE);
        assert!(coarse.noise >= deviation && coarse.noise < 1.05, "{coarse:?}");
        // Without the lower patches what is left is skew, and of the standard deviation alone.
        values.retain(|&value| value >= 0.0);
        let coarse = tail(&values, COARSE);
        assert!((coarse.noise - 0.67).abs() < 0.01 && coarse.skewness > 2.0, "{coarse:?}");
    }

    /// Of 30 000 values of noise 1 a few lie farther out than they would in a normal distribution.
    #[test]
    fn the_farthest_values_of_coarse_noise_count() {
        for (far, noise) in [(2, 8.0 / 3.987_879), (4, 8.0 / 3.719_016), (31, 8.0 / 3.090_232)] {
            let mut values = normal(30_000, 0.0, 1.0);
            values.sort_by(f32::total_cmp);
            values[..far].fill(-8.0);
            assert!((tail(&values, COARSE).noise - noise).abs() < 1e-3, "{far}: {:?}", tail(&values, COARSE));
        }
    }

    #[test]
    fn sources_do_not_count_in_coarse_noise() {
        let mut values = normal(10_000, 0.0, 1.0);
        values.extend([500.0; 300]);
        assert!((tail(&values, COARSE).noise - 1.0).abs() < 0.05);
    }
}
