//! The sky of one cell: a clipped estimate of level and noise from its sorted values.

use super::{Sky, Values};
use crate::arithmetic::machine::Task;
use crate::arithmetic::{Level, Real};
use crate::plane::sort::{median, ranked};

/// The fewest pixels of sky that a cell is measured on: a quarter of a window of 8 x 8.
pub const LEAST_PIXELS: usize = 16;

/// Values so many standard deviations from the sky are clipped.
const CLIP: f32 = 3.0;
/// The same where the sky is cut off below: what is left of its noise has a long upper tail.
const CLIP_PILED: f32 = 5.0;
/// At least so many steps around the sky are kept.
const CLIP_STEPS: f32 = 1.5;
/// What clipping at three standard deviations takes from the noise.
const CLIPPED_AWAY: f32 = 1.015;
/// Noise below so many steps is coarse: ranks say where the steps are, the mean where the sky is.
const COARSE: f32 = 1.0;
/// Noise below so many steps is too coarse for the mode, which is off by two and a half times what equal values, spread
/// evenly over a step, leave unsure of the median.
const FAIRLY_COARSE: f32 = 2.0;
/// A cell is cut off below where one in so many of its pixels has the least value.
const PILE_SHARE: usize = 10;
/// Standard deviation of a uniform distribution of width 1 (W. F. Sheppard 1898): `1 / sqrt(12)`.
const UNIFORM: f32 = 0.288_675_13;
/// From the distance between median and quartile to the standard deviation of a normal distribution.
const FROM_QUARTILE: f32 = 1.4826;
/// Rounds of clipping.
const ROUNDS: u32 = 10;

/// The sky among sorted keys of the values of a cell.
///
/// Clipped until nothing more is clipped (at most ten times), the level is the mode `2.5 median -
/// 1.5 mean`, or the median where the distribution is skew (Bertin and Arnouts 1996,
/// doi:10.1051/aas:1996164) or the noise below two steps of the values. Where the noise is coarse beside the step of the values, or the sky is cut
/// off below, it is the mean, which is what smoothing makes of such pixels. The noise is at least that of the step, `step / sqrt(12)`, and what the numbers resolve. Cost: about
/// eight looks at each value.
pub fn clipped(sorted: &[u32], values: &Values) -> Sky {
    Clipped { sorted, values }.run()
}

/// The same as a row loop.
pub(crate) struct Clipped<'a> {
    pub sorted: &'a [u32],
    pub values: &'a Values,
}

impl Task for Clipped<'_> {
    type Output = Sky;

    #[inline(always)]
    fn run(self) -> Sky {
        let Clipped { sorted, values } = self;
        if sorted.len() < LEAST_PIXELS {
            return Sky::UNKNOWN;
        }
        let step = clump_step(sorted, values.step);
        let piled = runs_below(sorted) * PILE_SHARE >= sorted.len();
        let least = values.resolution.greatest(step * UNIFORM);
        let coarse = |noise: f32| piled || noise < COARSE * step;
        let reach = if piled { CLIP_PILED } else { CLIP };
        let (mut kept, mut centre) = (sorted, quantile(sorted, 2, step));
        let mut noise = start(sorted, centre, step, piled).greatest(least);
        let (mut mean, mut middle, mut moments) = (centre, centre, None);
        for _ in 0..ROUNDS {
            let [below, inside, above] = within(kept, centre, (reach * noise).greatest(CLIP_STEPS * step));
            if inside.len() < LEAST_PIXELS / 2 {
                break;
            }
            let over = inside.len() == kept.len();
            match &mut moments {
                None => moments = Some(Moments::of(inside)),
                Some(moments) => [below, above].into_iter().for_each(|clipped| moments.without(clipped)),
            }
            let (new_mean, deviation) = moments.as_ref().map_or((mean, 0.0), Moments::mean_and_deviation);
            (kept, mean, middle) = (inside, new_mean, quantile(inside, 2, step));
            noise = (deviation * CLIPPED_AWAY).greatest(least);
            centre = if coarse(noise) { mean } else { middle };
            if over {
                break;
            }
        }
        let is_skew = (mean - middle).magnitude() >= 0.3 * noise;
        let level = match (coarse(noise), is_skew || noise < FAIRLY_COARSE * step) {
            (true, _) => mean,
            (false, true) => middle,
            (false, false) => 2.5 * middle - 1.5 * mean,
        };
        Sky { level, noise }
    }
}

/// How many of sorted keys equal the first.
#[inline(always)]
fn runs_below(sorted: &[u32]) -> usize {
    sorted.iter().take_while(|&key| Some(key) == sorted.first()).count()
}

/// The noise to begin with: half of the values lie within 0.6745 standard deviations, and the lower
/// half knows little of sources. Where the sky is cut off below, the upper half may know more, or
/// where that is cut off too, half of what is left.
#[inline(always)]
fn start(sorted: &[u32], centre: f32, step: f32, piled: bool) -> f32 {
    let lower = centre - quantile(sorted, 4, step);
    if !piled {
        return FROM_QUARTILE * lower;
    }
    let upper = at_rank(sorted, sorted.len() - 1 - sorted.len() / 4, step) - centre;
    let left = sorted.get(runs_below(sorted)..).unwrap_or(&[]);
    let above = if left.is_empty() { 0.0 } else { median::<f32>(left) - ranked::<f32>(sorted, 0) - step };
    FROM_QUARTILE * lower.greatest(upper).greatest(above)
}

/// The value below which one in `parts` of the sorted values lies.
#[inline(always)]
fn quantile(sorted: &[u32], parts: usize, step: f32) -> f32 {
    at_rank(sorted, sorted.len() / parts.max(1), step)
}

/// The value of a rank, the values of a clump being spread evenly over a step.
#[inline(always)]
pub(super) fn at_rank(sorted: &[u32], rank: usize, step: f32) -> f32 {
    let Some(value) = sorted.get(rank).map(|&key| f32::of_key(key)) else { return 0.0 };
    let (low, high) = (value - step / 3.0, value + step / 3.0);
    let first = sorted.partition_point(|&key| f32::of_key(key) < low);
    let end = sorted.partition_point(|&key| f32::of_key(key) <= high);
    let part = (rank.saturating_sub(first) as f32 + 0.5) / end.saturating_sub(first).max(1) as f32;
    value + step * (part - 0.5)
}

/// The sorted keys from the first to the last of which the values are at most `distance` from `centre`, between those
/// below and those above.
#[inline(always)]
fn within(sorted: &[u32], centre: f32, distance: f32) -> [&[u32]; 3] {
    let near = |&key: &u32| (f32::of_key(key) - centre).magnitude() <= distance;
    let first = sorted.iter().position(near).unwrap_or(sorted.len());
    let end = sorted.iter().rposition(near).map_or(first, |last| last + 1);
    let (below, rest) = sorted.split_at_checked(first).unwrap_or_default();
    let (inside, above) = rest.split_at_checked(end - first).unwrap_or_default();
    [below, inside, above]
}

/// Sums over the values of sorted keys and their squares, from one of them in the middle, so that what is clipped
/// later can be taken away again.
struct Moments {
    middle: f64,
    count: usize,
    sums: [f64; 2],
}

impl Moments {
    #[inline(always)]
    fn of(sorted: &[u32]) -> Moments {
        let middle = f64::from(median::<f32>(sorted));
        Moments { middle, count: sorted.len(), sums: sums(sorted, middle) }
    }

    /// Takes values away.
    #[inline(always)]
    fn without(&mut self, clipped: &[u32]) {
        let [sum, squares] = sums(clipped, self.middle);
        self.count = self.count.saturating_sub(clipped.len());
        let [all, all_squares] = &mut self.sums;
        (*all, *all_squares) = (*all - sum, *all_squares - squares);
    }

    /// Mean and standard deviation.
    #[inline(always)]
    fn mean_and_deviation(&self) -> (f32, f32) {
        let (count, [sum, squares]) = (self.count.max(1) as f64, self.sums);
        let variance = (squares - sum * sum / count) / count;
        let deviation = if variance > 0.0 { libm::sqrt(variance) } else { 0.0 };
        ((self.middle + sum / count) as f32, deviation as f32)
    }
}

/// The sums of the distances from `middle` and of their squares, in four lanes.
#[inline(always)]
fn sums(sorted: &[u32], middle: f64) -> [f64; 2] {
    const LANES: usize = 4;
    let (chunks, rest) = sorted.as_chunks::<LANES>();
    let distance = |key: u32| f64::from(f32::of_key(key)) - middle;
    let ([mut a, mut b, mut c, mut d], [mut aa, mut bb, mut cc, mut dd]) = ([0.0; LANES], [0.0; LANES]);
    for &[first, second, third, fourth] in chunks {
        let (first, second, third, fourth) = (distance(first), distance(second), distance(third), distance(fourth));
        (a, b, c, d) = (a + first, b + second, c + third, d + fourth);
        (aa, bb, cc, dd) = (aa + first * first, bb + second * second, cc + third * third, dd + fourth * fourth);
    }
    for distance in rest.iter().map(|&key| distance(key)) {
        (a, aa) = (a + distance, aa + distance * distance);
    }
    [(a + b) + (c + d), (aa + bb) + (cc + dd)]
}

/// The fewest values in which clumps are looked for.
const CLUMPS_FROM: usize = 200;
/// One in so many of the values is more than lies between two clumps.
const CLUMP_SHARE: usize = 50;

/// The step around which the values clump, where it is wider than the least one of the frame: a
/// flat field or a few pixels between the steps hide it there. It is the widest interval, tails
/// left out, that few values bridge, if most values beyond the middle clump lie near a multiple of it.
#[inline(always)]
fn clump_step(sorted: &[u32], step: f32) -> f32 {
    let count = sorted.len();
    let inner = sorted.get(count / 100..count - count / 20).unwrap_or(&[]);
    let later = inner.get(count / CLUMP_SHARE..).unwrap_or(&[]);
    let distances = inner.iter().zip(later).map(|(&low, &high)| f32::of_key(high) - f32::of_key(low));
    // Of numbers that are not below 0 the greatest has the greatest bits, and what has a sign vector units compare.
    let widest =
        f32::from_bits(distances.fold(0, |widest: i32, distance| widest.max(distance.to_bits() as i32)) as u32);
    if count < CLUMPS_FROM || widest <= 1.5 * step {
        return step;
    }
    let centre = ranked::<f32>(sorted, count / 2);
    let (mut near, mut others) = (0u32, 0u32);
    for value in sorted.iter().map(|&key| (f32::of_key(key) - centre) / widest) {
        let multiple = rounded(value);
        let is_other = multiple != 0.0;
        others += u32::from(is_other);
        near += u32::from(is_other & ((value - multiple).magnitude() < 1.0 / 6.0));
    }
    let (near, others) = (near as usize, others as usize);
    if others * CLUMP_SHARE >= count && near * 10 > others * 7 { widest } else { step }
}

/// The nearest whole number; of halves the even one, as `rintf` has it, without a call.
#[inline(always)]
fn rounded(value: f32) -> f32 {
    /// From 2^22 on numbers are multiples of a half, and what they are rounded to tells clumps no better.
    const WHOLE: f32 = 4_194_304.0;
    const SHIFT: f32 = 12_582_912.0;
    if value.magnitude() < WHOLE { (value + SHIFT) - SHIFT } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sky::noise::tests::normal;

    extern crate std;
    use std::vec::Vec;

    const COUNTS: Values = Values { step: 1.0, ..Values::UNKNOWN };

    fn sky(values: &Values, pixels: impl Iterator<Item = f32>) -> Sky {
        let mut keys: Vec<u32> = pixels.map(|value| (value + 0.0).key()).collect();
        keys.sort_unstable();
        clipped(&keys, values)
    }

    #[test]
    fn whole_counts_are_measured_between_the_counts() {
        for noise in [0.3, 0.5, 0.7, 1.0, 1.4, 2.5] {
            for part in [0.0, 0.25, 0.5, 0.75] {
                let counts = || normal(3600, 100.0 + part, noise).into_iter().map(libm::rintf);
                let found = sky(&COUNTS, counts());
                let mean = counts().map(f64::from).sum::<f64>() / 3600.0;
                let variance = counts().map(|value| (f64::from(value) - mean).powi(2)).sum::<f64>() / 3600.0;
                let (level, deviation) = (mean as f32, libm::sqrt(variance) as f32);
                assert!((found.level - level).abs() < 0.02 * deviation.max(0.5), "{found:?}, {level}, noise {noise}");
                assert!((found.noise / deviation - 1.0).abs() < 0.02, "{found:?}, {deviation}, noise {noise}");
            }
        }
    }

    #[test]
    fn the_noise_is_never_below_that_of_the_step() {
        let constant = || core::iter::repeat_n(5.0, 100);
        assert_eq!(sky(&COUNTS, constant()), Sky { level: 5.0, noise: UNIFORM });
        let model = Values { resolution: 0.25, ..Values::UNKNOWN };
        assert_eq!(sky(&model, constant()), Sky { level: 5.0, noise: 0.25 });
        assert!(!sky(&COUNTS, constant().take(LEAST_PIXELS - 1)).known());
    }

    /// What smoothing makes of pixels that are cut off at 0 is their mean, from photons to a sky below it.
    #[test]
    fn a_sky_that_is_cut_off_has_its_mean() {
        for (level, step) in [(0.0, 1.0), (0.5, 1.0), (0.0, 0.0), (-1.0, 0.0), (-2.0, 0.0)] {
            let cut = |value: f32| if step > 0.0 { libm::rintf(value).positive() } else { value.positive() };
            let pixels = || normal(3600, level, 1.0).into_iter().map(cut);
            let mean = pixels().sum::<f32>() / 3600.0;
            let variance = pixels().map(|value| (value - mean) * (value - mean)).sum::<f32>() / 3600.0;
            let found = sky(&Values { step, ..Values::UNKNOWN }, pixels());
            assert!((found.level - mean).abs() < 0.02, "{found:?}, the mean is {mean} for {level}");
            assert!((found.noise / libm::sqrtf(variance) - 1.0).abs() < 0.1, "{found:?} for {level}: {variance}");
        }
        // 60 photons on 6000 pixels, and a star.
        let photons = (0..6000).map(|at| if at % 100 == 0 { 1.0 } else { 0.0 }).chain([40.0; 9]);
        assert_eq!(sky(&COUNTS, photons), Sky { level: 0.01, noise: UNIFORM });
    }

    #[test]
    fn steps_show_through_a_flat_field_and_between_them() {
        let off_grid = |(at, value): (usize, f32)| value + if at % 100 == 7 { 0.37 } else { 1e-4 * (at % 13) as f32 };
        for noise in [0.3, 1.0] {
            let counts = || normal(3600, 100.4, noise).into_iter().map(libm::rintf).enumerate().map(off_grid);
            let found = sky(&Values { step: 1e-5, ..Values::UNKNOWN }, counts());
            let mean = counts().sum::<f32>() / 3600.0;
            assert!((found.level - mean).abs() < 0.05, "{found:?}, the mean is {mean}, noise {noise}");
        }
        // A tenth of the pixels are of sources: their light is wide and is no clump.
        let keys: Vec<u32> =
            normal(3600, 0.0, 1.0).into_iter().chain((0..400).map(|n| 3.0 + 0.5 * n as f32)).map(f32::key).collect();
        assert_eq!(clump_step(&keys, 1e-5), 1e-5);
    }

    #[test]
    fn what_is_taken_away_was_never_there() {
        let keys: Vec<u32> = normal(1003, 1e4, 3.0).into_iter().map(f32::key).collect();
        let (below, rest) = keys.split_at(37);
        let (inside, above) = rest.split_at(900);
        let mut moments = Moments::of(&keys);
        moments.without(below);
        moments.without(above);
        let (mean, deviation) = moments.mean_and_deviation();
        let exact = Moments::of(inside).mean_and_deviation();
        assert!((mean - exact.0).abs() <= 1e-3 && (deviation - exact.1).abs() < 1e-6, "{mean} {deviation}: {exact:?}");
        let values = || inside.iter().map(|&key| f64::from(f32::of_key(key)));
        let middle = values().sum::<f64>() / 900.0;
        let variance = values().map(|value| (value - middle) * (value - middle)).sum::<f64>() / 900.0;
        assert!((f64::from(mean) - middle).abs() < 1e-3 && (f64::from(deviation) - libm::sqrt(variance)).abs() < 1e-6);
        assert_eq!(Moments::of(&[7.5f32.key(); 30]).mean_and_deviation(), (7.5, 0.0));
    }

    #[test]
    fn halves_are_rounded_to_even_and_large_numbers_are_whole() {
        for value in [0.5, 1.5, -0.5, -2.5, 0.49, 7.0, -3.2, 4_194_303.5, 4_194_304.0, 1e9, -1e30] {
            assert_eq!(rounded(value), libm::rintf(value), "{value}");
        }
    }

    #[test]
    fn sources_hardly_move_the_sky() {
        let crowded = normal(3600, 100.0, 5.0).into_iter().chain((0..400).map(|n| 110.0 + n as f32));
        let found = sky(&Values::UNKNOWN, crowded);
        assert!((found.level - 100.0).abs() < 0.5 && (found.noise - 5.0).abs() < 0.4, "{found:?}");
    }
}
