//! Sky background and noise, as they can be known from the frame alone.
//!
//! [`Values`] tells what the detector and the software behind it did to the numbers: steps, a cut
//! at the black level, filling. [`clipped`] estimates level and noise of one cell from its sorted
//! values, and [`Mesh`] lays cells over the frame, bridges those without sky and gives level and
//! noise at every pixel.

#[deny(clippy::arithmetic_side_effects)]
pub mod classes;
mod clipped;
pub mod kapur;
mod mesh;
#[deny(clippy::arithmetic_side_effects)]
pub mod noise;
#[deny(clippy::arithmetic_side_effects)]
pub mod otsu;
pub mod photon;
mod quiet;
pub mod rosin;
#[deny(clippy::arithmetic_side_effects)]
pub mod select;
pub mod signal;
pub mod spike;
pub mod tail;
pub(crate) mod values;
pub mod view;

pub use clipped::{LEAST_PIXELS, clipped};
pub(crate) use mesh::Words;
pub use mesh::{CELL, MOST_CELLS, Mesh, Seen, Survey, cell_pixels, cells_along, mesh_cells};
pub use values::Values;

/// Between this share of the measured noise and all of it, noise by differences is the less certain.
const QUIETER: f32 = 0.9;

/// Background and noise of one cell, in units of the image; NaN where too few pixels are sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// The background level.
    pub level: f32,
    /// Standard deviation of a pixel.
    pub noise: f32,
}

impl Sky {
    /// A cell about which nothing is known.
    pub const UNKNOWN: Sky = Sky { level: f32::NAN, noise: f32::NAN };

    fn known(self) -> bool {
        self.level.is_finite() && self.noise.is_finite()
    }

    /// Takes a noise that is clearly less.
    fn quieten(&mut self, noise: Option<f32>) {
        self.noise = noise.filter(|noise| *noise < QUIETER * self.noise).unwrap_or(self.noise);
    }
}
