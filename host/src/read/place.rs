//! An image or a map named on the command line: `FILE`, `FILE[HDU]`, `FILE[X0:X1,Y0:Y1]` or both;
//! `FILE[*,*,K]` is a plane of a cube.

use std::fmt;
use std::path::{Path, PathBuf};

use super::section::Section;
use super::source::Source;
use super::{Admit, Fault, HduChoice, Image, ReadError, Take, Wanted, read};

/// Where a map is: a file, and the HDU in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place(PathBuf);

impl Place {
    /// The place that a text names.
    pub fn new(text: impl Into<PathBuf>) -> Self {
        Self(text.into())
    }

    /// The file, and what its brackets mean. A file of the whole name goes before the meaning of
    /// brackets.
    fn parts(&self) -> Parts<'_> {
        let mut parts = Parts { file: &self.0, hdu: None, section: None };
        while let Some((file, inside)) = parts.file.to_str().and_then(bracketed).filter(|_| !parts.file.exists()) {
            let section = Section::parse(inside);
            match (section, parts.hdu.is_some()) {
                (Some(section), false) if parts.section.is_none() => parts.section = Some(section),
                (None, false) => parts.hdu = inside.parse().ok(),
                _ => break,
            }
            parts.file = Path::new(file);
        }
        parts
    }

    /// Reads the map, if `admit` has nothing against its size.
    ///
    /// # Errors
    /// As [`super::image_if`].
    pub fn read_if(&self, admit: &mut Admit<'_>) -> Result<Image, ReadError> {
        self.read_hdu_if(None, admit)
    }

    /// The same from this HDU unless the brackets name one; `-` is standard input. Of a section, its
    /// own size is heard.
    ///
    /// # Errors
    /// As [`super::image_if`]; a section that is not in the image.
    pub fn read_hdu_if(&self, hdu: Option<&HduChoice>, admit: &mut Admit<'_>) -> Result<Image, ReadError> {
        self.read_to(hdu, admit, &mut None)
    }

    /// The same of a FITS image whose values `take` takes as they come: the image that is given back has none.
    ///
    /// # Errors
    /// As [`super::image_if`]; a section, a picture, and what `take` reports.
    pub fn hand_over(
        &self,
        hdu: Option<&HduChoice>,
        admit: &mut Admit<'_>,
        take: &mut Take<'_>,
    ) -> Result<Image, ReadError> {
        self.read_to(hdu, admit, &mut Some(take))
    }

    fn read_to(
        &self,
        hdu: Option<&HduChoice>,
        admit: &mut Admit<'_>,
        take: &mut Option<&mut Take<'_>>,
    ) -> Result<Image, ReadError> {
        let parts = self.parts();
        let wanted = Wanted { hdu: parts.hdu.as_ref().or(hdu), plane: parts.section.and_then(Section::plane) };
        let source = match parts.file == Path::new("-") {
            true => Source::new(Box::new(std::io::stdin()), None),
            false => Source::open(parts.file),
        };
        let Some(section) = &parts.section else {
            return read(source, parts.file, wanted, admit, take);
        };
        if take.is_some() {
            let why = "a section, which is cut from a whole image; strips need all of it".to_owned();
            return Err(Fault::Unsupported(why).in_file(parts.file));
        }
        let image = section
            .of(read(source, parts.file, wanted, &mut |_, _| Ok(()), take)?)
            .map_err(|fault| fault.in_file(parts.file))?;
        match admit(image.width as u64, image.height as u64) {
            Ok(()) => Ok(image),
            Err(why) => Err(Fault::Refused(why).in_file(parts.file)),
        }
    }
}

/// What a name says.
#[derive(Debug, PartialEq)]
struct Parts<'a> {
    file: &'a Path,
    hdu: Option<HduChoice>,
    section: Option<Section>,
}

/// A name that ends in brackets, and what is in them.
fn bracketed(text: &str) -> Option<(&str, &str)> {
    let (file, inside) = text.strip_suffix(']')?.rsplit_once('[')?;
    (!file.is_empty() && !inside.is_empty()).then_some((file, inside))
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.display().fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of three planes of 3 x 2 counts, the third axis that of wavelengths.
    fn cube() -> Vec<u8> {
        let cards = ["SIMPLE  = T", "BITPIX  = 16", "NAXIS   = 3", "NAXIS1  = 3", "NAXIS2  = 2", "NAXIS3  = 3"];
        let more = ["CTYPE3  = 'WAVE'", "CRVAL2  = 7.0", "END"];
        let mut bytes: Vec<u8> =
            cards.iter().chain(&more).flat_map(|card| format!("{card:<80}").into_bytes()).collect();
        bytes.resize(2880, b' ');
        bytes.extend((0..18i16).flat_map(i16::to_be_bytes));
        bytes.resize(5760, 0);
        bytes
    }

    #[test]
    fn a_plane_of_a_cube_has_its_pixels_and_its_coordinates() {
        let file = std::env::temp_dir().join(format!("skyfront-cube-{}.fits", std::process::id()));
        std::fs::write(&file, cube()).unwrap();
        let read = |brackets: &str| Place::new(format!("{}{brackets}", file.display())).read_if(&mut |_, _| Ok(()));
        let second = read("[*,*,2]").unwrap();
        assert_eq!((second.width, second.height, &second.pixels[..]), (3, 2, &[6.0, 7.0, 8.0, 9.0, 10.0, 11.0][..]));
        assert_eq!((second.header.real("CRVAL2"), second.header.text("CTYPE3")), (Some(7.0), None));
        assert_eq!(read("[0][2:3,2:2,3]").unwrap().pixels, [16.0, 17.0]);
        for (brackets, why) in [
            ("", "[*,*,1] is the first plane"),
            ("[0]", "a plane of a cube"),
            ("[*,*,4]", "plane 4"),
            ("[*,*,0]", "plane 0"),
        ] {
            assert!(read(brackets).is_err_and(|error| error.to_string().contains(why)), "{brackets}");
        }
        std::fs::remove_file(&file).unwrap();
    }

    #[test]
    fn brackets_choose_an_hdu_unless_a_file_has_them_in_its_name() {
        let hdu = |text: &str| text.parse::<HduChoice>().ok();
        let folder = std::env::temp_dir().join(format!("skyfront-place-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let named = folder.join("m[1]");
        std::fs::write(&named, "").unwrap();
        let parts = |file, hdu, section| Parts { file, hdu, section };
        assert_eq!(Place::new(&named).parts(), parts(&named, None, None));
        let within = folder.join("m[1][DQ,2]");
        assert_eq!(Place::new(&within).parts(), parts(&named, hdu("DQ,2"), None));
        std::fs::remove_dir_all(&folder).unwrap();
        let file = Path::new("dq.fits");
        assert_eq!(Place::new("dq.fits[3]").parts(), parts(file, hdu("3"), None));
        let section = Section::parse("2:5,1:9");
        assert!(section.is_some());
        assert_eq!(Place::new("dq.fits[2:5,1:9]").parts(), parts(file, None, section));
        assert_eq!(Place::new("dq.fits[SCI][2:5,1:9]").parts(), parts(file, hdu("SCI"), section));
        for name in ["dq.fits", "[3]", "a]b"] {
            assert_eq!(Place::new(name).parts(), parts(Path::new(name), None, None));
        }
    }
}
