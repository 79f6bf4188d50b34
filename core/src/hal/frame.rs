//! An image in a serial memory as a source of rows.

use super::pixels::PixelFormat;
use super::serial::{CHUNK, MemoryError, SerialMemory, in_range};
use crate::run::frame::Frame;
use embedded_hal::spi::SpiDevice;

/// Streams the rows of an image, row-major and without gaps, out of a serial memory.
///
/// Cost of a row: its bytes, and a transaction for each [`CHUNK`] of them. The memory can be used for
/// other things between two polls through [`Self::memory`].
///
/// ```
/// use embedded_hal::spi::{self, ErrorType, Operation, SpiDevice};
/// use skyfront_core::hal::{MemoryFrame, PixelFormat, SerialMemory};
/// use skyfront_core::run::frame::Frame;
///
/// /// A memory of 16 bytes, from which alone is read: the instruction, the address, then the data.
/// struct Rom([u8; 16]);
///
/// impl ErrorType for Rom {
///     type Error = spi::ErrorKind;
/// }
///
/// impl SpiDevice for Rom {
///     fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), spi::ErrorKind> {
///         let [Operation::Write([0x03, .., address]), Operation::Read(out)] = operations else {
///             return Err(spi::ErrorKind::Other);
///         };
///         let first = usize::from(*address);
///         out.copy_from_slice(&self.0[first..first + out.len()]);
///         Ok(())
///     }
/// }
///
/// // Two rows of three pixels from address 4 on; 0xffff says that a pixel is saturated.
/// let rom = Rom([0, 0, 0, 0, 1, 0, 2, 0, 3, 0, 0xff, 0xff, 0, 1, 7, 0]);
/// let frame = MemoryFrame::new(SerialMemory::new(rom), 4, 3, 2, PixelFormat::U16Le)?;
/// let (mut frame, mut row) = (frame.with_undefined(0xffff), [0.0; 3]);
/// frame.row(0, &mut row)?;
/// assert_eq!(row, [1.0, 2.0, 3.0]);
/// frame.row(1, &mut row)?;
/// assert!(row[0].is_nan() && row[1..] == [256.0, 7.0]);
/// assert!(frame.row(2, &mut row).is_err());
/// # Ok::<(), skyfront_core::hal::MemoryError<spi::ErrorKind>>(())
/// ```
#[derive(Debug)]
pub struct MemoryFrame<D> {
    memory: SerialMemory<D>,
    start: u32,
    width: usize,
    height: usize,
    format: PixelFormat,
    undefined: Option<u16>,
}

impl<D: SpiDevice> MemoryFrame<D> {
    /// The image of `width` x `height` pixels from address `start` on.
    ///
    /// # Errors
    /// [`MemoryError::Range`] when it does not lie within 24-bit addresses.
    pub fn new(
        memory: SerialMemory<D>,
        start: u32,
        width: usize,
        height: usize,
        format: PixelFormat,
    ) -> Result<Self, MemoryError<D::Error>> {
        in_range(start, width.saturating_mul(height).saturating_mul(format.bytes()))?;
        Ok(MemoryFrame { memory, start, width, height, format, undefined: None })
    }

    /// The same image, in which pixels of this value are undefined (dead, saturated or masked).
    #[must_use]
    pub fn with_undefined(self, value: u16) -> Self {
        MemoryFrame { undefined: Some(value), ..self }
    }

    /// The memory, to write results to between or after the polls of a run.
    pub fn memory(&mut self) -> &mut SerialMemory<D> {
        &mut self.memory
    }

    /// Gives the memory back.
    pub fn release(self) -> SerialMemory<D> {
        self.memory
    }

    fn pixel(&self, bytes: &[u8]) -> f32 {
        let value = self.format.decode(bytes);
        if self.undefined == Some(value) { f32::NAN } else { f32::from(value) }
    }
}

impl<D: SpiDevice> Frame for MemoryFrame<D> {
    type Error = MemoryError<D::Error>;

    fn row(&mut self, y: usize, out: &mut [f32]) -> Result<(), Self::Error> {
        let size = self.format.bytes();
        if y >= self.height || out.len() != self.width {
            return Err(MemoryError::Row { y, columns: out.len() });
        }
        // Below 2^24, as checked when the frame was made.
        let mut address = self.start.saturating_add((y.saturating_mul(self.width).saturating_mul(size)) as u32);
        for pixels in out.chunks_mut(self.format.pixels_of(CHUNK)) {
            let mut buffer = [0; CHUNK];
            let bytes = buffer.get_mut(..pixels.len().saturating_mul(size)).unwrap_or(&mut []);
            self.memory.read(address, bytes)?;
            for (pixel, bytes) in pixels.iter_mut().zip(bytes.chunks(size)) {
                *pixel = self.pixel(bytes);
            }
            address = address.saturating_add(bytes.len() as u32);
        }
        Ok(())
    }
}
