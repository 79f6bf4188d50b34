//! How long a run can take at most, known before it starts.
//!
//! Time is counted in row operations: one row of one pass. Each costs O(W): a row of a sweep, a
//! row of statistics, or W entries of the label table. In the label passes a look-up follows at
//! most W links, because only labels joined in the last two rows can lie between a label of the
//! row before and the first label of its component.

use crate::arithmetic::Exponent;
use crate::config::{Config, Diffusivity, Edge, Filter, Normalize, Rescale, Scheme, Start, Tau};
use crate::march;
use crate::noise;
use crate::select;
use crate::stage::Stage;

/// The most passes over the rows that a stage can take, whatever the image.
pub fn passes(config: &Config, stage: Stage) -> u32 {
    match stage {
        Stage::LowPercentile | Stage::HighPercentile => match config.normalize {
            Normalize::Percentile { .. } => select::PASSES,
            Normalize::MinMax | Normalize::Noise { .. } => 0,
        },
        Stage::Sky if matches!(config.normalize, Normalize::Noise { .. }) => noise::PASSES,
        Stage::Sky => 0,
        Stage::Median => select::PASSES,
        Stage::Threshold => match config.rescale {
            Rescale::R3 { tau: Tau::Otsu | Tau::Kapur | Tau::Rosin, .. } => 1,
            Rescale::R3 { tau: Tau::Noise { .. }, .. } => noise::PASSES,
            _ => 0,
        },
        Stage::Rescale => u32::from(config.rescale != Rescale::None),
        Stage::Filter if config.filter == Filter::None => 0,
        Stage::Filter => u32::from(config.filter_steps),
        Stage::StartLevel | Stage::StartMark | Stage::StartUp | Stage::StartDown => {
            u32::from(matches!(config.start, Start::Threshold { .. }))
        }
        Stage::Edge => u32::from(config.scheme != Scheme::ChanVese),
        Stage::Evolve if config.scheme == Scheme::FastMarching => 0,
        Stage::Evolve => config.max_steps(),
        Stage::Seed | Stage::Sow | Stage::Arrive => u32::from(config.scheme == Scheme::FastMarching),
        // As many looks a row as a row has pixels, and a last row that finds no pixel left.
        Stage::March if config.scheme == Scheme::FastMarching => march::looks(config.farthest()).saturating_add(1),
        Stage::March => 0,
        Stage::Done => 0,
        _ => 1,
    }
}

/// The most row operations that a stage can take in a frame of `height` rows.
pub fn rows(config: &Config, height: usize, stage: Stage) -> u64 {
    u64::from(passes(config, stage)).saturating_mul(height as u64)
}

/// The most row operations of a whole run.
pub fn total_rows(config: &Config, height: usize) -> u64 {
    Stage::ALL.iter().fold(0, |sum, &stage| sum.saturating_add(rows(config, height, stage)))
}

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
        Stage::Filter => match config.filter {
            Filter::None => "none",
            Filter::Heat => "heat",
            Filter::PeronaMalik { diffusivity: Diffusivity::F1, .. } => "perona-malik-f1",
            Filter::PeronaMalik { diffusivity: Diffusivity::F2, .. } => "perona-malik-f2",
        },
        Stage::Edge => match config.edge {
            Edge::G1 { p } if root(p) => "g1",
            Edge::G1 { .. } => "g1-power",
            Edge::G2 | Edge::G2Mod { .. } => "g2",
        },
        Stage::Evolve => step(config),
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
        (Scheme::FastMarching, _, _) => "none",
    }
}
