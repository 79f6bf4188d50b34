//! How far the arithmetics are from the f64 reference: a table over images, rescalings and schemes.
//!
//! `cargo run --release -p skyfront-tests --example agreement -- IMAGE...` prints, in Markdown, for each image, r1 and
//! r3, and each scheme with the paper's parameters: the steps and the mask pixels of the reference, and for each
//! arithmetic the steps, the mask pixels that differ and the bytes of the run. q11 runs in its band of 8 pixels, the
//! reference never in one.

use skyfront::read;
use skyfront_core::arithmetic::{Arithmetic, Cell, F32, Q11, Q24};
use skyfront_core::config::Scheme;
use skyfront_core::run::memory;
use skyfront_tests::agreement::Agreement;
use skyfront_tests::captions::{RESCALINGS, paper};
use std::path::Path;

const SCHEMES: [(Scheme, &str); 4] = [
    (Scheme::Fd, "fd"),
    (Scheme::Sl, "sl"),
    (Scheme::FdCurvature, "fd-curvature"),
    (Scheme::SlCurvature, "sl-curvature"),
];

const ARITHMETICS: [(&str, usize); 3] = [
    (F32::<skyfront::machine::Native>::NAME, <F32 as Arithmetic>::Cell::BYTES),
    (Q24::NAME, <Q24 as Arithmetic>::Cell::BYTES),
    (Q11::NAME, <Q11 as Arithmetic>::Cell::BYTES),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let columns = ARITHMETICS.map(|(name, _)| format!("{name} steps | {name} differ | {name} bytes")).join(" | ");
    println!("| image | rescaling | scheme | reference steps | mask pixels | {columns} |");
    println!("|---|---|---{}|", "|--:".repeat(2 + 3 * ARITHMETICS.len()));
    for path in std::env::args().skip(1) {
        let image = read::image(Path::new(&path), None)?;
        let name = Path::new(&path).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        for (rescaling, rescale) in RESCALINGS {
            for (scheme, label) in SCHEMES {
                let Agreement { reference, core } = Agreement::of(&paper(rescale, scheme), &image.pixels, image.width);
                let cells = core.iter().zip(ARITHMETICS).map(|(comparison, (_, bytes))| match comparison {
                    None => "not served | | ".to_owned(),
                    Some(c) => {
                        let wide = scheme == Scheme::SlCurvature;
                        let bytes = memory::bytes(image.width, image.height, bytes, wide, 0);
                        format!("{} | {} | {bytes}", c.steps.0, c.mask_pixels)
                    }
                });
                let mask = reference.labels.iter().filter(|&&label| label > 0).count();
                let cells: Vec<String> = cells.collect();
                println!("| {name} | {rescaling} | {label} | {} | {mask} | {} |", reference.steps, cells.join(" | "));
            }
        }
    }
    Ok(())
}
