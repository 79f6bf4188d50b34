//! One image through the core: memory, the poll loop, and what the outputs need.

use crate::background::SkyMaps;
use crate::extraction;
use crate::input::StartMap;
use crate::machine::Native;
use crate::parallel::evolve;
use crate::planes::Room;
use skyfront_core::arithmetic::{Arithmetic, Cell, F32, Real};
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::plane::part::Whole;
use skyfront_core::run::frame::SliceFrame;
use skyfront_core::run::outcome::{Outcome, Progress};
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::stage::Stage;
use skyfront_core::sources::catalog::Source;
use std::time::{Duration, Instant};

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
pub struct Drive<'a> {
    /// Sky of every pixel, for a run on signal-to-noise.
    pub background: Option<&'a [f32]>,
    /// Standard deviation of every pixel's noise, for a run on signal-to-noise.
    pub noise: Option<&'a [f32]>,
    /// Whether that noise only says which pixels are noisier than others.
    pub relative: bool,
    /// The image that this one is a part of, for the noise-aware segmentation.
    pub whole: Option<&'a dyn Whole>,
    /// Where the front starts, for [`skyfront_core::config::Start::Given`].
    pub start: Option<&'a StartMap>,
    /// Rows a poll.
    pub slice: usize,
    /// Whether to keep the planes of the steps.
    pub keep_stages: bool,
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
            start: None,
            slice: usize::MAX,
            keep_stages: false,
            threads: 1,
            take_front: None,
            watch: None,
        }
    }
}

/// Segments an image of `width` x `height` pixels, row-major, NaN = undefined, in f32.
///
/// # Errors
/// What the core finds wrong with the configuration or the image.
pub fn segment(
    config: &Config,
    pixels: &[f32],
    width: usize,
    height: usize,
    drive: &mut Drive<'_>,
) -> Result<Segmentation, Error> {
    if config.sky.is_known() {
        return extraction::segment::<F32<Native>, f32>(config, pixels, width, drive);
    }
    segment_in::<F32<Native>>(config, pixels, width, height, drive)
}

/// [`segment`] in any arithmetic.
///
/// # Errors
/// As [`segment`].
pub fn segment_in<A: Arithmetic>(
    config: &Config,
    pixels: &[f32],
    width: usize,
    height: usize,
    drive: &mut Drive<'_>,
) -> Result<Segmentation, Error> {
    let count = width * height;
    let mut room = Room::<A>::new(config, width, height, room_for_sources(count));
    if let Some(start) = drive.start {
        start.fill::<A>(config, (width, height), &mut room.front);
    }
    let mut segmenter = Segmenter::<A>::new(config, width, height, room.memory())?;
    let mut stages = StagePlanes::default();
    let (mut convergence, mut seconds, mut front_values) = (Vec::new(), Vec::new(), Vec::new());
    let (mut stage, mut started) = (segmenter.stage(), Instant::now());
    let outcome = loop {
        let bands = if drive.threads > 1 { segmenter.evolution() } else { None };
        let progress = match bands {
            None => segmenter.poll(drive.slice, &mut SliceFrame(pixels))?,
            Some(evolution) => {
                let rule = evolution.rule;
                let (steps, change) = evolve(evolution, drive.threads, &mut |pass, change| {
                    let last_change = rule.norm(change);
                    convergence.push(last_change);
                    if let Some(watch) = &mut drive.watch {
                        watch(&Progress::Working { stage: Stage::Evolve, pass, row: 0, last_change });
                    }
                });
                // The last step's change comes with the outcome, as in a run by polls.
                convergence.pop();
                segmenter.finish_evolution(steps, change)?
            }
        };
        if let Some(watch) = &mut drive.watch {
            watch(&progress);
        }
        if let Progress::Working { stage: Stage::Evolve, row: 0, pass, last_change } = progress
            && pass > 0
        {
            convergence.push(last_change);
        }
        if segmenter.stage() != stage {
            seconds.push((stage, started.elapsed()));
            let image = || segmenter.image().iter().map(|&cell| A::pixel(cell).to_f32()).collect::<Vec<_>>();
            match stage {
                Stage::Normalize if drive.keep_stages => stages.normalised = image(),
                Stage::Rescale if drive.keep_stages => stages.rescaled = image(),
                Stage::Filter if drive.keep_stages => stages.filtered = image(),
                Stage::Edge if drive.keep_stages => stages.edge = image(),
                Stage::Evolve | Stage::Arrive => {
                    let front = segmenter.front();
                    let value = |&cell: &A::Cell| A::level(cell).to_f32();
                    match &mut drive.take_front {
                        Some(take) => take(&|first, out| {
                            out.iter_mut().zip(&front[first..]).for_each(|(out, cell)| *out = value(cell));
                        }),
                        None => front_values = front.iter().map(value).collect(),
                    }
                }
                _ => {}
            }
            (stage, started) = (segmenter.stage(), Instant::now());
        }
        if let Progress::Done(outcome) = progress {
            break outcome;
        }
    };
    convergence.push(outcome.last_change);
    let Room { image, front, mut sources, .. } = room;
    sources.truncate(outcome.catalogued as usize);
    // The labels take the place of the front, in its own memory where cells have the same size.
    drop(image);
    let labels = front.into_iter().map(|cell| cell.label()).collect();
    Ok(Segmentation {
        arithmetic: A::NAME,
        width,
        height,
        labels,
        front: front_values,
        stages: drive.keep_stages.then_some(stages),
        convergence,
        sources,
        blended: None,
        plateaus: Vec::new(),
        outcome,
        sky: None,
        seconds,
        remarks: Vec::new(),
    })
}
