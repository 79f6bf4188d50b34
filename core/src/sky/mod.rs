//! Sky background and noise: a mesh of cells, each with a clipped mode, a median over the
//! neighbouring cells and bilinear values between their centres.

mod clipped;
mod mesh;

pub use clipped::clipped;
pub use mesh::{CELL, MOST_CELLS, Mesh, cell_pixels, cells_along, mesh_cells};

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
}
