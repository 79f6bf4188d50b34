//! The background beside a source: a frame of pixels around it that belong to no source.

use super::{Scene, clipped_scatter};
use skyfront_core::sources::catalog::Source;

/// Width of the frame around the bounding box, pixels (SExtractor's `BACKPHOTO_THICK`).
const WIDTH: usize = 24;

/// Background and noise beside a source; NaN where every pixel there belongs to sources.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Local {
    /// Median of the pixels in the frame, clipped at three standard deviations.
    pub background: f64,
    /// Their standard deviation.
    pub noise: f64,
}

impl Local {
    /// No background.
    pub const NONE: Local = Local { background: f64::NAN, noise: f64::NAN };

    /// The background beside a source.
    pub fn of(scene: &Scene<'_>, source: &Source) -> Local {
        let range = |(first, last): (u32, u32), n: usize| {
            (first as usize).saturating_sub(WIDTH)..(last as usize + WIDTH + 1).min(n)
        };
        let inside = |(first, last): (u32, u32), at: usize| (first as usize..=last as usize).contains(&at);
        let mut values = Vec::new();
        for y in range(source.rows, scene.height) {
            for x in range(source.columns, scene.width) {
                if !(inside(source.rows, y) && inside(source.columns, x)) {
                    values.extend(scene.sky_pixel(y * scene.width + x));
                }
            }
        }
        if values.is_empty() {
            return Local::NONE;
        }
        let (background, noise) = clipped_scatter(values.iter().copied());
        Local { background, noise }
    }
}
