//! How long a run can take at most, known before it starts.
//!
//! Time is counted in row operations: one row of one pass. Each costs O(W): a row of a sweep, a
//! row of statistics, or W entries of the label table. In the label passes a look-up follows at
//! most W links, because only labels joined in the last two rows can lie between a label of the
//! row before and the first label of its component.

use crate::config::{Config, Filter, Normalize, Rescale, Scheme, Start, Tau};
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
