//! How far two runs over the same image are apart.

use crate::pipeline::{Segmentation, StagePlanes};
use crate::reference::noise_aware::Found;
use crate::reference::{Plane, Stages, Vector, centroids};
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

/// What a whole run of the reference came to.
struct Whole<'a> {
    labels: &'a [u32],
    sources: u32,
    /// What pixels weigh nothing from on down.
    floor: f64,
    steps: u32,
    t: f64,
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
    let Stages { labels, sources, steps, t, .. } = reference;
    let whole = Whole { labels, sources: *sources, floor: reference.range.0, steps: *steps, t: *t };
    compare_runs(pixels, core, &whole, &stages)
}

/// The same of a run on signal-to-noise.
pub fn compare_signal(pixels: &[f32], core: &Segmentation, reference: &Found, unit: f64) -> Comparison {
    let Found { labels, sources, front, .. } = reference;
    let floor = core.outcome.extremes.least.into();
    let whole = Whole { labels, sources: *sources, floor, steps: front.steps, t: front.t };
    compare_runs(pixels, core, &whole, &[("u", &core.front, &front.u, unit)])
}

/// The same of a front in several bands; `pixels` are those of the first.
pub fn compare_bands(pixels: &[f32], core: &Segmentation, reference: &Vector, unit: f64) -> Comparison {
    let Vector { labels, evolution, .. } = reference;
    let sources = labels.iter().copied().max().unwrap_or(0);
    let (floor, steps, t) = (core.outcome.range.low.into(), evolution.steps, evolution.t);
    let whole = Whole { labels, sources, floor, steps, t };
    compare_runs(pixels, core, &whole, &[("u", &core.front, &evolution.u, unit)])
}

/// A stage: its plane in the core and in the reference, and the units of the one in 1 of the other.
type Stage<'a> = (&'static str, &'a Vec<f32>, &'a Plane, f64);

fn compare_runs(pixels: &[f32], core: &Segmentation, whole: &Whole<'_>, stages: &[Stage<'_>]) -> Comparison {
    let labels = core.labels.iter().zip(whole.labels);
    let partners = partners(core, whole.labels);
    // The front of a run on signal-to-noise is one step of the core, of as many as it was told.
    let steps = if core.outcome.steps > 0 { core.outcome.steps } else { whole.steps };
    let stages = stages.iter().filter(|(_, plane, ..)| !plane.is_empty());
    Comparison {
        stages: stages
            .map(|&(stage, core, reference, unit)| difference(stage, core, reference.values(), unit))
            .collect(),
        steps: (steps, whole.steps),
        t: (f64::from(steps) * whole.t / f64::from(whole.steps.max(1)), whole.t),
        sources: (core.outcome.sources, whole.sources),
        mask_pixels: labels.clone().filter(|&(&a, &b)| (a == 0) != (b == 0)).count(),
        label_pixels: labels.filter(|&(&a, &b)| partners.get(a as usize).copied().flatten().unwrap_or(0) != b).count(),
        centroid_shift: centroid_shift(pixels, core, whole, &partners),
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
fn partners(core: &Segmentation, labels: &[u32]) -> Vec<Option<u32>> {
    let mut shared = vec![BTreeMap::<u32, usize>::new(); core.outcome.sources as usize + 1];
    for (&label, &other) in core.labels.iter().zip(labels).filter(|(a, b)| **a != 0 && **b != 0) {
        *shared[label as usize].entry(other).or_default() += 1;
    }
    let most =
        |counts: &BTreeMap<u32, usize>| counts.iter().max_by_key(|&(_, pixels)| *pixels).map(|(&label, _)| label);
    shared.iter().map(most).collect()
}

fn centroid_shift(pixels: &[f32], core: &Segmentation, reference: &Whole<'_>, partners: &[Option<u32>]) -> f64 {
    let pixels: Vec<f64> = pixels.iter().map(|&v| v.into()).collect();
    let truth = centroids(reference.labels, reference.sources, &pixels, core.width, reference.floor);
    let shifts = core.sources.iter().map(|source| {
        let (x, y) = source.centroid();
        partners[source.label as usize].map_or(f64::INFINITY, |label| {
            let (tx, ty) = truth[label as usize - 1];
            (f64::from(x) - tx).hypot(f64::from(y) - ty)
        })
    });
    shifts.fold(0.0, f64::max)
}
