//! A quantity that is known for every pixel: one number, or a map of the image's shape.

use std::borrow::Cow;

/// Background or noise of an image.
///
/// ```
/// use skyfront::measure::{Level, estimate};
///
/// let (background, noise) = estimate(&[3.0, 5.0, 3.0, 5.0, 900.0], &[0, 0, 0, 0, 1]);
/// assert!(Level::Constant(background).at(2) == background && noise > 0.0);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Level<'a> {
    /// The same everywhere.
    Constant(f64),
    /// One value per pixel, row-major.
    Map(Cow<'a, [f32]>),
}

impl Level<'_> {
    /// The value at a pixel index; NaN beyond a map.
    #[inline(always)]
    pub fn at(&self, index: usize) -> f64 {
        // Spelled out: the compiler leaves the slice of a Cow a call for each pixel.
        let map = match self {
            Level::Constant(value) => return *value,
            Level::Map(Cow::Borrowed(map)) => map,
            Level::Map(Cow::Owned(map)) => map.as_slice(),
        };
        map.get(index).map_or(f64::NAN, |&value| f64::from(value))
    }
}

/// At most so many pixels are looked at for an estimate.
const SAMPLE: usize = 200_000;
/// Rounds of clipping at three standard deviations.
const ROUNDS: usize = 5;
/// From a median absolute deviation to a standard deviation, for Gaussian noise.
const MAD_TO_SIGMA: f64 = 1.482_602_218_505_602;

/// Background and noise of the pixels that belong to no source, by [`clipped_scatter`].
pub fn estimate(pixels: &[f32], labels: &[u32]) -> (f64, f64) {
    let sky = pixels.iter().zip(labels).filter(|(_, label)| **label == 0);
    clipped_scatter(sky.map(|(&pixel, _)| f64::from(pixel)))
}

/// Median of the finite values, and standard deviation from the median absolute deviation, after
/// clipping; (0, 0) where there are no values.
pub fn clipped_scatter(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let finite = || values.clone().filter(|value| value.is_finite());
    let step = finite().count().div_ceil(SAMPLE).max(1);
    let sample = sorted(finite().step_by(step));
    let mut sample = sample.as_slice();
    let (mut middle, mut sigma) = spread(sample);
    for _ in 0..ROUNDS {
        let (low, high) = (middle - 3.0 * sigma, middle + 3.0 * sigma);
        let kept = sample.partition_point(|&value| value < low)..sample.partition_point(|&value| value <= high);
        if kept.len() == sample.len() || kept.is_empty() {
            break;
        }
        sample = &sample[kept];
        (middle, sigma) = spread(sample);
    }
    (middle, sigma)
}

/// Values in the order of `total_cmp`, by whole numbers that sort alike: far fewer instructions.
fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let flip = |bits: i64| bits ^ ((bits >> 63) & i64::MAX);
    let mut ranks: Vec<i64> = values.map(|value| flip(value.to_bits() as i64)).collect();
    ranks.sort_unstable();
    ranks.into_iter().map(|rank| f64::from_bits(flip(rank) as u64)).collect()
}

/// Median and standard deviation of a sorted sample.
fn spread(sorted: &[f64]) -> (f64, f64) {
    let half = sorted.len() / 2;
    let mean_of_two = sorted.len().is_multiple_of(2);
    let Some(&upper) = sorted.get(half) else { return (0.0, 0.0) };
    let middle = if mean_of_two { 0.5 * (sorted[half - 1] + upper) } else { upper };
    let mut distances: Vec<f64> = sorted.iter().map(|value| (value - middle).abs()).collect();
    let (below, &mut upper, _) = distances.select_nth_unstable_by(half, f64::total_cmp);
    let lower = below.iter().copied().max_by(f64::total_cmp).filter(|_| mean_of_two);
    (middle, MAD_TO_SIGMA * lower.map_or(upper, |lower| 0.5 * (lower + upper)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sky_beside_a_source() {
        let pixels = [1.0, 2.0, 3.0, 100.0, f32::NAN];
        // Sorted sky: 1 2 3; distances from 2: 0 1 1.
        assert_eq!(estimate(&pixels, &[0, 0, 0, 7, 0]), (2.0, MAD_TO_SIGMA));
        assert_eq!(estimate(&pixels, &[1; 5]), (0.0, 0.0));
    }

    #[test]
    fn an_outlier_is_clipped() {
        let pixels: Vec<f32> = (0..100).map(|i| (i % 5) as f32).chain([1e6]).collect();
        assert_eq!(estimate(&pixels, &vec![0; 101]).0, 2.0);
    }

    #[test]
    fn values_of_both_signs_are_sorted() {
        let values = [1.5, -2.0, 0.0, f64::MIN, -0.5, 3.0, f64::MAX, -1e-300];
        assert_eq!(sorted(values.into_iter()), [f64::MIN, -2.0, -0.5, -1e-300, 0.0, 1.5, 3.0, f64::MAX]);
    }
}
