//! What the detector did to the values (`default.md`, 1).

use super::sample;

/// How the values of a frame came about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facts {
    /// The value that undefined pixels hold.
    pub fill: Option<f64>,
    /// The least distance of two other values; 0 where all are equal.
    pub step: f64,
    /// Whether a tenth of them have the least one.
    pub cut_off: bool,
    /// Whether more than four tenths of them have one value.
    pub coarse: bool,
    /// What the numbers resolve.
    pub resolution: f64,
}

impl Facts {
    /// Of pixels in rows of `width`.
    pub fn of(pixels: &[f64], width: usize) -> Facts {
        // Adding 0 makes one of both zeros.
        let mut sorted: Vec<f64> = sample(pixels.len()).map(|at| pixels[at] + 0.0).filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let fill = fill(&sorted).filter(|&fill| lies_together(&sorted, fill, pixels, width));
        let rest: Vec<(f64, usize)> = counts(&sorted).into_iter().filter(|run| Some(run.0) != fill).collect();
        let total: usize = rest.iter().map(|run| run.1).sum();
        let step = rest.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(f64::INFINITY, f64::min);
        Facts {
            fill,
            step: if step.is_finite() { step } else { 0.0 },
            cut_off: rest.first().is_some_and(|least| 10 * least.1 > total),
            coarse: rest.iter().any(|run| 10 * run.1 > 4 * total),
            resolution: range_of_pairs(pixels, width, fill) / f64::from(1 << 20),
        }
    }

    /// Whether a pixel is defined.
    pub fn defines(&self, pixel: f64) -> bool {
        pixel.is_finite() && Some(pixel) != self.fill
    }
}

/// Each value with how often it is there, the least first.
fn counts(sorted: &[f64]) -> Vec<(f64, usize)> {
    sorted.chunk_by(|a, b| a == b).map(|equal| (equal[0], equal.len())).collect()
}

/// The commonest, of equally common ones the least.
fn commonest(values: impl Iterator<Item = (f64, usize)>) -> Option<(f64, usize)> {
    values.reduce(|best, other| if other.1 > best.1 { other } else { best })
}

fn fill(sorted: &[f64]) -> Option<f64> {
    let values = counts(sorted);
    let candidates = [commonest(values.iter().copied()), values.first().copied()];
    candidates.into_iter().flatten().find(|&value| is_fill(sorted, &values, value)).map(|value| value.0)
}

fn is_fill(sorted: &[f64], values: &[(f64, usize)], (value, count): (f64, usize)) -> bool {
    let total = sorted.len();
    let below = sorted.partition_point(|&v| v < value);
    let above = &sorted[below + count..];
    let others = || values.iter().copied().filter(|other| other.0 != value);
    let Some(first) = commonest(others()).filter(|_| 100 * count > total && !above.is_empty()) else { return false };
    let second = commonest(others().filter(|other| other.0 != first.0)).unwrap_or(first);
    let spread = 6 * first.1 < total - count;
    let gap = above[above.len() / 100] - value;
    let apart = gap > 0.3 * (above[above.len() / 2] - value) && (spread || gap >= 16.0 * (first.0 - second.0).abs());
    let amidst = spread && count > 4 * first.1 && 1000 * below > total && 1000 * above.len() > total;
    (below == 0 && apart) || amidst
}

/// Whether a value that most pixels hold is followed by itself.
fn lies_together(sorted: &[f64], value: f64, pixels: &[f64], width: usize) -> bool {
    let share = sorted.iter().filter(|&&v| v == value).count() as f64 / sorted.len() as f64;
    let holders = pixels.iter().filter(|&&v| v == value).count() as f64;
    let pairs = pixels.chunks(width).flat_map(|row| row.windows(2)).filter(|pair| pair[0] == value && pair[1] == value);
    share <= 0.5 || pairs.count() as f64 / holders > 0.5 * (1.0 + share)
}

fn range_of_pairs(pixels: &[f64], width: usize, fill: Option<f64>) -> f64 {
    let defined = |pair: &&[f64]| pair.iter().all(|&v| v.is_finite() && Some(v) != fill);
    let pairs = || pixels.chunks(width).flat_map(|row| row.windows(2)).filter(defined);
    let least = pairs().map(|pair| pair[0].max(pair[1])).fold(f64::INFINITY, f64::min);
    let greatest = pairs().map(|pair| pair[0].min(pair[1])).fold(f64::NEG_INFINITY, f64::max);
    (greatest - least).max(0.0)
}
