//! Why the reference refuses to run.

use thiserror::Error;

/// An input the algorithm is not defined for.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ReferenceError {
    /// The slice is not a W x H image of at least 5 x 5 pixels.
    #[error("{pixels} pixels are not a {width} x {height} image of at least 5 x 5")]
    Size {
        /// Length of the slice.
        pixels: usize,
        /// Columns asked for.
        width: usize,
        /// Rows asked for.
        height: usize,
    },
    /// No pixel is finite, or the two levels of the normalisation coincide.
    #[error("the image has no two different levels to normalise between")]
    Constant,
    /// No pixel tells the sky or its noise.
    #[error("no pixel tells the sky or its noise")]
    NoSky,
    /// A parameter is out of its bounds.
    #[error("{name} = {value} is out of bounds: {bound}")]
    Parameter {
        /// The parameter's name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The condition it breaks.
        bound: &'static str,
    },
}
