//! One result folder for each of many images, named after the image.

use std::collections::HashSet;
use std::path::Path;

/// Endings that say how a file is stored, not what it shows.
const ENDINGS: [&str; 10] = [".gz", ".bz2", ".fz", ".fits", ".fit", ".fts", ".pgm", ".png", ".img", ".imh"];

/// Names of the folders for these images, in their order.
///
/// The first image of a name gets it, a later one `NAME-2`, `NAME-3` and so on: names depend on
/// the order of the images alone. Names that differ in case only count as equal, as they do on
/// some file systems. `taken` is not given away.
pub fn folders(images: &[impl AsRef<Path>], taken: &str) -> Vec<String> {
    let mut used: HashSet<String> = HashSet::from([taken.to_lowercase()]);
    let mut free = |name: &str| used.insert(name.to_lowercase());
    let name_of = |image: &Path| {
        let stem = stem(image);
        let numbered = (2..).map(|number| format!("{stem}-{number}"));
        std::iter::once(stem.clone()).chain(numbered).find(|name| free(name)).unwrap_or(stem)
    };
    images.iter().map(AsRef::as_ref).map(name_of).collect()
}

/// A file's name without the endings that tell its format.
fn stem(image: &Path) -> String {
    let name = image.file_name().unwrap_or_default().to_string_lossy();
    let mut stem = name.as_ref();
    while let Some(shorter) = ENDINGS.iter().find_map(|ending| strip(stem, ending)) {
        stem = shorter;
    }
    stem.to_owned()
}

/// `name` without `ending`, in whatever case; never nothing.
fn strip<'a>(name: &'a str, ending: &str) -> Option<&'a str> {
    let at = name.len().checked_sub(ending.len()).filter(|&at| at > 0 && name.is_char_boundary(at))?;
    let rest = name[at..].eq_ignore_ascii_case(ending).then_some(&name[..at])?;
    // Dots alone would be the folder itself, or its parent.
    (!rest.bytes().all(|byte| byte == b'.')).then_some(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_named_after_images() {
        let names = folders(&["a/m31.fits", "b/M33.FITS.gz", "c.d.fz", ".fits", "näme_星.fits"], "summary.csv");
        assert_eq!(names, ["m31", "M33", "c.d", ".fits", "näme_星"]);
    }

    #[test]
    fn no_folder_is_the_parent_or_the_results_themselves() {
        assert_eq!(
            folders(&["..fits", "...fits", "....fits.gz", "..a.fits"], "s"),
            ["..fits", "...fits", "....fits", "..a"]
        );
    }

    #[test]
    fn clashes_are_numbered_in_the_order_of_the_images() {
        let names =
            folders(&["a/x.fits", "b/x.fits", "x-2.fits", "X.png", "a/x.fits", "summary.csv.gz"], "summary.csv");
        assert_eq!(names, ["x", "x-2", "x-2-2", "X-3", "x-4", "summary.csv-2"]);
    }
}
