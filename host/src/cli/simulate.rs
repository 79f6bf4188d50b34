//! `skyfront simulate`: a sky and its truth as two FITS files, for scoring.

use super::simulated;
use crate::truth;
use crate::write::Products;
use crate::write::fits::Writer;
use anyhow::Result;
use clap::{Args, ValueEnum};
use skyfront_core::simulate::Kind;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder for sky.fits and truth.fits; made where it is absent.
    #[arg(long, short)]
    out: PathBuf,
    /// What kind of sky.
    #[arg(long, value_enum, default_value = "bright")]
    kind: KindOption,
    /// The same seed and size give the same sky.
    #[arg(long, default_value = "1")]
    seed: u32,
    /// Columns and rows.
    #[arg(long, default_value = "300", value_parser = clap::value_parser!(u16).range(8..=8192))]
    side: u16,
    /// Replace files that exist.
    #[arg(long)]
    overwrite: bool,
}

/// `--kind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum KindOption {
    /// High signal to noise: a few bright stars and galaxies leave the rest dark.
    Bright,
    /// Stars and galaxies in strong noise.
    Noisy,
    /// Stars only, many of them.
    Stars,
}

const SKY: &str = "sky.fits";
const TRUTH: &str = "truth.fits";

pub fn run(arguments: &Arguments) -> Result<()> {
    let kind = match arguments.kind {
        KindOption::Bright => Kind::Bright,
        KindOption::Noisy => Kind::Noisy,
        KindOption::Stars => Kind::Stars,
    };
    let side = usize::from(arguments.side);
    let mut products = Products::plan(&arguments.out, &[SKY, TRUTH], arguments.overwrite)?;
    let (image, sky) = simulated(kind, arguments.seed, side, side);
    let labels: Vec<f32> = truth::labels(&sky, side, side).into_iter().map(|label| label as f32).collect();
    for (name, pixels) in [(SKY, &image.pixels), (TRUTH, &labels)] {
        products.write_path(name, |path| {
            let mut writer = Writer::create(path)?;
            writer.image((side, side), &[], |y, row: &mut [f32]| {
                row.copy_from_slice(&pixels[y * side..(y + 1) * side]);
            })?;
            writer.finish()
        })?;
    }
    products.publish()?;
    Ok(())
}
