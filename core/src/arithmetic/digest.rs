//! CRC-32 (IEEE 802.3, reflected, as in zlib and PNG): the short name of a plane's bits.
//!
//! Bytes are fed little-endian, so that a digest does not depend on the processor.

use crate::arithmetic::Cell;

/// A running CRC-32.
///
/// ```
/// use skyfront_core::arithmetic::digest::Digest;
///
/// let mut digest = Digest::default();
/// digest.bytes(b"1234");
/// digest.bytes(b"56789");
/// assert_eq!(digest.value(), 0xCBF4_3926);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(u32);

impl Default for Digest {
    fn default() -> Self {
        Digest(!0)
    }
}

/// The table of one nibble: small enough for a microcontroller, twice as fast as bits.
#[allow(clippy::indexing_slicing, reason = "evaluated by the compiler")]
const NIBBLES: [u32; 16] = {
    let mut table = [0; 16];
    let mut n = 0;
    while n < 16 {
        let mut crc = n as u32;
        let mut bit = 0;
        while bit < 4 {
            crc = if crc & 1 == 1 { (crc >> 1) ^ 0xEDB8_8320 } else { crc >> 1 };
            bit += 1;
        }
        table[n] = crc;
        n += 1;
    }
    table
};

/// One nibble step; the index is below 16 by its mask.
#[allow(clippy::indexing_slicing, reason = "the mask keeps the index below the length")]
fn step(crc: u32, nibble: u32) -> u32 {
    let index = ((crc ^ nibble) & 15) as usize;
    (crc >> 4) ^ NIBBLES[index]
}

impl Digest {
    /// Feeds bytes.
    pub fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let crc = step(self.0, u32::from(byte));
            self.0 = step(crc, u32::from(byte) >> 4);
        }
    }

    /// Feeds the cells of a plane, each as its little-endian bytes.
    pub fn cells<C: Cell>(&mut self, cells: &[C]) {
        for cell in cells {
            let bytes = cell.bits().to_le_bytes();
            self.bytes(bytes.get(..C::BYTES).unwrap_or(&bytes));
        }
    }

    /// The CRC-32 of all bytes fed so far.
    pub fn value(self) -> u32 {
        !self.0
    }
}

/// The digest of a plane.
pub fn of_cells<C: Cell>(cells: &[C]) -> u32 {
    let mut digest = Digest::default();
    digest.cells(cells);
    digest.value()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_value_of_the_standard() {
        let mut digest = Digest::default();
        digest.bytes(b"123456789");
        assert_eq!(digest.value(), 0xCBF4_3926);
    }
}
