//! Every file of `../shared/fits-zoo` is read or refused as its manifest says. The files lie beside the repository:
//! `cargo test -p skyfront-tests -- --ignored zoo::` asks for them. `reading.rs` tries a zoo of our own.

use std::fs;
use std::path::{Path, PathBuf};

use skyfront::read::{self, HduChoice, Image, ReadError};
use skyfront_tests::command::{Folder, messages, skyfront};

/// A gzip file of two members.
const TWO_MEMBERS: &str = "gzip_two_members.fits.gz";

/// One line of the manifest.
struct Case {
    name: String,
    expect: String,
    shape: String,
    hdu: String,
}

/// The folder with the shared files.
fn shared() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared")
}

fn manifest(zoo: &Path) -> Vec<Case> {
    let text = fs::read_to_string(zoo.join("MANIFEST.tsv")).expect("../shared/fits-zoo with its manifest");
    let case = |line: &str| {
        let fields: Vec<&str> = line.split('\t').collect();
        let field = |n: usize| fields[n].to_owned();
        // The manifest calls it legal, and an error because cfitsio reads its first member only; here it is read whole.
        let expect = if fields[0] == TWO_MEMBERS { "ok".to_owned() } else { field(2) };
        Case { name: field(0), expect, shape: field(3), hdu: field(4) }
    };
    let cases: Vec<Case> = text.lines().skip(1).filter(|line| !line.is_empty()).map(case).collect();
    assert!(cases.len() > 100, "the manifest has only {} lines", cases.len());
    cases
}

/// What is wrong with an outcome, if anything is.
fn complaint(case: &Case, outcome: &Result<Image, ReadError>) -> Option<String> {
    match outcome {
        Ok(image) if case.expect == "error" => Some(format!("read as {}x{}", image.width, image.height)),
        Ok(image) => {
            let axes: Vec<usize> = case.shape.split('x').map(|n| n.parse().unwrap()).collect();
            let shape = (axes[0], axes.get(1).copied().unwrap_or(1));
            let right = (image.width, image.height) == shape
                && image.pixels.len() == shape.0 * shape.1
                && image.hdu.to_string() == case.hdu;
            (!right).then(|| format!("is {}x{} in HDU {}", image.width, image.height, image.hdu))
        }
        Err(error) => {
            let line = error.to_string();
            let clear = !line.contains('\n') && line.contains(&case.name);
            (case.expect == "ok" || !clear).then_some(line)
        }
    }
}

#[test]
#[ignore = "needs ../shared/fits-zoo"]
fn every_file_behaves_as_the_manifest_says() {
    let shared = shared();
    let zoo = shared.join("fits-zoo");
    let mut complaints = Vec::new();
    for case in manifest(&zoo).iter().filter(|case| case.name != "directory.fits") {
        let outcome = read::image(&zoo.join(&case.name), None);
        complaints.extend(complaint(case, &outcome).map(|what| format!("{} ({}): {what}", case.name, case.expect)));
    }
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
#[ignore = "needs ../shared/fits-zoo"]
fn every_readable_file_is_segmented_and_the_others_are_one_line_each() {
    let shared = shared();
    let cases = manifest(&shared.join("fits-zoo"));
    let folder = Folder::new("zoo");
    let (out, files) = (folder.file("out"), cases.iter().map(|case| shared.join("fits-zoo").join(&case.name)));
    let line = ["segment", "--quiet", "--json", "--no-pictures", "--out", &out].map(PathBuf::from);
    let output = skyfront(line.into_iter().chain(files));
    assert_eq!(output.status.code(), Some(1), "some must fail");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let results: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(results.len(), cases.len());
    let mut complaints = Vec::new();
    for (case, result) in cases.iter().zip(&results) {
        let failed = result.get("error").is_some();
        let right = match case.expect.as_str() {
            "ok" => !failed,
            "error" => failed,
            _ => true,
        };
        complaints.extend((!right).then(|| format!("{} ({}): {result}", case.name, case.expect)));
    }
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
    let failures = results.iter().filter(|result| result.get("error").is_some()).count();
    assert_eq!(messages(&output).lines().count(), failures, "{}", messages(&output));
}

/// The first pixel in which two planes differ; any NaN equals any other.
fn first_difference(ours: &[f32], theirs: &[f32]) -> Option<String> {
    assert_eq!(ours.len(), theirs.len());
    let same = |(a, b): (&f32, &f32)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
    let at = ours.iter().zip(theirs).position(|pair| !same(pair))?;
    Some(format!("pixel {at}: {} instead of {}", ours[at], theirs[at]))
}

#[test]
#[ignore = "needs ../shared/fits-zoo"]
fn every_readable_file_has_the_pixels_that_cfitsio_reads() {
    /// Written for readers that cfitsio, as built here, is not.
    const NOT_FOR_CFITSIO: [&str; 4] =
        ["whole_bzip2.fits.bz2", "real_nomtam_test.fits.bz2", "naxis_swapped_order.fits", TWO_MEMBERS];
    /// cfitsio gives undefined pixels some number unless asked for a mask.
    const WITH_BLANKS: [&str; 4] =
        ["blank_int16.fits", "comp_rice_f32_nan.fits", "real_astropy_comp_nan.fits", "real_astropy_blank.fits"];
    let shared = shared();
    let zoo = shared.join("fits-zoo");
    let mut complaints = Vec::new();
    let cases = manifest(&zoo);
    let readable = cases.iter().filter(|case| case.expect != "error");
    for case in readable.filter(|case| !NOT_FOR_CFITSIO.contains(&case.name.as_str())) {
        let path = zoo.join(&case.name);
        let image = read::image(&path, None).unwrap();
        let mut file = fitsio::FitsFile::open(&path).unwrap();
        let hdu = file.hdu(image.hdu).unwrap();
        let mut pixels: Vec<f32> = hdu.read_image(&mut file).unwrap();
        if WITH_BLANKS.contains(&case.name.as_str()) {
            let blanks = image.pixels.iter().zip(&mut pixels).filter(|(ours, _)| ours.is_nan());
            blanks.for_each(|(_, theirs)| *theirs = f32::NAN);
        }
        complaints.extend(first_difference(&image.pixels, &pixels).map(|what| format!("{}: {what}", case.name)));
    }
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
#[ignore = "needs ../shared/fits-zoo"]
fn the_same_scene_is_the_same_in_every_wrapping() {
    /// The first file of each line is the plain one.
    const SCENES: [&[&str]; 5] = [
        &[
            "fits-zoo/ext1_image.fits",
            "fits-zoo/comp_gzip_f32_lossless.fits",
            "fits-zoo/ext_1d_then_2d.fits",
            "fits-zoo/naxis3_plane1.fits",
            "fits-zoo/naxis4_radio.fits",
            "fits-zoo/no_padding.fits",
            "fits-zoo/trailing_junk.fits",
            "fits-zoo/plus+1.fits",
            "fits-zoo/näme_星.fits",
            "fits-zoo/whole_gzip.fits.gz",
            "fits-zoo/whole_gzip_no_suffix.fits",
            "fits-zoo/gzip_two_members.fits.gz",
            "fits-zoo/whole_bzip2.fits.bz2",
        ],
        &[
            "fits-zoo/bitpix16.fits",
            "fits-zoo/comp_rice_1_i16.fits",
            "fits-zoo/comp_gzip_1_i16.fits",
            "fits-zoo/comp_hcompress_1_i16.fits",
            "fits-zoo/comp_rice_tiles_17x13.fits",
        ],
        &["fits-zoo/uint16_bzero.fits", "fits-zoo/comp_rice_uint16.fits"],
        &["fits-zoo/bitpix64.fits", "fits-zoo/uint64_bzero.fits"],
        &[
            "real/m13_300.fits",
            "fits-zoo/real_m13_rice.fits",
            "fits-zoo/real_m13_gzip.fits",
            "fits-zoo/real_m13_hcomp.fits",
            "fits-zoo/real_m13_plio.fits",
        ],
    ];
    let shared = shared();
    let mut complaints = Vec::new();
    for scene in SCENES {
        let plain = read::image(&shared.join(scene[0]), None).unwrap();
        for name in &scene[1..] {
            let image = read::image(&shared.join(name), None).unwrap();
            complaints.extend(first_difference(&image.pixels, &plain.pixels).map(|what| format!("{name}: {what}")));
        }
    }
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
#[ignore = "needs ../shared/fits-zoo"]
fn undefined_pixels_are_where_the_manifest_says() {
    let shared = shared();
    let undefined = |name: &str| {
        let image = read::image(&shared.join("fits-zoo").join(name), None).unwrap();
        let at = (0..image.pixels.len()).filter(|&n| image.pixels[n].is_nan());
        at.map(|n| (n % image.width, n / image.width)).collect::<Vec<_>>()
    };
    let blank: Vec<_> = (30..34).flat_map(|y| (10..20).map(move |x| (x, y))).collect();
    assert_eq!(undefined("blank_int16.fits"), blank);
    let mut nan: Vec<_> = (0..8).flat_map(|y| (0..96).map(move |x| (x, y))).collect();
    nan.push((48, 40));
    assert_eq!(undefined("nan_some.fits"), nan);
    let columns: Vec<_> = (0..64).flat_map(|y| (0..3).map(move |x| (x, y))).collect();
    assert_eq!(undefined("comp_rice_f32_nan.fits"), columns);
    assert_eq!(undefined("inf_some.fits"), []);
}

#[test]
#[ignore = "needs ../shared/fits-zoo"]
fn an_hdu_can_be_chosen_by_number_and_by_name() {
    let shared = shared();
    let path = shared.join("fits-zoo/ext_err_first.fits");
    let read = |choice: &str| read::image(&path, Some(&choice.parse::<HduChoice>().unwrap())).unwrap();
    let (by_number, by_name) = (read("2"), read("sci"));
    assert_eq!(by_number.pixels, by_name.pixels);
    assert!(read::image(&path, None).unwrap().pixels.iter().all(|&v| v == 5.0));
}
