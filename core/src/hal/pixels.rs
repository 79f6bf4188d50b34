//! How a pixel or a label lies in a serial memory.

/// Unsigned whole numbers of one or two bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelFormat {
    /// One byte, 0 to 255.
    U8,
    /// Two bytes, the low one first, 0 to 65535.
    U16Le,
    /// Two bytes, the high one first, 0 to 65535 (as in FITS).
    U16Be,
}

impl PixelFormat {
    /// Bytes of one pixel.
    pub const fn bytes(self) -> usize {
        match self {
            PixelFormat::U8 => 1,
            PixelFormat::U16Le | PixelFormat::U16Be => 2,
        }
    }

    /// Pixels that fit into `bytes` bytes.
    pub const fn pixels_of(self, bytes: usize) -> usize {
        match self {
            PixelFormat::U8 => bytes,
            PixelFormat::U16Le | PixelFormat::U16Be => bytes >> 1,
        }
    }

    /// The greatest value.
    pub const fn greatest(self) -> u16 {
        match self {
            PixelFormat::U8 => u8::MAX as u16,
            PixelFormat::U16Le | PixelFormat::U16Be => u16::MAX,
        }
    }

    /// The value of one pixel's bytes; bytes that are not there count as 0.
    pub(super) fn decode(self, bytes: &[u8]) -> u16 {
        let first = bytes.first().copied().unwrap_or(0);
        let second = bytes.get(1).copied().unwrap_or(0);
        match self {
            PixelFormat::U8 => u16::from(first),
            PixelFormat::U16Le => u16::from_le_bytes([first, second]),
            PixelFormat::U16Be => u16::from_be_bytes([first, second]),
        }
    }

    /// The bytes of one value, of which the first [`Self::bytes`] count.
    pub(super) fn encode(self, value: u16) -> [u8; 2] {
        match self {
            PixelFormat::U8 | PixelFormat::U16Le => value.to_le_bytes(),
            PixelFormat::U16Be => value.to_be_bytes(),
        }
    }
}
