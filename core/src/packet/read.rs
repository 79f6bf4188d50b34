//! Packets on the ground.

use super::{BEGINNING, ENDS, Kind, PIECE, RECORD, VERSION};
use crate::arithmetic::digest::Digest;
use crate::track::{SIDES, Star};
use core::fmt;

/// Why bytes are not taken as a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PacketError {
    /// There are fewer bytes than a packet has, or than this one says it has.
    Short {
        /// How many there are.
        given: usize,
        /// How many it has.
        needed: usize,
    },
    /// They do not begin as a packet, or as one of another version.
    Foreign {
        /// What differs.
        what: &'static str,
    },
    /// The checksum fails.
    Damaged,
    /// The checksum holds, but what is in it is no such product.
    Form {
        /// Which part is wrong.
        what: &'static str,
    },
}

impl fmt::Display for PacketError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PacketError::Short { given, needed } => {
                write!(f, "the packet has {needed} bytes, of which {given} are there")
            }
            PacketError::Foreign { what } => write!(f, "the packet has another {what}"),
            PacketError::Damaged => f.write_str("the packet is damaged: its checksum fails"),
            PacketError::Form { what } => write!(f, "the packet has no sound {what}"),
        }
    }
}

impl core::error::Error for PacketError {}

/// A packet whose checksum holds.
#[derive(Clone, Copy, Debug)]
pub struct Packet<'a> {
    /// The sender's number of the product.
    pub product: u32,
    /// The packet's number within it, from 0.
    pub number: u32,
    /// Its bytes.
    pub length: usize,
    /// What is in it.
    pub contents: Contents<'a>,
}

/// What is in a packet.
#[derive(Clone, Copy, Debug)]
pub enum Contents<'a> {
    /// Stars.
    Stars {
        /// How many the product has.
        total: u32,
        /// Index of the first.
        first: u32,
        /// They.
        records: Records<'a>,
    },
    /// A part of a map of labels.
    Labels {
        /// Columns and rows of the map.
        size: (u32, u32),
        /// Where the part begins, in row-major order.
        first: u32,
        /// Its labels.
        runs: Runs<'a>,
    },
    /// Pieces of cut-outs.
    Cutouts {
        /// How many cut-outs the product has.
        total: u16,
        /// Bits of a pixel.
        bits: u16,
        /// The pieces.
        pieces: Pieces<'a>,
    },
}

impl Contents<'_> {
    /// Of which kind.
    pub fn kind(&self) -> Kind {
        match self {
            Contents::Stars { .. } => Kind::Stars,
            Contents::Labels { .. } => Kind::Labels,
            Contents::Cutouts { .. } => Kind::Cutouts,
        }
    }
}

/// Bytes that are read from the front.
#[derive(Clone, Copy, Debug)]
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*taken)
    }

    fn word(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn short(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    /// A number in bytes of seven bits; none where it does not end within 32.
    fn sevens(&mut self) -> Option<u32> {
        let mut number = 0;
        for place in [0u32, 7, 14, 21, 28] {
            let [byte] = self.array::<1>()?;
            let bits = u32::from(byte & 0x7F);
            if place == 28 && bits > 0xF {
                return None;
            }
            number |= bits.wrapping_shl(place);
            if byte & 0x80 == 0 {
                return Some(number);
            }
        }
        None
    }
}

/// The stars of a packet, in their order.
#[derive(Clone, Copy, Debug)]
pub struct Records<'a>(Bytes<'a>);

impl Iterator for Records<'_> {
    type Item = Star;

    fn next(&mut self) -> Option<Star> {
        let mut record = Bytes(self.0.take(RECORD)?);
        let mut real = || record.word().map(f32::from_bits);
        let (x, y, flux, snr) = (real()?, real()?, real()?, real()?);
        let (errx2, erry2, errxy) = (real()?, real()?, real()?);
        Some(Star { x, y, flux, snr, errx2, erry2, errxy, flags: record.word()? })
    }
}

/// Pixels in a row that have the same label; they may go on in the next row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// The label, 0 for the background.
    pub label: u32,
    /// How many pixels, at least 1.
    pub length: u32,
}

/// The runs of a packet, in their order.
#[derive(Clone, Copy, Debug)]
pub struct Runs<'a>(Bytes<'a>);

impl Iterator for Runs<'_> {
    type Item = Run;

    fn next(&mut self) -> Option<Run> {
        let mut bytes = self.0;
        let (label, length) = (bytes.sevens()?, bytes.sevens()?);
        if length == 0 {
            return None;
        }
        self.0 = bytes;
        Some(Run { label, length })
    }
}

/// A piece of a cut-out.
#[derive(Clone, Copy, Debug)]
pub struct Piece<'a> {
    /// Index of the cut-out.
    pub cutout: u16,
    /// First column and row of the cut-out in the frame.
    pub origin: (u16, u16),
    /// Its columns and rows, 64 at most; 0 where the window lies beside the frame.
    pub size: (u16, u16),
    /// Where the piece begins in it, in row-major order.
    pub first: u16,
    /// How many pixels there are.
    pub count: u16,
    pixels: &'a [u8],
    bits: u16,
}

impl<'a> Piece<'a> {
    /// The pixels, counts.
    pub fn pixels(&self) -> impl Iterator<Item = u16> + use<'a> {
        let each = if self.bits == 8 { 1 } else { 2 };
        let pixels = self.pixels.chunks_exact(each);
        pixels.map(|bytes| match *bytes {
            [low, high] => u16::from_le_bytes([low, high]),
            [byte] => u16::from(byte),
            _ => 0,
        })
    }

    /// Whether it lies in its cut-out.
    fn is_sound(&self, total: u16) -> bool {
        let (columns, rows) = self.size;
        let end = u32::from(self.first).saturating_add(u32::from(self.count));
        let most = SIDES.1;
        let pixels = u32::from(columns).saturating_mul(u32::from(rows));
        self.cutout < total && columns <= most && rows <= most && end <= pixels
    }
}

/// The pieces of a packet, in their order.
#[derive(Clone, Copy, Debug)]
pub struct Pieces<'a> {
    bytes: Bytes<'a>,
    bits: u16,
}

impl<'a> Iterator for Pieces<'a> {
    type Item = Piece<'a>;

    fn next(&mut self) -> Option<Piece<'a>> {
        let mut bytes = self.bytes;
        let mut head = Bytes(bytes.take(PIECE)?);
        let mut short = || head.short();
        let (cutout, x, y, columns, rows) = (short()?, short()?, short()?, short()?, short()?);
        let (first, count) = (short()?, short()?);
        let length = usize::from(count).saturating_mul(if self.bits == 8 { 1 } else { 2 });
        let pixels = bytes.take(length)?;
        self.bytes = bytes;
        Some(Piece { cutout, origin: (x, y), size: (columns, rows), first, count, pixels, bits: self.bits })
    }
}

impl<'a> Packet<'a> {
    /// The packet that bytes begin with; what follows it is not looked at. Cost: its bytes, twice.
    ///
    /// # Errors
    /// [`PacketError`] tells what is wrong.
    pub fn read(bytes: &'a [u8]) -> Result<Packet<'a>, PacketError> {
        let (given, least) = (bytes.len(), ENDS.0.saturating_add(ENDS.1));
        let short = |needed| PacketError::Short { given, needed };
        let mut head = Bytes(bytes);
        if head.array().ok_or(short(least))? != BEGINNING {
            return Err(PacketError::Foreign { what: "beginning" });
        }
        let [version, kind] = head.array().ok_or(short(least))?;
        if version != VERSION {
            return Err(PacketError::Foreign { what: "format version" });
        }
        let length = usize::from(head.short().ok_or(short(least))?).max(least);
        let whole = bytes.get(..length).and_then(<[u8]>::split_last_chunk::<4>);
        let (front, end) = whole.ok_or(short(length))?;
        let mut digest = Digest::default();
        digest.bytes(front);
        if digest.value() != u32::from_le_bytes(*end) {
            return Err(PacketError::Damaged);
        }
        let mut body = Bytes(front.get(8..).unwrap_or(&[]));
        let (product, number) = body.word().zip(body.word()).ok_or(short(least))?;
        Ok(Packet { product, number, length, contents: contents(kind, body)? })
    }
}

/// A sound body of a kind.
fn contents(kind: u8, body: Bytes<'_>) -> Result<Contents<'_>, PacketError> {
    let kind = Kind::ALL.into_iter().find(|known| *known as u8 == kind);
    let (what, contents) = match kind {
        Some(Kind::Stars) => ("records of stars", stars(body)),
        Some(Kind::Labels) => ("runs of labels", labels(body)),
        Some(Kind::Cutouts) => ("pieces of cut-outs", cutouts(body)),
        None => ("kind", None),
    };
    contents.ok_or(PacketError::Form { what })
}

fn stars(mut body: Bytes<'_>) -> Option<Contents<'_>> {
    let (total, first) = (body.word()?, body.word()?);
    let (records, rest) = body.0.as_chunks::<RECORD>();
    let end = first.checked_add(u32::try_from(records.len()).ok()?)?;
    (rest.is_empty() && end <= total).then_some(Contents::Stars { total, first, records: Records(body) })
}

fn labels(mut body: Bytes<'_>) -> Option<Contents<'_>> {
    let (size, first) = ((body.word()?, body.word()?), body.word()?);
    let runs = Runs(body);
    let mut left = runs;
    let end = left.by_ref().try_fold(first, |end, run| end.checked_add(run.length))?;
    let pixels = size.0.checked_mul(size.1)?;
    (left.0.0.is_empty() && end <= pixels).then_some(Contents::Labels { size, first, runs })
}

fn cutouts(mut body: Bytes<'_>) -> Option<Contents<'_>> {
    let (total, bits) = (body.short()?, body.short()?);
    let pieces = Pieces { bytes: body, bits };
    let mut left = pieces;
    let sound = left.by_ref().all(|piece| piece.is_sound(total));
    let known = bits == 8 || bits == 16;
    (known && sound && left.bytes.0.is_empty()).then_some(Contents::Cutouts { total, bits, pieces })
}
