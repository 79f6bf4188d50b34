//! What a picture format is decoded to.

/// A decoded picture, top row first.
pub(super) struct Picture {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) pixels: Vec<f32>,
    /// Bits of a sample.
    pub(super) bitpix: i64,
}
