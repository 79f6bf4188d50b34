//! Images in which nothing can stand out: constant or blank ones, and those too small to have a sky.
//!
//! They are no error on the ground, where one of a thousand frames may be blank: the run has no
//! source, and says why.

use crate::read::Image;
use crate::remarks::share;
use crate::segmentation::{Drive, Segmentation, StagePlanes};
use skyfront_core::error::Error;
use skyfront_core::image::normalize::{Extremes, Range};
use skyfront_core::run::outcome::{Outcome, StopReason};

/// The run over an image that the core refused for this reason; the error again where it is a real one.
///
/// # Errors
/// Whatever does not mean that the image has no source.
pub fn found(
    refused: Error,
    image: &Image,
    arithmetic: &'static str,
    drive: &mut Drive<'_>,
) -> Result<Segmentation, Error> {
    let (width, height) = (image.width, image.height);
    let remark = match refused {
        Error::Constant { value } => format!("all pixels that decide equal {value}: nothing stands out"),
        Error::Size { least, .. } if width < least || height < least => {
            format!("{width} x {height} pixels are too few: sources need at least {least} x {least}")
        }
        Error::NoNoise { value, equal, defined } if equal == defined => {
            format!("all {defined} defined pixels equal {value}: nothing stands out")
        }
        Error::NoNoise { value, equal, defined } => format!(
            "{} of the {defined} defined pixels equal {value}, and the rest shows no noise that sources could stand \
             out of; --weight N --weight-type rms gives it",
            share(equal as usize, defined as usize)
        ),
        Error::NoSky { defined, needed } => format!(
            "{} of the pixels are defined, and in no cell of the sky as many as {needed}: sky and noise cannot be \
             measured; --background N and --weight N --weight-type rms give them",
            share(defined as usize, width * height)
        ),
        Error::NothingDefined { .. } => "no pixel is defined: nothing can be found".to_owned(),
        real => return Err(real),
    };
    let mut extremes = Extremes::NONE;
    image.pixels.chunks_exact(width).for_each(|row| extremes.observe(row));
    // The front has passed everywhere.
    const PASSED: f32 = -1.0;
    if let Some(take) = &mut drive.take_front {
        take(&|_, out| out.fill(PASSED));
    }
    let kept = if drive.take_front.is_none() { width * height } else { 0 };
    let flat = vec![0.0; if drive.keep_stages { width * height } else { 0 }];
    Ok(Segmentation {
        arithmetic,
        width,
        height,
        labels: vec![0; width * height],
        front: vec![PASSED; kept],
        stages: drive.keep_stages.then(|| StagePlanes {
            normalised: flat.clone(),
            rescaled: Vec::new(),
            filtered: flat.clone(),
            edge: flat,
        }),
        convergence: Vec::new(),
        sources: Vec::new(),
        blended: None,
        plateaus: Vec::new(),
        outcome: without_front(extremes),
        sky: None,
        seconds: Vec::new(),
        remarks: vec![remark],
    })
}

/// What a run tells in which no front moved, as long as it has no source.
pub fn without_front(extremes: Extremes) -> Outcome {
    Outcome {
        reason: StopReason::Rest,
        steps: 0,
        last_change: 0.0,
        extremes,
        range: Range { low: extremes.least, high: extremes.greatest },
        tau: 0.0,
        gradient: (0.0, 0.0),
        mask_pixels: 0,
        sources: 0,
        catalogued: 0,
        unlabelled: 0,
        unreached: 0,
        work: 0,
    }
}
