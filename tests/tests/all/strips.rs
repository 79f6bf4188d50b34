//! Images that memory does not hold, segmented in strips by the program: the files of one piece, whatever the wrapping, in
//! the memory that was told.

use crate::habits::watched_command;
use skyfront_core::simulate::Kind;
use skyfront_tests::command::{Folder, messages, program, skyfront};
use skyfront_tests::compressed;
use skyfront_tests::fits_bytes::{Header, gzip, samples};
use skyfront_tests::runs::sky;
use std::fs;
use std::process::Command;

const WIDTH: usize = 250;
const HEIGHT: usize = 8000;
const FILES: [&str; 3] = ["segmentation.fits", "catalog.csv", "catalog.fits"];

/// A noisy sky in 16 bits, scaled, with undefined pixels, plain and in wrappings.
fn written(folder: &Folder) -> Vec<String> {
    let values = sky(Kind::Noisy, 3, WIDTH, HEIGHT).into_iter().map(|value| (f64::from(value) * 20_000.0).round());
    let mut values: Vec<f64> = values.map(|value| value.clamp(-32_000.0, 32_000.0)).collect();
    (700..760).for_each(|y| values[y * WIDTH + 30..][..50].fill(-32_768.0));
    let header = Header::primary(16, &[WIDTH as u64, HEIGHT as u64]).card("BSCALE", 0.5).card("BZERO", 100);
    let header = header.card("BLANK", -32_768).card("GAIN", 2.0).card("CRPIX2", 7);
    let plain = header.with(samples(16, &values));
    let names = ["plain.fits", "gzipped.fits.gz"].map(|name| folder.file(name));
    fs::write(&names[0], &plain).expect("a file can be written");
    fs::write(&names[1], gzip(&plain)).expect("a file can be written");
    names.into()
}

/// The same files in two folders.
fn assert_same(folder: &Folder, one: &str, other: &str, files: &[&str]) {
    for name in files {
        let [one, other] = [one, other].map(|out| fs::read(folder.file(&format!("{out}/{name}"))).expect("a product"));
        assert!(one == other, "{name}: {} and {} bytes", one.len(), other.len());
    }
}

#[test]
fn strips_have_the_files_of_one_piece_in_the_memory_that_is_told() {
    let folder = Folder::new("strips");
    let images = written(&folder);
    let line = |image: &str, out: &str, more: &[&str]| {
        let mut command = Command::new(program());
        command.args(["segment", image, "--overwrite", "--threads", "2", "--out", &folder.file(out)]).args(more);
        watched_command(&mut command)
    };
    for (image, number) in images.iter().zip(["a", "b"]) {
        let (one, strips) = (format!("one-{number}"), format!("strips-{number}"));
        let (run, whole) = line(image, &one, &["--no-pictures", "--map-only"]);
        assert!(run.status.success(), "{}", messages(&run));
        let (run, held) = line(image, &strips, &["--strips", "--max-memory", "36M"]);
        let said = messages(&run);
        assert!(run.status.success(), "{said}");
        println!("{said}{held} kB in strips, {whole} kB in one piece");
        assert!(said.contains(" strips of ") && !said.contains("go on beyond"), "{said}");
        assert!(held < 36_000 && held + 10_000 < whole, "{held} kB in strips, {whole} kB in one piece");
        assert_same(&folder, &one, &strips, &FILES);
        assert_eq!(folder.names(&strips), ["catalog.csv", "catalog.fits", "segmentation.fits", "summary.json"]);
    }
    assert_same(&folder, "strips-a", "strips-b", &["catalog.csv"]);
}

#[test]
fn tiles_are_handed_over_row_by_row() {
    const SIZE: [usize; 2] = [700, 200];
    let folder = Folder::new("strips-tiles");
    // Cut off at the black level.
    let count = |value: f32| (f64::from(value) * 5000.0).round().max(0.0);
    let values: Vec<f64> = sky(Kind::Noisy, 4, SIZE[1], SIZE[0]).into_iter().map(count).collect();
    for kind in compressed::KINDS.iter().filter(|kind| kind.lossless) {
        let path = folder.file(&format!("{}.fits", kind.name));
        compressed::write_sized(path.as_ref(), kind, &values, SIZE)
            .unwrap_or_else(|why| panic!("{}: {why}", kind.name));
        for (out, more) in
            [("one", &["--no-pictures", "--map-only"][..]), ("strips", &["--strips", "--max-memory", "28500k"])]
        {
            let line = ["segment", &path, "--overwrite", "--out", &folder.file(out)].map(str::to_owned);
            let run = skyfront(line.into_iter().chain(more.iter().map(|&word| word.to_owned())));
            assert!(run.status.success(), "{}: {}", kind.name, messages(&run));
            assert!(out == "one" || messages(&run).contains(" strips of "), "{}", messages(&run));
        }
        assert_same(&folder, "one", "strips", &FILES);
    }
}

#[test]
fn what_needs_all_of_an_image_is_refused_by_both_names() {
    let folder = Folder::new("strips-refused");
    let image = written(&folder).remove(0);
    let out = folder.file("out");
    for (options, words) in [
        (&["--preset", "paper-f160"][..], "a front or a filter in steps"),
        (&["--filter", "median"], "a front or a filter in steps"),
        (&["--arithmetic", "q24"], "--arithmetic f32"),
        (&["--mask", &image], "no maps"),
        (&["--segmentation", &image], "no maps"),
        (&["--regions"], "--regions"),
        (&["--sky-maps"], "--sky-maps"),
        (&[&image], "one image"),
        (&["--job-list", "jobs.csv"], "--job-list"),
    ] {
        let line = ["segment", &image, "--strips", "--out", &out];
        let run = skyfront(line.iter().chain(options));
        let said = messages(&run);
        assert_eq!(run.status.code(), Some(2), "{options:?}: {said}");
        assert!(said.contains("--strips") && said.contains(words), "{options:?}: {said}");
    }
    let blank = folder.file("blank.fits");
    let bytes = Header::primary(-32, &[300, 300]).with(samples(-32, &[f64::NAN; 300 * 300]));
    fs::write(&blank, bytes).expect("a file can be written");
    let section = format!("{image}[1:50,1:60]");
    for (image, more, words) in [
        (&section, "1G", "a section"),
        (&image, "26M", "even in strips"),
        (&folder.file("absent.fits"), "1G", "absent.fits"),
        (&blank, "1G", "every pixel is undefined"),
    ] {
        let run = skyfront(["segment", image, "--strips", "--out", &out, "--max-memory", more]);
        let said = messages(&run);
        assert_eq!((run.status.code(), said.lines().count()), (Some(1), 1), "{said}");
        assert!(said.contains(words), "{said}");
        assert!(folder.names("out").is_empty(), "{:?}", folder.names("out"));
    }
    // Without the option, the refusal names it.
    let run = skyfront(["segment", &image, "--out", &out, "--max-memory", "36M"]);
    assert!(messages(&run).contains("or give --strips"), "{}", messages(&run));
}
