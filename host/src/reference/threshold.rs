//! Automatic thresholds other than Otsu's, of an image with levels in \[0, 1\].

use super::normalize::sky;
use super::otsu::histogram;

/// The threshold of greatest entropy (J. N. Kapur, P. K. Sahoo, A. K. C. Wong 1985, DOI 10.1016/0734-189X(85)90125-2):
/// the upper edge of the last background bin of 256, the first of equals (to 1e-9). 0 when all levels share a bin.
pub fn kapur(levels: impl Iterator<Item = f64>) -> f64 {
    let histogram = histogram(levels);
    let (mut best, mut tau) = (f64::NEG_INFINITY, 0.0);
    for last in 0..histogram.len() - 1 {
        let (background, objects) = histogram.split_at(last + 1);
        if let (Some(a), Some(b)) = (entropy(background), entropy(objects))
            && a + b > best + 1e-9
        {
            (best, tau) = (a + b, (last + 1) as f64 / histogram.len() as f64);
        }
    }
    tau
}

/// - sum p ln p of a class, p the shares of its bins; `None` when it is empty.
fn entropy(class: &[u64]) -> Option<f64> {
    let all = class.iter().sum::<u64>() as f64;
    let shares = class.iter().filter(|&&n| n > 0).map(|&n| n as f64 / all);
    (all > 0.0).then(|| -shares.map(|p| p * p.ln()).sum::<f64>())
}

/// The corner of a histogram with one peak (P. L. Rosin 2001, DOI 10.1016/S0031-3203(00)00136-9): of the bins under the
/// line from the highest bin to the first empty one behind the last in use, the upper edge of the one farthest from
/// the line. 0 when all levels share a bin.
pub fn rosin(levels: impl Iterator<Item = f64>) -> f64 {
    let histogram = histogram(levels);
    let used: Vec<usize> = (0..histogram.len()).filter(|&bin| histogram[bin] > 0).collect();
    let (Some(&first), Some(&last)) = (used.first(), used.last()) else { return 0.0 };
    if first == last {
        return 0.0;
    }
    // Clipped levels gather in the last bin.
    let height = used.iter().filter(|&&bin| bin < 255).map(|&bin| histogram[bin]).max().unwrap_or(0);
    let peak = used.iter().copied().find(|&bin| bin < 255 && histogram[bin] == height).unwrap_or(first);
    // Distance of (bin, n) from the line through (peak, height) and (last + 1, 0), downwards positive.
    let (dx, dy) = ((last + 1 - peak) as f64, -(height as f64));
    let distance = |bin: usize| {
        let (x, y) = ((bin - peak) as f64, histogram[bin] as f64 - height as f64);
        (dy * x - dx * y) / dx.hypot(dy)
    };
    let farthest = (peak..=last).fold(peak, |best, bin| if distance(bin) > distance(best) { bin } else { best });
    (farthest + 1) as f64 / histogram.len() as f64
}

/// The level k standard deviations above the sky, in \[0, 1\]; lower by 2^-18 of itself, so that levels that are whole
/// numbers of the original image do not meet it.
pub fn noise(levels: impl Iterator<Item = f64>, k: f64) -> f64 {
    let mut sorted: Vec<f64> = levels.collect();
    sorted.sort_by(f64::total_cmp);
    let (level, noise) = sky(&sorted);
    ((level + k * noise) * (1.0 - 0.5f64.powi(18))).clamp(0.0, 1.0)
}
