//! Tile-compressed images: tiles in a binary table, each compressed on its own (FITS standard 4.0, section 10).
//!
//! Decoded here rather than by cfitsio: its decoders trust the stream (they read on until the tile is full, wherever
//! that leads), and this program reads files from anywhere. Every step below is bounded by the bytes that are there.

mod bits;
mod hcompress;
mod plio;
mod quantize;
mod rice;
mod table;

use std::io::Read;

use flate2::bufread::GzDecoder;

use super::Take;
use super::error::Fault;
use super::hdu::Hdu;
use super::header::Header;
use super::pixels::{self, Scaling};
use super::source::Source;
use crate::planes::can_be_had;
use bits::Exhausted;
use hcompress::Broken;
use quantize::Method;
use table::{Piece, Table};

/// An image of so many pixels may be compressed to nothing ...
const FREE_PIXELS: u128 = 1 << 22;
/// ... and beyond that a byte can stand for so many pixels at most: the longest run that PLIO writes in one byte, twice
/// what gzip reaches.
const PIXELS_PER_BYTE: u128 = 2048;

/// What a pixel of a tile takes while it is decoded: bytes as they come and in order, a wide number, a value.
const TILE_BYTES: u64 = 32;

/// How the tiles of an image are to be decoded.
struct Recipe {
    coding: Coding,
    bitpix: i64,
    scaling: Scaling,
    /// Floating-point values are stored as integers by this method; `None`: as they are.
    quantized: Option<Method>,
    /// The integer for undefined pixels, if it is the same in all tiles.
    blank: Option<i64>,
    /// Scale and zero of the quantization, if they are the same in all tiles.
    constant: (Option<f64>, Option<f64>),
}

/// `ZCMPTYPE`.
enum Coding {
    Rice { bytes: u32, block: usize },
    Gzip { shuffled: bool },
    Plio,
    Hcompress,
    None,
}

/// The content of one tile.
enum Values {
    Integers(Vec<i64>),
    Reals(Vec<f64>),
}

/// Reads the compressed image whose table starts here. Returns its pixels, unless `take` takes them a row of tiles at a
/// time, and what is to be said about them.
pub(super) fn read(
    source: &mut Source,
    hdu: &Hdu,
    bitpix: i64,
    plane: (u64, u64),
    take: &mut Option<&mut Take<'_>>,
) -> Result<(Vec<f32>, Option<String>), Fault> {
    let data = load(source, hdu.bytes)?;
    let count = u128::from(plane.0) * u128::from(plane.1);
    if count > FREE_PIXELS.max(data.len() as u128 * PIXELS_PER_BYTE) {
        return Err(Fault::Truncated { promised: count / PIXELS_PER_BYTE, present: data.len() as u64 });
    }
    let table = Table::new(&hdu.header, &data)?;
    let recipe = Recipe::new(&hdu.header, &table, bitpix)?;
    let (width, height) = (plane.0 as usize, plane.1 as usize);
    let grid = Grid::new(&hdu.header, width, height)?;
    if grid.tiles() != table.rows() {
        return Err(Fault::Corrupt(format!(
            "{} tiles make up the image, but there are {}",
            grid.tiles(),
            table.rows()
        )));
    }
    let mut pixels = Vec::new();
    let kept = if take.is_some() { grid.tile.1 } else { height };
    pixels.try_reserve_exact(width * kept).map_err(|_| pixels::memory(plane))?;
    if !can_be_had((grid.tile.0 * grid.tile.1) as u64 * TILE_BYTES) {
        return Err(pixels::memory(plane));
    }
    pixels.resize(width * kept, f32::NAN);
    let mut tile = Vec::new();
    for number in 0..grid.tiles() {
        let (x, y, columns, rows) = grid.tile(number);
        recipe.decode(&table, number, (columns, rows), &mut tile)?;
        for (line, values) in pixels.chunks_mut(width).skip(y % kept).zip(tile.chunks(columns)) {
            line[x..x + columns].copy_from_slice(values);
        }
        if let Some(take) = take.as_mut().filter(|_| x + columns == width) {
            take(&pixels[..width * rows])?;
        }
    }
    if take.is_some() {
        pixels.clear();
    }
    Ok((pixels, smoothing(&hdu.header)))
}

/// The bytes of a data unit, reserved only if the file is long enough or as they arrive.
fn load(source: &mut Source, promised: u128) -> Result<Vec<u8>, Fault> {
    let present = source.at_most_left();
    if let Some(present) = present.filter(|&present| u128::from(present) < promised) {
        return Err(Fault::Truncated { promised, present });
    }
    let wanted = u64::try_from(promised).unwrap_or(u64::MAX);
    let mut data = Vec::new();
    source.take(wanted).read_to_end(&mut data).map_err(|error| source.broken(error))?;
    match data.len() as u64 {
        present if present < wanted => Err(Fault::Truncated { promised, present }),
        _ => Ok(data),
    }
}

/// HCOMPRESS images may ask to be smoothed; that changes pixels by up to half the scale and is not done.
fn smoothing(header: &Header) -> Option<String> {
    let asked = (1..10).any(|n| {
        header.text(&format!("ZNAME{n}")).as_deref() == Some("SMOOTH") && header.integer(&format!("ZVAL{n}")) == Some(1)
    });
    asked.then(|| "the header asks for HCOMPRESS smoothing (SMOOTH = 1), which is not applied".to_owned())
}

/// How the image is cut into tiles.
struct Grid {
    size: (usize, usize),
    tile: (usize, usize),
}

impl Grid {
    /// `ZTILEn`; by default a tile is a row.
    fn new(header: &Header, width: usize, height: usize) -> Result<Self, Fault> {
        let length = |n: usize, default: usize, most: usize| match header.text(&format!("ZTILE{n}")) {
            None => Ok(default),
            Some(text) => match text.parse::<usize>() {
                Ok(length @ 1..) => Ok(length.min(most)),
                _ => Err(Fault::Header(format!("ZTILE{n} = {text} is not a length"))),
            },
        };
        Ok(Self { size: (width, height), tile: (length(1, width, width)?, length(2, 1, height)?) })
    }

    fn tiles(&self) -> usize {
        self.size.0.div_ceil(self.tile.0) * self.size.1.div_ceil(self.tile.1)
    }

    /// First column and row, number of columns and rows of a tile.
    fn tile(&self, number: usize) -> (usize, usize, usize, usize) {
        let across = self.size.0.div_ceil(self.tile.0);
        let (x, y) = (number % across * self.tile.0, number / across * self.tile.1);
        (x, y, self.tile.0.min(self.size.0 - x), self.tile.1.min(self.size.1 - y))
    }
}

impl Recipe {
    fn new(header: &Header, table: &Table<'_>, bitpix: i64) -> Result<Self, Fault> {
        let coding = coding(header)?;
        let constant = (header.real("ZSCALE"), header.real("ZZERO"));
        let method = header.text("ZQUANTIZ").unwrap_or_default();
        let scaled = table.has("ZSCALE") || constant.0.is_some();
        let seed = header.integer("ZDITHER0").unwrap_or(1).clamp(1, 10_000);
        let quantized = match method.as_str() {
            _ if bitpix > 0 || !scaled => None,
            "NONE" => None,
            "SUBTRACTIVE_DITHER_1" => Some(Method::Dithered { seed, keeps_zero: false }),
            "SUBTRACTIVE_DITHER_2" => Some(Method::Dithered { seed, keeps_zero: true }),
            _ => Some(Method::Rounded),
        };
        let mut blank = pixels::blank(header, "ZBLANK")?.or(pixels::blank(header, "BLANK")?);
        let mut scaling = Scaling::of(header, bitpix)?;
        if matches!(coding, Coding::Plio) {
            // Unsigned 16-bit masks are written by cfitsio with their zero point already added.
            const OFFSET: f64 = 32768.0;
            if scaling.zero() == OFFSET {
                blank = blank.map(|blank| blank.saturating_add(OFFSET as i64));
            }
            scaling = scaling.without_offset(OFFSET);
        }
        Ok(Self { coding, bitpix, scaling, quantized, blank, constant })
    }

    /// Decodes one tile into physical values, row by row.
    fn decode(&self, table: &Table<'_>, number: usize, shape: (usize, usize), out: &mut Vec<f32>) -> Result<(), Fault> {
        out.clear();
        let blank = table.number("ZBLANK", number).map_or(self.blank, |value| Some(value as i64));
        match self.values(table, number, shape)? {
            Values::Reals(values) => out.extend(values.iter().map(|&value| self.scaling.real(value))),
            Values::Integers(values) if self.bitpix > 0 => out.extend(values.iter().map(|&value| match blank {
                Some(blank) if blank == value => f32::NAN,
                _ => self.scaling.long(value),
            })),
            Values::Integers(values) => {
                let tile = quantize::Tile {
                    scale: table.number("ZSCALE", number).or(self.constant.0).unwrap_or(1.0),
                    zero: table.number("ZZERO", number).or(self.constant.1).unwrap_or(0.0),
                    blank,
                    number,
                };
                let method = self.quantized.unwrap_or(Method::Rounded);
                tile.values(method, &values, |value| out.push(self.scaling.real(value)));
            }
        }
        Ok(())
    }

    /// The stored values of one tile, from whichever column holds them.
    fn values(&self, table: &Table<'_>, number: usize, shape: (usize, usize)) -> Result<Values, Fault> {
        let corrupt = |what: &str| Fault::Corrupt(format!("tile {number} {what}"));
        let count = shape.0 * shape.1;
        if let Some(piece) = table.piece("COMPRESSED_DATA", number)? {
            return self.compressed(&piece, shape).map_err(corrupt);
        }
        if let Some(piece) = table.piece("GZIP_COMPRESSED_DATA", number)? {
            let bytes = gunzip(piece.bytes, count).map_err(corrupt)?;
            return raw(&bytes, count, self.bitpix < 0).map_err(corrupt);
        }
        match table.piece("UNCOMPRESSED_DATA", number)? {
            Some(piece) => raw(piece.bytes, count, matches!(piece.element, b'E' | b'D')).map_err(corrupt),
            None => Err(corrupt("holds no data")),
        }
    }

    fn compressed(&self, piece: &Piece<'_>, (columns, rows): (usize, usize)) -> Result<Values, &'static str> {
        const SHORT: &str = "ends before its pixels do";
        let count = columns * rows;
        let floats = self.bitpix < 0 && self.quantized.is_none();
        let mut integers = vec![0; if matches!(self.coding, Coding::Gzip { .. } | Coding::None) { 0 } else { count }];
        match &self.coding {
            Coding::Gzip { shuffled } => {
                let mut bytes = gunzip(piece.bytes, count)?;
                if *shuffled {
                    bytes = unshuffle(&bytes, count);
                }
                return raw(&bytes, count, floats);
            }
            Coding::None => return raw(piece.bytes, count, floats),
            Coding::Rice { bytes, block } => {
                rice::decode(piece.bytes, *bytes, *block, &mut integers).map_err(|Exhausted| SHORT)?;
            }
            Coding::Plio => plio::decode(piece.bytes, &mut integers).map_err(|Exhausted| SHORT)?,
            Coding::Hcompress => {
                hcompress::decode(piece.bytes, columns, rows, &mut integers).map_err(|broken| match broken {
                    Broken::Exhausted => SHORT,
                    Broken::Header => "does not begin as HCOMPRESS data of its size",
                    Broken::Code => "holds a code that does not exist",
                })?;
            }
        }
        Ok(Values::Integers(integers))
    }
}

fn coding(header: &Header) -> Result<Coding, Fault> {
    let parameter = |name: &str, default: i64| {
        let named = (1..10).find(|n| header.text(&format!("ZNAME{n}")).as_deref() == Some(name));
        named.and_then(|n| header.integer(&format!("ZVAL{n}"))).unwrap_or(default)
    };
    let name = header.text("ZCMPTYPE").ok_or_else(|| Fault::Header("ZCMPTYPE is missing".into()))?;
    match name.trim_end() {
        "RICE_1" | "RICE_ONE" => match (parameter("BYTEPIX", 4), parameter("BLOCKSIZE", 32)) {
            (bytes @ (1 | 2 | 4), block @ 1..=65536) => Ok(Coding::Rice { bytes: bytes as u32, block: block as usize }),
            (bytes, block) => Err(Fault::Unsupported(format!("RICE_1 with BYTEPIX {bytes} and BLOCKSIZE {block}"))),
        },
        "GZIP_1" => Ok(Coding::Gzip { shuffled: false }),
        "GZIP_2" => Ok(Coding::Gzip { shuffled: true }),
        "PLIO_1" => Ok(Coding::Plio),
        "HCOMPRESS_1" => Ok(Coding::Hcompress),
        "NOCOMPRESS" => Ok(Coding::None),
        other => Err(Fault::Unsupported(format!("compression {other}"))),
    }
}

/// Undoes gzip; at most eight bytes per pixel are taken.
fn gunzip(bytes: &[u8], count: usize) -> Result<Vec<u8>, &'static str> {
    let mut out = Vec::new();
    let limit = count as u64 * 8 + 1;
    GzDecoder::new(bytes).take(limit).read_to_end(&mut out).map_err(|_| "is not a sound gzip stream")?;
    Ok(out)
}

/// Brings the bytes of each value together again: all first bytes stand first, then all second ones. What is left over
/// stays at the end.
fn unshuffle(bytes: &[u8], count: usize) -> Vec<u8> {
    let size = bytes.len() / count;
    let (shuffled, rest) = bytes.split_at(count * size);
    (0..shuffled.len()).map(|n| shuffled[n % size * count + n / size]).chain(rest.iter().copied()).collect()
}

/// Big-endian values, whose size follows from their number.
fn raw(bytes: &[u8], count: usize, floats: bool) -> Result<Values, &'static str> {
    fn all<const N: usize, T>(bytes: &[u8], value: impl Fn([u8; N]) -> T) -> Vec<T> {
        bytes.as_chunks::<N>().0.iter().map(|chunk| value(*chunk)).collect()
    }
    let exact = bytes.len() == count * (bytes.len() / count);
    match (bytes.len() / count, floats) {
        (4, true) if exact => Ok(Values::Reals(all(bytes, |b| f32::from_be_bytes(b).into()))),
        (8, true) if exact => Ok(Values::Reals(all(bytes, f64::from_be_bytes))),
        (1, false) if exact => Ok(Values::Integers(all(bytes, |[b]| b.into()))),
        (2, false) if exact => Ok(Values::Integers(all(bytes, |b| i16::from_be_bytes(b).into()))),
        (4, false) if exact => Ok(Values::Integers(all(bytes, |b| i32::from_be_bytes(b).into()))),
        (8, false) if exact => Ok(Values::Integers(all(bytes, i64::from_be_bytes))),
        _ => Err("has another number of bytes than its pixels need"),
    }
}
