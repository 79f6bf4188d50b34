//! The sky of one cell: a clipped estimate of level and noise from its sorted values.

use super::{Sky, Values};
use crate::arithmetic::{Level, Real};
use crate::sort::ranked;

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
/// Noise below this part of a step is coarse: ranks say where the steps are, the mean where the sky is.
const COARSE: f32 = 0.6;
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
/// doi:10.1051/aas:1996164). Where the noise is coarse beside the step of the values, or the sky is cut
/// off below, it is the mean, which is what smoothing makes of such pixels. The noise is at least that of the step, `step / sqrt(12)`, and what the numbers resolve. Cost: about
/// eight looks at each value.
pub fn clipped(sorted: &[u32], values: &Values) -> Sky {
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
    let (mut mean, mut middle) = (centre, centre);
    for _ in 0..ROUNDS {
        let inside = within(kept, centre, (reach * noise).greatest(CLIP_STEPS * step));
        if inside.len() < LEAST_PIXELS / 2 {
            break;
        }
        let over = inside.len() == kept.len();
        let moments = Moments::of(inside);
        (kept, mean, middle) = (inside, moments.mean, quantile(inside, 2, step));
        noise = (moments.deviation * CLIPPED_AWAY).greatest(least);
        centre = if coarse(noise) { mean } else { middle };
        if over {
            break;
        }
    }
    let is_skew = (mean - middle).magnitude() >= 0.3 * noise;
    let level = match (coarse(noise), is_skew) {
        (true, _) => mean,
        (false, true) => middle,
        (false, false) => 2.5 * middle - 1.5 * mean,
    };
    Sky { level, noise }
}

/// How many of sorted keys equal the first.
fn runs_below(sorted: &[u32]) -> usize {
    sorted.chunk_by(|a, b| a == b).next().map_or(0, <[u32]>::len)
}

/// The noise to begin with: half of the values lie within 0.6745 standard deviations, and the lower
/// half knows little of sources. Where the sky is cut off below, the upper half may know more.
fn start(sorted: &[u32], centre: f32, step: f32, piled: bool) -> f32 {
    let lower = centre - quantile(sorted, 4, step);
    let upper = at_rank(sorted, sorted.len() - 1 - sorted.len() / 4, step) - centre;
    FROM_QUARTILE * if piled { lower.greatest(upper) } else { lower }
}

/// The value below which one in `parts` of the sorted values lies.
fn quantile(sorted: &[u32], parts: usize, step: f32) -> f32 {
    at_rank(sorted, sorted.len() / parts.max(1), step)
}

/// The value of a rank, equal values being spread evenly over a step.
fn at_rank(sorted: &[u32], rank: usize, step: f32) -> f32 {
    let Some(&key) = sorted.get(rank) else { return 0.0 };
    let first = sorted.partition_point(|&other| other < key);
    let end = sorted.partition_point(|&other| other <= key);
    let part = ((rank - first) as f32 + 0.5) / (end - first) as f32;
    f32::of_key(key) + step * (part - 0.5)
}

/// The sorted keys whose values are at most `distance` from `centre`.
fn within(sorted: &[u32], centre: f32, distance: f32) -> &[u32] {
    let near = |&key: &u32| (f32::of_key(key) - centre).magnitude() <= distance;
    let first = sorted.iter().position(near).unwrap_or(sorted.len());
    let end = sorted.iter().rposition(near).map_or(first, |last| last + 1);
    sorted.get(first..end).unwrap_or(&[])
}

/// Mean and standard deviation, from sums in rising order.
struct Moments {
    mean: f32,
    deviation: f32,
}

impl Moments {
    fn of(sorted: &[u32]) -> Moments {
        let values = || sorted.iter().map(|&key| f64::from(f32::of_key(key)));
        let count = sorted.len().max(1) as f64;
        let mean = values().sum::<f64>() / count;
        let squares: f64 = values().map(|value| (value - mean) * (value - mean)).sum();
        Moments { mean: mean as f32, deviation: libm::sqrt(squares / count) as f32 }
    }
}

/// The fewest values in which clumps are looked for.
const CLUMPS_FROM: usize = 200;
/// One in so many of the values is more than lies between two clumps.
const CLUMP_SHARE: usize = 50;

/// The step around which the values clump, where it is wider than the least one of the frame: a
/// flat field or a few pixels between the steps hide it there. It is the widest interval, tails
/// left out, that few values bridge, if most values beyond the middle clump lie near a multiple of it.
fn clump_step(sorted: &[u32], step: f32) -> f32 {
    let count = sorted.len();
    let inner = sorted.get(count / 100..count - count / 20).unwrap_or(&[]);
    let distance = |pair: &[u32]| ranked::<f32>(pair, pair.len().saturating_sub(1)) - ranked::<f32>(pair, 0);
    let widest = inner.windows(count / CLUMP_SHARE + 1).map(distance).fold(0.0, f32::greatest);
    if count < CLUMPS_FROM || widest <= 1.5 * step {
        return step;
    }
    let centre = ranked::<f32>(sorted, count / 2);
    let (mut near, mut others) = (0, 0);
    for value in sorted.iter().map(|&key| (f32::of_key(key) - centre) / widest) {
        let multiple = libm::rintf(value);
        if multiple != 0.0 {
            others += 1;
            near += usize::from((value - multiple).magnitude() < 1.0 / 6.0);
        }
    }
    if others * CLUMP_SHARE >= count && near * 10 > others * 7 { widest } else { step }
}
