//! From the bytes of a FITS file to the wanted image: walk over the HDUs, choose one, read it.

use std::path::Path;

use super::error::{Fault, ReadError};
use super::hdu::{BLOCK, Hdu, Kind, Shape};
use super::header::Header;
use super::source::Source;
use super::{Admit, Image, Take, Wanted, pixels, tiles};

/// Reads the wanted HDU, or the first 2-D image.
pub(super) fn read(
    mut source: Source,
    path: &Path,
    wanted: Wanted<'_>,
    admit: &mut Admit<'_>,
    take: &mut Option<&mut Take<'_>>,
) -> Result<Image, ReadError> {
    let mut seen = Vec::new();
    let mut primary = Header::default();
    let at = |hdu: Option<usize>| move |fault: Fault| ReadError { file: path.to_owned(), hdu, fault };
    loop {
        let number = seen.len();
        let next = Hdu::next(&mut source, number).map_err(at((number > 0).then_some(number)))?;
        let Some(hdu) = next else { return Err(at(None)(missing(&seen, wanted))) };
        if is_wanted(&hdu, wanted) {
            let image = read_hdu(&mut source, hdu, wanted.plane, admit, take).map_err(at(Some(number)))?;
            let checksum = source.checksum().map_err(at(None))?;
            return Ok(Image { primary, checksum, ..image });
        }
        skip(&mut source, &hdu).map_err(at(Some(number)))?;
        seen.push((hdu.label(), hdu.words()));
        if number == 0 {
            primary = hdu.header;
        }
    }
}

fn is_wanted(hdu: &Hdu, wanted: Wanted<'_>) -> bool {
    match (wanted.hdu, &hdu.kind) {
        (Some(choice), _) => choice.matches(hdu),
        (None, Kind::Array(shape)) if wanted.plane.is_some() => shape.cube().is_some(),
        (None, Kind::Array(shape)) => shape.plane().is_some(),
        (None, Kind::Tiles(shape)) => shape.tiled_plane().is_some(),
        (None, Kind::Other(_)) => false,
    }
}

fn read_hdu(
    source: &mut Source,
    hdu: Hdu,
    wanted: Option<usize>,
    admit: &mut Admit<'_>,
    take: &mut Option<&mut Take<'_>>,
) -> Result<Image, Fault> {
    let not_an_image = || Fault::NotTwoDimensional(hdu.words());
    let (mut warnings, mut is_defined) = (Vec::new(), false);
    let any = &mut is_defined;
    let mut watched = take.as_mut().map(|take| {
        move |pixels: &[f32]| {
            *any |= any_finite(pixels);
            take(pixels)
        }
    });
    let take = &mut watched.as_mut().map(|take| take as &mut Take<'_>);
    let (bitpix, plane, pixels) = match &hdu.kind {
        Kind::Array(shape) => {
            let (plane, before) = match wanted {
                Some(number) => plane_of(shape, number)?,
                None => (shape.plane().ok_or_else(not_an_image)?, 0),
            };
            admit(plane.0, plane.1).map_err(Fault::Refused)?;
            source.skip(before)?;
            (shape.bitpix, plane, pixels::read(source, &hdu, shape.bitpix, plane, take)?)
        }
        Kind::Tiles(_) if wanted.is_some() => {
            return Err(Fault::Unsupported("a plane of compressed data; decompress the file by funpack".to_owned()));
        }
        Kind::Tiles(shape) => {
            let plane = shape.tiled_plane().ok_or_else(not_an_image)?;
            admit(plane.0, plane.1).map_err(Fault::Refused)?;
            let (pixels, warning) = tiles::read(source, &hdu, shape.bitpix, plane, take)?;
            warnings.extend(warning);
            (shape.bitpix, plane, pixels)
        }
        Kind::Other(_) => return Err(not_an_image()),
    };
    is_defined |= any_finite(&pixels);
    warnings.extend(undefined(is_defined, bitpix)?);
    warnings.extend(hdu.header.oddities());
    let kept = match &hdu.kind {
        Kind::Array(_) if wanted.is_some() => Some([1, 2]),
        Kind::Array(shape) => shape.plane_axes().filter(|kept| *kept != [1, 2]),
        _ => None,
    };
    Ok(Image {
        width: plane.0 as usize,
        height: plane.1 as usize,
        pixels,
        hdu: hdu.number,
        name: hdu.name(),
        bitpix,
        header: kept.map_or_else(|| hdu.header.clone(), |kept| hdu.header.with_axes(kept)),
        primary: Header::default(),
        checksum: 0,
        warnings,
    })
}

/// Columns and rows of a plane of a cube, numbered from 1, and the bytes before it.
fn plane_of(shape: &Shape, number: usize) -> Result<((u64, u64), u64), Fault> {
    let number = number as u64;
    let wrong = || Fault::Section(format!("plane {number} is not in {}", shape.words()));
    let (width, height, _) = shape.cube().filter(|&(.., planes)| (1..=planes).contains(&number)).ok_or_else(wrong)?;
    let bytes = u128::from(width) * u128::from(height) * u128::from(shape.bitpix.unsigned_abs() / 8);
    let before = u64::try_from(bytes * u128::from(number - 1)).map_err(|_| wrong())?;
    Ok(((width, height), before))
}

/// An image without any value: a broken one if its samples could hold values, an empty one if all are `BLANK`.
fn undefined(is_defined: bool, bitpix: i64) -> Result<Option<String>, Fault> {
    match is_defined {
        true => Ok(None),
        false if bitpix < 0 => Err(Fault::NothingDefined),
        false => Ok(Some("every pixel is BLANK".to_owned())),
    }
}

fn any_finite(pixels: &[f32]) -> bool {
    pixels.iter().any(|value| value.is_finite())
}

/// Passes over the data of an HDU; a file that ends there has no further HDU, which the caller will find.
fn skip(source: &mut Source, hdu: &Hdu) -> Result<(), Fault> {
    let padded = hdu.bytes.div_ceil(BLOCK.into()) * u128::from(BLOCK);
    let present = source.at_most_left().unwrap_or(u64::MAX);
    if u128::from(present) < hdu.bytes {
        return Err(Fault::Truncated { promised: hdu.bytes, present });
    }
    source.skip(u64::try_from(padded).unwrap_or(u64::MAX)).map(|_| ())
}

/// Why nothing was found, with what there is instead.
fn missing(seen: &[(String, String)], wanted: Wanted<'_>) -> Fault {
    const SHOWN: usize = 24;
    let mut list: Vec<String> = seen.iter().take(SHOWN).map(|(label, words)| format!("{label}: {words}")).collect();
    if seen.len() > SHOWN {
        list.push(format!("and {} more", seen.len() - SHOWN));
    }
    let present = list.join("; ");
    match wanted.hdu {
        Some(choice) => Fault::NoSuchHdu { wanted: choice.to_string(), present },
        None => Fault::NoImage(present),
    }
}
