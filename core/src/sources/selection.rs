//! Which regions are sources: by area, or by their significance in an image matched to their size.

use crate::arithmetic::codec::Codec;
use crate::arithmetic::{Level, Real};
use crate::config::{Config, Select, Separate, narrow_area, part_area};
use crate::plane::crew::Crew;
use crate::plane::grid::Grid;
use crate::plane::mask::Mask;
use crate::plane::part::{Question, Whole};
use crate::plane::raster::Sample;
use crate::plane::rows::next_with;
use crate::plane::smooth::Weights;
use crate::plane::sort::Keys;
use crate::plane::walk::Walk;
use crate::sky::tail::Tail;
use crate::sky::view::{Known, View};
use crate::sources::centre::each_pixel;
use crate::sources::significance::height;
use crate::sources::tree::Region;

/// Scale of the matched image, pixels.
const MATCHED: f32 = 1.7;
/// Scale of what is taken from it, pixels.
const WIDE: f32 = 2.5;
/// How much the matched image is sharpened: what lies on the halo of a bright source must stand
/// above that, and what is narrow is brighter than smoothing lets it be.
const SHARPENING: f32 = 0.6;
/// The same for the narrow image, in which little is left of what is wider than a star.
const NARROW_WIDE: f32 = 3.4;
/// See [`NARROW_WIDE`].
const NARROW_SHARPENING: f32 = 3.0;
/// What stands out there by so many times the height that noise reaches is no unevenness of a wide source.
const STANDS_OUT: f32 = 1.2;
/// It needs this part of the smallest peak and light.
const LENIENCY: f32 = 0.5;
/// The noise of the matched image where that of every pixel is 1 and its own.
const WHITE: f32 = 0.219_635;
/// The same of the narrow image.
const NARROW_WHITE: f32 = 0.519_534;
/// By so much less counts a peak in the outermost row or column of the image, and in the next. Planes are
/// mirrored at the border, where pixels are summed up with themselves: white noise of the matched image is
/// 1.38 and 1.17 times as large there. These pixels are few, so that more of it may be let pass in each.
const AT_BORDER: [f32; 2] = [0.8, 0.92];
/// So many deviations of the noise that the caller knows of, and the frame does not have, could take light away.
const UNSEEN: f32 = 2.0;
/// Rounds of the cut on significance, which depends on the number of sources it leaves.
const CUTS: u32 = 4;

/// The planes of these steps, W x H each, and the table of regions.
#[derive(Debug)]
pub struct Planes<'m, L: Level> {
    /// Signal-to-noise.
    pub signal: &'m [L],
    /// The matched image, in the end.
    pub matched: &'m mut [L],
    /// The narrow image, in the end.
    pub narrow: &'m mut [L],
    /// The pixels near sources.
    pub masked: Mask<'m>,
    /// Room for rows.
    pub rows: &'m mut [L],
    /// Scratch for sorting.
    pub keys: Keys<'m>,
    /// The labels: 1 + the index of a region.
    pub labels: &'m mut [u32],
    /// The regions.
    pub regions: &'m mut [Region<L>],
}

/// The cut on significance: how high above noise a source's peak in the matched image must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// In the noise of the image; 0 where none is asked for.
    pub significance: f32,
    /// The noise of the matched image.
    matched: Noise,
    /// The noise of the narrow image.
    narrow: Noise,
}

impl Cut {
    /// Every peak will do.
    pub const NONE: Cut = Cut { significance: 0.0, matched: Noise::ONE, narrow: Noise::ONE };
}

/// The noise of an image in which peaks are sought.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Noise {
    /// What is measured, or what the given noise of the pixels would make of it where that is more.
    size: f32,
    /// How much less is measured.
    unseen: f32,
}

impl Noise {
    const ONE: Noise = Noise { size: 1.0, unseen: 0.0 };

    /// Noise as measured in an image to which independent pixels of noise 1 bring `white`.
    fn of(measured: f32, white: f32, known: Known<'_>) -> Noise {
        let white = if known.noise.is_some() && !known.relative { white } else { 0.0 };
        Noise { size: measured.greatest(white), unseen: (white - measured).positive() }
    }

    /// A value in units of it.
    fn units(&self, value: f32) -> f32 {
        if self.size > 0.0 { (value - UNSEEN * self.unseen) / self.size } else { f32::MAX }
    }
}

/// Sources that are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Their number.
    pub sources: u32,
    /// Their pixels.
    pub pixels: u32,
}

/// What the cut is found by, part by part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cutting<L> {
    /// The noise of the narrow image.
    pub narrow: Tail<L>,
    /// That of the matched image.
    pub matched: Tail<L>,
    /// That of the steps in it.
    pub slope: Tail<L>,
    /// Sources that may be false.
    pub allowed: f32,
    /// The cut.
    pub cut: Cut,
}

impl<L: Level> Cutting<L> {
    /// Nothing is known.
    pub const NOTHING: Cutting<L> =
        Cutting { narrow: Tail::UNKNOWN, matched: Tail::UNKNOWN, slope: Tail::UNKNOWN, allowed: 0.0, cut: Cut::NONE };

    /// The list of fields, out or in.
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        for tail in [&mut self.narrow, &mut self.matched, &mut self.slope] {
            tail.code(codec)?;
        }
        let Cut { significance, matched, narrow } = &mut self.cut;
        for real in [&mut self.allowed, significance] {
            codec.real(real)?;
        }
        for Noise { size, unseen } in [matched, narrow] {
            codec.real(size)?;
            codec.real(unseen)?;
        }
        Ok(())
    }
}

/// Measures every region, and finds the cut on the peak in the matched image. Means nothing while other parts of the
/// image have yet to answer.
pub(crate) fn cut<L: Level, P: Sample>(
    (walk, crew): (&mut Walk, &impl Crew),
    cutting: &mut Cutting<L>,
    view: &View<'_, P>,
    config: &Config,
    work: &mut Planes<'_, L>,
) -> Option<()> {
    let (grid, width) = (view.grid, view.grid.width.get());
    walk.pass(grid.height, 2 * width, |rows| {
        Weights::gauss(MATCHED).apply_rows(rows, work.signal, work.rows, work.matched, grid, crew);
    })?;
    measure_narrow((walk, crew), &mut cutting.narrow, view, work)?;
    walk.pass(grid.height, 2 * width, |rows| {
        Weights::gauss(WIDE).sharpen_rows(rows, work.matched, work.rows, grid, SHARPENING, crew);
    })?;
    measure((walk, crew), view, work)?;
    let matched = |at: usize| work.matched.get(at).copied().unwrap_or(L::ZERO);
    let questions = [Question::Matched, Question::MatchedPowers];
    view.tail(walk, (&mut cutting.matched, questions), matched, work.masked, work.keys.again())?;
    // The last of a row has no next one: its step is back.
    let next = |at: usize| if (at + 1).is_multiple_of(grid.width.get()) { at.wrapping_sub(1) } else { at + 1 };
    let step = |at: usize| matched(next(at)) - matched(at);
    let questions = [Question::Slope, Question::SlopePowers];
    view.tail(walk, (&mut cutting.slope, questions), step, work.masked, work.keys.again())?;
    let Cutting { narrow, matched: tail, slope, allowed, cut } = cutting;
    let [noise, narrow_noise, slope] = [tail.noise, narrow.noise, slope.noise].map(L::to_f32);
    let matched = Noise::of(noise, WHITE, view.known);
    let narrow = Noise::of(narrow_noise, NARROW_WHITE, view.known);
    let roughness = if noise > 0.0 { slope / noise } else { 0.0 };
    let (columns, rows) = view.image();
    let elements = (columns * rows) as f32 * roughness * roughness;
    walk.once(1, || {
        *cut = Cut { significance: 0.0, matched, narrow };
        *allowed = config.significance.false_sources;
    })?;
    // What reaches how far can only be told in the noise of all parts.
    if view.known.whole.is_some_and(Whole::is_waiting) {
        return Some(());
    }
    let reaches = view.known.whole.map(|whole| reaches(whole, grid, config, *cut, work));
    for _ in 0..CUTS {
        walk.once(8, || cut.significance = tail.raised(height(elements, *allowed)))?;
        let own = if reaches.is_none() { work.regions.len() } else { 0 };
        walk.tally(own, 1, |tally, part| {
            let before = if part.start == 0 { 0 } else { tally.count };
            let some = work.regions.get(part).unwrap_or(&[]).iter();
            tally.count = before + some.filter(|region| is_source(region, config, *cut)).count();
        })?;
        let kept = match reaches {
            None => walk.tally.count,
            Some(reaches) => reaches.len() - reaches.partition_point(|&key| key < Level::key(cut.significance)),
        };
        walk.once(1, || {
            let share = config.significance.false_share * kept as f32;
            *allowed = if share > *allowed { share } else { *allowed };
        })?;
    }
    Some(())
}

/// The narrow image, and the noise of it, from the matched image before it is sharpened.
fn measure_narrow<L: Level, P: Sample>(
    (walk, crew): (&mut Walk, &impl Crew),
    noise: &mut Tail<L>,
    view: &View<'_, P>,
    work: &mut Planes<'_, L>,
) -> Option<()> {
    let (grid, width) = (view.grid, view.grid.width.get());
    walk.pass(grid.height, 2 * width, |rows| {
        let (from, narrow) = (&*work.matched, (&mut *work.narrow, NARROW_SHARPENING));
        Weights::gauss(NARROW_WIDE).sharpen_into(rows, from, work.rows, narrow, grid, crew);
    })?;
    let narrow = |at: usize| work.narrow.get(at).copied().unwrap_or(L::ZERO);
    let questions = [Question::Narrow, Question::NarrowPowers];
    view.tail(walk, (noise, questions), narrow, work.masked, work.keys.again())
}

/// How far up in significance what may be a source in any part of an image is one: sorted keys. Each is told by the part
/// that has its first pixel.
fn reaches<'w, L: Level>(
    whole: &'w dyn Whole,
    grid: Grid,
    config: &Config,
    cut: Cut,
    work: &mut Planes<'_, L>,
) -> &'w [u32] {
    /// In place of a label: who has the first pixel.
    const OWN: u32 = 1;
    const FOREIGN: u32 = 2;
    let part = whole.part();
    for (at, &label) in work.labels.iter().enumerate() {
        if let Some(region) = work.regions.get_mut((label as usize).wrapping_sub(1))
            && region.label == 0
        {
            region.label = if part.owns(grid.place(at)) { OWN } else { FOREIGN };
        }
    }
    let own = work.regions.iter().filter(|region| region.label == OWN);
    let mut keys = own.map(|region| reach(region, config, cut)).filter(|&reach| reach >= 0.0).map(Level::key);
    let reaches = whole.words(Question::Reaches, &mut keys).unwrap_or(&[]);
    work.regions.iter_mut().for_each(|region| region.label = 0);
    reaches
}

/// Area, light and matched peak of every region, from its pixels, and its peaks in the narrow image and in
/// the matched one, of which those at the border count for less. By area alone the images mean nothing, and
/// neither do the peaks.
pub(crate) fn measure<L: Level, P: Sample>(
    (walk, crew): (&mut Walk, &impl Crew),
    view: &View<'_, P>,
    work: &mut Planes<'_, L>,
) -> Option<()> {
    walk.pass(work.regions.len(), 1, |part| {
        for region in work.regions.get_mut(part).unwrap_or(&mut []) {
            (region.area, region.sum, region.value, region.label) = (0, L::NOTHING, L::ZERO, 0);
            region.offsets = (0.0, 0.0);
        }
    })?;
    let ((columns, rows), (left, bottom)) = (view.image(), view.origin());
    let weight = |at: usize, length: usize| AT_BORDER.get(at.min(length.saturating_sub(at + 1))).unwrap_or(&1.0);
    let (narrow, matched, signal) = (&*work.narrow, &*work.matched, work.signal);
    each_pixel((walk, crew), (view.grid, work.labels), work.regions, |region, at, (x, y)| {
        if let (Some(narrow), Some(&matched), Some(&signal)) = (narrow.get(at), matched.get(at), signal.get(at)) {
            region.area += 1;
            region.sum = region.sum + signal.times(1);
            if matched > region.value {
                region.value = matched;
            }
            let peaks = region.offsets;
            let weight = weight(left + x, columns) * weight(bottom + y, rows);
            let (narrow, matched) = (narrow.to_f32() * weight, matched.to_f32() * weight);
            region.offsets = (peaks.0.greatest(narrow), peaks.1.greatest(matched));
        }
    })
}

/// Whether a region is a source at a cut.
fn is_source<L: Level>(region: &Region<L>, config: &Config, cut: Cut) -> bool {
    match config.select {
        Select::Area => region.area > 0 && region.area >= config.min_area,
        Select::Significance => reach(region, config, cut) >= cut.significance,
    }
}

/// The greatest significance of a cut at which a region is a source; -1 for none. What was not divided from another
/// and stands out in the narrow image needs less area, peak and light.
fn reach<L: Level>(region: &Region<L>, config: &Config, cut: Cut) -> f32 {
    let divided = config.separate == Separate::Tree && region.divided > 0;
    let least_area = if divided { part_area(config.min_area) } else { config.min_area };
    let (peak, light) = (config.significance.peak * config.outline.threshold, config.significance.light);
    let enough = |part: f32, least_area: u32| {
        region.area >= least_area
            && region.value >= L::of(part * peak)
            && region.sum >= L::share(L::ONE.times(1), part * light)
    };
    let (narrow, matched) = region.offsets;
    let (narrow, matched) = (cut.narrow.units(narrow), cut.matched.units(matched));
    if enough(1.0, least_area) {
        matched
    } else if !divided && enough(LENIENCY, narrow_area(config.min_area)) {
        matched.least(narrow / STANDS_OUT)
    } else {
        -1.0
    }
}

/// Drops what is no source and numbers the rest in raster order.
pub(crate) fn keep<L: Level>(
    walk: &mut Walk,
    kept: &mut Kept,
    (config, cut): (&Config, Cut),
    labels: &mut [u32],
    regions: &mut [Region<L>],
) -> Option<()> {
    walk.pass(labels.len(), 1, |part| {
        let mut next = part.start;
        while let Some(at) = next_with(labels.get(..part.end).unwrap_or(&[]), next, u32::MAX) {
            next = at + 1;
            let Some(label) = labels.get_mut(at) else { break };
            let Some(region) = regions.get_mut((*label as usize).wrapping_sub(1)) else { continue };
            if region.label == 0 && is_source(region, config, cut) {
                kept.sources += 1;
                region.label = kept.sources;
            }
            *label = region.label;
            kept.pixels += u32::from(*label != 0);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::crew::Alone;
    use crate::plane::smooth::ROOM_ROWS;

    extern crate std;

    /// The noise that independent pixels of noise 1 bring to a filtered image: the root of the sum of the squares of
    /// what becomes of one pixel.
    #[test]
    fn white_noise_is_what_the_filters_make_of_one_pixel() {
        const SIDE: usize = 64;
        let grid = Grid::of(SIDE * SIDE, SIDE).unwrap();
        let mut one = std::vec![0.0f32; SIDE * SIDE];
        one[SIDE / 2 * SIDE + SIDE / 2] = 1.0;
        for (wide, strength, white) in [(WIDE, SHARPENING, WHITE), (NARROW_WIDE, NARROW_SHARPENING, NARROW_WHITE)] {
            let (mut plane, mut room) = (one.clone(), std::vec![0.0; ROOM_ROWS * SIDE]);
            Weights::gauss(MATCHED).apply(&one, &mut room, &mut plane, grid, &Alone);
            Weights::gauss(wide).sharpen(&mut plane, &mut room, grid, strength, &Alone);
            let power: f64 = plane.iter().map(|&value| f64::from(value).powi(2)).sum();
            assert!((power.sqrt() / f64::from(white) - 1.0).abs() < 1e-5, "{} beside {white}", power.sqrt());
        }
    }

    #[test]
    fn noise_that_is_given_is_believed_where_the_frame_has_less() {
        let map = [1.0];
        let given = Known { noise: Some(&map), ..Known::default() };
        for (known, measured, size, unseen) in [
            (Known::default(), 0.1, 0.1, 0.0),
            (Known { relative: true, ..given }, 0.1, 0.1, 0.0),
            (given, 0.8, 0.8, 0.0),
            (given, 0.1, 0.5, 0.4),
            (given, 0.0, 0.5, 0.5),
        ] {
            assert_eq!(Noise::of(measured, 0.5, known), Noise { size, unseen });
        }
        // Twice what is unseen could take light away.
        let noise = Noise::of(0.1, 0.5, given);
        assert_eq!(noise.units(3.3), 5.0);
        assert_eq!(Noise::of(0.0, 0.5, Known::default()).units(1.0), f32::MAX);
    }

    #[test]
    fn a_source_has_at_least_the_area_the_peak_and_the_light_that_are_asked() {
        let config = Config { min_area: 5, ..Config::NOISE_AWARE };
        let (peak, light) = (config.significance.peak * config.outline.threshold, config.significance.light);
        let least = Region::<f32> { area: 5, value: peak, sum: light.into(), offsets: (0.0, 9.0), ..Region::BLANK };
        assert_eq!(reach(&least, &config, Cut::NONE), 9.0);
        for less in [
            Region { area: 4, ..least },
            Region { value: 0.99 * peak, ..least },
            Region { sum: 0.99 * least.sum, ..least },
        ] {
            assert!(reach(&less, &config, Cut::NONE) < 9.0, "{less:?}");
        }
    }
}
