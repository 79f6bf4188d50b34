//! Where the pixels come from: a frame delivers its rows as often as the pipeline asks.

use core::convert::Infallible;

/// A source of image rows: a slice, a camera buffer, a serial memory.
///
/// Row 0 comes first (the bottom row of a FITS image). A pixel that is NaN or infinite is
/// undefined: it takes no part in statistics and never belongs to a source. The pipeline asks for
/// each row several times and must get the same values each time.
pub trait Frame {
    /// What can go wrong while a row is read.
    type Error;

    /// Writes row `y` into `out`, which has one element per column.
    ///
    /// # Errors
    /// Whatever the source reports; the pipeline passes it up and can be polled again.
    fn row(&mut self, y: usize, out: &mut [f32]) -> Result<(), Self::Error>;
}

/// Bands that lie in memory, row-major and of one size: their rows one band after another, as
/// [`Segmenter::of_bands`](crate::run::segmenter::Segmenter::of_bands) asks for them. Rows beyond
/// the slices are undefined.
#[derive(Clone, Copy, Debug)]
pub struct BandFrame<'a>(pub &'a [&'a [f32]]);

impl Frame for BandFrame<'_> {
    type Error = Infallible;

    fn row(&mut self, y: usize, out: &mut [f32]) -> Result<(), Infallible> {
        let height = self.0.first().and_then(|band| band.len().checked_div(out.len())).unwrap_or(0);
        let place = y.checked_div(height).zip(y.checked_rem(height));
        let (band, y) = place.and_then(|(band, y)| Some((*self.0.get(band)?, y))).unwrap_or((&[], 0));
        SliceFrame(band).row(y, out)
    }
}

/// A frame that lies in memory, row-major. Rows beyond the slice are undefined.
#[derive(Clone, Copy, Debug)]
pub struct SliceFrame<'a>(pub &'a [f32]);

impl Frame for SliceFrame<'_> {
    type Error = Infallible;

    fn row(&mut self, y: usize, out: &mut [f32]) -> Result<(), Infallible> {
        let width = out.len();
        let start = y.saturating_mul(width);
        match self.0.get(start..start.saturating_add(width)) {
            Some(row) => out.iter_mut().zip(row).for_each(|(out, &pixel)| *out = pixel),
            None => out.fill(f32::NAN),
        }
        Ok(())
    }
}
