//! One image through the core's segmenter: memory, the poll loop, and what the outputs need.

use crate::parallel::evolve;
use crate::planes::{BandRoom, Room};
use crate::segmentation::{Drive, Segmentation, StagePlanes, room_for_sources};
use skyfront_core::arithmetic::{Arithmetic, Cell, Real};
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::front::scheme::Still;
use skyfront_core::run::frame::{BandFrame, SliceFrame};
use skyfront_core::run::outcome::Progress;
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::stage::Stage;
use std::time::{Duration, Instant};

/// Segments an image of `width` x `height` pixels, row-major, NaN = undefined, by a front alone.
///
/// # Errors
/// What the core finds wrong with the configuration or the image.
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
    let all: Vec<&[f32]> = std::iter::once(pixels).chain(drive.bands.iter().copied()).collect();
    let mut band_room = BandRoom::<A>::new(if drive.bands.is_empty() { 0 } else { all.len() }, count);
    let mut segmenter = match drive.bands {
        [] => Segmenter::<A>::new(config, width, height, room.memory())?,
        _ => Segmenter::of_bands(config, width, height, room.memory(), band_room.bands())?,
    };
    let mut stages = StagePlanes::default();
    let (mut convergence, mut seconds, mut front_values) = (Vec::new(), Vec::new(), Vec::new());
    let (mut stage, mut started) = (segmenter.stage(), Instant::now());
    let outcome = loop {
        let bands = if drive.threads > 1 { segmenter.evolution() } else { None };
        let progress = match bands {
            None => segmenter.poll(drive.slice, &mut BandFrame(&all))?,
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
                Stage::Evolve | Stage::Arrive | Stage::Turn if segmenter.stage() != Stage::Turn => {
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

/// An image that was filtered in steps.
#[derive(Clone, Debug)]
pub struct Filtered {
    /// Row-major, in units of the pixels.
    pub image: Vec<f32>,
    /// Wall time of each stage.
    pub seconds: Vec<(Stage, Duration)>,
}

/// Filters an image of `width` columns, row-major, NaN = undefined, for a front that is not a segmenter's.
///
/// # Errors
/// What the core finds wrong with the configuration or the image.
pub fn filter_in<A: Arithmetic>(
    config: &Config,
    pixels: &[f32],
    width: usize,
    drive: &mut Drive<'_>,
) -> Result<Filtered, Error> {
    let height = pixels.len() / width.max(1);
    let mut room = Room::<A>::new(config, width, height, 0);
    let mut segmenter = Segmenter::<A, Still>::new(config, width, height, room.memory())?;
    let (mut stage, mut started, mut seconds) = (segmenter.stage(), Instant::now(), Vec::new());
    let range = loop {
        let progress = segmenter.poll(drive.slice, &mut SliceFrame(pixels))?;
        if let Some(watch) = &mut drive.watch {
            watch(&progress);
        }
        if segmenter.stage() != stage {
            seconds.push((stage, started.elapsed()));
            (stage, started) = (segmenter.stage(), Instant::now());
        }
        if let Progress::Done(outcome) = progress {
            break outcome.range;
        }
    };
    let image = segmenter.image().iter().map(|&cell| range.pixel(A::pixel(cell).to_f32())).collect();
    Ok(Filtered { image, seconds })
}
