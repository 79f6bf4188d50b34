//! What the detector, and the software behind it, did to the values of a frame.
//!
//! They count in steps (B. Widrow, I. Kollar 2008, Quantization Noise), cut off what is below the
//! black level, and fill pixels that were never observed with one number.

use crate::arithmetic::codec::Codec;
use crate::arithmetic::{Level, Real};
use crate::plane::part::{self, Question, Whole};
use crate::plane::raster::{Raster, Sample, mixed};
use crate::plane::sort::{Keys, SAMPLES, median, ranked};
use crate::plane::walk::Walk;
use core::ops::Range;

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
/// So many in ten of the pixels, or more, have one value where the noise is about a step of the values or less.
const COARSE_TENTHS: usize = 4;
/// Fewer values do not tell a saturated sky from chance.
const SATURATED_FROM: usize = 1000;
/// The part of the range of a frame that is taken for exact: single precision resolves a little more.
const RESOLUTION: f32 = 1.0 / (1 << 20) as f32;

/// Pixels that are looked at together.
const PIECE: usize = 64;

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
    /// Whether more than four tenths of them have one value: the noise is about a step of the values or less.
    pub coarse: bool,
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
    /// A checksum over the values of all pixels by their places, where they can change while they are read
    /// ([`Sample::CHANGES`]); else 0.
    pub checksum: u32,
}

impl Values {
    /// Nothing is known: every finite value is as good as another.
    pub const UNKNOWN: Values = Values {
        step: 0.0,
        fill: f32::NAN,
        filled: 0,
        defined: 0,
        piled: false,
        coarse: false,
        saturated: false,
        greatest: 0.0,
        resolution: 0.0,
        commonest: 0.0,
        checksum: 0,
    };

    /// Looks at the pixels of a frame, row-major in rows of `width`, that are finite and `allowed`.
    /// Steps, fill and pile are read from a sample of at most [`crate::plane::sort::SAMPLES`]. Cost: two
    /// looks at each pixel and one sort of the sample.
    pub fn measure(pixels: &[f32], width: usize, allowed: impl Fn(usize) -> bool, keys: Keys<'_>) -> Values {
        let mut look = Look::NOTHING;
        let _ = look.step(&mut Walk::whole(), None, &Raster::of(pixels, width), allowed, keys);
        look.values
    }

    /// Whether a value is an observation.
    #[inline]
    pub fn holds(&self, value: f32) -> bool {
        value.is_finite() && value != self.fill
    }

    /// What sorted values of a sample tell, where `fill` is none of them.
    fn of_sample(sorted: &[u32], fill: f32) -> Values {
        let mut values = Values { fill, ..Values::UNKNOWN };
        let rest = || runs(sorted).filter(|run| run.value != fill);
        values.commonest = rest().reduce(commoner).map_or(0.0, |run| run.value);
        values.step = least_gap(rest().map(|run| run.value));
        let count: usize = rest().map(|run| run.count).sum();
        values.coarse = rest().any(|run| 10 * run.count > COARSE_TENTHS * count);
        values.piled = rest().next().is_some_and(|least| least.count * PILE_SHARE > count);
        if let Some(most) = rest().last() {
            values.greatest = most.value;
            values.saturated = count >= SATURATED_FROM && most.count * PILE_SHARE > count;
        }
        values
    }
}

/// Values that are looked at, part by part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    pub values: Values,
    /// What may be filling; NaN for nothing.
    candidate: f32,
    /// How often it is in the sample.
    occurrences: usize,
    pairs: Pairs,
    /// The least and the greatest value that neighbours reach together.
    span: (f32, f32),
}

impl Look {
    /// Before the first look.
    pub const NOTHING: Look = Look {
        values: Values::UNKNOWN,
        candidate: f32::NAN,
        occurrences: 0,
        pairs: Pairs { all: 0, followed: 0 },
        span: (f32::MAX, f32::MIN),
    };

    /// The list of fields, out or in.
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        let Values { step, fill, filled, defined, piled, coarse, saturated, greatest, resolution, commonest, checksum } =
            &mut self.values;
        for real in [step, fill, greatest, resolution, commonest, &mut self.candidate] {
            codec.real(real)?;
        }
        for word in [filled, defined, checksum] {
            codec.word(word)?;
        }
        codec.flag(piled)?;
        codec.flag(coarse)?;
        codec.flag(saturated)?;
        for count in [&mut self.occurrences, &mut self.pairs.all, &mut self.pairs.followed] {
            codec.size(count)?;
        }
        codec.real(&mut self.span.0)?;
        codec.real(&mut self.span.1)
    }

    /// [`Values::measure`] in parts, and of all parts of an image, where the frame is one of them: while others have yet
    /// to answer, the values are unknown.
    pub fn step<P: Sample>(
        &mut self,
        walk: &mut Walk,
        whole: Option<&dyn Whole>,
        frame: &Raster<'_, P>,
        allowed: impl Fn(usize) -> bool,
        mut keys: Keys<'_>,
    ) -> Option<()> {
        /// Looks at each value of the sample, of the search for what is filling and of what the sample tells.
        const LOOKS: usize = 10;
        let (count, width) = (frame.count(), frame.width);
        // One key for both zeros.
        let observed = |at: usize| {
            let value = if allowed(at) { frame.value(at) } else { None };
            value.filter(|value| value.is_finite()).map(|value| value + 0.0)
        };
        let asked = whole.map(|whole| (whole, Question::Values));
        let sampled = (count, width, true);
        let Some(sorted) = part::sorted(walk, asked, sampled, &mut keys, observed)? else { return Some(()) };
        let looks = LOOKS * count.min(SAMPLES);
        walk.once(looks, || {
            *self = Look { candidate: fill_value(sorted).unwrap_or(f32::NAN), ..Look::NOTHING };
            self.occurrences = occurrences(sorted, self.candidate);
        })?;
        let candidate = self.candidate;
        let holds = |at: usize| observed(at) == Some(candidate);
        let is_asked = whole.is_some() && !candidate.is_nan();
        if let Some(whole) = whole.filter(|_| is_asked) {
            let Some(pairs) = Pairs::asked(whole, width, holds) else { return Some(()) };
            self.pairs = pairs;
        }
        let rows = if is_asked || candidate.is_nan() { 0 } else { frame.height };
        walk.pass(rows, width, |rows| self.pairs.count(rows.start * width..rows.end * width, width, holds))?;
        walk.once(looks, || {
            let is_filled = !candidate.is_nan() && self.pairs.are_together(sorted.len(), self.occurrences);
            self.values = Values::of_sample(sorted, if is_filled { candidate } else { f32::NAN });
        })?;
        let (columns, rows) =
            whole.map(Whole::part).map_or((0..width, 0..frame.height), |part| (part.columns, part.rows));
        walk.pass(rows.len(), width, |part| {
            self.span((columns, rows.start + part.start..rows.start + part.end), frame, allowed);
        })?;
        walk.once(1, || self.end(whole))
    }

    /// Counts the pixels of some rows, and takes the range that neighbours in a row reach together: one hot
    /// pixel does not widen it.
    fn span<P: Sample>(
        &mut self,
        (columns, rows): (Range<usize>, Range<usize>),
        frame: &Raster<'_, P>,
        allowed: impl Fn(usize) -> bool,
    ) {
        let (width, mut reach) = (frame.width, Reach { least: self.span.0, greatest: self.span.1 });
        let Look { values, .. } = self;
        // A part sees the pixel that its neighbour has on the left.
        let first = columns.start.saturating_sub(1);
        for y in rows {
            let pieces = frame.part(y, first..columns.end).chunks(PIECE);
            let mut before = None;
            for (x, pixels) in (first..).step_by(PIECE).zip(pieces) {
                let mut piece = [0.0; PIECE];
                piece.iter_mut().zip(pixels).for_each(|(value, pixel)| *value = pixel.value());
                let places = y * width + x..;
                let piece = piece.get(..pixels.len()).unwrap_or(&[]);
                if P::CHANGES {
                    let sum = |sum: u32, (at, &pixel): (usize, &f32)| sum.wrapping_add(mixed(at as u32, pixel));
                    values.checksum = places.clone().zip(piece).fold(values.checksum, sum);
                }
                // Apart: of the first vector units make one question, and of the second nobody asks where nothing is known.
                let holds = |pixel: f32| pixel.is_finite() & (pixel != values.fill);
                if piece.iter().fold(true, |all, &pixel| all & holds(pixel))
                    && places.clone().zip(piece).all(|(at, _)| allowed(at))
                {
                    values.defined += (piece.len() - usize::from(x < columns.start)) as u32;
                    reach = reach.with(piece).after(before, piece.first().copied());
                    before = piece.last().copied();
                    continue;
                }
                for (x, (at, &pixel)) in (x..).zip(places.zip(piece)) {
                    let seen = pixel.is_finite() && allowed(at);
                    let defined = Some(pixel).filter(|&pixel| seen && values.holds(pixel));
                    if x >= columns.start {
                        values.defined += u32::from(defined.is_some());
                        values.filled += u32::from(seen && defined.is_none());
                        reach = reach.after(before, defined);
                    }
                    before = defined;
                }
            }
        }
        self.span = (reach.least, reach.greatest);
    }

    /// What the counts of all parts tell; of one of them, where others have yet to answer.
    fn end(&mut self, whole: Option<&dyn Whole>) {
        if self.ask(whole).is_none() {
            self.values = Values::UNKNOWN;
        }
        let (least, greatest) = self.span;
        if greatest > least {
            self.values.resolution = greatest * RESOLUTION - least * RESOLUTION;
        }
    }

    fn ask(&mut self, whole: Option<&dyn Whole>) -> Option<()> {
        if let Some(whole) = whole {
            let (Values { defined, filled, .. }, (least, greatest)) = (self.values, self.span);
            let counts = [f64::from(defined), f64::from(filled), 0.0, 0.0];
            let own = |value: f32| [value.key()].into_iter().filter(move |_| least < f32::MAX);
            let sums = whole.sums(Question::Defined, &mut || counts);
            let keys = whole.words(Question::Least, &mut own(least));
            let others = whole.words(Question::Greatest, &mut own(greatest));
            let [defined, filled, ..] = sums?;
            (self.values.defined, self.values.filled) = (defined as u32, filled as u32);
            let least = keys?.first().map_or(f32::MAX, |&key| f32::of_key(key));
            let greatest = others?.last().map_or(f32::MIN, |&key| f32::of_key(key));
            self.span = (least, greatest);
        }
        Some(())
    }
}

/// What neighbours in a row reach together.
#[derive(Clone, Copy)]
struct Reach {
    least: f32,
    greatest: f32,
}

impl Reach {
    /// With two neighbours, if both are defined.
    fn after(self, before: Option<f32>, pixel: Option<f32>) -> Reach {
        before.zip(pixel).map_or(self, |(before, pixel)| self.with(&[before, pixel]))
    }

    /// With the neighbours in a piece of a row.
    fn with(self, row: &[f32]) -> Reach {
        // Whole numbers with a sign, of which vector units find the least.
        let rank = |value: f32| (value.key() ^ 1 << 31) as i32;
        let ends = (rank(self.least), rank(self.greatest));
        let pairs = row.iter().zip(row.get(1..).unwrap_or(&[]));
        let (least, greatest) = pairs.fold(ends, |(least, greatest), (&before, &after)| {
            let (before, after) = (rank(before), rank(after));
            (least.min(before.max(after)), greatest.max(before.min(after)))
        });
        let value = |rank: i32| f32::of_key(rank as u32 ^ 1 << 31);
        Reach { least: value(least), greatest: value(greatest) }
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
#[derive(Clone, Copy, Debug)]
struct Pairs {
    all: usize,
    followed: usize,
}

impl Pairs {
    fn count(&mut self, places: impl Iterator<Item = usize>, width: usize, holds: impl Fn(usize) -> bool) {
        for at in places.filter(|&at| holds(at)) {
            self.all += 1;
            self.followed += usize::from(!(at + 1).is_multiple_of(width.max(1)) && holds(at + 1));
        }
    }

    /// Of all parts of an image.
    fn asked(whole: &dyn Whole, width: usize, holds: impl Fn(usize) -> bool) -> Option<Pairs> {
        let mut own = || {
            let mut pairs = Pairs { all: 0, followed: 0 };
            pairs.count(whole.part().own(width), width, &holds);
            [pairs.all as f64, pairs.followed as f64, 0.0, 0.0]
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
    fn every_pixel_of_a_whole_frame_is_defined() {
        let values = measured(&strewn(100.0, 3.0));
        assert_eq!((values.defined, values.filled), (10_000, 0));
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

    #[test]
    fn a_fill_value_is_farther_from_the_rest_than_three_tenths_of_the_way_to_its_median() {
        let is_fill_below = |nearest: f32| {
            let rest = (0..20).map(|n| 10.0 + (n as f32 - 9.0) / 8.0);
            let sorted: Vec<u32> = [0.0; 5].into_iter().chain([nearest]).chain(rest).map(f32::key).collect();
            is_fill(&sorted, Run { value: 0.0, count: 5 })
        };
        assert!(!is_fill_below(3.0) && is_fill_below(3.001));
    }
}
