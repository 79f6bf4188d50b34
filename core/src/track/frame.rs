//! A frame as it lies in the camera's buffer.

use crate::error::Error;

mod sealed {
    pub trait Sealed {}
    impl Sealed for u8 {}
    impl Sealed for u16 {}
}

/// A pixel of a camera: a byte or two, in the processor's order.
pub trait Pixel: sealed::Sealed + Copy {
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

/// Rows of pixels, row-major, each `stride` pixels after the one before.
#[derive(Clone, Copy, Debug)]
pub struct Raster<'a, P> {
    pixels: &'a [P],
    pub(super) width: usize,
    pub(super) height: usize,
    stride: usize,
}

impl<'a, P: Pixel> Raster<'a, P> {
    /// A frame of `width` x `height` pixels, at most 65535 along an axis.
    ///
    /// # Errors
    /// [`Error::Size`] for an impossible size, [`Error::Parameter`] for a stride shorter than a row,
    /// [`Error::Length`] for a slice that ends before the last row does.
    pub fn new(pixels: &'a [P], width: usize, height: usize, stride: usize) -> Result<Self, Error> {
        const MOST: usize = u16::MAX as usize;
        let least = usize::from(super::SIDES.0);
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

    /// Columns `x` of row `y`; none where they do not lie in the frame.
    #[inline(always)]
    pub(crate) fn row(&self, y: usize, x: core::ops::Range<usize>) -> &'a [P] {
        let start = y.saturating_mul(self.stride);
        self.pixels.get(start.saturating_add(x.start)..start.saturating_add(x.end)).unwrap_or(&[])
    }
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
