//! Selection (`default.md`, 7).

use super::smooth::{Tail, sharpened, smoothed};
use super::{Judge, Plane, Regions, Settings};

/// The cut on significance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// The height in noise units of the matched image.
    pub significance: f64,
    /// The same in noise units of a pixel, or `--min-peak` times the threshold where that is more.
    pub least: f64,
}

/// The matched image.
pub fn matched(signal: &Plane) -> Plane {
    sharpened(&smoothed(signal, 1.7), 2.5, 0.6)
}

/// What a source is asked about: its pixels, its peak in the matched image, and its light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sums {
    area: usize,
    peak: f64,
    light: f64,
}

fn sums(signal: &Plane, matched: &Plane, regions: &Regions) -> Vec<Sums> {
    let mut sums = vec![Sums::default(); regions.table.len()];
    for (at, &label) in regions.labels.iter().enumerate().filter(|(_, label)| **label > 0) {
        let sum = &mut sums[label as usize - 1];
        sum.area += 1;
        sum.peak = sum.peak.max(matched.values()[at]);
        sum.light += signal.values()[at];
    }
    sums
}

/// Whether each region is a source at a cut.
fn sources(sums: &[Sums], regions: &Regions, least: f64, settings: &Settings, judge: &Judge) -> Vec<bool> {
    let is_source = |(sum, region): (&Sums, &super::Region)| {
        if !settings.by_significance {
            return sum.area >= settings.min_area.max(1);
        }
        let part = settings.min_area + 2 * settings.min_area / 3;
        let area = if region.divided.is_some() { part } else { settings.min_area };
        sum.area >= area && !judge.exceeds(least, sum.peak) && !judge.exceeds(settings.light, sum.light)
    };
    sums.iter().zip(&regions.table).map(is_source).collect()
}

/// The height in standard deviations that noise exceeds so often.
fn height(elements: f64, allowed: f64) -> f64 {
    let expected = |z: f64| elements / (2.0 * std::f64::consts::PI).powf(1.5) * z * (-0.5 * z * z).exp();
    let (mut low, mut high) = (1.0, 14.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if expected(middle) > allowed { &mut low } else { &mut high }) = middle;
    }
    high
}

/// The cut for regions in their final pixels.
pub fn cut(
    signal: &Plane,
    matched: &Plane,
    masked: &[bool],
    cut_off: bool,
    regions: &Regions,
    settings: &Settings,
    judge: &Judge,
) -> Cut {
    let values = matched.values();
    let tail = Tail::of(values, masked, cut_off);
    let width = matched.width();
    let step = |at: usize| {
        let next = if (at + 1).is_multiple_of(width) { at.checked_sub(1) } else { Some(at + 1) };
        next.map_or(0.0, |next| values[next]) - values[at]
    };
    let steps: Vec<f64> = (0..values.len()).map(step).collect();
    let slope = Tail::of(&steps, masked, cut_off).noise;
    let roughness = if tail.noise > 0.0 { slope / tail.noise } else { 0.0 };
    let elements = values.len() as f64 * roughness * roughness;
    let sums = sums(signal, matched, regions);
    // Of a significance that is not asked for.
    if !settings.by_significance {
        return Cut { significance: 0.0, least: 0.0 };
    }
    let (mut allowed, mut cut) = (settings.false_sources, Cut { significance: 0.0, least: 0.0 });
    for _ in 0..4 {
        let significance = tail.raised(height(elements, allowed));
        cut = Cut { significance, least: (significance * tail.noise).max(settings.peak * settings.threshold) };
        let kept = sources(&sums, regions, cut.least, settings, judge).iter().filter(|&&kept| kept).count();
        allowed = allowed.max(settings.false_share * kept as f64);
    }
    cut
}

/// The labels of the sources, numbered by their first pixels, and their number.
pub fn select(
    signal: &Plane,
    matched: &Plane,
    regions: &Regions,
    least: f64,
    settings: &Settings,
    judge: &Judge,
) -> (Vec<u32>, u32) {
    let kept = sources(&sums(signal, matched, regions), regions, least, settings, judge);
    let mut numbers = vec![0; kept.len()];
    let mut count = 0;
    let number = |&label: &u32| {
        let Some(region) = (label as usize).checked_sub(1).filter(|&region| kept[region]) else { return 0 };
        if numbers[region] == 0 {
            count += 1;
            numbers[region] = count;
        }
        numbers[region]
    };
    let labels = regions.labels.iter().map(number).collect();
    (labels, count)
}
