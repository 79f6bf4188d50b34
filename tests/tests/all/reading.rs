//! Reading the specimens: right pixels, or one clear line.

use std::fs;

use skyfront::read::{self, HduChoice};
use skyfront_tests::command::Folder;
use skyfront_tests::compressed;
use skyfront_tests::fits_bytes::{Header, gzip, samples, tiled};
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

/// A mask whose bits lie beyond what f64 keeps of a sum with 2^63.
#[test]
fn unsigned_numbers_of_64_bits_in_tiles_keep_small_values() {
    let folder = Folder::new("unsigned");
    let path = folder.path().join("mask.fits");
    let stored: Vec<u8> = [0i64, 1, 2, 3].iter().flat_map(|v| (v ^ i64::MIN).to_be_bytes()).collect();
    let unsigned = |header: Header| header.card("BZERO", "9223372036854775808").card("BSCALE", 1);
    for (coding, bytes) in [("GZIP_1", stored.clone()), ("GZIP_2", shuffled(&stored, 8))] {
        let file = tiled(64, (4, 1), coding, "COMPRESSED_DATA", &[gzip(&bytes)], unsigned);
        fs::write(&path, file).unwrap();
        assert_eq!(read::image(&path, None).unwrap().pixels, [0.0, 1.0, 2.0, 3.0], "{coding}");
    }
}

fn shuffled(bytes: &[u8], size: usize) -> Vec<u8> {
    (0..size).flat_map(|byte| bytes.chunks(size).map(move |value| value[byte])).collect()
}

#[test]
fn undefined_pixels_are_those_of_blank_however_it_is_written() {
    let folder = Folder::new("blank");
    let path = folder.path().join("blank.fits");
    let values = samples(16, &[7.0, 8.0, -9.0, 7.0]);
    for written in ["7", "7.0", "0.7E1"] {
        fs::write(&path, Header::primary(16, &[2, 2]).card("BLANK", written).with(values.clone())).unwrap();
        let pixels = read::image(&path, None).unwrap().pixels;
        assert!(same(&pixels, &[f32::NAN, 8.0, -9.0, f32::NAN]), "{written}: {pixels:?}");
    }
    fs::write(&path, Header::primary(16, &[2, 2]).card("BLANK", "7.5").with(values)).unwrap();
    assert!(read::image(&path, None).unwrap_err().to_string().contains("BLANK = 7.5"));
    // Unsigned numbers of 16 bits lie in PLIO with their zero point added: 3 pixels of 9, 1 of 7.
    let list: Vec<u8> = [0u16, 7, 0xff9c, 11, 0, 0, 0, 0x2008, 0x4003, 0x3002, 0x4001]
        .iter()
        .flat_map(|word| word.to_be_bytes())
        .collect();
    let unsigned = |header: Header| header.card("BZERO", 32768).card("BSCALE", 1).card("BLANK", 7 - 32768);
    fs::write(&path, tiled(16, (4, 1), "PLIO_1", "COMPRESSED_DATA", &[list], unsigned)).unwrap();
    let pixels = read::image(&path, None).unwrap().pixels;
    assert!(same(&pixels, &[9.0, 9.0, 9.0, f32::NAN]), "{pixels:?}");
}

#[test]
fn the_two_long_axes_of_an_image_are_its_plane() {
    let folder = Folder::new("axes");
    let path = folder.path().join("axes.fits");
    let values = samples(16, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    for axes in [[1, 1, 3, 2], [3, 1, 2, 1], [1, 3, 1, 2], [3, 2, 1, 1]] {
        let header = Header::primary(16, &axes).text("CTYPE3", "RA---TAN").text("CTYPE1", "STOKES");
        fs::write(&path, header.with(values.clone())).unwrap();
        let image = read::image(&path, None).unwrap();
        assert_eq!((image.width, image.height), (3, 2), "{axes:?}");
        assert_eq!(image.pixels, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let kept = if axes == [1, 1, 3, 2] { "RA---TAN" } else { "STOKES" };
        let expected = (axes != [1, 3, 1, 2]).then_some(kept);
        assert_eq!(image.header.text("CTYPE1").as_deref(), expected, "{axes:?}");
    }
}

#[test]
fn a_header_with_several_values_of_a_keyword_says_so() {
    let folder = Folder::new("several");
    let path = folder.path().join("several.fits");
    let header = Header::primary(16, &[2, 2]).card("GAIN", 1.0).card("GAIN", 2.0).text("SATURATE", "none");
    fs::write(&path, header.with(samples(16, &[1.0, 2.0, 3.0, 4.0]))).unwrap();
    let warnings = read::image(&path, None).unwrap().warnings.join("\n");
    assert!(warnings.contains("GAIN") && warnings.contains("SATURATE = none is no number"), "{warnings}");
}

#[test]
fn integers_are_saturated_where_their_type_ends() {
    let folder = Folder::new("limit");
    let path = folder.path().join("limit.fits");
    let limit = |header: Header, bitpix: i32| {
        fs::write(&path, header.with(samples(bitpix, &[1.0, 2.0, 3.0, 4.0]))).unwrap();
        read::image(&path, None).unwrap().limit()
    };
    assert_eq!(limit(Header::primary(8, &[2, 2]), 8), Some(255.0));
    assert_eq!(limit(Header::primary(16, &[2, 2]).card("BZERO", 32768), 16), Some(65535.0));
    assert_eq!(limit(Header::primary(16, &[2, 2]), 16), Some(32767.0));
    assert_eq!(limit(Header::primary(16, &[2, 2]).card("BSCALE", 0.5), 16), None);
    assert_eq!(limit(Header::primary(-32, &[2, 2]), -32), None);
}
