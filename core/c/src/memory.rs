//! One block of memory, divided into what a run needs.

use core::mem::{align_of, size_of};
use skyfront_core::run::memory::{flags_len, ring_cells};
use skyfront_core::sky::otsu::Histogram;
use skyfront_core::sources::catalog::Source;

/// What a piece may begin after, so that it is aligned.
pub(crate) const ALIGNMENT: usize = 16;

/// The rest of a block.
pub struct Block {
    next: *mut u8,
    left: usize,
}

impl Block {
    /// A block of the caller's.
    ///
    /// # Safety
    /// `start` points to `bytes` bytes that nobody else uses for as long as what is taken from the block is used.
    pub unsafe fn new(start: *mut u8, bytes: usize) -> Block {
        Block { next: start, left: bytes }
    }

    /// A piece of the block for `count` values; none where it is too small.
    pub fn take<T>(&mut self, count: usize) -> Option<*mut T> {
        let padding = self.next.align_offset(align_of::<T>());
        let bytes = count.checked_mul(size_of::<T>())?.checked_add(padding)?;
        let left = self.left.checked_sub(bytes)?;
        // SAFETY: both places lie within the block, of which `bytes` are left at least.
        let (piece, next) = unsafe { (self.next.add(padding), self.next.add(bytes)) };
        (self.next, self.left) = (next, left);
        Some(piece.cast())
    }

    /// A piece filled with a value.
    pub fn filled<T: Copy>(&mut self, count: usize, value: T) -> Option<&'static mut [T]> {
        let piece = self.take::<T>(count)?;
        for index in 0..count {
            // SAFETY: the piece has room for `count` values and is aligned for them.
            unsafe { piece.add(index).write(value) };
        }
        // SAFETY: all values were just written, and the block gives no piece twice. How long the memory stays is
        // the promise made to `new`.
        Some(unsafe { core::slice::from_raw_parts_mut(piece, count) })
    }
}

/// Bytes of the slices of a run, each with what its alignment may cost; 0 where they cannot be counted.
pub const fn slices(width: usize, height: usize, sources: usize) -> usize {
    const MOST: usize = 1 << 28;
    /// What the alignment of seven slices may cost.
    const PADDING: u128 = 7 * ALIGNMENT as u128;
    if width > MOST || height > MOST || sources > MOST {
        return 0;
    }
    let (width, height, sources) = (width as u128, height as u128, sources as u128);
    let ring = ring_cells(width as usize, true) as u128;
    let flags = flags_len(width as usize, height as usize) as u128;
    let cells = width.saturating_mul(height).saturating_mul(2).saturating_add(ring).saturating_add(width);
    let bytes = cells
        .saturating_mul(size_of::<f32>() as u128)
        .saturating_add(flags)
        .saturating_add(sources.saturating_mul(size_of::<Source>() as u128))
        .saturating_add(size_of::<Histogram>() as u128)
        .saturating_add(PADDING);
    if bytes > isize::MAX as u128 { 0 } else { bytes as usize }
}
