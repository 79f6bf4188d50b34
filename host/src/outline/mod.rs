//! The outlines of sources: where the front's zero level runs, to a fraction of a pixel.

mod files;
mod trace;

pub use files::{POLYGONS, REGIONS, write_polygons, write_regions};
pub use trace::{Ring, rings};
