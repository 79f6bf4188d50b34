//! Camera frames in picture formats, turned so that they stand like FITS images.

use std::path::Path;

use super::decoded::Picture;
use super::error::{Fault, ReadError};
use super::header::Header;
use super::source::Source;
use super::{Admit, HduChoice, Image, pgm, png};

/// A reader of one picture format.
pub(super) type Decode = fn(&mut Source, &mut Admit<'_>) -> Result<Picture, Fault>;

/// The reader for the format that a file begins with, if it is a picture.
pub(super) fn format(head: &[u8]) -> Option<Decode> {
    match head {
        [b'P', b'2' | b'5', blank, ..] if blank.is_ascii_whitespace() || *blank == b'#' => Some(pgm::read),
        [0x89, b'P', b'N', b'G', ..] => Some(png::read),
        _ => None,
    }
}

/// Reads a picture. Its bottom row becomes row 0, where FITS images begin.
pub(super) fn read(
    mut source: Source,
    path: &Path,
    wanted: Option<&HduChoice>,
    decode: Decode,
    admit: &mut Admit<'_>,
) -> Result<Image, ReadError> {
    if let Some(choice) = wanted.filter(|&choice| *choice != HduChoice::Number(0)) {
        let fault = Fault::NoSuchHdu { wanted: choice.to_string(), present: "one picture, which is 0".into() };
        return Err(fault.in_file(path));
    }
    let mut picture = decode(&mut source, admit).map_err(|fault| fault.in_file(path))?;
    flip(&mut picture.pixels, picture.width);
    Ok(Image {
        width: picture.width,
        height: picture.height,
        pixels: picture.pixels,
        header: Header::default(),
        primary: Header::default(),
        hdu: 0,
        name: None,
        bitpix: picture.bitpix,
        checksum: source.checksum().map_err(|fault| fault.in_file(path))?,
        warnings: Vec::new(),
    })
}

/// Exchanges the first row with the last, and so on.
fn flip(pixels: &mut [f32], width: usize) {
    let rows = pixels.len() / width;
    let (top, bottom) = pixels.split_at_mut(rows / 2 * width);
    for (a, b) in top.chunks_mut(width).zip(bottom.rchunks_mut(width)) {
        a.swap_with_slice(b);
    }
}
