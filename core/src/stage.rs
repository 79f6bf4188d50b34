//! The stages of a run and their order.

use crate::config::Order;

/// The steps, in the order of a run; each is one pass over the rows, or several.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Extremes of the pixels (one pass).
    Extremes,
    /// The low percentile (four passes), where asked for.
    LowPercentile,
    /// The high percentile (four passes), where asked for.
    HighPercentile,
    /// The median, which stands in for undefined pixels (four passes), where there are any.
    Median,
    /// Pixels into the image plane.
    Normalize,
    /// Otsu's histogram, where `r3` asks for it.
    Otsu,
    /// Rescaling in place.
    Rescale,
    /// The filter, one pass a step.
    Filter,
    /// Extremes of the gradient.
    Gradient,
    /// The image plane becomes the edge detector.
    Edge,
    /// `u0` into the front plane, or a check of the caller's.
    Front,
    /// The front moves, one pass a step.
    Evolve,
    /// Provisional labels (label pass 1).
    Provisional,
    /// Label pass 2, over the table.
    Resolve,
    /// Label pass 3.
    Count,
    /// Label pass 4, over the table.
    Number,
    /// Label pass 5, and the catalogue.
    Measure,
    /// Nothing left to do.
    Done,
}

impl Stage {
    /// The order of all stages.
    pub(crate) fn following(self, order: Order) -> Stage {
        use Order::{FilterFirst, RescaleFirst};
        match (self, order) {
            (Stage::Extremes, _) => Stage::LowPercentile,
            (Stage::LowPercentile, _) => Stage::HighPercentile,
            (Stage::HighPercentile, _) => Stage::Median,
            (Stage::Median, _) => Stage::Normalize,
            (Stage::Normalize, RescaleFirst) | (Stage::Filter, FilterFirst) => Stage::Otsu,
            (Stage::Otsu, _) => Stage::Rescale,
            (Stage::Normalize, FilterFirst) | (Stage::Rescale, RescaleFirst) => Stage::Filter,
            (Stage::Rescale, FilterFirst) | (Stage::Filter, RescaleFirst) => Stage::Gradient,
            (Stage::Gradient, _) => Stage::Edge,
            (Stage::Edge, _) => Stage::Front,
            (Stage::Front, _) => Stage::Evolve,
            (Stage::Evolve, _) => Stage::Provisional,
            (Stage::Provisional, _) => Stage::Resolve,
            (Stage::Resolve, _) => Stage::Count,
            (Stage::Count, _) => Stage::Number,
            (Stage::Number, _) => Stage::Measure,
            (Stage::Measure | Stage::Done, _) => Stage::Done,
        }
    }

    /// Whether the stage asks for the original pixels.
    pub(crate) fn reads_frame(self) -> bool {
        matches!(
            self,
            Stage::Extremes
                | Stage::LowPercentile
                | Stage::HighPercentile
                | Stage::Median
                | Stage::Normalize
                | Stage::Otsu
                | Stage::Provisional
                | Stage::Measure
        )
    }
}
