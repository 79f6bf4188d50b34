//! The front before its first step.

use crate::arithmetic::{Arithmetic, Real};
use crate::config::{Config, Scheme};
use crate::front::settle::FLOOR;

/// The least width and height: `u0` begins two pixels inside the frame and needs one inside that.
pub const LEAST_SIDE: usize = 5;
/// The most columns of a frame.
pub const MOST_COLUMNS: usize = 1 << 20;

/// The centred `u0` of spec section 2, in the front's unit.
///
/// `1 - max(|x - cx| / (W dx/2 - 2 dx), |y - cy| / (H dx/2 - 2 dx))`: 1 in the middle of the
/// frame, 0 two pixels inside its border, negative outside. With a band it is the distance to that
/// rectangle in pixels, along the nearer axis, and saturated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    width: usize,
    height: usize,
    /// Units of the front plane in one unit of the paper's `u0`.
    pub unit: f32,
    /// Saturation above and below zero, in units of the front plane.
    band: f32,
    floor: f32,
    /// One pixel, in units of the front plane.
    pixel: f32,
}

impl Profile {
    /// The front of a frame of `width` x `height` pixels, each at least [`LEAST_SIDE`].
    pub fn new(config: &Config, width: usize, height: usize) -> Profile {
        let shorter = width.min(height).saturating_sub(4);
        let half = shorter as f32 * 0.5;
        let (unit, band, floor) = match (config.scheme, config.band) {
            (scheme, _) if scheme.is_by_regions() => (half, 1.0, 1.0),
            (Scheme::FastMarching, band) => (half, band.unwrap_or(half), FLOOR),
            (_, Some(band)) => (half, band, FLOOR),
            (_, None) => (1.0, f32::MAX, f32::MAX),
        };
        Profile { width, height, unit, band, floor, pixel: unit / half }
    }

    /// Saturates a front value.
    #[inline]
    pub fn saturate(&self, value: f32) -> f32 {
        if value > self.band {
            self.band
        } else if value < -self.floor {
            -self.floor
        } else {
            value
        }
    }

    /// Turns a row of distances to the objects, in pixels, into a front `margin` pixels outside.
    pub fn outside_row<A: Arithmetic>(&self, margin: f32, row: &mut [A::Cell]) {
        for cell in row {
            let depth = margin - A::level(*cell).to_f32();
            let depth = if depth < -FLOOR { -FLOOR } else { depth };
            *cell = A::to_level(A::Real::of(self.saturate(depth * self.pixel)));
        }
    }

    /// Turns a row of distances, told apart however far, into a front `margin` pixels outside, not saturated: one
    /// that is to grow is as high around as it is deep inside.
    pub fn around_row(&self, margin: f32, row: &mut [f32]) {
        row.iter_mut().for_each(|cell| *cell = (margin - *cell) * self.pixel);
    }

    /// Writes row `y` of `u0`.
    pub fn row<A: Arithmetic>(&self, y: usize, row: &mut [A::Cell]) {
        let (y, columns, rows) = (y as u32, self.width as u32, self.height as u32);
        let vertical = off_centre(y, rows);
        let height = (self.height.saturating_sub(4)) as f32 * 0.5;
        let width = (self.width.saturating_sub(4)) as f32 * 0.5;
        for (x, cell) in (0u32..).zip(row) {
            let horizontal = off_centre(x, columns);
            let value = if self.band < f32::MAX {
                let (across, along) = (width * (1.0 - horizontal), height * (1.0 - vertical));
                if across < along { across } else { along }
            } else {
                1.0 - if horizontal > vertical { horizontal } else { vertical }
            };
            *cell = A::to_level(A::Real::of(self.saturate(value)));
        }
    }
}

/// Turns a row of a front upside down; 0 stays 0.
pub fn turn_row<A: Arithmetic>(row: &mut [A::Cell]) {
    row.iter_mut().for_each(|cell| *cell = A::to_level(A::Real::ZERO - A::level(*cell)));
}

/// `|x - (n-1)/2| / (n/2 - 2)`, a quotient of two integers and so the same from both ends.
#[inline(always)]
fn off_centre(x: u32, n: u32) -> f32 {
    let offset = (2 * x).abs_diff(n.saturating_sub(1));
    // Signed: vector units turn only such numbers into f32.
    offset as i32 as f32 / n.saturating_sub(4).max(1) as i32 as f32
}
