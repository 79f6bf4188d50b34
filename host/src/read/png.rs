//! PNG camera frames: grayscale with 8 or 16 bits.

use std::io::{Cursor, Read};

use png::{BitDepth, ColorType, Decoder, DecodingError, Limits};

use super::Admit;
use super::decoded::Picture;
use super::error::Fault;
use super::pixels;
use super::source::Source;

/// The most bytes that one compressed byte can stand for (deflate), with some for small pictures.
const RATIO: u64 = 1032;
const SLACK: u64 = 1 << 16;

/// Reads the picture that starts here; the top row of the picture comes first.
pub(super) fn read(source: &mut Source, admit: &mut Admit<'_>) -> Result<Picture, Fault> {
    let mut file = Vec::new();
    source.read_to_end(&mut file).map_err(|error| source.broken(error))?;
    let most = file.len() as u64 * RATIO + SLACK;
    let limits = Limits { bytes: usize::try_from(most).unwrap_or(usize::MAX) };
    let mut reader = Decoder::new_with_limits(Cursor::new(&file), limits).read_info().map_err(broken)?;
    let (color, depth) = reader.output_color_type();
    let size = match (color, depth) {
        (ColorType::Grayscale, BitDepth::Eight) => 1,
        (ColorType::Grayscale, BitDepth::Sixteen) => 2,
        _ => {
            let what = format!("a PNG of type {color:?} with {depth:?} bits; convert it to grayscale of 8 or 16 bits");
            return Err(Fault::Unsupported(what));
        }
    };
    let (width, height) = (reader.info().width, reader.info().height);
    let promised = u128::from(width) * u128::from(height) * size;
    if promised > u128::from(most) {
        return Err(Fault::Truncated { promised, present: most });
    }
    let mut bytes = Vec::new();
    let plane = (width.into(), height.into());
    admit(plane.0, plane.1).map_err(Fault::Refused)?;
    bytes.try_reserve_exact(promised as usize).map_err(|_| pixels::memory(plane))?;
    bytes.resize(promised as usize, 0);
    reader.next_frame(&mut bytes).map_err(broken)?;
    let pixels = match size {
        1 => bytes.iter().map(|&b| b.into()).collect(),
        _ => bytes.as_chunks::<2>().0.iter().map(|b| u16::from_be_bytes(*b).into()).collect(),
    };
    Ok(Picture { width: width as usize, height: height as usize, pixels, bitpix: size as i64 * 8 })
}

fn broken(error: DecodingError) -> Fault {
    Fault::Corrupt(format!("PNG: {error}"))
}
