//! How far two runs over the same image are apart.

use crate::pipeline::{Segmentation, StagePlanes};
use crate::reference::{Stages, centroids};
use std::collections::BTreeMap;

/// PlaneDifference of two planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneDifference {
    /// Name of the stage.
    pub stage: &'static str,
    /// Largest |core - reference|.
    pub max: f64,
    /// Root of the mean square.
    pub rms: f64,
}

/// What a run of the core and one of the reference differ in.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The stages that both ran, in their order; the front, in units of the paper's u, comes last.
    pub stages: Vec<PlaneDifference>,
    /// Steps of core and reference.
    pub steps: (u32, u32),
    /// Time at which the front stopped, in core and reference.
    pub t: (f64, f64),
    /// Sources in core and reference.
    pub sources: (u32, u32),
    /// Pixels that only one of them puts into a source or leaves out by its size.
    pub mask_pixels: usize,
    /// Pixels with another label, where sources that share most pixels count as the same.
    pub label_pixels: usize,
    /// The farthest that a centroid of the core lies from that of the source it shares most pixels with, in pixels;
    /// infinite for a source of the core that has no pixel in one of the reference.
    pub centroid_shift: f64,
}

/// Compares a run of the core that kept its stages with one of the reference over the same `pixels`.
///
/// `unit` is the number of units of the core's front plane in 1 of the paper's u.
pub fn compare(pixels: &[f32], core: &Segmentation, reference: &Stages, unit: f64) -> Comparison {
    let none = StagePlanes::default();
    let planes = core.stages.as_ref().unwrap_or(&none);
    let stages = [
        ("normalised", &planes.normalised, &reference.normalised, 1.0),
        ("rescaled", &planes.rescaled, &reference.rescaled, 1.0),
        ("filtered", &planes.filtered, &reference.filtered, 1.0),
        ("g", &planes.edge, &reference.g, 1.0),
        ("u", &core.front, &reference.u, unit),
    ];
    let stages = stages.into_iter().filter(|(_, plane, ..)| !plane.is_empty());
    let labels = core.labels.iter().zip(&reference.labels);
    let partners = partners(core, reference);
    Comparison {
        stages: stages
            .map(|(stage, core, reference, unit)| difference(stage, core, reference.values(), unit))
            .collect(),
        steps: (core.outcome.steps, reference.steps),
        t: (f64::from(core.outcome.steps) * reference.t / f64::from(reference.steps), reference.t),
        sources: (core.outcome.sources, reference.sources),
        mask_pixels: labels.clone().filter(|&(&a, &b)| (a == 0) != (b == 0)).count(),
        label_pixels: labels.filter(|&(&a, &b)| partners.get(a as usize).copied().flatten().unwrap_or(0) != b).count(),
        centroid_shift: centroid_shift(pixels, core, reference, &partners),
    }
}

fn difference(stage: &'static str, core: &[f32], reference: &[f64], unit: f64) -> PlaneDifference {
    let (mut max, mut squares) = (0.0f64, 0.0);
    for (&a, &b) in core.iter().zip(reference) {
        let difference = (f64::from(a) / unit - b).abs();
        max = max.max(difference);
        squares += difference * difference;
    }
    PlaneDifference { stage, max, rms: (squares / reference.len() as f64).sqrt() }
}

/// For each label of the core (from 0), the source of the reference that shares most pixels with it.
fn partners(core: &Segmentation, reference: &Stages) -> Vec<Option<u32>> {
    let mut shared = vec![BTreeMap::<u32, usize>::new(); core.outcome.sources as usize + 1];
    for (&label, &other) in core.labels.iter().zip(&reference.labels).filter(|(a, b)| **a != 0 && **b != 0) {
        *shared[label as usize].entry(other).or_default() += 1;
    }
    let most =
        |counts: &BTreeMap<u32, usize>| counts.iter().max_by_key(|&(_, pixels)| *pixels).map(|(&label, _)| label);
    shared.iter().map(most).collect()
}

fn centroid_shift(pixels: &[f32], core: &Segmentation, reference: &Stages, partners: &[Option<u32>]) -> f64 {
    let pixels: Vec<f64> = pixels.iter().map(|&v| v.into()).collect();
    let truth = centroids(&reference.labels, reference.sources, &pixels, core.width, reference.range.0);
    let shifts = core.sources.iter().map(|source| {
        let (x, y) = source.centroid();
        partners[source.label as usize].map_or(f64::INFINITY, |label| {
            let (tx, ty) = truth[label as usize - 1];
            (f64::from(x) - tx).hypot(f64::from(y) - ty)
        })
    });
    shifts.fold(0.0, f64::max)
}
