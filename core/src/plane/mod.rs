//! Planes of pixels, and what goes over them: rows and tiles, the sweep that moves a front in place,
//! smoothing, and the sorting of samples.
//!
//! Planes are row-major; row 0 comes first and is the bottom row of a FITS image. Pixel centres
//! have whole coordinates from (0, 0).

pub(crate) mod beside;
pub mod camera;
pub mod crew;
pub mod field;
pub mod grid;
pub mod lattice;
pub mod mask;
pub mod part;
#[deny(clippy::arithmetic_side_effects)]
pub mod raster;
pub mod rows;
pub mod smooth;
pub mod sort;
pub mod sweep;
pub mod tiles;
#[deny(clippy::arithmetic_side_effects)]
pub(crate) mod walk;
