//! How far the fixed-point arithmetics are from f32: a table over images, rescalings and schemes.
//!
//! `cargo run --release -p skyfront-tests --example agreement -- IMAGE...` prints, in Markdown, for
//! each image, r1 and r3, and each scheme with the paper's parameters: the steps and the mask
//! pixels of f32 (paper's `u0`), and for q24 and q11 (band of 8 pixels) the steps, the mask pixels
//! that differ from f32 and the bytes of the run.

use skyfront::machine::Native;
use skyfront::pipeline::{Drive, Segmentation, segment_in};
use skyfront::read;
use skyfront_core::arithmetic::{Arithmetic, Cell, F32, Q11, Q24};
use skyfront_core::config::{Config, Edge, Rescale, Scheme};
use skyfront_core::error::Error;
use skyfront_core::memory;
use std::path::Path;

const SCHEMES: [(Scheme, &str); 4] = [
    (Scheme::Fd, "fd"),
    (Scheme::Sl, "sl"),
    (Scheme::FdCurvature, "fd-curvature"),
    (Scheme::SlCurvature, "sl-curvature"),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "| image | rescaling | scheme | f32 steps | f32 mask | q24 steps | q24 differ | q24 bytes | q11 steps | q11 differ | q11 bytes |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for path in std::env::args().skip(1) {
        let image = read::image(Path::new(&path), None)?;
        let size = (image.width, image.height);
        let name =
            Path::new(&path).file_stem().map_or_else(|| path.clone(), |name| name.to_string_lossy().into_owned());
        for (rescale, rescaling) in [(Rescale::R1 { alpha: 0.25 }, "r1"), (Config::PAPER_F160.rescale, "r3")] {
            for (scheme, label) in SCHEMES {
                let config = paper(rescale, scheme);
                let reference =
                    segment_in::<F32<Native>>(&config, &image.pixels, size.0, size.1, &mut Drive::default())?;
                let q24 = compare::<Q24>(&config, &image.pixels, size, &reference);
                let q11 = compare::<Q11>(&Config { band: Some(8.0), ..config }, &image.pixels, size, &reference);
                let steps = reference.outcome.steps;
                println!(
                    "| {name} | {rescaling} | {label} | {steps} | {} | {q24} | {q11} |",
                    reference.outcome.mask_pixels
                );
            }
        }
    }
    Ok(())
}

/// The paper's parameters for a rescaling and a scheme (captions of Test 1).
fn paper(rescale: Rescale, scheme: Scheme) -> Config {
    let curvature = matches!(scheme, Scheme::FdCurvature | Scheme::SlCurvature);
    let edge = if curvature { Edge::G1 { p: 5000.0 } } else { Edge::G2Mod { c2: 0.8 } };
    let nu = if matches!(rescale, Rescale::R1 { .. }) { 1e-6 } else { 1e-4 };
    Config { rescale, edge, nu, ..Config::PAPER_F160 }.with_scheme(scheme)
}

/// Steps, differing mask pixels and bytes as three cells of the table.
fn compare<A: Arithmetic>(config: &Config, pixels: &[f32], size: (usize, usize), reference: &Segmentation) -> String {
    match segment_in::<A>(config, pixels, size.0, size.1, &mut Drive::default()) {
        Ok(run) => {
            let differ = run.labels.iter().zip(&reference.labels).filter(|&(&a, &b)| (a > 0) != (b > 0)).count();
            let window = config.scheme == Scheme::SlCurvature;
            let bytes = memory::bytes(size.0, size.1, A::Cell::BYTES, window, 0);
            format!("{} | {differ} | {bytes}", run.outcome.steps)
        }
        Err(Error::Arithmetic { .. }) => "not served | |".into(),
        Err(error) => format!("{error} | |"),
    }
}
