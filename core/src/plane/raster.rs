//! A frame as it lies in memory: single precision, or the counts of a camera in its own buffer.

use crate::error::Error;
use crate::plane::grid::Grid;
use core::fmt::Debug;
use core::ops::Range;
use core::sync::atomic::{AtomicU8, AtomicU16, Ordering};

pub(crate) mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for u8 {}
    impl Sealed for u16 {}
    impl Sealed for super::AtomicU8 {}
    impl Sealed for super::AtomicU16 {}
}

/// What a pixel is kept as.
pub trait Sample: sealed::Sealed + Debug + Sync {
    /// Whether others may write to it while a run reads it, as a camera may to its buffer. Such a frame is
    /// summed up as it is read, and one that was changed is [`Error::FrameChanged`].
    const CHANGES: bool = false;

    /// Its value; not finite where it is undefined.
    fn value(&self) -> f32;
}

impl Sample for f32 {
    #[inline(always)]
    fn value(&self) -> f32 {
        *self
    }
}

impl Sample for u8 {
    #[inline(always)]
    fn value(&self) -> f32 {
        f32::from(*self)
    }
}

impl Sample for u16 {
    #[inline(always)]
    fn value(&self) -> f32 {
        f32::from(*self)
    }
}

impl Sample for AtomicU8 {
    const CHANGES: bool = true;

    #[inline(always)]
    fn value(&self) -> f32 {
        f32::from(self.load(Ordering::Relaxed))
    }
}

impl Sample for AtomicU16 {
    const CHANGES: bool = true;

    #[inline(always)]
    fn value(&self) -> f32 {
        f32::from(self.load(Ordering::Relaxed))
    }
}

/// A pixel of a camera: a byte or two, in the processor's order.
pub trait Pixel: Sample + Copy {
    /// How many bits it has.
    const BITS: u32;

    /// Its value, counts.
    fn count(self) -> u16;
}

impl Pixel for u8 {
    const BITS: u32 = 8;

    #[inline(always)]
    fn count(self) -> u16 {
        u16::from(self)
    }
}

impl Pixel for u16 {
    const BITS: u32 = 16;

    #[inline(always)]
    fn count(self) -> u16 {
        self
    }
}

/// The least number of columns, and of rows, of a camera's frame.
pub(crate) const LEAST_SIDE: u16 = 8;

/// Rows of pixels, row-major, each `stride` pixels after the one before.
#[derive(Debug)]
pub struct Raster<'a, P> {
    pixels: &'a [P],
    pub(crate) width: usize,
    pub(crate) height: usize,
    stride: usize,
}

impl<P> Clone for Raster<'_, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<P> Copy for Raster<'_, P> {}

impl<'a, P: Sample> Raster<'a, P> {
    /// A frame of `width` x `height` pixels, 8 to 65535 along an axis.
    ///
    /// # Errors
    /// [`Error::Size`] for an impossible size, [`Error::Parameter`] for a stride shorter than a row,
    /// [`Error::Length`] for a slice that ends before the last row does.
    pub fn new(pixels: &'a [P], width: usize, height: usize, stride: usize) -> Result<Self, Error> {
        const MOST: usize = u16::MAX as usize;
        let least = usize::from(LEAST_SIDE);
        if width < least || height < least || width > MOST || height > MOST {
            let most_pixels = MOST.saturating_mul(MOST);
            return Err(Error::Size { width, height, least, most_columns: MOST, most_pixels });
        }
        if stride < width {
            let (value, limit) = (stride as f32, width as f32);
            return Err(Error::Parameter { name: "stride", value, bound: "at least", limit });
        }
        let needed = stride.saturating_mul(height.saturating_sub(1)).saturating_add(width);
        if pixels.len() < needed {
            return Err(Error::Length { name: "frame", given: pixels.len(), needed });
        }
        Ok(Raster { pixels, width, height, stride })
    }

    /// The whole rows of pixels that lie one behind the other, of whatever size.
    pub fn of(pixels: &'a [P], width: usize) -> Self {
        let width = width.max(1);
        Raster { pixels, width, height: Grid::of(pixels.len(), width).map_or(0, |grid| grid.height), stride: width }
    }

    /// Number of pixels.
    pub fn count(&self) -> usize {
        self.width.saturating_mul(self.height)
    }

    /// Columns `x` of row `y`; none where they do not lie in the frame.
    #[inline(always)]
    pub(crate) fn part(&self, y: usize, x: Range<usize>) -> &'a [P] {
        let start = y.saturating_mul(self.stride);
        self.pixels.get(start.saturating_add(x.start)..start.saturating_add(x.end)).unwrap_or(&[])
    }

    /// Row `y`; empty beyond the frame.
    #[inline(always)]
    pub fn row(&self, y: usize) -> &'a [P] {
        if y < self.height { self.part(y, 0..self.width) } else { &[] }
    }

    /// The value of a pixel by its index, counted without what lies between two rows; `None` beyond the frame.
    #[inline(always)]
    pub fn value(&self, at: usize) -> Option<f32> {
        let place = if self.stride == self.width {
            at
        } else {
            let (y, x) = (at.checked_div(self.width)?, at.checked_rem(self.width)?);
            y.saturating_mul(self.stride).saturating_add(x)
        };
        if at < self.count() { self.pixels.get(place).map(Sample::value) } else { None }
    }

    /// The sum of [`mixed`] values of all pixels of some rows.
    pub(crate) fn checksum(&self, rows: Range<usize>) -> u32 {
        let first = rows.start.saturating_mul(self.width) as u32;
        let pixels = rows.flat_map(|y| self.row(y)).zip(first..);
        pixels.fold(0, |sum, (pixel, at)| sum.wrapping_add(mixed(at, pixel.value())))
    }
}

/// What a pixel adds to the checksum of a frame, by its index: no change of one value adds the same, and values that
/// trade places add something else.
#[inline(always)]
pub(crate) fn mixed(at: u32, value: f32) -> u32 {
    (value.to_bits() ^ at.wrapping_mul(0x9E37_79B1)).wrapping_mul(0x85EB_CA6B)
}

/// A pixel that is never to be used.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadPixel {
    /// Its column.
    pub x: u16,
    /// Its row.
    pub y: u16,
}

impl BadPixel {
    /// Row by row, and along these.
    #[inline]
    pub(crate) fn place(&self) -> (u16, u16) {
        (self.y, self.x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_is_found_whatever_the_stride() {
        let pixels: [u16; 10 * 12] = core::array::from_fn(|at| at as u16);
        let frame = Raster::new(&pixels, 8, 9, 12).expect("a frame");
        assert_eq!(
            (frame.count(), frame.value(0), frame.value(8), frame.value(71)),
            (72, Some(0.0), Some(12.0), Some(103.0))
        );
        assert_eq!((frame.value(72), frame.row(9).len(), frame.row(8)[0]), (None, 0, 96));
        let rows = Raster::of(&pixels, 7);
        assert_eq!((rows.height, rows.value(118), rows.value(119)), (17, Some(118.0), None));
    }

    #[test]
    fn a_checksum_tells_changes_and_places() {
        let mut pixels = [7u8; 64];
        let sum = |pixels: &[u8]| Raster::of(pixels, 8).checksum(0..8);
        let before = sum(&pixels);
        pixels[9] = 8;
        let changed = sum(&pixels);
        pixels.swap(9, 10);
        assert!(before != changed && changed != sum(&pixels) && before != sum(&pixels));
    }
}
