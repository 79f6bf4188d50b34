//! Images that are hard on a source finder: lines, rings, combs, checkers, galaxies in galaxies, clouds. What a
//! pixel costs must not grow with the image.
//!
//! `cargo bench -p skyfront-benches --bench hostile [-- SIDE ...]`, by default 512 to 4096. Printed are the
//! processor's time per pixel and, where valgrind is installed, for the smaller sides the instructions, which
//! nothing else on the machine changes. More than [`GATE`] times as many for the greatest side as
//! for the least, or as much time, are a failure.

use nix::sys::resource::{UsageWho, getrusage};
use skyfront_tests::command::{Folder, program};
use skyfront_tests::fits_bytes::{Header, samples};
use std::collections::BTreeMap;
use std::process::{Command, ExitCode, Stdio};

/// What a pixel of the greatest side may cost, in units of one of the least.
const GATE: f64 = 1.3;
/// Sides of which the instructions are counted: that takes fifty times as long.
const COUNTED: usize = 1024;

/// A name, and the light at column and row of an image of a side.
type Kind = (&'static str, fn(usize, usize, usize) -> f64);

const KINDS: [Kind; 7] = [
    ("lines", |_, y, _| if y % 16 < 3 { 50.0 } else { 0.0 }),
    ("lines aslant", |x, y, _| if (y as f64 + 0.3 * x as f64) % 16.0 < 3.0 { 50.0 } else { 0.0 }),
    ("rings", |x, y, side| if from_middle(x, y, side) % 16.0 < 3.0 { 50.0 } else { 0.0 }),
    ("combs", |x, y, _| if y % 64 < 3 || (x % 8 < 2 && y % 64 < 40) { 50.0 } else { 0.0 }),
    ("checkers", |x, y, _| if (x / 8 + y / 8) % 2 == 0 { 40.0 } else { 0.0 }),
    ("nested galaxies", nested),
    ("clouds", clouds),
];

fn from_middle(x: usize, y: usize, side: usize) -> f64 {
    let middle = side as f64 / 2.0;
    (x as f64 - middle).hypot(y as f64 - middle)
}

/// Three galaxies in each other, and knots on them.
fn nested(x: usize, y: usize, _: usize) -> f64 {
    let far = from_middle(x % 256, y % 256, 256);
    let knot = from_middle(x % 32, y % 32, 32);
    let galaxies: f64 = [4.0, 16.0, 48.0].iter().map(|scale| 200.0 * (-far / scale).exp()).sum();
    galaxies + 60.0 * (-knot * knot / 8.0).exp()
}

/// Noise on every scale up to the image's, each twice as strong as the one of half its size.
fn clouds(x: usize, y: usize, side: usize) -> f64 {
    let scales = (1..).map(|octave| side >> octave).take_while(|&scale| scale >= 4);
    let of_scale = |scale: usize| {
        let corner = |dx: usize, dy: usize| noise(x / scale + dx, y / scale + dy, scale) - 6.0;
        let (u, v) = ((x % scale) as f64 / scale as f64, (y % scale) as f64 / scale as f64);
        let row = |dy: usize| corner(0, dy) * (1.0 - u) + corner(1, dy) * u;
        (row(0) * (1.0 - v) + row(1) * v) * 10.0 * scale as f64 / side as f64
    };
    scales.map(of_scale).sum()
}

/// The sum of twelve numbers from 0 to 1: variance 1, mean 6.
fn noise(x: usize, y: usize, seed: usize) -> f64 {
    let mut state = (x as u64) << 40 ^ (y as u64) << 16 ^ seed as u64;
    let mut uniform = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed >> 40) as f64 / (1u64 << 24) as f64
    };
    (0..12).map(|_| uniform()).sum()
}

/// The words of a run.
fn line(folder: &Folder, image: &str) -> Vec<String> {
    let words = ["segment", image, "--overwrite", "--quiet", "--no-pictures", "--threads", "1", "--out"];
    words.iter().map(|&word| word.to_owned()).chain([folder.file("out")]).collect()
}

/// Nanoseconds of the processor per pixel, the least of some runs.
fn time(line: &[String], side: usize) -> f64 {
    let used = || {
        let usage = getrusage(UsageWho::RUSAGE_CHILDREN).expect("the system counts");
        let seconds = |time: nix::sys::time::TimeVal| time.tv_sec() as f64 + 1e-6 * time.tv_usec() as f64;
        seconds(usage.user_time()) + seconds(usage.system_time())
    };
    let run = |_| {
        let before = used();
        assert!(Command::new(program()).args(line).status().expect("it can be started").success());
        used() - before
    };
    let runs = if side < 2048 { 5 } else { 2 };
    (0..runs).map(run).fold(f64::INFINITY, f64::min) * 1e9 / (side * side) as f64
}

/// Instructions per pixel; none without valgrind.
fn instructions(line: &[String], side: usize) -> Option<f64> {
    let mut valgrind = Command::new("valgrind");
    valgrind.args(["--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"]);
    let output = valgrind.arg(program()).args(line).stdout(Stdio::null()).output().ok()?;
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let count = text.lines().find_map(|line| line.split_once("refs:")).map(|(_, count)| count.trim().replace(',', ""));
    count.and_then(|count| count.parse::<f64>().ok()).map(|count| count / (side * side) as f64)
}

/// Builds the program as it is now, which cargo does for tests alone.
fn build() {
    let line = ["build", "--release", "--quiet", "--package", "skyfront-tests", "--bin", "program-under-test"];
    let status = Command::new(env!("CARGO")).args(line).status().expect("cargo can be started");
    assert!(status.success(), "the program can be built");
}

fn main() -> ExitCode {
    build();
    let sides: Vec<usize> = std::env::args().filter_map(|word| word.parse().ok()).collect();
    let sides = if sides.is_empty() { vec![512, 1024, 2048, 4096] } else { sides };
    let folder = Folder::new("hostile");
    let mut costs: BTreeMap<(&str, &str), Vec<f64>> = BTreeMap::new();
    for &side in &sides {
        for (name, light) in KINDS {
            let pixel = |at: usize| light(at % side, at / side, side) + noise(at % side, at / side, 1);
            let pixels: Vec<f64> = (0..side * side).map(pixel).collect();
            let image = folder.file("image.fits");
            let bytes = Header::primary(-32, &[side as u64; 2]).with(samples(-32, &pixels));
            std::fs::write(&image, bytes).expect("an image can be written");
            let line = line(&folder, &image);
            let (time, count) = (time(&line, side), (side <= COUNTED).then(|| instructions(&line, side)).flatten());
            println!("{name:16} {side:5} {time:8.0} ns {:8.0} instructions per pixel", count.unwrap_or(f64::NAN));
            costs.entry((name, "time")).or_default().push(time);
            costs.entry((name, "instructions")).or_default().extend(count);
        }
    }
    let mut failed = false;
    for ((name, what), each) in costs {
        let (Some(first), Some(last)) = (each.first(), each.last()) else { continue };
        failed |= last > &(GATE * first);
        println!("{name:16} {what:12} times {:.2}", last / first);
    }
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
