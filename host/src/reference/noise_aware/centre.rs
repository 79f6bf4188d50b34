//! Centres of wide sources, and plateaus (`default.md`, 6).

use super::light::{light, opposite, place, to_part};
use super::photon::grown;
use super::{Judge, Plane, Regions};

/// Gives wide regions the middle of their light as a centre, and marks plateaus. `image` is the one that was divided,
/// `smooth` the one smoothed by need, `noise` that of the fine image.
pub fn centre(image: &Plane, smooth: &Plane, regions: &mut Regions, (noise, photon): (f64, f64), judge: &Judge) {
    let (width, values) = (image.width(), image.values());
    let mut pixels: Vec<Vec<usize>> = vec![Vec::new(); regions.table.len()];
    for (at, &label) in regions.labels.iter().enumerate().filter(|(_, label)| **label > 0) {
        pixels[label as usize - 1].push(at);
    }
    for (region, pixels) in regions.table.iter_mut().zip(&pixels) {
        let upper: Vec<usize> = pixels.iter().copied().filter(|&at| values[at] > 0.5 * values[region.peak]).collect();
        let top = smooth.values()[region.peak];
        if upper.len() > 20 {
            let total: f64 = upper.iter().map(|&at| values[at]).sum();
            let mean = |of: fn((f64, f64)) -> f64| {
                let (peak, off) = (of(place(region.peak, width)), |at: usize| of(place(at, width)));
                let mean = upper.iter().map(|&at| values[at] * (off(at) - peak)).sum::<f64>() / total;
                peak + to_part(mean, judge)
            };
            let middle = (mean(|place| place.0), mean(|place| place.1));
            let is_level = |place| light(smooth, place).is_some_and(|light| judge.exceeds(light, 0.85 * top));
            let across = opposite(middle, place(region.peak, width));
            if upper.len() > 50 || (is_level(middle) && is_level(across)) {
                region.centre = middle;
            }
        }
        let level = pixels.iter().filter(|&&at| judge.exceeds(smooth.values()[at], 0.97 * top)).count();
        let is_seen = judge.exceeds(0.03 * top, noise * grown(photon, top));
        region.plateau = is_seen && level >= 5 && 8 * level >= upper.len();
        region.area = upper.len();
    }
}
