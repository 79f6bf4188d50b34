//! Reading images: FITS in all its varieties, PGM and PNG, told apart by their first bytes.
//!
//! One call, [`image`], gives the pixels as row-major `f32` with the first FITS row as row 0 (the bottom of the
//! picture), undefined pixels as NaN, and the header for what else is to be known. File names are taken literally:
//! brackets and plus signs have no meaning. Whole-file gzip and bzip2 are undone on the way.
//!
//! PGM and PNG files begin with the top row of the picture, FITS images with the bottom row. They are turned over when
//! read, so that a picture stands upright wherever row 0 is drawn at the bottom.

mod choice;
mod decoded;
mod error;
mod fits;
mod hdu;
pub mod header;
mod pgm;
mod picture;
mod pixels;
mod place;
mod png;
mod section;
mod source;
mod tiles;

use std::io::Read;
use std::path::Path;

pub use choice::HduChoice;
pub use error::{Fault, ReadError};
pub use header::{Card, Header};
pub use place::Place;

use source::Source;

/// A two-dimensional image with what its file says about it.
#[derive(Clone, Debug)]
pub struct Image {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` values, row-major, first FITS row first. NaN = undefined (NaN, `BLANK`); infinities are kept.
    pub pixels: Vec<f32>,
    /// Header of the image's HDU (empty for PGM and PNG).
    pub header: Header,
    /// Header of the primary HDU where the image is in an extension; otherwise empty.
    pub primary: Header,
    /// Number of the HDU, 0 = primary.
    pub hdu: usize,
    /// `EXTNAME` of the HDU.
    pub name: Option<String>,
    /// Sample type as stored: 8, 16, 32, 64, -32 or -64.
    pub bitpix: i64,
    /// CRC-32 (IEEE) of the file's bytes as they lie on the disk.
    pub checksum: u32,
    /// What a user should know about how the file was read.
    pub warnings: Vec<String>,
}

impl Image {
    /// The value at which the type of integer pixels ends, above which none can be; none for others.
    pub fn limit(&self) -> Option<f64> {
        let real = |keyword: &str, default| self.header.real(keyword).unwrap_or(default);
        let (zero, scale) = (real("BZERO", 0.0), real("BSCALE", 1.0));
        match self.bitpix {
            // Scaled pixels fill the range of their type, saturated or not.
            _ if scale != 1.0 => None,
            bits @ (8 | 16) if self.header.cards().is_empty() => Some((1u32 << bits) as f64 - 1.0),
            8 => Some(zero + 255.0),
            16 => Some(zero + f64::from(i16::MAX)),
            32 => Some(f64::from((zero + f64::from(i32::MAX)) as f32)),
            _ => None,
        }
    }

    /// A number from the image's header or, failing that, from the primary header (`EXPTIME`, `GAIN`, ...).
    pub fn real(&self, keyword: &str) -> Option<f64> {
        self.header.real(keyword).or_else(|| self.primary.real(keyword))
    }
}

/// Reads one image from a file.
///
/// Without a choice the first HDU with a 2-D image is taken (trailing axes of length 1 do not count, tables and 1-D
/// data are passed over). One pass over the file; memory is 4 bytes per pixel, reserved only after the size that the
/// header claims has been checked against the file.
///
/// # Errors
/// [`ReadError`] with the file, the HDU and the reason in one line.
pub fn image(path: &Path, hdu: Option<&HduChoice>) -> Result<Image, ReadError> {
    image_if(path, hdu, &mut |_, _| Ok(()))
}

/// Hears the columns and rows of an image before memory is taken for its pixels, and says in one line why it must not
/// be read.
pub type Admit<'a> = dyn FnMut(u64, u64) -> Result<(), String> + 'a;

/// Reads one image from a file, if `admit` has nothing against its size.
///
/// # Errors
/// As for [`image`], and [`Fault::Refused`].
pub fn image_if(path: &Path, hdu: Option<&HduChoice>, admit: &mut Admit<'_>) -> Result<Image, ReadError> {
    read(Source::open(path), path, Wanted { hdu, plane: None }, admit, &mut None)
}

/// Reads one image from a stream of bytes, of which there are `length` if that is known; `name` is for messages.
///
/// Without a length, memory grows with the bytes that arrive.
///
/// # Errors
/// As for [`image`].
pub fn stream(
    input: Box<dyn Read>,
    length: Option<u64>,
    name: &Path,
    hdu: Option<&HduChoice>,
) -> Result<Image, ReadError> {
    stream_if(input, length, name, hdu, &mut |_, _| Ok(()))
}

/// Reads one image from a stream of bytes, if `admit` has nothing against its size.
///
/// # Errors
/// As for [`image_if`].
pub fn stream_if(
    input: Box<dyn Read>,
    length: Option<u64>,
    name: &Path,
    hdu: Option<&HduChoice>,
    admit: &mut Admit<'_>,
) -> Result<Image, ReadError> {
    read(Source::new(input, length), name, Wanted { hdu, plane: None }, admit, &mut None)
}

/// Takes the values of an image piece by piece in their order.
pub type Take<'a> = dyn FnMut(&[f32]) -> std::io::Result<()> + 'a;

/// What of a file is wanted.
#[derive(Clone, Copy, Debug)]
struct Wanted<'a> {
    /// The HDU; the first that has such an image where none is named.
    hdu: Option<&'a HduChoice>,
    /// The plane of a cube, from 1; none for an image.
    plane: Option<usize>,
}

fn read(
    source: Result<Source, Fault>,
    path: &Path,
    wanted: Wanted<'_>,
    admit: &mut Admit<'_>,
    take: &mut Option<&mut Take<'_>>,
) -> Result<Image, ReadError> {
    let mut source = source.map_err(|fault| fault.in_file(path))?;
    let head = source.peek().map_err(|fault| fault.in_file(path))?;
    match picture::format(head) {
        Some(_) if wanted.plane.is_some() => Err(Fault::Section("a picture has no planes".to_owned()).in_file(path)),
        Some(_) if take.is_some() => {
            Err(Fault::Unsupported("a picture, which is read as a whole; strips need FITS".to_owned()).in_file(path))
        }
        Some(decode) => picture::read(source, path, wanted.hdu, decode, admit),
        None => fits::read(source, path, wanted, admit, take),
    }
}
