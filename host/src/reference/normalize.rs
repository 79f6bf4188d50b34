//! Step 1: grey levels to \[0, 1\] (`risc01`).

use super::{Normalize, Plane, ReferenceError};

/// The normalised image and the two levels that became 0 and 1. Pixels that are not finite take no part in the
/// levels and are given the median of the others.
pub(super) fn normalize(
    how: Normalize,
    pixels: &[f64],
    width: usize,
    height: usize,
) -> Result<(Plane, (f64, f64)), ReferenceError> {
    let mut sorted: Vec<f64> = pixels.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let (Some(&min), Some(&max)) = (sorted.first(), sorted.last()) else {
        return Err(ReferenceError::Constant);
    };
    let (low, high) = match how {
        Normalize::MinMax => (min, max),
        Normalize::Percentile(low, high) => (percentile(&sorted, low), percentile(&sorted, high)),
        Normalize::Noise(below, above) => match sky(&sorted) {
            (_, 0.0) => (min, max),
            (level, noise) => (level - below * noise, level + above * noise),
        },
    };
    if low >= high {
        return Err(ReferenceError::Constant);
    }
    let level = |v: f64| ((v - low) / (high - low)).clamp(0.0, 1.0);
    let fill = level(percentile(&sorted, 50.0));
    let plane = Plane::from_fn(width, height, |i, j| {
        let v = pixels[j as usize * width + i as usize];
        if v.is_finite() { level(v) } else { fill }
    });
    Ok((plane, (low, high)))
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
