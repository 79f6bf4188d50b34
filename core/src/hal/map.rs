//! The label map, back into a serial memory.

use super::pixels::PixelFormat;
use super::serial::{CHUNK, MemoryError, SerialMemory, in_range};
use crate::arithmetic::Cell;
use embedded_hal::spi::SpiDevice;

/// Writes a label map row-major and without gaps, one chunk of [`CHUNK`] bytes per poll.
///
/// Each chunk is read back and compared. A poll that fails can be made again: it writes the same
/// chunk again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapWriter {
    start: u32,
    format: PixelFormat,
    written: usize,
}

impl MapWriter {
    /// A map of `pixels` labels from address `start` on.
    ///
    /// # Errors
    /// [`MemoryError::Range`] when it does not lie within 24-bit addresses.
    pub fn new<E>(start: u32, pixels: usize, format: PixelFormat) -> Result<Self, MemoryError<E>> {
        in_range(start, pixels.saturating_mul(format.bytes()))?;
        Ok(MapWriter { start, format, written: 0 })
    }

    /// Labels written so far.
    pub fn written(&self) -> usize {
        self.written
    }

    /// Writes the next chunk of `labels`, always the same whole map; `true` when none is left.
    ///
    /// # Errors
    /// [`MemoryError::Label`] where a label does not fit the format, before any byte of its chunk is
    /// written; or those of [`SerialMemory::write`].
    pub fn poll<D: SpiDevice, C: Cell>(
        &mut self,
        memory: &mut SerialMemory<D>,
        labels: &[C],
    ) -> Result<bool, MemoryError<D::Error>> {
        let size = self.format.bytes();
        let left = labels.get(self.written..).unwrap_or(&[]);
        let chunk = left.get(..self.format.pixels_of(CHUNK)).unwrap_or(left);
        let mut buffer = [0; CHUNK];
        for (bytes, cell) in buffer.chunks_mut(size).zip(chunk) {
            let value = self.value(cell.label())?;
            bytes.iter_mut().zip(self.format.encode(value)).for_each(|(to, from)| *to = from);
        }
        let bytes = buffer.get(..chunk.len().saturating_mul(size)).unwrap_or(&buffer);
        let offset = u32::try_from(self.written.saturating_mul(size)).unwrap_or(u32::MAX);
        memory.write(self.start.saturating_add(offset), bytes)?;
        self.written = self.written.saturating_add(chunk.len());
        Ok(self.written >= labels.len())
    }

    fn value<E>(&self, label: u32) -> Result<u16, MemoryError<E>> {
        let greatest = self.format.greatest();
        match u16::try_from(label) {
            Ok(value) if value <= greatest => Ok(value),
            _ => Err(MemoryError::Label { label, greatest }),
        }
    }
}
