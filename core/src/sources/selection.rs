//! Which regions are sources: by area, or by their significance in an image matched to their size.

use crate::arithmetic::Level;
use crate::config::{Config, Select, Separate, part_area};
use crate::plane::crew::Crew;
use crate::plane::grid::Grid;
use crate::plane::part::{Question, Whole};
use crate::plane::rows::{next_with, used};
use crate::plane::smooth::Weights;
use crate::plane::sort::Keys;
use crate::sky::view::View;
use crate::sources::significance::height;
use crate::sources::tree::Region;

/// Scale of the matched image, pixels.
const MATCHED: f32 = 1.7;
/// Scale of what is taken from it, pixels.
const WIDE: f32 = 2.5;
/// How much the matched image is sharpened: what lies on the halo of a bright source must stand
/// above that, and what is narrow is brighter than smoothing lets it be.
const SHARPENING: f32 = 0.6;
/// Rounds of the cut on significance, which depends on the number of sources it leaves.
const CUTS: u32 = 4;

/// The planes of these steps, W x H each, and the table of regions.
#[derive(Debug)]
pub struct Planes<'m, L: Level> {
    /// Signal-to-noise.
    pub signal: &'m [L],
    /// The matched image, in the end.
    pub matched: &'m mut [L],
    /// 1 near sources, 0 on sky.
    pub masked: &'m [L],
    /// Scratch.
    pub scratch: &'m mut [L],
    /// Scratch for sorting.
    pub keys: Keys<'m>,
    /// The labels: 1 + the index of a region.
    pub labels: &'m mut [u32],
    /// The regions.
    pub regions: &'m mut [Region<L>],
}

/// The least peak of a source in the matched image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut<L> {
    /// In its noise; 0 where none is asked for.
    pub significance: f32,
    /// In units of the signal.
    pub least: L,
}

impl<L: Level> Cut<L> {
    /// Every peak will do.
    pub const NONE: Cut<L> = Cut { significance: 0.0, least: L::ZERO };
}

/// Sources that are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Their number.
    pub sources: u32,
    /// Their pixels.
    pub pixels: u32,
}

/// Measures every region, and finds the cut on the peak in the matched image. Means nothing while other parts of the
/// image have yet to answer.
pub fn cut<L: Level>(view: &View<'_>, config: &Config, work: &mut Planes<'_, L>, crew: &impl Crew) -> Cut<L> {
    let grid = view.grid;
    Weights::gauss(MATCHED).apply(work.signal, work.scratch, work.matched, grid, crew);
    Weights::gauss(WIDE).sharpen(work.matched, work.scratch, grid, SHARPENING, crew);
    measure(work);
    let peaks = view.known.whole.map(|whole| peaks(whole, grid, config, work));
    let matched = |at: usize| work.matched.get(at).copied().unwrap_or(L::ZERO);
    let questions = [Question::Matched, Question::MatchedPowers];
    let tail = view.tail(questions, matched, work.masked, work.keys.again());
    let noise = tail.noise.to_f32();
    // The last of a row has no next one: its step is back.
    let next = |at: usize| if (at + 1).is_multiple_of(grid.width.get()) { at.wrapping_sub(1) } else { at + 1 };
    let step = |at: usize| matched(next(at)) - matched(at);
    let questions = [Question::Slope, Question::SlopePowers];
    let slope = view.tail(questions, step, work.masked, work.keys.again()).noise.to_f32();
    let roughness = if noise > 0.0 { slope / noise } else { 0.0 };
    let (columns, rows) = view.image();
    let elements = (columns * rows) as f32 * roughness * roughness;
    let floor = config.significance.peak * config.outline.threshold;
    let (mut allowed, mut cut) = (config.significance.false_sources, Cut { significance: 0.0, least: L::of(floor) });
    for _ in 0..CUTS {
        let significance = tail.raised(height(elements, allowed));
        let least = significance * noise;
        cut = Cut { significance, least: L::of(if least > floor { least } else { floor }) };
        let kept = match peaks {
            None => work.regions.iter().filter(|region| is_source(region, config, cut)).count(),
            Some(peaks) => peaks.len() - peaks.partition_point(|&key| key < cut.least.key()),
        };
        let share = config.significance.false_share * kept as f32;
        allowed = if share > allowed { share } else { allowed };
    }
    cut
}

/// The peaks of what may be a source in all parts of an image, sorted keys; each source is told by the part that has its
/// first pixel.
fn peaks<'w, L: Level>(whole: &'w dyn Whole, grid: Grid, config: &Config, work: &mut Planes<'_, L>) -> &'w [u32] {
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
    let any_peak = |region: &Region<L>| Cut { least: region.value, ..Cut::NONE };
    let own = work.regions.iter().filter(|region| region.label == OWN && is_source(region, config, any_peak(region)));
    let peaks = whole.words(Question::Peaks, &mut own.map(|region| region.value.key())).unwrap_or(&[]);
    work.regions.iter_mut().for_each(|region| region.label = 0);
    peaks
}

/// Area, light and matched peak of every region, from its pixels.
pub fn measure<L: Level>(work: &mut Planes<'_, L>) {
    for region in work.regions.iter_mut() {
        (region.area, region.sum, region.value, region.label) = (0, L::NOTHING, L::ZERO, 0);
    }
    for (at, label) in used(work.labels) {
        let (matched, signal) = (work.matched.get(at), work.signal.get(at));
        let region = work.regions.get_mut((label as usize).wrapping_sub(1));
        if let (Some(region), Some(&matched), Some(&signal)) = (region, matched, signal) {
            region.area += 1;
            region.sum = region.sum + signal.times(1);
            if matched > region.value {
                region.value = matched;
            }
        }
    }
}

fn is_source<L: Level>(region: &Region<L>, config: &Config, cut: Cut<L>) -> bool {
    if config.select == Select::Area {
        return region.area > 0 && region.area >= config.min_area;
    }
    let light = L::share(L::ONE.times(1), config.significance.light);
    let divided = config.separate == Separate::Tree && region.divided > 0;
    let least_area = if divided { part_area(config.min_area) } else { config.min_area };
    region.area >= least_area && region.value >= cut.least && region.sum >= light
}

/// Drops what is no source and numbers the rest in raster order.
pub fn keep<L: Level>(config: &Config, cut: Cut<L>, labels: &mut [u32], regions: &mut [Region<L>]) -> Kept {
    let mut kept = Kept::default();
    let mut next = 0;
    while let Some(at) = next_with(labels, next, u32::MAX) {
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
    kept
}
