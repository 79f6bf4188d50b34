//! One image through the core, on signal-to-noise or on pixel values.

use crate::extraction;
use crate::machine::Native;
use skyfront_core::arithmetic::F32;
use skyfront_core::config::Config;
use skyfront_core::error::Error;

pub use crate::evolution::segment_in;
pub use crate::segmentation::{Drive, MOST_SOURCES, Segmentation, StagePlanes, TakeFront, Values, room_for_sources};

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
