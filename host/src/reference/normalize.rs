//! Step 1: grey levels to \[0, 1\] (`risc01`).

use super::{Normalize, Plane, ReferenceError};

/// The two grey levels that become 0 and 1.
///
/// # Errors
/// No pixel is finite, or the two coincide.
pub fn range(how: Normalize, pixels: &[f64]) -> Result<(f64, f64), ReferenceError> {
    let sorted = sorted(pixels);
    let (Some(&min), Some(&max)) = (sorted.first(), sorted.last()) else {
        return Err(ReferenceError::Constant);
    };
    let (low, high) = match how {
        Normalize::MinMax => (min, max),
        Normalize::Percentile(low, high) => (percentile(&sorted, low), percentile(&sorted, high)),
        Normalize::Signal(below, above) => (-below, above),
        Normalize::Noise(below, above) => match sky(&sorted) {
            (_, 0.0) => (min, max),
            (level, noise) => (level - below * noise, level + above * noise),
        },
    };
    if low < high { Ok((low, high)) } else { Err(ReferenceError::Constant) }
}

/// The image between two grey levels. Pixels that are not finite are given the median of the others.
pub fn normalize((low, high): (f64, f64), pixels: &[f64], width: usize, height: usize) -> Plane {
    let level = |v: f64| ((v - low) / (high - low)).clamp(0.0, 1.0);
    let fill = level(percentile(&sorted(pixels), 50.0));
    Plane::from_fn(width, height, |i, j| {
        let v = pixels[j as usize * width + i as usize];
        if v.is_finite() { level(v) } else { fill }
    })
}

/// The finite pixels in rising order.
fn sorted(pixels: &[f64]) -> Vec<f64> {
    let mut sorted: Vec<f64> = pixels.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// Level and noise of the sky among sorted levels: the median, and what the percentile one standard deviation below
/// the middle of a normal distribution is less. Levels beyond 3 standard deviations above the sky are then left out,
/// and both taken again, three times in all.
pub(super) fn sky(sorted: &[f64]) -> (f64, f64) {
    let mut kept = sorted;
    let (mut level, mut noise) = (0.0, 0.0);
    for _ in 0..3 {
        level = percentile(kept, 50.0);
        noise = level - percentile(kept, 15.865525);
        kept = &sorted[..sorted.partition_point(|&v| v <= level + 3.0 * noise)];
    }
    (level, noise)
}

/// The percentile's lower nearest rank: a level of the image, nothing between two.
fn percentile(sorted: &[f64], percent: f64) -> f64 {
    let rank = (percent / 100.0 * (sorted.len() - 1) as f64).floor();
    sorted[rank as usize]
}
