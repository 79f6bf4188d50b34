//! What a run reports: how far it is, and what it found.

use crate::image::normalize::{Extremes, Range};
use crate::run::stage::Stage;

/// Which rule ended the evolution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The front came to rest.
    Rest,
    /// `t_max` was reached first.
    TimeLimit,
}

/// What a run found, beside the labels in the front plane and the catalogue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Which rule ended the evolution.
    pub reason: StopReason,
    /// Steps of the front; the time is this many `dt`.
    pub steps: u32,
    /// The paper's norm of the last step's change.
    pub last_change: f32,
    /// Extremes and number of the defined pixels.
    pub extremes: Extremes,
    /// The pixel values that became 0 and 1.
    pub range: Range,
    /// The threshold of `r3`, on the scale of the rescaled image; 0 without `r3`.
    pub tau: f32,
    /// Least and greatest `|grad I|` of the filtered image, per dx.
    pub gradient: (f32, f32),
    /// Pixels of {u > 0} that are defined.
    pub mask_pixels: u32,
    /// Number of sources; labels run from 1 to this.
    pub sources: u32,
    /// How many of them are in the catalogue; the rest found no room there.
    pub catalogued: u32,
    /// Pixels of the mask left without a label because the label table was full.
    pub unlabelled: u32,
    /// Pixels of the mask that no front can have reached by `t_max`; their components are no source.
    pub unreached: u32,
    /// Rows of work done.
    pub work: u64,
}

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// There is more to do.
    Working {
        /// The step under way.
        stage: Stage,
        /// Number of the pass within the stage, from 0.
        pass: u32,
        /// Rows of that pass done.
        row: u32,
        /// The paper's norm of the last complete step of the front.
        last_change: f32,
    },
    /// The labels and the catalogue are there.
    Done(Outcome),
}
