//! The paper's steps 1 to 3: pixel values become numbers in [0, 1], intensities are rescaled so
//! that faint objects stand out, and noise is smoothed away.

pub mod filter;
pub mod normalize;
pub mod rescale;
