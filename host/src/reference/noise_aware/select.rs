//! Selection (`default.md`, 7).

use super::smooth::{Tail, sharpened, smoothed};
use super::{Facts, Judge, Plane, Regions, Settings};

/// The cut on significance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cut {
    /// The height in noise units of the matched image.
    pub significance: f64,
    /// The same in noise units of a pixel.
    pub least: f64,
    /// The peak from which on a source stands out there.
    pub narrow: f64,
}

/// The matched image.
pub fn matched(signal: &Plane) -> Plane {
    sharpened(&smoothed(signal, 1.7), 2.5, 0.6)
}

/// The narrow image.
fn narrow(signal: &Plane) -> Plane {
    sharpened(&smoothed(signal, 1.7), 3.4, 3.0)
}

/// What a source is asked about: its pixels, its peak in the matched image, the same where the border's pixels count for
/// less, its peak in the narrow image, and its light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sums {
    area: usize,
    peak: f64,
    even_peak: f64,
    narrow: f64,
    light: f64,
}

fn sums(signal: &Plane, matched: &Plane, regions: &Regions) -> Vec<Sums> {
    let mut sums = vec![Sums::default(); regions.table.len()];
    let narrow = narrow(signal);
    let of_axis = |at: usize, length: usize| match at.min(length - 1 - at) {
        0 => 0.8,
        1 => 0.92,
        _ => 1.0,
    };
    let (width, height) = (matched.width(), matched.height());
    let weight = |at: usize| of_axis(at % width, width) * of_axis(at / width, height);
    for (at, &label) in regions.labels.iter().enumerate().filter(|(_, label)| **label > 0) {
        let sum = &mut sums[label as usize - 1];
        sum.area += 1;
        sum.peak = sum.peak.max(matched.values()[at]);
        sum.even_peak = sum.even_peak.max(matched.values()[at] * weight(at));
        sum.narrow = sum.narrow.max(narrow.values()[at] * weight(at));
        sum.light += signal.values()[at];
    }
    sums
}

/// Whether each region is a source at a cut.
fn sources(sums: &[Sums], regions: &Regions, cut: Cut, settings: &Settings, judge: &Judge) -> Vec<bool> {
    let is_source = |(sum, region): (&Sums, &super::Region)| {
        if !settings.by_significance {
            return sum.area >= settings.min_area.max(1);
        }
        let part = settings.min_area + 2 * settings.min_area / 3;
        let area = if region.divided.is_some() { part } else { settings.min_area };
        let stands_out = region.divided.is_none() && !judge.exceeds(cut.narrow, sum.narrow);
        let part = if stands_out { 0.5 } else { 1.0 };
        let area = if stands_out { settings.min_area - settings.min_area / 3 } else { area };
        sum.area >= area
            && !judge.exceeds(cut.least, sum.even_peak)
            && !judge.exceeds(part * settings.peak * settings.threshold, sum.peak)
            && !judge.exceeds(part * settings.light, sum.light)
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
    facts: &Facts,
    regions: &Regions,
    settings: &Settings,
    judge: &Judge,
) -> Cut {
    let values = matched.values();
    let tail = Tail::of(values, masked, facts);
    let width = matched.width();
    let step = |at: usize| {
        let next = if (at + 1).is_multiple_of(width) { at.checked_sub(1) } else { Some(at + 1) };
        next.map_or(0.0, |next| values[next]) - values[at]
    };
    let steps: Vec<f64> = (0..values.len()).map(step).collect();
    let slope = Tail::of(&steps, masked, facts).noise;
    let roughness = if tail.noise > 0.0 { slope / tail.noise } else { 0.0 };
    let elements = values.len() as f64 * roughness * roughness;
    let sums = sums(signal, matched, regions);
    // Of a significance that is not asked for.
    if !settings.by_significance {
        return Cut::default();
    }
    let narrow_noise = Tail::of(narrow(signal).values(), masked, facts).noise;
    let (mut allowed, mut cut) = (settings.false_sources, Cut::default());
    for _ in 0..4 {
        let significance = tail.raised(height(elements, allowed));
        cut = Cut { significance, least: significance * tail.noise, narrow: 1.2 * significance * narrow_noise };
        let kept = sources(&sums, regions, cut, settings, judge).iter().filter(|&&kept| kept).count();
        allowed = allowed.max(settings.false_share * kept as f64);
    }
    cut
}

/// The labels of the sources, numbered by their first pixels, and their number.
pub fn select(
    signal: &Plane,
    matched: &Plane,
    regions: &Regions,
    cut: Cut,
    settings: &Settings,
    judge: &Judge,
) -> (Vec<u32>, u32) {
    let kept = sources(&sums(signal, matched, regions), regions, cut, settings, judge);
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
