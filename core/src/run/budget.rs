//! How long a run can take at most, known before it starts.
//!
//! Time is counted in row operations: one row of one pass. Each costs O(W): a row of a sweep, a
//! row of statistics, or W entries of the label table. In the label passes a look-up follows at
//! most W links, because only labels joined in the last two rows can lie between a label of the
//! row before and the first label of its component.

use crate::arithmetic::Exponent;
use crate::config::{Config, Edge, Rescale, Scheme, Tau};
use crate::plane::sort::SAMPLES;
use crate::run::plan::Plan;
use crate::run::stage::Stage;
use crate::sky::mesh_cells;

/// The most passes over the rows that a stage can take, whatever the image.
pub fn passes(config: &Config, stage: Stage) -> u32 {
    Plan::of(config).passes(stage)
}

/// The most row operations that a stage can take in a frame of `height` rows.
pub fn rows(config: &Config, height: usize, stage: Stage) -> u64 {
    Plan::of(config).rows(height, stage)
}

/// The most row operations of a whole run.
pub fn total_rows(config: &Config, height: usize) -> u64 {
    Plan::of(config).total_rows(height)
}

/// The most work of a run on signal-to-noise ([`crate::run::extract`]) with so many regions, in cells: a pixel of a
/// pass, a key of a sort or a region of the table. An upper bound of what each pass can need; a field of stars takes a
/// third of it.
pub const fn cells(config: &Config, (width, height): (usize, usize), regions: usize) -> u64 {
    let pixels = (width as u64).saturating_mul(height as u64);
    let sample = if pixels < SAMPLES as u64 { pixels } else { SAMPLES as u64 };
    let cells = mesh_cells(width, height, config.sky.cell()) as u64;
    let steps = config.outline.steps as u64;
    pixels
        .saturating_mul(PASSES.saturating_add(steps))
        .saturating_add(sample.saturating_mul(SAMPLE_PASSES))
        .saturating_add((regions as u64).saturating_mul(REGION_PASSES))
        .saturating_add(cells.saturating_mul(CELL_PASSES))
        .saturating_add(FIXED)
}

/// The most polls of so many rows in which a run with that work ends: each does at least half of what it may, or ends a
/// step.
pub const fn polls(cells: u64, width: usize, rows: usize) -> u64 {
    let each = (width as u64).saturating_mul(if rows > 1 { rows as u64 } else { 1 });
    let each = if each > 1 { each } else { 1 };
    cells.saturating_mul(2).div_ceil(each).saturating_add(MOST_STEPS)
}

/// Passes over all pixels: 3 for the values, 24 for background and signal, 27 for smoothing, 16 for the mask, 44 for the
/// photon noise, 1 for the front's start, 30 for the tree, 99 for deblending, 17 for the selection.
const PASSES: u64 = 261;
/// Passes over a sample: 14 sorts of 11, and what its values tell.
const SAMPLE_PASSES: u64 = 174;
/// Passes over the regions.
const REGION_PASSES: u64 = 65;
/// Passes over the cells of the mesh, half of them its copy: up to 128 rings of unknown cells are filled from eight
/// neighbours each, three times.
const CELL_PASSES: u64 = 3 * 4 * 130;
/// The frame's typical source.
const FIXED: u64 = 160_000;
/// Steps of a run, none of which ends in the middle of a poll.
const MOST_STEPS: u64 = 20;

/// What a stage does in a configuration, as a word: work for a pixel is alike where stage and word
/// are, and `host/src/cli/resources.txt` has the instructions for each pair.
///
/// `-power` is an exponent that is no power of two, `-64` directions of that number, `-band` a front
/// in a band; `-` stands for stages that always do the same.
pub fn variant(config: &Config, stage: Stage) -> &'static str {
    let root = |p: f32| !matches!(Exponent::of(p), Exponent::Any(_));
    match stage {
        Stage::Rescale => match config.rescale {
            Rescale::None => "none",
            Rescale::R1 { alpha } if root(alpha) => "r1",
            Rescale::R1 { .. } => "r1-power",
            Rescale::R2 { alpha } if root(alpha) => "r2",
            Rescale::R2 { .. } => "r2-power",
            Rescale::R3 { beta, .. } if root(f32::from(beta)) => "r3",
            Rescale::R3 { .. } => "r3-power",
        },
        Stage::Threshold => match config.rescale {
            Rescale::R3 { tau: Tau::Otsu, .. } => "otsu",
            Rescale::R3 { tau: Tau::Kapur, .. } => "kapur",
            Rescale::R3 { tau: Tau::Rosin, .. } => "rosin",
            Rescale::R3 { tau: Tau::Noise { .. }, .. } => "noise",
            _ => "none",
        },
        Stage::Filter => config.filter.step_name(),
        Stage::Edge => match config.edge {
            Edge::G1 { p } if root(p) => "g1",
            Edge::G1 { .. } => "g1-power",
            Edge::G2 | Edge::G2Mod { .. } => "g2",
        },
        Stage::Evolve => step(config),
        Stage::Front | Stage::Turn if config.scheme.has_two_fronts() => "multiphase",
        _ => "-",
    }
}

/// [`variant`] of a step of the front.
fn step(config: &Config) -> &'static str {
    let (fine, band) = (config.directions == 64, config.band.is_some());
    match (config.scheme, fine, band) {
        (Scheme::Fd, _, false) => "fd",
        (Scheme::Fd, _, true) => "fd-band",
        (Scheme::FdCurvature, _, false) => "fd-curvature",
        (Scheme::FdCurvature, _, true) => "fd-curvature-band",
        (Scheme::FdFiltered, _, false) => "fd-filtered",
        (Scheme::FdFiltered, _, true) => "fd-filtered-band",
        (Scheme::Sl, false, false) => "sl",
        (Scheme::Sl, false, true) => "sl-band",
        (Scheme::Sl, true, false) => "sl-64",
        (Scheme::Sl, true, true) => "sl-64-band",
        (Scheme::SlCurvature, false, false) => "sl-curvature",
        (Scheme::SlCurvature, false, true) => "sl-curvature-band",
        (Scheme::SlCurvature, true, false) => "sl-curvature-64",
        (Scheme::SlCurvature, true, true) => "sl-curvature-64-band",
        (Scheme::ChanVese, _, _) => "chan-vese",
        (Scheme::Multiphase, _, _) => "multiphase",
        (Scheme::Region | Scheme::FastMarching, _, _) => "none",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_that_are_no_roots_are_work_of_their_own() {
        let words = |alpha, p| {
            let config = Config { rescale: Rescale::R1 { alpha }, edge: Edge::G1 { p }, ..Config::PAPER_F160 };
            [Stage::Rescale, Stage::Edge].map(|stage| variant(&config, stage))
        };
        assert_eq!([words(0.25, 2.0), words(0.3, 3.0)], [["r1", "g1"], ["r1-power", "g1-power"]]);
    }
}
