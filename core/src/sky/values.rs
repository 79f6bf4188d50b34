//! What the detector, and the software behind it, did to the values of a frame.
//!
//! They count in steps (B. Widrow, I. Kollar 2008, Quantization Noise), cut off what is below the
//! black level, and fill pixels that were never observed with one number.

use crate::arithmetic::{Level, Real};
use crate::sort::{Keys, median, ranked};

/// A fill value has more than one in so many of the pixels.
const FILL_SHARE: usize = 100;
/// One in so many of the pixels must lie on either side of a fill value that is inside the range.
const SIDE_SHARE: usize = 1000;
/// Values that are not filled repeat less often than the fill value by this factor.
const FILL_EXCESS: usize = 20;
/// How far from the rest a fill value lies, in units of the distance to the rest's median.
const APART: f32 = 0.3;
/// A fill value of whole counts is so many steps away from the rest.
const APART_STEPS: f32 = 16.0;
/// A frame is cut off below where one in so many of its pixels has the least value.
const PILE_SHARE: usize = 10;
/// Fewer values do not tell a saturated sky from chance.
const SATURATED_FROM: usize = 1000;
/// The part of the range of a frame that is taken for exact: single precision resolves a little more.
const RESOLUTION: f32 = 1.0 / (1 << 20) as f32;

/// How the values of a frame came about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Values {
    /// The least distance of two values, in units of the image: 1 for whole counts; 0 where all
    /// are equal. At least as small as the true step.
    pub step: f32,
    /// What pixels without an observation hold; these are undefined. NaN where there is no such value.
    pub fill: f32,
    /// Pixels that hold it.
    pub filled: u32,
    /// Defined pixels.
    pub defined: u32,
    /// Whether a tenth of the defined pixels have the least value: what is darker was cut off there.
    pub piled: bool,
    /// Whether a tenth of them have the greatest value: what is brighter was cut off there. Never
    /// told of fewer than a thousand pixels.
    pub saturated: bool,
    /// The greatest of the values that were looked at.
    pub greatest: f32,
    /// The least noise that the numbers can express: 2^-20 of the range that pairs of neighbours
    /// span, in units of the image.
    pub resolution: f32,
    /// The commonest of the defined values.
    pub commonest: f32,
}

impl Values {
    /// Nothing is known: every finite value is as good as another.
    pub const UNKNOWN: Values = Values {
        step: 0.0,
        fill: f32::NAN,
        filled: 0,
        defined: 0,
        piled: false,
        saturated: false,
        greatest: 0.0,
        resolution: 0.0,
        commonest: 0.0,
    };

    /// Looks at the pixels of a frame, row-major in rows of `width`, that are finite and `allowed`.
    /// Steps, fill and pile are read from a sample of at most [`crate::sort::SAMPLES`]. Cost: two
    /// looks at each pixel and one sort of the sample.
    pub fn measure(pixels: &[f32], width: usize, allowed: impl Fn(usize) -> bool, mut keys: Keys<'_>) -> Values {
        let observed = |&at: &usize| allowed(at) && pixels.get(at).is_some_and(|pixel| pixel.is_finite());
        // One key for both zeros.
        let value = |at: usize| pixels.get(at).copied().unwrap_or(0.0) + 0.0;
        let sample = (0..pixels.len()).step_by(keys.stride(pixels.len())).filter(observed);
        let sorted = keys.sorted(sample.map(value));
        let fill = fill_value(sorted).filter(|&fill| {
            let pairs = Pairs::count(pixels, width, |at| observed(&at) && value(at) == fill);
            pairs.are_together(sorted.len(), occurrences(sorted, fill))
        });
        let fill = fill.unwrap_or(f32::NAN);
        let mut values = Values { fill, ..Values::UNKNOWN };
        let rest = || runs(sorted).filter(|run| run.value != fill);
        let commonest = rest().reduce(|most, run| if run.count > most.count { run } else { most });
        values.commonest = commonest.map_or(0.0, |run| run.value);
        values.step = least_gap(rest().map(|run| run.value));
        let count: usize = rest().map(|run| run.count).sum();
        values.piled = rest().next().is_some_and(|least| least.count * PILE_SHARE > count);
        if let Some(most) = rest().last() {
            values.greatest = most.value;
            values.saturated = count >= SATURATED_FROM && most.count * PILE_SHARE > count;
        }
        values.span(pixels, width, |at| observed(&at));
        values
    }

    /// Whether a value is an observation.
    pub fn holds(&self, value: f32) -> bool {
        value.is_finite() && value != self.fill
    }

    /// Counts the pixels, and takes the range that neighbours in a row reach together: one hot
    /// pixel does not widen it.
    fn span(&mut self, pixels: &[f32], width: usize, observed: impl Fn(usize) -> bool) {
        let (mut least, mut greatest) = (f32::MAX, f32::MIN);
        for (y, row) in pixels.chunks(width.max(1)).enumerate() {
            let mut before = None;
            for (x, &pixel) in row.iter().enumerate() {
                let seen = observed(y * width + x);
                let defined = seen && self.holds(pixel);
                self.defined += u32::from(defined);
                self.filled += u32::from(seen && !defined);
                if let (Some(before), true) = (before, defined) {
                    least = least.least(pixel.greatest(before));
                    greatest = greatest.greatest(pixel.least(before));
                }
                before = defined.then_some(pixel);
            }
        }
        if greatest > least {
            self.resolution = greatest * RESOLUTION - least * RESOLUTION;
        }
    }
}

/// Equal values among sorted ones.
#[derive(Clone, Copy, Debug)]
struct Run {
    value: f32,
    count: usize,
}

fn runs(sorted: &[u32]) -> impl Iterator<Item = Run> {
    sorted.chunk_by(|a, b| a == b).map(|run| Run { value: ranked(run, 0), count: run.len() })
}

fn occurrences(sorted: &[u32], value: f32) -> usize {
    runs(sorted).find(|run| run.value == value).map_or(0, |run| run.count)
}

/// The least distance between rising values; 0 where there are fewer than two.
fn least_gap(values: impl Iterator<Item = f32>) -> f32 {
    let (mut before, mut gap) = (None, f32::MAX);
    for value in values {
        if let Some(before) = before {
            gap = gap.least(value - before);
        }
        before = Some(value);
    }
    if gap < f32::MAX { gap } else { 0.0 }
}

/// A value that fills what was not observed: far more frequent than all others, and either in the
/// midst of values of which hardly two are equal, or far below the rest.
fn fill_value(sorted: &[u32]) -> Option<f32> {
    let longest = runs(sorted).reduce(|longest, run| if run.count > longest.count { run } else { longest })?;
    let (total, fill) = (sorted.len(), longest.value);
    let (rest, distinct) = (total - longest.count, runs(sorted).count() - 1);
    if longest.count * FILL_SHARE <= total || rest == 0 {
        return None;
    }
    let below = sorted.partition_point(|&key| f32::of_key(key) < fill);
    let above = sorted.get(below + longest.count..).unwrap_or(&[]);
    let nearest = ranked::<f32>(above, above.len() / 100) - fill;
    let apart = !above.is_empty() && nearest > APART * (median::<f32>(above) - fill);
    let enough = |side: usize| side * SIDE_SHARE > total;
    let inside = enough(below) && enough(above.len());
    let single = 2 * distinct > rest && longest.count.saturating_mul(distinct) > FILL_EXCESS * rest;
    let step = least_gap(runs(sorted).map(|run| run.value));
    let is_fill = if single { inside || apart } else { below == 0 && apart && nearest >= APART_STEPS * step };
    is_fill.then_some(fill)
}

/// How often one value is followed by itself.
struct Pairs {
    all: usize,
    followed: usize,
}

impl Pairs {
    fn count(pixels: &[f32], width: usize, holds: impl Fn(usize) -> bool) -> Pairs {
        let mut pairs = Pairs { all: 0, followed: 0 };
        for at in (0..pixels.len()).filter(|&at| holds(at)) {
            pairs.all += 1;
            pairs.followed += usize::from((at + 1) % width.max(1) != 0 && holds(at + 1));
        }
        pairs
    }

    /// What most pixels hold is filled in where it lies together; zeros of a photon counter are strewn.
    fn are_together(&self, total: usize, count: usize) -> bool {
        let strewn = self.all.saturating_mul(total + count);
        2 * count <= total || 2 * self.followed.saturating_mul(total) > strewn
    }
}
