//! Bits from a byte stream, most significant first. Reading past the end is an error, not a fault.

/// The compressed stream ended before its pixels did.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Exhausted;

/// A position in a byte stream.
pub(super) struct Bits<'a> {
    bytes: &'a [u8],
    /// Bits taken from the stream and not yet handed out, in the low `held` bits.
    buffer: u64,
    held: u32,
}

impl<'a> Bits<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, buffer: 0, held: 0 }
    }

    /// The next `count` bits (at most 32) as an unsigned number.
    pub(super) fn take(&mut self, count: u32) -> Result<u32, Exhausted> {
        while self.held < count {
            let (&byte, rest) = self.bytes.split_first().ok_or(Exhausted)?;
            self.bytes = rest;
            self.buffer = (self.buffer << 8) | u64::from(byte);
            self.held += 8;
        }
        self.held -= count;
        let value = self.buffer >> self.held;
        self.buffer &= (1 << self.held) - 1;
        Ok(value as u32)
    }

    /// Passes over zeros and the one that ends them; returns the number of zeros.
    pub(super) fn unary(&mut self) -> Result<u32, Exhausted> {
        let mut zeros = 0;
        while self.buffer == 0 {
            let (&byte, rest) = self.bytes.split_first().ok_or(Exhausted)?;
            zeros += self.held;
            self.bytes = rest;
            self.buffer = u64::from(byte);
            self.held = 8;
        }
        let length = u64::BITS - self.buffer.leading_zeros();
        zeros += self.held - length;
        self.held = length - 1;
        self.buffer &= (1 << self.held) - 1;
        Ok(zeros)
    }

    /// Drops the rest of a byte that was begun.
    pub(super) fn align(&mut self) {
        self.held -= self.held % 8;
        self.buffer &= (1 << self.held) - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_come_most_significant_first() {
        let mut bits = Bits::new(&[0b1010_0000, 0, 0b0001_1111, 0xff]);
        assert_eq!(bits.take(3), Ok(0b101));
        assert_eq!(bits.unary(), Ok(16));
        bits.align();
        assert_eq!(bits.take(8), Ok(0xff));
        assert_eq!(bits.take(1), Err(Exhausted));
        assert_eq!(bits.unary(), Err(Exhausted));
    }

    #[test]
    fn thirty_two_bits_may_straddle_bytes() {
        let mut bits = Bits::new(&[0x12, 0x34, 0x56, 0x78, 0x9a]);
        assert_eq!(bits.take(4), Ok(1));
        assert_eq!(bits.take(32), Ok(0x2345_6789));
    }
}
