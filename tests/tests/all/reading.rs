//! Reading the specimens: right pixels, or one clear line.

use std::fs;

use skyfront::read::{self, HduChoice};
use skyfront_tests::command::Folder;
use skyfront_tests::compressed;
use skyfront_tests::fits_bytes::{Header, samples};
use skyfront_tests::specimens::{self, Expect, HEIGHT, WIDTH};

fn same(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()))
}

#[test]
fn every_specimen_is_read_or_refused_as_it_should() {
    let folder = Folder::new("specimens");
    let mut complaints = Vec::new();
    let specimens = specimens::all();
    assert!(specimens.len() > 90, "only {} specimens", specimens.len());
    for specimen in specimens {
        let path = folder.path().join(specimen.name);
        fs::write(&path, &specimen.bytes).unwrap();
        let outcome = read::image(&path, None);
        let fault = match (&specimen.expect, &outcome) {
            (Expect::Pixels(hdu, pixels), Ok(image)) => {
                let placed = image.hdu == *hdu && (image.width, image.height) == (WIDTH, HEIGHT);
                (!placed || !same(pixels, &image.pixels)).then(|| "has other pixels".to_owned())
            }
            (Expect::Refused(words), Err(error)) => {
                let line = error.to_string();
                let clear = line.contains(specimen.name) && line.contains(words) && line.lines().count() == 1;
                (!clear).then(|| format!("is refused with: {line}"))
            }
            (Expect::Pixels(..), Err(error)) => Some(format!("is refused: {error}")),
            (Expect::Refused(_), Ok(_)) => Some("is read".to_owned()),
        };
        complaints.extend(fault.map(|fault| format!("{} {fault}", specimen.name)));
    }
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn compressed_images_are_read_as_cfitsio_reads_them() {
    let folder = Folder::new("compressed");
    let scene = specimens::scene();
    let exact: Vec<f32> = scene.iter().map(|&v| v as f32).collect();
    for kind in compressed::KINDS {
        let path = folder.path().join(format!("{}.fits", kind.name));
        compressed::write(&path, &kind, &scene).unwrap_or_else(|error| panic!("{}: {error}", kind.name));
        let image = read::image(&path, None).unwrap();
        assert_eq!((image.hdu, image.width, image.height), (1, WIDTH, HEIGHT), "{}", kind.name);
        assert!(same(&image.pixels, &compressed::read(&path)), "{}: not what cfitsio reads", kind.name);
        assert!(!kind.lossless || same(&image.pixels, &exact), "{}: not the scene", kind.name);
        let far = image.pixels.iter().zip(&exact).filter(|(v, s)| (**v - **s).abs() > 60.0).count();
        assert_eq!(far, 0, "{}: pixels far from the scene", kind.name);
    }
}

#[test]
fn an_hdu_is_chosen_by_number_name_or_version() {
    let folder = Folder::new("choice");
    let path = folder.path().join("many.fits");
    let extension = |name: &str, version: u64, value: f64| {
        Header::image(16, &[2, 2]).text("EXTNAME", name).card("EXTVER", version).with(samples(16, &[value; 4]))
    };
    let primary = Header::primary(8, &[]).card("EXPTIME", 30.5).bytes();
    fs::write(&path, [primary, extension("SCI", 1, 1.0), extension("ERR", 1, 2.0), extension("SCI", 2, 3.0)].concat())
        .unwrap();
    let read = |choice: &str| read::image(&path, Some(&choice.parse::<HduChoice>().unwrap()));
    for (choice, value) in [("1", 1.0), ("sci", 1.0), ("Err", 2.0), ("SCI,2", 3.0), ("3", 3.0)] {
        assert_eq!(read(choice).unwrap().pixels, [value; 4], "{choice}");
    }
    assert_eq!(read("SCI").unwrap().real("EXPTIME"), Some(30.5), "from the primary header");
    for (choice, words) in [("4", "no HDU 4; the file has 0: empty"), ("DQ", "2 ERR: a 2-D"), ("0", "--hdu")] {
        let line = read(choice).unwrap_err().to_string();
        assert!(line.contains(words), "{line}");
    }
}

#[test]
fn a_directory_and_a_missing_file_are_named() {
    let folder = Folder::new("directory.fits");
    let directory = read::image(folder.path(), None).unwrap_err().to_string();
    assert!(directory.contains("directory.fits") && directory.contains("is a directory"), "{directory}");
    let missing = read::image(&folder.path().join("absent.fits"), None).unwrap_err().to_string();
    assert!(missing.contains("absent.fits") && missing.contains("No such file"), "{missing}");
}

#[test]
fn the_checksum_is_that_of_the_file() {
    let folder = Folder::new("checksum");
    let path = folder.path().join("a.fits");
    for specimen in specimens::all().iter().filter(|s| matches!(s.expect, Expect::Pixels(..))) {
        fs::write(&path, &specimen.bytes).unwrap();
        let expected = crc32fast::hash(&specimen.bytes);
        assert_eq!(read::image(&path, None).unwrap().checksum, expected, "{}", specimen.name);
    }
}
