//! Tile-compressed images as cfitsio writes them.

use std::path::Path;

use fitsio::FitsFile;
use fitsio::errors::Error;
use fitsio::images::{ImageDescription, ImageType};

use crate::specimens::{HEIGHT, WIDTH};

/// A way to compress an image.
pub struct Kind {
    pub name: &'static str,
    /// The compression in cfitsio's extended file name syntax: algorithm, tile, quantization.
    syntax: &'static str,
    stored: ImageType,
    /// Whether every pixel comes back as it was.
    pub lossless: bool,
}

/// Every way that is tested.
pub const KINDS: [Kind; 18] = [
    lossless("rice", "R", ImageType::Short),
    lossless("rice-long", "R", ImageType::Long),
    lossless("rice-tiles", "R 7,5", ImageType::Short),
    lossless("rice-unsigned", "R", ImageType::UnsignedShort),
    lossless("gzip", "G", ImageType::Short),
    lossless("gzip-tiles", "G 24,16", ImageType::Long),
    lossless("hcompress", "H 24,16", ImageType::Short),
    lossless("hcompress-tiles", "H 9,16", ImageType::Short),
    lossless("hcompress-long", "H 24,16", ImageType::Long),
    lossless("plio", "P", ImageType::Short),
    lossless("float", "G; q 0", ImageType::Float),
    lossless("double", "G; q 0", ImageType::Double),
    lossy("quantized", "R; q 4", ImageType::Float),
    lossy("dithered-zeros", "R; qz 4", ImageType::Float),
    lossy("not-dithered", "R; q0 4", ImageType::Float),
    lossy("quantized-double", "G; q 4", ImageType::Double),
    lossy("quantized-hcompress", "H 24,16; q 4", ImageType::Float),
    lossy("hcompress-scaled", "H 12,8; s 3", ImageType::Long),
];

const fn lossless(name: &'static str, syntax: &'static str, stored: ImageType) -> Kind {
    Kind { name, syntax, stored, lossless: true }
}

const fn lossy(name: &'static str, syntax: &'static str, stored: ImageType) -> Kind {
    Kind { name, syntax, stored, lossless: false }
}

/// Has cfitsio write an image of the size of the specimens, into extension 1 of a new file.
///
/// # Errors
/// What cfitsio says.
pub fn write(path: &Path, kind: &Kind, values: &[f64]) -> Result<(), Error> {
    write_sized(path, kind, values, [HEIGHT, WIDTH])
}

/// The same for an image of so many rows and columns.
///
/// # Errors
/// What cfitsio says.
pub fn write_sized(path: &Path, kind: &Kind, values: &[f64], size: [usize; 2]) -> Result<(), Error> {
    let description = ImageDescription { data_type: kind.stored, dimensions: &size };
    let name = format!("{}[compress {}]", path.display(), kind.syntax);
    let mut file = FitsFile::create(name).with_custom_primary(&description).open()?;
    let hdu = file.hdu(1)?;
    // cfitsio compresses only what has the type of the image already.
    match kind.stored {
        ImageType::Short => hdu.write_image(&mut file, &as_type(values, |v| v as i16)),
        ImageType::UnsignedShort => hdu.write_image(&mut file, &as_type(values, |v| v as u16)),
        ImageType::Long => hdu.write_image(&mut file, &as_type(values, |v| v as i32)),
        _ => hdu.write_image(&mut file, values),
    }
}

/// The image as cfitsio reads it back.
pub fn read(path: &Path) -> Vec<f32> {
    let mut file = FitsFile::open(path).expect("cfitsio opens its own file");
    let hdu = file.hdu(1).expect("the image is in extension 1");
    hdu.read_image(&mut file).expect("cfitsio reads its own image")
}

fn as_type<T>(values: &[f64], convert: impl Fn(f64) -> T) -> Vec<T> {
    values.iter().map(|&value| convert(value)).collect()
}
