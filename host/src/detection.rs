//! The noise-aware segmentation on the host: memory, the call, the catalogue.

use crate::background::SkyMaps;
use crate::nothing::without_front;
use crate::pipeline::{Drive, Segmentation, StagePlanes};
use skyfront_core::arithmetic::Level;
use skyfront_core::catalog::Source;
use skyfront_core::detect::{Known, Workspace, detect, regions};
use skyfront_core::detection::Detection;
use skyfront_core::error::Error;
use skyfront_core::normalize::Extremes;
use skyfront_core::outcome::Outcome;
use skyfront_core::sky::{Sky, mesh_cells};
use skyfront_core::stage::Stage;
use skyfront_core::tree::Region;
use std::time::Instant;

/// Bytes that an image and [`segment`] without pictures take together, by what they hold.
pub fn memory(width: usize, height: usize) -> [(usize, &'static str); 4] {
    let plane = width * height * size_of::<f32>();
    [
        (2 * plane, "the image, and the level that is kept of it"),
        (8 * plane, "eight planes to work in"),
        (regions(width, height) * size_of::<Region<f32>>(), "table of regions"),
        (2 * mesh_cells(width, height) * size_of::<Sky>(), "mesh of the sky"),
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

/// Segments an image, row-major, NaN = undefined, in `L`; the `front` of the result is the smoothed
/// signal-to-noise above the outline.
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
    let [mut signal, mut fine, mut smooth, mut masked, mut scratch] = [(); 5].map(|()| vec![L::ZERO; count]);
    let [mut parents, mut order, mut labels] = [(); 3].map(|()| vec![0; count]);
    let mut mesh = vec![Sky::UNKNOWN; mesh_cells(width, height)];
    let mut table = vec![Region::<L>::BLANK; regions(width, height)];
    let mut work = Workspace {
        signal: &mut signal,
        fine: &mut fine,
        smooth: &mut smooth,
        masked: &mut masked,
        scratch: &mut scratch,
        parents: &mut parents,
        order: &mut order,
        labels: &mut labels,
        mesh: &mut mesh,
        regions: &mut table,
    };
    // A noise map may be a weight map: it says how noisy pixels are beside each other.
    let known = Known { background: drive.background, noise: drive.noise, relative: true };
    let found = detect(pixels, width, &known, detection, &mut work)?;
    let [smooth, masked] = [smooth, masked].map(in_f32);
    let sky = SkyMaps::measure_into(pixels, &masked, width, [fine, scratch].map(in_f32));
    let mut extremes = Extremes::NONE;
    pixels.chunks_exact(width).for_each(|row| extremes.observe(row));
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
        front: smooth.iter().map(|value| value - detection.outline).collect(),
        stages,
        convergence: Vec::new(),
        sources,
        blended: Some(blended),
        plateaus,
        outcome,
        sky: Some(sky),
        seconds: vec![(Stage::Measure, started.elapsed())],
        remark: None,
    })
}

/// A plane in single precision, in its own memory.
fn in_f32<L: Level>(plane: Vec<L>) -> Vec<f32> {
    plane.into_iter().map(L::to_f32).collect()
}
