//! A run written out between two polls, and taken up again, perhaps elsewhere.
//!
//! All words are little-endian, 32 bits. In order: the header (magic, version, code of the
//! arithmetic, columns, rows, sources in the catalogue, CRC-32 of the configuration), the state,
//! the counts, the image plane, the front plane, the ring of old rows (cells of 2 or 4 bytes as they are), the
//! flags of the tiles, the catalogue, of several bands their planes and what is known of each, and the CRC-32 of everything before. Nothing is buffered beyond 64 bytes.

use crate::arithmetic::Arithmetic;
use crate::arithmetic::codec::{Codec, Reader, Writer};
use crate::arithmetic::digest::Digest;
use crate::config::Config;
use crate::front::bands::Bands;
use crate::plane::sweep::ring_len;
use crate::run::memory::{Memory, flags_len};
use crate::run::plan::Plan;
use crate::run::state::State;
use crate::sky::otsu::BINS;
use crate::sources::catalog::Source;
use core::fmt;

/// "SkyF", little-endian.
const MAGIC: u32 = 0x4679_6B53;
/// Changes with the format.
const VERSION: u32 = 7;
/// Words of the header, of the state, of a source and of a band.
const HEADER_WORDS: usize = 7;
const STATE_WORDS: usize = 134;
const SOURCE_WORDS: usize = 25;
const BAND_WORDS: usize = 21;

/// Why a snapshot was not taken up. The run that was to take it up has lost its memory and will
/// only report [`crate::error::Error::NotRestored`]; set up another, or take up another snapshot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SnapshotError<E> {
    /// The medium failed or ended early.
    Read(E),
    /// It is no snapshot, or that of another version, arithmetic, size, catalogue or configuration.
    Foreign {
        /// Which of these.
        what: &'static str,
    },
    /// The checksum fails, or the state is none that a run can be in.
    Damaged,
}

impl<E: fmt::Display> fmt::Display for SnapshotError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SnapshotError::Read(error) => write!(f, "reading the snapshot: {error}"),
            SnapshotError::Foreign { what } => write!(f, "the snapshot has another {what} than this run"),
            SnapshotError::Damaged => write!(f, "the snapshot is damaged"),
        }
    }
}

impl<E: fmt::Debug + fmt::Display> core::error::Error for SnapshotError<E> {}

/// What a snapshot must agree on with the run that takes it up.
type Header = [(u32, &'static str); HEADER_WORDS];

/// Writes a header, what `body` writes, and the checksum of both.
pub(crate) fn write_out<E, W: FnMut(&[u8]) -> Result<(), E>>(
    write: W,
    header: &[(u32, &'static str)],
    body: impl FnOnce(&mut Writer<W>) -> Result<(), E>,
) -> Result<(), E> {
    let mut writer = Writer { write, digest: Digest::default() };
    for &(mut word, _) in header {
        writer.word(&mut word)?;
    }
    body(&mut writer)?;
    let mut sum = writer.digest.value();
    writer.word(&mut sum)
}

/// Reads them back: first a header, which must be this one.
pub(crate) fn read_back<E, R: FnMut(&mut [u8]) -> Result<(), E>>(
    read: R,
    header: &[(u32, &'static str)],
    body: impl FnOnce(&mut Reader<R>) -> Result<(), E>,
) -> Result<(), SnapshotError<E>> {
    let mut reader = Reader { read, digest: Digest::default() };
    for &(expected, what) in header {
        let mut word = 0;
        reader.word(&mut word).map_err(SnapshotError::Read)?;
        if word != expected {
            return Err(SnapshotError::Foreign { what });
        }
    }
    body(&mut reader).map_err(SnapshotError::Read)?;
    let (found, mut sum) = (reader.digest.value(), 0);
    reader.word(&mut sum).map_err(SnapshotError::Read)?;
    if sum == found { Ok(()) } else { Err(SnapshotError::Damaged) }
}

/// Bytes of a snapshot, for cells of `cell_bytes`, a kernel of `window` rows and `sources`.
pub const fn bytes(width: usize, height: usize, cell_bytes: usize, window: usize, sources: usize) -> usize {
    let words = HEADER_WORDS + STATE_WORDS + BINS + SOURCE_WORDS * sources + flags_len(width, height) + 1;
    4 * words + cell_bytes * (2 * width * height + ring_len(width, window))
}

/// Bytes more, of so many bands ([`crate::front::bands`]).
pub const fn band_bytes(width: usize, height: usize, cell_bytes: usize, bands: usize) -> usize {
    bands * (cell_bytes * width * height + 4 * BAND_WORDS)
}

/// A run, as a snapshot sees it.
pub(crate) struct Parts<'a, 'm, A: Arithmetic> {
    pub config: &'a Config,
    pub width: usize,
    pub height: usize,
    pub window: usize,
    /// The bound on row operations.
    pub bound: u64,
    pub memory: &'a mut Memory<'m, A>,
    pub bands: &'a mut Bands<'m, A>,
    pub state: &'a mut State<A>,
}

impl<A: Arithmetic> Parts<'_, '_, A> {
    fn header(&self) -> Header {
        [
            (MAGIC, "kind of contents"),
            (VERSION, "format version"),
            (u32::from(A::CODE), "arithmetic"),
            (self.width as u32, "width"),
            // Of all bands, as the frame has them.
            (self.height.saturating_mul(self.bands.each.len().max(1)) as u32, "height"),
            (self.memory.sources.len() as u32, "length of the catalogue"),
            (self.config.digest(), "configuration"),
        ]
    }

    /// Everything after the header, out or in.
    fn body<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        let pixels = self.width.saturating_mul(self.height);
        self.state.code(codec)?;
        self.memory.counts.0.iter_mut().try_for_each(|count| codec.word(count))?;
        codec.cells(self.memory.image.get_mut(..pixels).unwrap_or(&mut []))?;
        codec.cells(self.memory.front.get_mut(..pixels).unwrap_or(&mut []))?;
        codec.cells(self.memory.ring.get_mut(..ring_len(self.width, self.window)).unwrap_or(&mut []))?;
        for flag in self.memory.tiles.iter_mut() {
            let mut word = u32::from(*flag);
            codec.word(&mut word)?;
            *flag = word as u8;
        }
        self.memory.sources.iter_mut().try_for_each(|source: &mut Source| source.code(codec))?;
        self.bands.code(pixels, codec)
    }

    /// Writes the run out. It is left as it was.
    pub fn save<E>(&mut self, write: impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        write_out(write, &self.header(), |writer| self.body(writer))
    }

    /// Takes a run up. After an error the memory holds nothing of use.
    pub fn restore<E>(&mut self, read: impl FnMut(&mut [u8]) -> Result<(), E>) -> Result<(), SnapshotError<E>> {
        read_back(read, &self.header(), |reader| self.body(reader))?;
        let plan = Plan::of_bands(self.config, self.bands.each.len());
        let is_sound = self.bands.is_sound() && self.state.is_sound(plan, (self.width, self.height), self.bound);
        if is_sound { Ok(()) } else { Err(SnapshotError::Damaged) }
    }
}
