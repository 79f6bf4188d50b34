//! The background beside a source: a frame of pixels around it that belong to no source.

use super::{Scene, clipped_scatter};
use skyfront_core::sources::catalog::Source;
use std::ops::Range;

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
        let range = |(first, last): (u32, u32), most: &Range<usize>| {
            (first as usize).saturating_sub(WIDTH).max(most.start)..(last as usize + WIDTH + 1).min(most.end)
        };
        let (columns, last) = (range(source.columns, &(0..scene.width)), source.columns.1 as usize);
        let mut values = Vec::new();
        for y in range(source.rows, &scene.rows) {
            let within = (source.rows.0 as usize..=source.rows.1 as usize).contains(&y);
            // Beside the bounding box, or above and below it.
            let (left, right) = if within { (source.columns.0 as usize, last + 1) } else { (columns.end, columns.end) };
            let pixels = (columns.start..left).chain(right..columns.end);
            values.extend(pixels.filter_map(|x| scene.sky_pixel(scene.index(x, y))));
        }
        if values.is_empty() {
            return Local::NONE;
        }
        let (background, noise) = clipped_scatter(values.iter().copied());
        Local { background, noise }
    }
}
