//! The noise-aware segmentation on the host: memory, the call, the catalogue.

use crate::background::SkyMaps;
use crate::nothing::without_front;
use crate::pipeline::{Drive, Segmentation, StagePlanes};
use crate::remarks;
use skyfront_core::arithmetic::Level;
use skyfront_core::config::detection::Detection;
use skyfront_core::error::Error;
use skyfront_core::image::normalize::Extremes;
use skyfront_core::run::detect::{Known, Workspace, detect, regions};
use skyfront_core::run::outcome::Outcome;
use skyfront_core::run::stage::Stage;
use skyfront_core::sky::{Mesh, Sky, mesh_cells};
use skyfront_core::sources::catalog::Source;
use skyfront_core::sources::tree::Region;
use std::time::Instant;

/// Bytes that an image and [`segment`] without pictures take together, by what they hold.
pub fn memory(width: usize, height: usize) -> [(usize, &'static str); 4] {
    let plane = width * height * size_of::<f32>();
    [
        (2 * plane, "the image, and the level that is kept of it"),
        (9 * plane, "nine planes to work in"),
        (regions(width, height) * size_of::<Region<f32>>(), "table of regions"),
        (mesh_cells(width, height) * size_of::<Sky>(), "mesh of the sky"),
    ]
}

/// The signal-to-noise that pictures show.
pub mod shown {
    /// Black.
    pub const LEAST: f32 = -5.0;
    /// White.
    pub const GREATEST: f32 = 20.0;

    /// A signal-to-noise on the scale from black, 0, to white, 1.
    pub fn unit(value: &f32) -> f32 {
        ((value - LEAST) / (GREATEST - LEAST)).clamp(0.0, 1.0)
    }
}

/// Segments an image, row-major, NaN = undefined, in `L`.
///
/// # Errors
/// What the core finds wrong with the image.
pub fn segment<L: Level>(
    detection: &Detection,
    pixels: &[f32],
    width: usize,
    drive: &Drive<'_>,
) -> Result<Segmentation, Error> {
    let started = Instant::now();
    let count = pixels.len();
    let height = count / width.max(1);
    let [mut signal, mut fine, mut smooth, mut front, mut masked, mut scratch] = [(); 6].map(|()| vec![L::ZERO; count]);
    let [mut parents, mut order, mut labels] = [(); 3].map(|()| vec![0; count]);
    let mut mesh = vec![Sky::UNKNOWN; mesh_cells(width, height)];
    let mut table = vec![Region::<L>::BLANK; regions(width, height)];
    let mut work = Workspace {
        signal: &mut signal,
        fine: &mut fine,
        smooth: &mut smooth,
        front: &mut front,
        masked: &mut masked,
        scratch: &mut scratch,
        parents: &mut parents,
        order: &mut order,
        labels: &mut labels,
        mesh: &mut mesh,
        regions: &mut table,
    };
    let known = Known { background: drive.background, noise: drive.noise, relative: drive.relative };
    let found = detect(pixels, width, &known, detection, &mut work)?;
    let [smooth, front, masked] = [smooth, front, masked].map(in_f32);
    let observed = |pixel: f32| if found.values.holds(pixel) { pixel } else { f32::NAN };
    let mut sky = SkyMaps::of(&Mesh::over(&mut mesh, (width, height)), width, [fine, scratch].map(in_f32));
    // Nothing is measured in what was never observed.
    sky.noise
        .iter_mut()
        .zip(pixels)
        .filter(|(_, pixel)| **pixel == found.values.fill)
        .for_each(|(noise, _)| *noise = f32::NAN);
    let mut extremes = Extremes::NONE;
    let mut row = vec![0.0; width];
    for pixels in pixels.chunks_exact(width) {
        row.iter_mut().zip(pixels).for_each(|(out, &pixel)| *out = observed(pixel));
        extremes.observe(&row);
    }
    let mut sources: Vec<Source> = (1..=found.sources).map(Source::empty).collect();
    for (at, (&label, &pixel)) in labels.iter().zip(pixels).enumerate() {
        if let Some(source) = (label as usize).checked_sub(1).and_then(|index| sources.get_mut(index)) {
            source.add((at % width) as u32, (at / width) as u32, pixel, extremes.least);
        }
    }
    let [mut blended, mut plateaus] = [(); 2].map(|()| vec![false; sources.len()]);
    let mark = |of: &mut [bool], label: u32| {
        (label as usize).checked_sub(1).and_then(|index| of.get_mut(index)).into_iter().for_each(|of| *of = true);
    };
    for region in table {
        if let Some(other) = region.divided_from(&labels) {
            // The other may remember a part that was dropped.
            mark(&mut blended, region.label);
            mark(&mut blended, other);
        }
        if region.plateau > 0.0 {
            mark(&mut plateaus, region.label);
        }
    }
    let stages = drive.keep_stages.then(|| StagePlanes {
        normalised: signal.iter().map(|value| shown::unit(&value.to_f32())).collect(),
        rescaled: Vec::new(),
        filtered: smooth.iter().map(shown::unit).collect(),
        edge: masked,
    });
    let outcome = Outcome {
        mask_pixels: found.mask_pixels,
        sources: found.sources,
        catalogued: found.sources,
        unlabelled: found.unlabelled,
        ..without_front(extremes)
    };
    Ok(Segmentation {
        arithmetic: L::NAME,
        width,
        height,
        labels,
        front,
        stages,
        convergence: Vec::new(),
        sources,
        blended: Some(blended),
        plateaus,
        outcome,
        sky: Some(sky),
        seconds: vec![(Stage::Measure, started.elapsed())],
        remarks: remarks::on(&found, count),
    })
}

/// A plane in single precision, in its own memory.
fn in_f32<L: Level>(plane: Vec<L>) -> Vec<f32> {
    plane.into_iter().map(L::to_f32).collect()
}
