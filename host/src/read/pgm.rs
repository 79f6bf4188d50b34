//! PGM camera frames: binary (`P5`) with one or two bytes per pixel, and plain text (`P2`).

use std::io::Read;

use super::Admit;
use super::decoded::Picture;
use super::error::Fault;
use super::pixels;
use super::source::Source;

/// Reads the picture that starts here; the top row of the picture comes first.
pub(super) fn read(source: &mut Source, admit: &mut Admit<'_>) -> Result<Picture, Fault> {
    let mut magic = [0; 2];
    source.fill(&mut magic)?;
    let [width, height, white] = [number(source)?, number(source)?, number(source)?];
    if width == 0 || height == 0 || !(1..=65535).contains(&white) {
        return Err(Fault::Header(format!("a PGM of {width} x {height} pixels with values up to {white}")));
    }
    let size = if white < 256 { 1 } else { 2 };
    let text = &magic == b"P2";
    // A number and a blank are at least two bytes of text, of which the last blank may be missing.
    let promised = u128::from(width) * u128::from(height) * if text { 2 } else { size } - u128::from(text);
    if let Some(present) = source.at_most_left().filter(|&present| u128::from(present) < promised) {
        return Err(Fault::Truncated { promised, present });
    }
    let plane = (width.into(), height.into());
    admit(plane.0, plane.1).map_err(Fault::Refused)?;
    let pixels = if text { words(source, plane)? } else { samples(source, plane, size as usize)? };
    Ok(Picture { width: width as usize, height: height as usize, pixels, bitpix: size as i64 * 8 })
}

/// A number of the header or of plain text, behind blanks and comments, and the one blank after it.
fn number(source: &mut Source) -> Result<u32, Fault> {
    let odd = || Fault::Header("the PGM header is not three numbers".into());
    let mut digits = String::new();
    loop {
        match byte(source)? {
            Some(b'#') => while !matches!(byte(source)?, None | Some(b'\n')) {},
            Some(digit @ b'0'..=b'9') if digits.len() < 10 => digits.push(digit.into()),
            Some(blank) if blank.is_ascii_whitespace() && digits.is_empty() => {}
            Some(blank) if blank.is_ascii_whitespace() => break,
            None if !digits.is_empty() => break,
            _ => return Err(odd()),
        }
    }
    digits.parse().map_err(|_| odd())
}

fn byte(source: &mut Source) -> Result<Option<u8>, Fault> {
    let mut byte = [0];
    Ok((source.fill(&mut byte)? == 1).then_some(byte[0]))
}

fn words(source: &mut Source, plane: (u64, u64)) -> Result<Vec<f32>, Fault> {
    let mut pixels = Vec::new();
    for _ in 0..plane.0 * plane.1 {
        pixels.try_reserve(1).map_err(|_| pixels::memory(plane))?;
        pixels.push(number(source)? as f32);
    }
    Ok(pixels)
}

/// Unsigned big-endian samples.
fn samples(source: &mut Source, plane: (u64, u64), size: usize) -> Result<Vec<f32>, Fault> {
    let promised = plane.0 as usize * plane.1 as usize * size;
    let mut bytes = Vec::new();
    source.take(promised as u64).read_to_end(&mut bytes).map_err(|error| source.broken(error))?;
    if bytes.len() < promised {
        return Err(Fault::Truncated { promised: promised as u128, present: bytes.len() as u64 });
    }
    Ok(match size {
        1 => bytes.iter().map(|&b| b.into()).collect(),
        _ => bytes.as_chunks::<2>().0.iter().map(|b| u16::from_be_bytes(*b).into()).collect(),
    })
}
