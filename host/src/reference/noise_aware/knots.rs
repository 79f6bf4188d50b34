//! Galaxies with knots (`default.md`, 6).

use super::{Judge, Plane, Regions};

/// What a source is, by its pixels.
#[derive(Clone, Copy, Debug, Default)]
struct Light {
    pixels: f64,
    /// In all.
    sum: f64,
    /// In that of the peak.
    extent: f64,
    /// Of its middle, seen from the peak.
    offset: (f64, f64),
}

/// The light of every source, by its label less 1.
fn lights(image: &Plane, regions: &Regions) -> Vec<Light> {
    let mut lights = vec![Light::default(); regions.table.len()];
    let place = |at: usize| ((at % image.width()) as f64, (at / image.width()) as f64);
    for (at, &label) in regions.labels.iter().enumerate().filter(|(_, label)| **label > 0) {
        let index = label as usize - 1;
        let ((x, y), (peak_x, peak_y)) = (place(at), place(regions.table[index].peak));
        let (light, value) = (&mut lights[index], image.values()[at].max(0.0));
        light.pixels += 1.0;
        light.sum += value;
        light.offset = (light.offset.0 + value * (x - peak_x), light.offset.1 + value * (y - peak_y));
    }
    for (light, region) in lights.iter_mut().zip(&regions.table) {
        let peak = image.values()[region.peak];
        light.extent = if peak > 0.0 { light.sum / peak } else { 0.0 };
        if light.sum > 0.0 {
            light.offset = (light.offset.0 / light.sum, light.offset.1 / light.sum);
        }
    }
    lights
}

/// The labels once each galaxy has its knots, if they are `least` or more.
pub fn joined(image: &Plane, regions: &Regions, least: usize, judge: &Judge) -> Vec<u32> {
    if least == 0 {
        return regions.labels.clone();
    }
    let (width, lights) = (image.width(), lights(image, regions));
    let light = |label: u32| lights[label as usize - 1];
    let mut brightest: Vec<Option<u32>> = vec![None; lights.len()];
    let labels = &regions.labels;
    let beside = (0..labels.len()).filter(|at| at % width + 1 < width).map(|at| (labels[at], labels[at + 1]));
    let above = (0..labels.len() - width).map(|at| (labels[at], labels[at + width]));
    for (one, other) in beside.chain(above).filter(|&(one, other)| one != other && one != 0 && other != 0) {
        for (own, near) in [(one, other), (other, one)] {
            let known = &mut brightest[own as usize - 1];
            if known.is_none_or(|known| light(near).sum > light(known).sum) {
                *known = Some(near);
            }
        }
    }
    let is_galaxy = |of: Light| {
        judge.exceeds(of.extent, 50.0)
            && judge.exceeds(0.05 * of.pixels, of.extent)
            && judge.exceeds(0.1 * of.pixels.sqrt(), of.offset.0.hypot(of.offset.1))
    };
    let galaxy_of = |label: u32| {
        let galaxy = brightest[label as usize - 1].filter(|&galaxy| is_galaxy(light(galaxy)))?;
        let (own, whole) = (light(label), light(galaxy).sum);
        let is_part = judge.exceeds(own.sum, 0.001 * whole) && judge.exceeds(0.007 * whole, own.sum);
        (is_part && judge.exceeds(25.0, own.extent)).then_some(galaxy)
    };
    let galaxies: Vec<Option<u32>> = (1..).take(lights.len()).map(galaxy_of).collect();
    let knots = |galaxy: u32| galaxies.iter().filter(|&&other| other == Some(galaxy)).count();
    let owner = |&label: &u32| match label.checked_sub(1).and_then(|index| galaxies[index as usize]) {
        Some(galaxy) if knots(galaxy) >= least => galaxy,
        _ => label,
    };
    labels.iter().map(owner).collect()
}
