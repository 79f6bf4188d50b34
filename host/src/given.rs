//! A run over a label map or places that are given: nothing is found, only measured.

use crate::background::SkyMaps;
use crate::extraction::shown;
use crate::input::Input;
use crate::nothing::without_front;
use crate::pipeline::{Segmentation, StagePlanes};
use skyfront_core::image::normalize::Extremes;
use skyfront_core::run::outcome::Outcome;
use skyfront_core::sources::catalog::Source;

/// The method's name in headers and summaries.
pub const METHOD: &str = "given";

/// The run that a map of an image stands for; without a map no pixel has a label. `arithmetic` is that
/// of its numbers, the sky is measured beside the labels.
pub fn segment(input: &Input, arithmetic: &'static str, keep_stages: bool) -> Segmentation {
    let image = &input.detected.image;
    let (width, height) = (image.width, image.height);
    let (labels, count) = match &input.segmentation {
        Some(map) => (map.labels.clone(), map.names.len() as u32),
        None => (vec![0; width * height], 0),
    };
    let mut extremes = Extremes::NONE;
    image.pixels.chunks_exact(width).for_each(|row| extremes.observe(row));
    let mut sources: Vec<Source> = (1..=count).map(Source::empty).collect();
    for (at, (&label, &pixel)) in labels.iter().zip(&image.pixels).enumerate() {
        if let Some(source) = (label as usize).checked_sub(1).and_then(|index| sources.get_mut(index)) {
            source.add((at % width) as u32, (at / width) as u32, pixel, extremes.least);
        }
    }
    let sky = SkyMaps::beside(&image.pixels, &labels, width);
    let marked = |outside: f32| labels.iter().map(|&label| if label > 0 { 1.0 } else { outside }).collect();
    let stages = keep_stages.then(|| StagePlanes {
        normalised: image
            .pixels
            .iter()
            .zip(sky.level.iter().zip(&sky.noise))
            .map(|(pixel, (level, noise))| shown::unit(&((pixel - level) / noise)))
            .collect(),
        rescaled: Vec::new(),
        filtered: Vec::new(),
        edge: marked(0.0),
    });
    let front = marked(-1.0);
    let mask_pixels = labels.iter().filter(|label| **label > 0).count() as u32;
    Segmentation {
        arithmetic,
        width,
        height,
        labels,
        front,
        stages,
        convergence: Vec::new(),
        sources,
        blended: None,
        plateaus: Vec::new(),
        outcome: Outcome { mask_pixels, sources: count, catalogued: count, ..without_front(extremes) },
        sky: Some(sky),
        seconds: Vec::new(),
        remarks: Vec::new(),
    }
}
