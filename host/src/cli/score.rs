//! `skyfront score`: how well a label map agrees with the truth.

use super::say::Stdout;
use crate::read::{self, HduChoice, Image};
use crate::score::score;
use anyhow::{Result, ensure};
use clap::Args;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub struct Arguments {
    /// Label map of the truth, 0 = background.
    truth: PathBuf,
    /// Label map to score.
    map: PathBuf,
    /// The image in which objects are represented by their brightest pixel.
    #[arg(long)]
    image: PathBuf,
    /// HDU of the truth: a number (0 = primary) or a name.
    #[arg(long, value_name = "N|NAME")]
    ext: Option<HduChoice>,
}

/// Prints the measures as JSON.
pub fn run(arguments: &Arguments) -> Result<()> {
    let truth = read::image(&arguments.truth, arguments.ext.as_ref())?;
    let map = read::image(&arguments.map, None)?;
    let image = read::image(&arguments.image, None)?;
    same_size(&truth, &map, &arguments.map)?;
    same_size(&truth, &image, &arguments.image)?;
    let result = score(&labels(&truth), &labels(&map), &image.pixels);
    writeln!(Stdout, "{:#}", result.json())?;
    Ok(())
}

fn same_size(truth: &Image, other: &Image, path: &Path) -> Result<()> {
    let (width, height) = (truth.width, truth.height);
    ensure!(
        (other.width, other.height) == (width, height),
        "{} has {} x {} pixels, the truth {width} x {height}",
        path.display(),
        other.width,
        other.height
    );
    Ok(())
}

/// Labels are whole numbers, exact in `f32` up to 2^24.
fn labels(map: &Image) -> Vec<i64> {
    map.pixels.iter().map(|&label| label as i64).collect()
}
