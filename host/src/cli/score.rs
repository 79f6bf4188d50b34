//! `skyfront score`: how well a label map agrees with the truth.

use super::memory::image_within;
use super::say::Stdout;
use crate::input::LabelMap;
use crate::read::{self, HduChoice, Image, ReadError};
use crate::score::score;
use anyhow::{Result, anyhow};
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

/// Prints the measures as one line of JSON.
pub fn run(arguments: &Arguments) -> Result<()> {
    let truth = image_within(BYTES, &arguments.truth, arguments.ext.as_ref())?;
    let map = of_same_size(&truth, &arguments.map)?;
    let image = of_same_size(&truth, &arguments.image)?;
    let result = score(&labels(&truth, &arguments.truth)?, &labels(&map, &arguments.map)?, &image.pixels);
    writeln!(Stdout, "{}", result.json())?;
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

/// The labels of a map; an image that is none would be scored without sense.
fn labels(map: &Image, path: &Path) -> Result<Vec<i64>> {
    let labels = LabelMap::of(&map.pixels).map_err(|odd| {
        let (x, y) = (odd % map.width + 1, odd / map.width + 1);
        anyhow!("{} is no label map: pixel ({x}, {y}) is {}", path.display(), map.pixels[odd])
    })?;
    Ok(labels.labels.iter().map(|&label| i64::from(label)).collect())
}
