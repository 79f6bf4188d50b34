//! `skyfront score`: how well a label map agrees with the truth.

use super::memory::image_within;
use super::say::Stdout;
use crate::read::{self, HduChoice, Image, ReadError};
use crate::score::score;
use anyhow::Result;
use clap::Args;
use std::path::{Path, PathBuf};

/// Bytes per pixel that a score takes at most, where every pixel is an object of its own.
const BYTES: u64 = 240;

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
    let truth = image_within(BYTES, &arguments.truth, arguments.ext.as_ref())?;
    let map = of_same_size(&truth, &arguments.map)?;
    let image = of_same_size(&truth, &arguments.image)?;
    let result = score(&labels(&truth), &labels(&map), &image.pixels);
    writeln!(Stdout, "{:#}", result.json())?;
    Ok(())
}

/// Reads an image, if it has the size of the truth.
fn of_same_size(truth: &Image, path: &Path) -> Result<Image, ReadError> {
    let (truth_width, truth_height) = (truth.width as u64, truth.height as u64);
    read::image_if(path, None, &mut |width, height| match (width, height) == (truth_width, truth_height) {
        true => Ok(()),
        false => Err(format!("has {width} x {height} pixels, the truth {truth_width} x {truth_height}")),
    })
}

/// Labels are whole numbers, exact in `f32` up to 2^24.
fn labels(map: &Image) -> Vec<i64> {
    map.pixels.iter().map(|&label| label as i64).collect()
}
