//! The caller's memory, and how much of it a run needs.

use crate::arithmetic::{Arithmetic, Cell};
use crate::error::Error;
use crate::front::bands::Band;
use crate::plane::sweep::ring_len;
pub use crate::plane::tiles::flags_len;
use crate::sky::otsu::Histogram;
use crate::sources::catalog::Source;

/// The slices a run works in. All are overwritten; none needs to be cleared.
#[derive(Debug)]
pub struct Memory<'m, A: Arithmetic> {
    /// W x H cells: the image, then the edge detector, at the end the label table.
    pub image: &'m mut [A::Cell],
    /// W x H cells: the front, at the end the labels (0 = background).
    pub front: &'m mut [A::Cell],
    /// [`ring_cells`] cells: old rows of the sweep under way.
    pub ring: &'m mut [A::Cell],
    /// [`flags_len`] bytes: which tiles of the front can still move.
    pub tiles: &'m mut [u8],
    /// W samples: the row of original pixels at work.
    pub samples: &'m mut [f32],
    /// The counts of the pass under way: of brightness for a threshold, of digits for a percentile.
    pub counts: &'m mut Histogram,
    /// The catalogue, as long as the caller likes; sources beyond its end are counted.
    pub sources: &'m mut [Source],
}

/// Rows of old values that the widest kernel of a scheme needs: 11 with semi-Lagrangian
/// curvature, else 3.
pub const fn window(sl_curvature: bool) -> usize {
    if sl_curvature { 11 } else { 3 }
}

/// Cells of [`Memory::ring`] for a frame of `width` columns.
pub const fn ring_cells(width: usize, sl_curvature: bool) -> usize {
    ring_len(width, window(sl_curvature))
}

/// All bytes of [`Memory`], for cells of `cell_bytes` and a catalogue of `sources`.
pub const fn bytes(width: usize, height: usize, cell_bytes: usize, sl_curvature: bool, sources: usize) -> usize {
    cell_bytes * (2 * width * height + ring_cells(width, sl_curvature))
        + flags_len(width, height)
        + size_of::<f32>() * width
        + size_of::<Histogram>()
        + size_of::<Source>() * sources
}

/// All bytes of [`Bands`](crate::front::bands::Bands), for cells of `cell_bytes`: what a run over so many bands needs
/// beside [`bytes`].
pub const fn band_bytes(width: usize, height: usize, cell_bytes: usize, bands: usize) -> usize {
    bands * (cell_bytes * width * height + size_of::<Band>())
}

/// More than a [`crate::run::segmenter::Segmenter`] itself takes, whatever its arithmetic and scheme.
pub const SEGMENTER_BYTES: usize = 1280;

/// The greatest catalogue with which a run, the segmenter and the catalogue included, stays within
/// two cells a pixel and 64 bytes a column; for frames of 300 columns and more, and not much taller.
pub const fn catalogue_room(width: usize, height: usize, cell_bytes: usize, sl_curvature: bool) -> usize {
    let planes = cell_bytes * 2 * width * height;
    let rest = bytes(width, height, cell_bytes, sl_curvature, 0) - planes + SEGMENTER_BYTES;
    (64 * width).saturating_sub(rest) / size_of::<Source>()
}

impl<A: Arithmetic> Memory<'_, A> {
    /// Checks every slice but the catalogue against the frame and the window of the scheme.
    ///
    /// # Errors
    /// [`Error::Length`] names the first slice that is too short.
    pub fn check(&self, width: usize, height: usize, window: usize) -> Result<(), Error> {
        let enough = |name, given, needed| {
            if given >= needed { Ok(()) } else { Err(Error::Length { name, given, needed }) }
        };
        let pixels = width.saturating_mul(height);
        enough("the image plane", self.image.len(), pixels)?;
        enough("the front plane", self.front.len(), pixels)?;
        enough("the ring of old rows", self.ring.len(), ring_len(width, window.max(3)))?;
        enough("the flags of the tiles", self.tiles.len(), flags_len(width, height))?;
        enough("the sample row", self.samples.len(), width)
    }

    /// Bytes in use, as [`bytes`] counts them.
    pub fn bytes(&self) -> usize {
        A::Cell::BYTES * (self.image.len() + self.front.len() + self.ring.len())
            + self.tiles.len()
            + size_of_val(self.samples)
            + size_of_val(self.counts)
            + size_of_val(self.sources)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::arithmetic::F32;

    #[test]
    fn the_bytes_in_use_are_those_that_are_stated() {
        const SIDE: usize = 20;
        let (mut planes, mut ring) = ([[0.0; SIDE * SIDE]; 2], [0.0; ring_cells(SIDE, false)]);
        let (mut tiles, mut samples) = ([0; flags_len(SIDE, SIDE)], [0.0; SIDE]);
        let (mut counts, mut sources) = (Histogram::EMPTY, [Source::empty(1); 3]);
        let [image, front] = &mut planes;
        let memory = Memory::<F32> {
            image,
            front,
            ring: &mut ring,
            tiles: &mut tiles,
            samples: &mut samples,
            counts: &mut counts,
            sources: &mut sources,
        };
        assert_eq!(memory.bytes(), bytes(SIDE, SIDE, 4, false, 3));
    }
}
