//! Fields as little-endian words, written and read by the same list.
//!
//! A type lists its fields once, in `code`; whether they go out or come in is the codec's affair.

use crate::arithmetic::digest::Digest;
use crate::arithmetic::{Bits, Cell};

/// Where fields go to or come from. Every byte passes through a running CRC-32.
pub(crate) trait Codec {
    /// What the medium can report.
    type Error;

    /// A word out, or in.
    fn word(&mut self, value: &mut u32) -> Result<(), Self::Error>;

    /// A run of cells, in chunks.
    fn cells<C: Cell>(&mut self, cells: &mut [C]) -> Result<(), Self::Error>;

    /// Two words, the lower first.
    fn long(&mut self, value: &mut u64) -> Result<(), Self::Error> {
        let (mut low, mut high) = (*value as u32, (*value >> 32) as u32);
        self.word(&mut low)?;
        self.word(&mut high)?;
        *value = u64::from(low) | u64::from(high) << 32;
        Ok(())
    }

    /// A count or an index, which is below 2^32.
    fn size(&mut self, value: &mut usize) -> Result<(), Self::Error> {
        let mut word = *value as u32;
        self.word(&mut word)?;
        *value = word as usize;
        Ok(())
    }

    /// Yes or no.
    fn flag(&mut self, value: &mut bool) -> Result<(), Self::Error> {
        let mut word = u32::from(*value);
        self.word(&mut word)?;
        *value = word != 0;
        Ok(())
    }

    /// The bits of a sum; what is no number comes in as 0.
    fn double(&mut self, value: &mut f64) -> Result<(), Self::Error> {
        let mut bits = value.to_bits();
        self.long(&mut bits)?;
        let read = f64::from_bits(bits);
        *value = if read.is_finite() { read } else { 0.0 };
        Ok(())
    }

    /// A number of any arithmetic.
    fn bits<B: Bits>(&mut self, value: &mut B) -> Result<(), Self::Error> {
        let mut bits = value.bits();
        self.word(&mut bits)?;
        *value = B::from_bits(bits);
        Ok(())
    }

    /// A run of words.
    fn words(&mut self, words: &mut [u32]) -> Result<(), Self::Error> {
        words.iter_mut().try_for_each(|word| self.word(word))
    }

    /// The bits of a number; whoever reads it checks that it is one.
    fn real(&mut self, value: &mut f32) -> Result<(), Self::Error> {
        let mut bits = value.to_bits();
        self.word(&mut bits)?;
        *value = f32::from_bits(bits);
        Ok(())
    }
}

/// Bytes of a chunk.
const CHUNK: usize = 64;

/// Fields to bytes.
pub(crate) struct Writer<W> {
    pub(crate) write: W,
    pub(crate) digest: Digest,
}

impl<E, W: FnMut(&[u8]) -> Result<(), E>> Writer<W> {
    fn bytes(&mut self, bytes: &[u8]) -> Result<(), E> {
        self.digest.bytes(bytes);
        (self.write)(bytes)
    }
}

impl<E, W: FnMut(&[u8]) -> Result<(), E>> Codec for Writer<W> {
    type Error = E;

    fn word(&mut self, value: &mut u32) -> Result<(), E> {
        self.bytes(&value.to_le_bytes())
    }

    fn cells<C: Cell>(&mut self, cells: &mut [C]) -> Result<(), E> {
        for chunk in cells.chunks(CHUNK / 4) {
            let mut bytes = [0; CHUNK];
            for (to, cell) in bytes.chunks_mut(C::BYTES).zip(chunk) {
                to.iter_mut().zip(cell.bits().to_le_bytes()).for_each(|(to, byte)| *to = byte);
            }
            let length = chunk.len().saturating_mul(C::BYTES);
            self.bytes(bytes.get(..length).unwrap_or(&[]))?;
        }
        Ok(())
    }
}

/// Bytes to fields. The reading closure fills the whole slice or fails.
pub(crate) struct Reader<R> {
    pub(crate) read: R,
    pub(crate) digest: Digest,
}

impl<E, R: FnMut(&mut [u8]) -> Result<(), E>> Reader<R> {
    fn bytes(&mut self, bytes: &mut [u8]) -> Result<(), E> {
        (self.read)(bytes)?;
        self.digest.bytes(bytes);
        Ok(())
    }
}

impl<E, R: FnMut(&mut [u8]) -> Result<(), E>> Codec for Reader<R> {
    type Error = E;

    fn word(&mut self, value: &mut u32) -> Result<(), E> {
        let mut bytes = [0; 4];
        self.bytes(&mut bytes)?;
        *value = u32::from_le_bytes(bytes);
        Ok(())
    }

    fn cells<C: Cell>(&mut self, cells: &mut [C]) -> Result<(), E> {
        for chunk in cells.chunks_mut(CHUNK / 4) {
            let mut bytes = [0; CHUNK];
            let length = chunk.len().saturating_mul(C::BYTES);
            self.bytes(bytes.get_mut(..length).unwrap_or(&mut []))?;
            for (cell, from) in chunk.iter_mut().zip(bytes.chunks(C::BYTES)) {
                let mut word = [0; 4];
                word.iter_mut().zip(from).for_each(|(to, &byte)| *to = byte);
                *cell = C::from_bits(u32::from_le_bytes(word));
            }
        }
        Ok(())
    }
}
