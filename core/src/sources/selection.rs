//! Which regions are sources: by area, or by their significance in an image matched to their size.

use crate::arithmetic::{Level, Real};
use crate::config::{Config, Select, Separate, part_area};
use crate::plane::grid::Grid;
use crate::plane::smooth::Weights;
use crate::plane::sort::Keys;
use crate::sky::tail::Tail;
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
    /// The same for what stands out in the narrow image.
    pub lenient: L,
    /// The peak from which on a source stands out there.
    pub narrow: f32,
}

impl<L: Level> Cut<L> {
    /// Every peak will do.
    pub const NONE: Cut<L> = Cut { significance: 0.0, least: L::ZERO, lenient: L::ZERO, narrow: 0.0 };
}

/// Sources that are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Their number.
    pub sources: u32,
    /// Their pixels.
    pub pixels: u32,
}

/// Measures every region, and finds the cut on the peak in the matched image. `piled` is as in
/// [`crate::sky::Values`].
pub fn cut<L: Level>(grid: Grid, piled: bool, config: &Config, work: &mut Planes<'_, L>) -> Cut<L> {
    let narrow_noise = measure_narrow(grid, piled, work);
    Weights::gauss(MATCHED).apply(work.signal, work.scratch, work.matched, grid);
    Weights::gauss(WIDE).sharpen(work.matched, work.scratch, grid, SHARPENING);
    measure(work);
    let matched = |at: usize| work.matched.get(at).copied().unwrap_or(L::ZERO);
    let tail = Tail::measure(matched, work.masked, piled, work.keys.again());
    let noise = tail.noise.to_f32();
    let step = |at: usize| matched(at + 1) - matched(at);
    let slope = Tail::measure(step, work.masked, piled, work.keys.again()).noise.to_f32();
    let roughness = if noise > 0.0 { slope / noise } else { 0.0 };
    let elements = work.signal.len() as f32 * roughness * roughness;
    let floor = config.significance.peak * config.outline.threshold;
    let (mut allowed, mut cut) = (config.significance.false_sources, Cut::NONE);
    for _ in 0..CUTS {
        let significance = tail.raised(height(elements, allowed));
        let least = |floor: f32| L::of((significance * noise).greatest(floor));
        let narrow = STANDS_OUT * significance * narrow_noise;
        cut = Cut { significance, least: least(floor), lenient: least(LENIENCY * floor), narrow };
        let kept = work.regions.iter().filter(|region| is_source(region, config, cut)).count();
        let share = config.significance.false_share * kept as f32;
        allowed = if share > allowed { share } else { allowed };
    }
    cut
}

/// The peak of every region in the narrow image, and the noise of that. Leaves it in the matched plane.
fn measure_narrow<L: Level>(grid: Grid, piled: bool, work: &mut Planes<'_, L>) -> f32 {
    Weights::gauss(MATCHED).apply(work.signal, work.scratch, work.matched, grid);
    Weights::gauss(NARROW_WIDE).sharpen(work.matched, work.scratch, grid, NARROW_SHARPENING);
    for region in work.regions.iter_mut() {
        region.offsets = (0.0, 0.0);
    }
    for (&label, &narrow) in work.labels.iter().zip(work.matched.iter()) {
        if let Some(region) = work.regions.get_mut((label as usize).wrapping_sub(1)) {
            region.offsets.0 = region.offsets.0.greatest(narrow.to_f32());
        }
    }
    let narrow = |at: usize| work.matched.get(at).copied().unwrap_or(L::ZERO);
    Tail::measure(narrow, work.masked, piled, work.keys.again()).noise.to_f32()
}

/// Area, light and matched peak of every region, from its pixels.
pub fn measure<L: Level>(work: &mut Planes<'_, L>) {
    for region in work.regions.iter_mut() {
        (region.area, region.sum, region.value, region.label) = (0, L::NOTHING, L::ZERO, 0);
    }
    for ((&label, &matched), &signal) in work.labels.iter().zip(work.matched.iter()).zip(work.signal.iter()) {
        if let Some(region) = work.regions.get_mut((label as usize).wrapping_sub(1)) {
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
    let divided = config.separate == Separate::Tree && region.divided > 0;
    let least_area = if divided { part_area(config.min_area) } else { config.min_area };
    let stands_out = !divided && region.offsets.0 >= cut.narrow;
    let (least, part) = if stands_out { (cut.lenient, LENIENCY) } else { (cut.least, 1.0) };
    let light = L::share(L::ONE.times(1), part * config.significance.light);
    region.area >= least_area && region.value >= least && region.sum >= light
}

/// Drops what is no source and numbers the rest in raster order.
pub fn keep<L: Level>(config: &Config, cut: Cut<L>, labels: &mut [u32], regions: &mut [Region<L>]) -> Kept {
    let mut kept = Kept::default();
    for label in labels.iter_mut() {
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
