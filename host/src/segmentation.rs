//! What a run gives, and how it is driven.

use crate::background::SkyMaps;
use crate::input::StartMap;
use skyfront_core::plane::part::Whole;
use skyfront_core::run::outcome::{Outcome, Progress};
use skyfront_core::run::stage::Stage;
use skyfront_core::sources::catalog::Source;
use std::time::Duration;

/// Room in the catalogue; more sources are counted and reported.
pub const MOST_SOURCES: usize = 100_000;

/// Room in the catalogue of a front's run over so many pixels.
pub fn room_for_sources(pixels: usize) -> usize {
    (pixels / 4).clamp(1, MOST_SOURCES)
}

/// Planes as they stood after a step, row-major, for pictures and comparisons.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StagePlanes {
    /// Step 1.
    pub normalised: Vec<f32>,
    /// Step 2; empty where nothing was rescaled.
    pub rescaled: Vec<f32>,
    /// Step 3; empty where nothing was filtered.
    pub filtered: Vec<f32>,
    /// Step 4.
    pub edge: Vec<f32>,
}

/// A segmented image.
#[derive(Clone, Debug)]
pub struct Segmentation {
    /// Name of the arithmetic it was made in.
    pub arithmetic: &'static str,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Labels, row-major, 0 = background.
    pub labels: Vec<u32>,
    /// The final front, in its unit; empty where it was given away.
    pub front: Vec<f32>,
    /// Planes of the steps, where they were asked for.
    pub stages: Option<StagePlanes>,
    /// The paper's norm of every step's change.
    pub convergence: Vec<f32>,
    /// The catalogue.
    pub sources: Vec<Source>,
    /// Of every source, whether it was divided from another; none where nothing is divided.
    pub blended: Option<Vec<bool>>,
    /// Of every source, whether it ends in a plateau; empty where that was not looked for.
    pub plateaus: Vec<bool>,
    /// What the run found.
    pub outcome: Outcome,
    /// Sky and noise, where the run measured them.
    pub sky: Option<SkyMaps>,
    /// Wall time of each stage.
    pub seconds: Vec<(Stage, Duration)>,
    /// What must be known of the image and its sky, and why there can be no source.
    pub remarks: Vec<String>,
}

/// Gives the values of a plane from a pixel's index on, row-major.
pub type Values<'a> = dyn Fn(usize, &mut [f32]) + 'a;

/// Receives a front.
pub type TakeFront<'a> = dyn FnMut(&Values<'_>) + 'a;

/// How a run is driven, which changes nothing in its result, and what it is given beside the image.
///
/// ```
/// use skyfront::pipeline::{Drive, segment};
/// use skyfront::truth::simulated;
/// use skyfront_core::config::Config;
/// use skyfront_core::run::outcome::Progress;
/// use skyfront_core::simulate::Kind;
///
/// let (image, _) = simulated(Kind::Bright, 5, 96, 96);
/// let (noise, mut polls) = (vec![8e-4; 96 * 96], 0);
/// let mut watch = |_: &Progress| polls += 1;
/// let (noise, watch) = (Some(&noise[..]), Some(&mut watch as _));
/// let mut drive = Drive { noise, watch, threads: 2, keep_stages: true, ..Drive::default() };
/// let run = segment(&Config::NOISE_AWARE, &image.pixels, 96, 96, &mut drive)?;
/// assert!(polls > 0 && run.stages.is_some());
/// # Ok::<(), skyfront_core::error::Error>(())
/// ```
pub struct Drive<'a> {
    /// Sky of every pixel, for a run on signal-to-noise.
    pub background: Option<&'a [f32]>,
    /// Standard deviation of every pixel's noise, for a run on signal-to-noise.
    pub noise: Option<&'a [f32]>,
    /// Whether that noise only says which pixels are noisier than others.
    pub relative: bool,
    /// The image that this one is a part of, for the noise-aware segmentation.
    pub whole: Option<&'a dyn Whole>,
    /// Further bands of the image, of the same size, for one front in all of them
    /// ([`skyfront_core::front::bands`]).
    pub bands: &'a [&'a [f32]],
    /// Where the front starts, for [`skyfront_core::config::Start::Given`].
    pub start: Option<&'a StartMap>,
    /// Rows a poll.
    pub slice: usize,
    /// Whether to keep the planes of the steps.
    pub keep_stages: bool,
    /// Whether the values of each source's pixels are summed up in [`Segmentation::sources`] by a run on
    /// signal-to-noise; else these have areas and places alone, which is all that the catalogue takes from them.
    pub keep_sums: bool,
    /// Threads for the evolution.
    pub threads: usize,
    /// Takes the final front, in its unit; without it the front is kept in the result.
    pub take_front: Option<&'a mut TakeFront<'a>>,
    /// Called after every poll.
    pub watch: Option<&'a mut dyn FnMut(&Progress)>,
}

impl Default for Drive<'_> {
    /// Whole passes on one thread, no stages kept, nobody watching.
    fn default() -> Self {
        Drive {
            background: None,
            noise: None,
            relative: false,
            whole: None,
            bands: &[],
            start: None,
            slice: usize::MAX,
            keep_stages: false,
            keep_sums: true,
            threads: 1,
            take_front: None,
            watch: None,
        }
    }
}
