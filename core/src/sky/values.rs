//! What the detector, and the software behind it, did to the values of a frame.
//!
//! They count in steps (B. Widrow, I. Kollar 2008, Quantization Noise), cut off what is below the
//! black level, and fill pixels that were never observed with one number.

use crate::arithmetic::{Level, Real};
use crate::plane::part::{self, Question, Whole};
use crate::plane::sort::{Keys, median, ranked};

/// A fill value has more than one in so many of the pixels.
const FILL_SHARE: usize = 100;
/// One in so many of the pixels must lie on either side of a fill value that is inside the range.
const SIDE_SHARE: usize = 1000;
/// Inside the range there are so many times as many of a fill value as of any other.
const FILL_EXCESS: usize = 4;
/// Noise is spread over many values where the commonest has less than one in so many.
const SPREAD: usize = 6;
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
    /// Steps, fill and pile are read from a sample of at most [`crate::plane::sort::SAMPLES`]. Cost: two
    /// looks at each pixel and one sort of the sample.
    pub fn measure(pixels: &[f32], width: usize, allowed: impl Fn(usize) -> bool, keys: Keys<'_>) -> Values {
        Values::asked(None, pixels, width, allowed, keys).unwrap_or(Values::UNKNOWN)
    }

    /// The same of all parts of an image, where the pixels are one of them; `None` while others have yet to answer.
    pub(crate) fn asked(
        whole: Option<&dyn Whole>,
        pixels: &[f32],
        width: usize,
        allowed: impl Fn(usize) -> bool,
        mut keys: Keys<'_>,
    ) -> Option<Values> {
        let observed = |&at: &usize| allowed(at) && pixels.get(at).is_some_and(|pixel| pixel.is_finite());
        // One key for both zeros.
        let value = |at: usize| pixels.get(at).copied().unwrap_or(0.0) + 0.0;
        let asked = whole.map(|whole| (whole, Question::Values));
        let sampled = (pixels.len(), width, true);
        let sorted = part::sorted(asked, sampled, &mut keys, |at| observed(&at).then(|| value(at)))?;
        let mut fill = f32::NAN;
        if let Some(candidate) = fill_value(sorted) {
            let pairs = Pairs::asked(whole, pixels.len(), width, |at| observed(&at) && value(at) == candidate)?;
            if pairs.are_together(sorted.len(), occurrences(sorted, candidate)) {
                fill = candidate;
            }
        }
        let mut values = Values { fill, ..Values::UNKNOWN };
        let rest = || runs(sorted).filter(|run| run.value != fill);
        values.commonest = rest().reduce(commoner).map_or(0.0, |run| run.value);
        values.step = least_gap(rest().map(|run| run.value));
        let count: usize = rest().map(|run| run.count).sum();
        values.piled = rest().next().is_some_and(|least| least.count * PILE_SHARE > count);
        if let Some(most) = rest().last() {
            values.greatest = most.value;
            values.saturated = count >= SATURATED_FROM && most.count * PILE_SHARE > count;
        }
        values.span(whole, pixels, width, allowed)?;
        Some(values)
    }

    /// Whether a value is an observation.
    #[inline]
    pub fn holds(&self, value: f32) -> bool {
        value.is_finite() && value != self.fill
    }

    /// Counts the pixels, and takes the range that neighbours in a row reach together: one hot
    /// pixel does not widen it.
    fn span(
        &mut self,
        whole: Option<&dyn Whole>,
        pixels: &[f32],
        width: usize,
        allowed: impl Fn(usize) -> bool,
    ) -> Option<()> {
        let part = whole.map(Whole::part);
        let all = (0..width, 0..pixels.len().div_ceil(width.max(1)));
        let (columns, rows) = part.map_or(all, |part| (part.columns, part.rows));
        let mut range = Range { least: f32::MAX, greatest: f32::MIN };
        for (y, row) in pixels.chunks(width.max(1)).enumerate().take(rows.end).skip(rows.start) {
            // A part sees the pixel that its neighbour has on the left.
            let first = columns.start.saturating_sub(1);
            let row = row.get(first..columns.end.min(row.len())).unwrap_or(&[]);
            let own = (columns.start - first).min(row.len());
            let holds = |(x, &pixel): (usize, &f32)| self.holds(pixel) & allowed(y * width + x);
            if (first..).zip(row).fold(true, |all, pixel| all & holds(pixel)) {
                self.defined += (row.len() - own) as u32;
                range = range.with(row);
                continue;
            }
            let mut before = None;
            for (x, &pixel) in (first..).zip(row) {
                let seen = pixel.is_finite() && allowed(y * width + x);
                let defined = seen && self.holds(pixel);
                if x >= columns.start {
                    self.defined += u32::from(defined);
                    self.filled += u32::from(seen && !defined);
                    if let (Some(before), true) = (before, defined) {
                        range = range.with(&[before, pixel]);
                    }
                }
                before = defined.then_some(pixel);
            }
        }
        let Range { mut least, mut greatest } = range;
        if let Some(whole) = whole {
            let counts = [f64::from(self.defined), f64::from(self.filled), 0.0, 0.0];
            let own = |value: f32| [value.key()].into_iter().filter(move |_| least < f32::MAX);
            let sums = whole.sums(Question::Defined, &mut || counts);
            let keys = whole.words(Question::Least, &mut own(least));
            let others = whole.words(Question::Greatest, &mut own(greatest));
            let [defined, filled, ..] = sums?;
            (self.defined, self.filled) = (defined as u32, filled as u32);
            least = keys?.first().map_or(f32::MAX, |&key| f32::of_key(key));
            greatest = others?.last().map_or(f32::MIN, |&key| f32::of_key(key));
        }
        if greatest > least {
            self.resolution = greatest * RESOLUTION - least * RESOLUTION;
        }
        Some(())
    }
}

/// What neighbours in a row reach together.
#[derive(Clone, Copy)]
struct Range {
    least: f32,
    greatest: f32,
}

impl Range {
    /// With the neighbours of a piece of a row.
    fn with(self, row: &[f32]) -> Range {
        // Whole numbers with a sign, of which vector units find the least.
        let rank = |value: f32| (value.key() ^ 1 << 31) as i32;
        let ends = (rank(self.least), rank(self.greatest));
        let pairs = row.iter().zip(row.get(1..).unwrap_or(&[]));
        let (least, greatest) = pairs.fold(ends, |(least, greatest), (&before, &after)| {
            let (before, after) = (rank(before), rank(after));
            (least.min(before.max(after)), greatest.max(before.min(after)))
        });
        let value = |rank: i32| f32::of_key(rank as u32 ^ 1 << 31);
        Range { least: value(least), greatest: value(greatest) }
    }
}

/// Equal values among sorted ones.
#[derive(Clone, Copy, Debug)]
struct Run {
    value: f32,
    count: usize,
}

fn runs(sorted: &[u32]) -> impl Iterator<Item = Run> {
    let mut rest = sorted;
    core::iter::from_fn(move || {
        let first = *rest.first()?;
        let count = rest.iter().take_while(|&&key| key == first).count();
        rest = rest.get(count..).unwrap_or(&[]);
        Some(Run { value: f32::of_key(first), count })
    })
}

/// The more frequent of two values, the first where both are as frequent.
fn commoner(one: Run, other: Run) -> Run {
    if other.count > one.count { other } else { one }
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

/// A value that fills what was not observed: the commonest, or the least.
fn fill_value(sorted: &[u32]) -> Option<f32> {
    let commonest = runs(sorted).reduce(commoner);
    let candidates = [commonest, runs(sorted).next()];
    candidates.into_iter().flatten().find(|&run| is_fill(sorted, run)).map(|run| run.value)
}

/// Whether equal values are filling: far below the rest, or in its midst far more than there are of any
/// other. Noise that is coarse beside the steps gathers in few values too, but then in more than one.
fn is_fill(sorted: &[u32], fill: Run) -> bool {
    let (total, rest) = (sorted.len(), sorted.len() - fill.count);
    let first = sorted.partition_point(|&key| f32::of_key(key) < fill.value);
    let [below, above] = [0..first, first + fill.count..total].map(|side| sorted.get(side).unwrap_or(&[]));
    if fill.count * FILL_SHARE <= total || above.is_empty() {
        return false;
    }
    let others = || runs(sorted).filter(|run| run.value != fill.value);
    let most = others().reduce(commoner).unwrap_or(fill);
    let next = others().filter(|run| run.value != most.value).reduce(commoner).unwrap_or(most);
    let spread = most.count * SPREAD < rest;
    let nearest = ranked::<f32>(above, above.len() / 100) - fill.value;
    // Noise that is coarse has its commonest values on neighbouring steps.
    let far = spread || nearest >= APART_STEPS * (most.value - next.value).magnitude();
    if below.is_empty() && far && nearest > APART * (median::<f32>(above) - fill.value) {
        return true;
    }
    let amidst = |side: &[u32]| side.len() * SIDE_SHARE > total;
    spread && fill.count > FILL_EXCESS * most.count && amidst(below) && amidst(above)
}

/// How often one value is followed by itself.
struct Pairs {
    all: usize,
    followed: usize,
}

impl Pairs {
    fn count(places: impl Iterator<Item = usize>, width: usize, holds: impl Fn(usize) -> bool) -> Pairs {
        let mut pairs = Pairs { all: 0, followed: 0 };
        for at in places.filter(|&at| holds(at)) {
            pairs.all += 1;
            pairs.followed += usize::from(!(at + 1).is_multiple_of(width.max(1)) && holds(at + 1));
        }
        pairs
    }

    /// Of a frame of `count` pixels, or of all parts of an image.
    fn asked(whole: Option<&dyn Whole>, count: usize, width: usize, holds: impl Fn(usize) -> bool) -> Option<Pairs> {
        let Some(whole) = whole else { return Some(Pairs::count(0..count, width, holds)) };
        let mut own = || {
            let Pairs { all, followed } = Pairs::count(whole.part().own(width), width, &holds);
            [all as f64, followed as f64, 0.0, 0.0]
        };
        let [all, followed, ..] = whole.sums(Question::Filling, &mut own)?;
        Some(Pairs { all: all as usize, followed: followed as usize })
    }

    /// What most pixels hold is filled in where it lies together; zeros of a photon counter are strewn.
    fn are_together(&self, total: usize, count: usize) -> bool {
        let strewn = self.all.saturating_mul(total + count);
        2 * count <= total || 2 * self.followed.saturating_mul(total) > strewn
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sky::noise::tests::normal;

    extern crate std;
    use std::vec::Vec;

    const WIDTH: usize = 100;

    /// Noise without order in the frame.
    fn strewn(level: f32, noise: f32) -> Vec<f32> {
        let sorted = normal(WIDTH * WIDTH, level, noise);
        (0..sorted.len()).map(|at| sorted[at * 7919 % sorted.len()]).collect()
    }

    fn rounded(level: f32, noise: f32) -> Vec<f32> {
        strewn(level, noise).into_iter().map(libm::rintf).collect()
    }

    fn measured(pixels: &[f32]) -> Values {
        let (mut keys, mut spare) = (std::vec![0; pixels.len()], std::vec![0; pixels.len()]);
        Values::measure(pixels, WIDTH, |_| true, Keys(&mut keys, &mut spare))
    }

    #[test]
    fn the_step_is_that_of_the_counts() {
        assert_eq!(measured(&rounded(100.2, 3.0)).step, 1.0);
        let halves: Vec<f32> = rounded(100.2, 3.0).iter().map(|value| 0.5 * value).collect();
        assert_eq!(measured(&halves).step, 0.5);
        assert!(measured(&strewn(100.0, 3.0)).step < 1e-3);
        assert_eq!(measured(&[7.0; 300]).step, 0.0);
        // Rounding makes both zeros: they are one value.
        assert_eq!(measured(&rounded(0.0, 3.0)).step, 1.0);
    }

    #[test]
    fn what_fills_a_part_of_the_frame_is_undefined() {
        for (level, noise, whole) in [
            (0.0, 5.0, false),
            (100.0, 5.0, false),
            (-40.0, 5.0, false),
            (0.0, 5.0, true),
            (1000.0, 50.0, true),
            (20.0, 0.8, true),
        ] {
            // A few zeros more among those of the sky cannot be told.
            for columns in if whole && level == 0.0 { [30, 50] } else { [2, 75] } {
                let mut pixels = if whole { rounded(level, noise) } else { strewn(level, noise) };
                let filled = |at: usize| at % WIDTH < columns;
                let fill = if level < 0.0 { -999.0 } else { 0.0 };
                pixels.iter_mut().enumerate().filter(|(at, _)| filled(*at)).for_each(|(_, pixel)| *pixel = fill);
                let values = measured(&pixels);
                assert_eq!(values.fill, fill, "{columns} columns at {level}, noise {noise}: {values:?}");
                assert!(values.filled as usize >= columns * WIDTH, "{values:?}");
                assert_eq!(values.filled + values.defined, 10_000);
                assert!(!values.holds(fill) && values.holds(level + noise) && !values.piled);
            }
        }
    }

    #[test]
    fn what_a_detector_counts_is_no_fill() {
        let clipped = |level: f32| strewn(level, 1.0).into_iter().map(f32::positive).collect::<Vec<_>>();
        let photons: Vec<f32> = strewn(0.0, 1.0).iter().map(|value| if *value > 2.3 { 1.0 } else { 0.0 }).collect();
        // Divided by an exposure that differs from pixel to pixel.
        let exposed: Vec<f32> = photons.iter().zip(0..).map(|(count, at)| count / (1.0 + 1e-5 * at as f32)).collect();
        let mut off_grid = rounded(100.0, 0.3);
        off_grid.iter_mut().step_by(97).zip(0..).for_each(|(value, n)| *value += 0.001 * n as f32);
        let mut saturated = strewn(100.0, 5.0);
        saturated[500..700].fill(60_000.0);
        for (name, pixels) in [
            ("coarse counts", rounded(100.0, 0.3)),
            ("counts", rounded(100.0, 3.0)),
            ("a cut at 0", clipped(0.0)),
            ("a cut above the sky", clipped(-1.0)),
            ("photons", photons),
            ("photons by exposure", exposed),
            ("values off the steps", off_grid),
            ("a saturated star", saturated),
        ] {
            let values = measured(&pixels);
            assert!(values.fill.is_nan() && values.filled == 0, "{name}: {values:?}");
        }
    }

    #[test]
    fn a_cut_below_or_above_is_seen() {
        let cut = |pixels: Vec<f32>| {
            let values = measured(&pixels);
            (values.piled, values.saturated)
        };
        assert_eq!(cut(strewn(100.0, 3.0)), (false, false));
        assert_eq!(cut(strewn(1.0, 1.0).into_iter().map(f32::positive).collect()), (true, false));
        assert_eq!(cut(strewn(254.0, 1.0).into_iter().map(|value| value.least(255.0)).collect()), (false, true));
        // A window has too few pixels to tell.
        assert!(!measured(&[1.0, 2.0, 3.0, 3.0]).saturated);
    }

    #[test]
    fn a_hot_pixel_does_not_widen_the_range() {
        let mut pixels = strewn(100.0, 5.0);
        let quiet = measured(&pixels).resolution;
        pixels[5050] = 1e9;
        pixels[7070] = -1e9;
        let hot = measured(&pixels).resolution;
        assert!((0.7..1.4).contains(&(hot / quiet)), "{hot} beside {quiet}");
        assert!(measured(&[f32::MIN, f32::MIN, f32::MAX, f32::MAX]).resolution.is_finite());
        assert_eq!(measured(&[f32::NAN; 9]).defined, 0);
    }
}
