//! A map named on the command line: `FILE`, or `FILE[HDU]`.

use std::fmt;
use std::path::{Path, PathBuf};

use super::{Admit, HduChoice, Image, ReadError, image_if};

/// Where a map is: a file, and the HDU in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place(PathBuf);

impl Place {
    /// The place that a text names.
    pub fn new(text: impl Into<PathBuf>) -> Self {
        Self(text.into())
    }

    /// The file and the HDU. A file of the whole name goes before the meaning of brackets.
    fn parts(&self) -> (&Path, Option<HduChoice>) {
        let split = || self.0.to_str()?.strip_suffix(']')?.rsplit_once('[');
        match split() {
            Some((file, hdu)) if !file.is_empty() && !self.0.exists() => (Path::new(file), hdu.parse().ok()),
            _ => (&self.0, None),
        }
    }

    /// Reads the map, if `admit` has nothing against its size.
    ///
    /// # Errors
    /// As [`image_if`].
    pub fn read_if(&self, admit: &mut Admit<'_>) -> Result<Image, ReadError> {
        let (file, hdu) = self.parts();
        image_if(file, hdu.as_ref(), admit)
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.display().fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brackets_choose_an_hdu_unless_a_file_has_them_in_its_name() {
        let hdu = |text: &str| text.parse::<HduChoice>().ok();
        let folder = std::env::temp_dir().join(format!("skyfront-place-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let named = folder.join("m[1]");
        std::fs::write(&named, "").unwrap();
        assert_eq!(Place::new(&named).parts(), (named.as_path(), None));
        let within = folder.join("m[1][DQ,2]");
        assert_eq!(Place::new(&within).parts(), (named.as_path(), hdu("DQ,2")));
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(Place::new("dq.fits[3]").parts(), (Path::new("dq.fits"), hdu("3")));
        for name in ["dq.fits", "[3]", "a]b"] {
            assert_eq!(Place::new(name).parts(), (Path::new(name), None));
        }
    }
}
