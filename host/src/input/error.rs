//! Why a map cannot be used, in one line that names the option and the file.

use crate::read::ReadError;

/// A map that was refused.
#[derive(Debug, thiserror::Error)]
#[error("--{option}: {reason}")]
pub struct MapError {
    /// The option that named it.
    pub option: &'static str,
    /// Why.
    pub reason: Reason,
}

/// Why a map was refused.
#[derive(Debug, thiserror::Error)]
pub enum Reason {
    /// It could not be read.
    #[error("{0}")]
    Unreadable(#[from] ReadError),
    /// It has another shape than the image.
    #[error("{file} has {width} x {height} pixels, the image {image_width} x {image_height}")]
    Shape {
        /// The map.
        file: String,
        /// Its columns.
        width: u64,
        /// Its rows.
        height: u64,
        /// Columns of the image.
        image_width: usize,
        /// Rows of the image.
        image_height: usize,
    },
    /// It does not hold what its kind of map holds.
    #[error("{file} is no such map: pixel ({x}, {y}) is {value}, but {wanted}")]
    Content {
        /// The map.
        file: String,
        /// Column of the first wrong pixel, from 1.
        x: usize,
        /// Its row, from 1.
        y: usize,
        /// Its value.
        value: f32,
        /// What the map must hold.
        wanted: &'static str,
    },
    /// No pixel of the image is left.
    #[error("{file} leaves no pixel of the image: {why}")]
    NothingLeft {
        /// The map.
        file: String,
        /// What the map removes.
        why: &'static str,
    },
    /// It lies elsewhere on the sky than the image.
    #[error("{file} does not lie where the image does: its pixels are up to {pixels:.1} away by its coordinates")]
    Elsewhere {
        /// The other image.
        file: String,
        /// The greatest distance of a corner from that of the image, in pixels.
        pixels: f64,
    },
    /// A table of places that cannot be used.
    #[error("{0}")]
    Table(String),
    /// The map marks no pixel.
    #[error("{0} marks no pixel: all are 0 or undefined")]
    Empty(String),
}
