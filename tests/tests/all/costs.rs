//! What a run of the default takes: memory no more than is told beforehand, and instructions no more than last time.

use skyfront::extraction;
use skyfront_core::config::Config;
use skyfront_core::simulate::Kind;
use skyfront_tests::command::{Folder, program, workspace};
use skyfront_tests::fits_bytes::{Header, samples};
use skyfront_tests::runs::sky;
use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// A simulated sky of a side as a file.
fn image(folder: &Folder, side: usize) -> String {
    let pixels: Vec<f64> = sky(Kind::Bright, 17, side, side).into_iter().map(f64::from).collect();
    let file = folder.file(&format!("{side}.fits"));
    let bytes = Header::primary(-32, &[side as u64; 2]).with(samples(-32, &pixels));
    fs::write(&file, bytes).expect("an image can be written");
    file
}

/// A run of the default over an image, without pictures.
fn run(command: &mut Command, image: &str, folder: &Folder, options: &[&str]) -> Child {
    let line = ["segment", image, "--quiet", "--overwrite", "--no-pictures", "--map-only", "--out"];
    command.args(line).arg(folder.file("out")).args(options);
    command.stderr(Stdio::piped()).spawn().expect("it can be started")
}

/// The most memory that a run has held at a time, in bytes.
#[cfg(target_os = "linux")]
fn peak(image: &str, folder: &Folder, threads: usize) -> usize {
    let mut child = run(&mut Command::new(program()), image, folder, &["--threads", &threads.to_string()]);
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    while child.try_wait().expect("it can be asked").is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let held = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = held.and_then(|words| words.split_whitespace().next()).and_then(|word| word.parse().ok());
        peak = peak.max(1024 * kib.unwrap_or(0));
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(child.wait().expect("it ends").success());
    peak
}

/// On a sky of ordinary sources a pixel takes its image and 24 bytes, and never more than is told.
#[cfg(target_os = "linux")]
#[test]
fn a_pixel_takes_its_image_and_24_bytes() {
    const SIDES: [usize; 2] = [64, 1280];
    let folder = Folder::new("peak");
    let images = SIDES.map(|side| image(&folder, side));
    let told = |side| extraction::memory(&Config::NOISE_AWARE, side, side).iter().map(|part| part.0).sum::<usize>();
    for threads in [1, 3] {
        let [small, large] = images.each_ref().map(|image| peak(image, &folder, threads));
        let (grown, pixels) = (large - small, SIDES[1] * SIDES[1] - SIDES[0] * SIDES[0]);
        println!("{threads} threads: {small} and {large} bytes, {} a pixel", grown as f64 / pixels as f64);
        assert!(grown <= 28 * pixels, "{threads} threads: {grown} bytes for {pixels} pixels");
        assert!(grown <= told(SIDES[1]) - told(SIDES[0]), "{threads} threads: {grown} bytes, {} told", told(SIDES[1]));
        // Or what is told is not what is taken.
        assert!(grown >= 16 * pixels, "{threads} threads: {grown} bytes for {pixels} pixels");
    }
}

/// More than this share above the figure is a failure, and so is less: then the figure is to be lowered.
const TOLERANCE: f64 = 0.05;
/// Another compiler's code, or that for a processor without AVX2, may differ by this share.
const OF_COMPILERS: f64 = 0.3;
/// Columns and rows of the sky on which instructions are counted.
const SIDE: usize = 512;

/// Whether the row loops run on the vector units for which the figures are.
fn vectors() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// Instructions of the core's steps of the default, whatever else the machine does, in f32 and q24.
#[test]
fn the_steps_of_the_default_take_no_more_instructions_than_before() {
    let folder = Folder::new("instructions");
    let image = image(&folder, SIDE);
    let table = fs::read_to_string(workspace().join("tests/instructions.txt")).expect("the table is there");
    let figure = |name: &str| table.lines().find_map(|line| line.strip_prefix(name)).expect("a line for it").trim();
    let compiler = Command::new("rustc").arg("--version").output().expect("rustc is there");
    let same = vectors() && String::from_utf8_lossy(&compiler.stdout).trim() == figure("compiler");
    for arithmetic in ["f32", "q24"] {
        let mut valgrind = Command::new("valgrind");
        valgrind.args([
            "--tool=callgrind",
            "--callgrind-out-file=/dev/null",
            "--toggle-collect=*Extractor*poll_by*",
            "--separate-threads=no",
        ]);
        valgrind.arg(program());
        let child = run(&mut valgrind, &image, &folder, &["--arithmetic", arithmetic, "--threads", "1"]);
        let output = child.wait_with_output().expect("valgrind ends (Debian: apt-get install valgrind)");
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{text}");
        let counted = text.lines().find_map(|line| line.split_once("Collected :")).map(|(_, count)| count.trim());
        let counted: f64 = counted.and_then(|count| count.parse().ok()).expect("valgrind tells how many");
        let expected: f64 = figure(arithmetic).parse().expect("a number");
        println!("{arithmetic} {counted}, {:+.1} %", 100.0 * (counted / expected - 1.0));
        let tolerance = if same { TOLERANCE } else { OF_COMPILERS };
        assert!((counted / expected - 1.0).abs() <= tolerance, "{arithmetic}: {counted} instructions, not {expected}");
    }
}
