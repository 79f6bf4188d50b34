//! Every FITS product holds to the standard, its checksums too, whatever the image came as.

use skyfront_tests::command::{Folder, messages, skyfront};
use skyfront_tests::fits_bytes::{Header, bzip2, gzip, samples};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const SIDE: usize = 64;

/// A sky with a star, and a header with all that headers can have.
fn image() -> Vec<u8> {
    let pixel = |n: usize| {
        let (x, y) = ((n % SIDE) as f64, (n / SIDE) as f64);
        let noise = ((n as u32).wrapping_mul(2_654_435_761) >> 20) % 41;
        f64::from(noise) + 3000.0 * (-((x - 30.0).powi(2) + (y - 21.0).powi(2)) / 8.0).exp()
    };
    let pixels: Vec<f64> = (0..SIDE * SIDE).map(pixel).collect();
    let header = Header::primary(16, &[SIDE as u64; 2])
        .text("CTYPE1", "RA---TAN")
        .text("CTYPE2", "DEC--TAN")
        .card("CRVAL1", 83.6)
        .card("CRVAL2", -5.4)
        .card("CRPIX1", 32)
        .card("CRPIX2", 32)
        .card("CDELT1", -2.7e-4)
        .card("CDELT2", 2.7e-4)
        .line("BUNIT   = 'adu\0\0   '")
        .text("OBJECT", "it''s a star")
        .card("EXPTIME", 30);
    header.with(samples(16, &pixels))
}

/// The FITS files below a folder.
fn fits_files(folder: &Path) -> Vec<PathBuf> {
    let entries: Vec<PathBuf> = fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path()).collect();
    let below = entries.iter().filter(|path| path.is_dir()).flat_map(|path| fits_files(path));
    entries.iter().filter(|path| path.extension().is_some_and(|e| e == "fits")).cloned().chain(below).collect()
}

#[test]
fn every_product_passes_fitsverify() {
    let folder = Folder::new("products");
    let bytes = image();
    let long = format!("{}.fits", "a long name it's ".repeat(9));
    let images = [("plain.fits", bytes.clone()), (&long, bytes.clone())];
    let wrapped = [("zipped.fits.gz", gzip(&bytes)), ("packed.fits.bz2", bzip2(&bytes))];
    let images: Vec<String> = images
        .into_iter()
        .chain(wrapped)
        .map(|(name, bytes)| {
            fs::write(folder.file(name), bytes).expect("an image can be written");
            folder.file(name)
        })
        .collect();
    let run = |out: &str, options: &[&str]| {
        let out = folder.file(out);
        let line = ["segment", "--quiet", "--no-pictures", "--out", &out];
        let output = skyfront(line.iter().chain(options).copied().chain(images.iter().map(String::as_str)));
        assert!(output.status.success(), "{}", messages(&output));
    };
    run("default", &["--sky-maps", "--apertures", "2,4", "--zero-point", "25", "--background", "20"]);
    run("marched", &["--preset", "paper-f160", "--scheme", "fast-marching", "--arrival"]);
    assert!(skyfront(["demo", "--quiet", "--out", &folder.file("demo")]).status.success());
    assert!(skyfront(["simulate", "--out", &folder.file("simulated")]).status.success());
    let below = ["default", "marched", "demo", "simulated"].map(|name| fits_files(&folder.path().join(name)));
    let files = below.concat();
    assert_eq!(files.len(), 4 * 6 + 4 * 5 + 6 + 2);
    let verdict = Command::new("fitsverify").args(&files).output();
    let verdict = verdict.expect("fitsverify is missing (Debian: apt-get install fitsverify)");
    let text = String::from_utf8_lossy(&verdict.stdout);
    let sound = text.matches("Verification found 0 warning(s) and 0 error(s)").count();
    assert_eq!(sound, files.len(), "{text}");
    for file in &files {
        let bytes = fs::read(file).expect("a product");
        let count = |card: &[u8]| bytes.windows(card.len()).filter(|window| *window == card).count();
        let sums = [count(b"CHECKSUM= '"), count(b"DATASUM = '")];
        assert!(sums[0] > 0 && sums[0] == sums[1], "{}", file.display());
    }
}
