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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    /// In 12 columns and 8 rows: half of the rectangle measures 4 and 2 pixels.
    fn profile(scheme: Scheme, band: Option<f32>) -> Profile {
        Profile::new(&Config { band, ..Config::PAPER_F160.with_scheme(scheme) }, 12, 8)
    }

    fn row(profile: &Profile, y: usize) -> [f32; 12] {
        let mut row = [9.0; 12];
        profile.row::<F32>(y, &mut row);
        row
    }

    #[test]
    fn it_falls_from_the_middle_to_two_pixels_inside_the_frame() {
        let paper = profile(Scheme::Fd, None);
        let half = [-0.375, -0.125, 0.125, 0.375, 0.625, 0.75];
        assert_eq!(row(&paper, 3)[..6], half);
        half.iter().zip(row(&paper, 4).iter().rev()).for_each(|(value, mirrored)| assert_eq!(value, mirrored));
        assert_eq!(row(&paper, 0), [-0.75; 12]);
        assert_eq!((paper.unit, paper.pixel), (1.0, 0.5));
    }

    #[test]
    fn with_a_band_it_is_the_distance_to_the_rectangle() {
        let banded = profile(Scheme::Fd, Some(1.25));
        assert_eq!(row(&banded, 3)[..6], [-1.5, -0.5, 0.5, 1.25, 1.25, 1.25]);
        assert_eq!(row(&banded, 1)[..6], [-1.5, -0.5, -0.5, -0.5, -0.5, -0.5]);
        assert_eq!((banded.unit, banded.pixel), (2.0, 1.0));
        assert_eq!(row(&profile(Scheme::ChanVese, None), 3)[..6], [-1.0, -0.5, 0.5, 1.0, 1.0, 1.0]);
        assert_eq!(row(&profile(Scheme::FastMarching, None), 3)[..6], [-1.5, -0.5, 0.5, 1.5, 1.5, 1.5]);
    }

    #[test]
    fn the_widest_frame_is_the_same_from_both_ends() {
        let columns = MOST_COLUMNS as u32;
        for x in [0, 1, 123_457, columns / 2 - 1] {
            assert_eq!(off_centre(x, columns), off_centre(columns - 1 - x, columns));
        }
        assert_eq!(off_centre(columns / 2, columns), 1.0 / 1_048_572.0);
    }

    #[test]
    fn near_objects_it_is_the_distance_to_them() {
        for (band, expected) in [(None, [1.5, 1.0, -0.5, -0.75]), (Some(2.5), [2.5, 2.0, -1.0, -1.5])] {
            let mut row = [0.0, 1.0, 4.0, 9.0];
            profile(Scheme::Fd, band).outside_row::<F32>(3.0, &mut row);
            assert_eq!(row, expected);
        }
        let mut around = [0.0, 9.0];
        profile(Scheme::Fd, None).around_row(4.0, &mut around);
        assert_eq!(around, [2.0, -2.5]);
        let mut around = [0.0, 9.0];
        profile(Scheme::Fd, Some(2.5)).around_row(4.0, &mut around);
        assert_eq!(around, [4.0, -5.0]);
        turn_row::<F32>(&mut around);
        assert_eq!(around, [-4.0, 5.0]);
    }
}
