//! A run written out between two polls, and taken up again, perhaps elsewhere.
//!
//! All words are little-endian, 32 bits. In order: the header (magic, version, code of the
//! arithmetic, columns, rows, sources in the catalogue, CRC-32 of the configuration), the state,
//! the counts, the image plane, the front plane, the ring of old rows (cells of 2 or 4 bytes as they are), the
//! flags of the tiles, the catalogue, and the CRC-32 of everything before. Nothing is buffered beyond 64 bytes.

use crate::arithmetic::Arithmetic;
use crate::catalog::Source;
use crate::codec::{Codec, Reader, Writer};
use crate::config::{ChanVese, Config, Diffusivity, Edge, Filter, Normalize, Rescale, Start, Tau};
use crate::digest::Digest;
use crate::memory::{Memory, flags_len};
use crate::otsu::BINS;
use crate::state::State;
use crate::sweep::ring_len;
use core::fmt;

/// "SkyF", little-endian.
const MAGIC: u32 = 0x4679_6B53;
/// Changes with the format.
const VERSION: u32 = 5;
/// Words of the header, of the state and of a source.
const HEADER_WORDS: usize = 7;
const STATE_WORDS: usize = 116;
const SOURCE_WORDS: usize = 25;

/// Why a snapshot was not taken up. The run that was to take it up has lost its memory and will
/// only report [`crate::error::Error::Corrupted`]; set up another.
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
struct Header([(u32, &'static str); HEADER_WORDS]);

impl Header {
    fn of<A: Arithmetic>(config: &Config, width: usize, height: usize, sources: usize) -> Header {
        Header([
            (MAGIC, "kind of contents"),
            (VERSION, "format version"),
            (u32::from(A::CODE), "arithmetic"),
            (width as u32, "width"),
            (height as u32, "height"),
            (sources as u32, "length of the catalogue"),
            (config_digest(config), "configuration"),
        ])
    }
}

/// Bytes of a snapshot, for cells of `cell_bytes`, a kernel of `window` rows and `sources`.
pub const fn bytes(width: usize, height: usize, cell_bytes: usize, window: usize, sources: usize) -> usize {
    let words = HEADER_WORDS + STATE_WORDS + BINS + SOURCE_WORDS * sources + flags_len(width, height) + 1;
    4 * words + cell_bytes * (2 * width * height + ring_len(width, window))
}

/// The CRC-32 of all parameters: what a snapshot knows its configuration by.
pub fn config_digest(config: &Config) -> u32 {
    // Every field by name, so that a new one cannot be forgotten.
    let Config {
        normalize,
        rescale,
        filter,
        filter_steps,
        filter_dt,
        order,
        edge,
        scheme,
        nu,
        chan_vese: ChanVese { mu: length, lambda1, lambda2 },
        curvature_form,
        degenerate,
        directions,
        dx,
        dt,
        t_max,
        eps_front,
        eps,
        stop,
        start,
        band,
        connectivity,
        min_area,
        // Not a part of the steps that a snapshot interrupts.
        detection: _,
    } = *config;
    let (normalize, low, high) = match normalize {
        Normalize::MinMax => (0, 0.0, 0.0),
        Normalize::Percentile { low, high } => (1, low, high),
        Normalize::Noise { below, above } => (2, below, above),
    };
    let (rescale, exponent, tau) = match rescale {
        Rescale::None => (0, 0.0, 0.0),
        Rescale::R1 { alpha } => (1, alpha, 0.0),
        Rescale::R2 { alpha } => (2, alpha, 0.0),
        Rescale::R3 { beta, tau: Tau::Otsu } => (3, f32::from(beta), 0.0),
        Rescale::R3 { beta, tau: Tau::Value(tau) } => (4, f32::from(beta), tau),
        Rescale::R3 { beta, tau: Tau::Kapur } => (5, f32::from(beta), 0.0),
        Rescale::R3 { beta, tau: Tau::Rosin } => (6, f32::from(beta), 0.0),
        Rescale::R3 { beta, tau: Tau::Noise { k } } => (7, f32::from(beta), k),
    };
    let (filter, mu) = match filter {
        Filter::None => (0, 0.0),
        Filter::Heat => (1, 0.0),
        Filter::PeronaMalik { diffusivity: Diffusivity::F1, mu } => (2, mu),
        Filter::PeronaMalik { diffusivity: Diffusivity::F2, mu } => (3, mu),
    };
    let (edge, sharpness) = match edge {
        Edge::G1 { p } => (0, p),
        Edge::G2 => (1, 0.0),
        Edge::G2Mod { c2 } => (2, c2),
    };
    let (start, margin) = match start {
        Start::Frame => (0, 0.0),
        Start::Given => (1, 0.0),
        Start::Threshold { margin } => (2, margin),
    };
    let mut digest = Digest::default();
    let choices = [order as u8, scheme as u8, curvature_form as u8, stop as u8, start, connectivity as u8];
    digest.bytes(&[normalize, rescale, filter, edge, directions, u8::from(band.is_some())]);
    digest.bytes(&choices);
    digest.bytes(&filter_steps.to_le_bytes());
    digest.bytes(&min_area.to_le_bytes());
    let band = band.unwrap_or(0.0);
    let numbers = [low, high, exponent, tau, mu, filter_dt, sharpness, nu, degenerate, dx, dt, t_max, eps_front];
    for number in numbers.into_iter().chain([eps, band, margin, length, lambda1, lambda2]) {
        digest.bytes(&number.to_bits().to_le_bytes());
    }
    digest.value()
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
    pub state: &'a mut State<A>,
}

impl<A: Arithmetic> Parts<'_, '_, A> {
    fn header(&self) -> Header {
        Header::of::<A>(self.config, self.width, self.height, self.memory.sources.len())
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
        self.memory.sources.iter_mut().try_for_each(|source: &mut Source| source.code(codec))
    }

    /// Writes the run out. It is left as it was.
    pub fn save<E>(&mut self, write: impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        let mut writer = Writer { write, digest: Digest::default() };
        for (mut word, _) in self.header().0 {
            writer.word(&mut word)?;
        }
        self.body(&mut writer)?;
        let mut sum = writer.digest.value();
        writer.word(&mut sum)
    }

    /// Takes a run up. After an error the memory holds nothing of use.
    pub fn restore<E>(&mut self, read: impl FnMut(&mut [u8]) -> Result<(), E>) -> Result<(), SnapshotError<E>> {
        let mut reader = Reader { read, digest: Digest::default() };
        for (expected, what) in self.header().0 {
            let mut word = 0;
            reader.word(&mut word).map_err(SnapshotError::Read)?;
            if word != expected {
                return Err(SnapshotError::Foreign { what });
            }
        }
        self.body(&mut reader).map_err(SnapshotError::Read)?;
        let (found, mut sum) = (reader.digest.value(), 0);
        reader.word(&mut sum).map_err(SnapshotError::Read)?;
        let sound = self.state.is_sound(self.config, self.width, self.height, self.bound);
        if sum == found && sound { Ok(()) } else { Err(SnapshotError::Damaged) }
    }
}
