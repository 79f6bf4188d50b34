//! `skyfront score`: how well a label map agrees with the truth.

use super::say::Stdout;
use crate::input::LabelMap;
use crate::read::{self, HduChoice, Image};
use crate::score::score;
use anyhow::{Result, anyhow, ensure};
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

/// Prints the measures as one line of JSON.
pub fn run(arguments: &Arguments) -> Result<()> {
    let truth = read::image(&arguments.truth, arguments.ext.as_ref())?;
    let map = read::image(&arguments.map, None)?;
    let image = read::image(&arguments.image, None)?;
    same_size(&truth, &map, &arguments.map)?;
    same_size(&truth, &image, &arguments.image)?;
    let result = score(&labels(&truth, &arguments.truth)?, &labels(&map, &arguments.map)?, &image.pixels);
    writeln!(Stdout, "{}", result.json())?;
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

/// The labels of a map; an image that is none would be scored without sense.
fn labels(map: &Image, path: &Path) -> Result<Vec<i64>> {
    let labels = LabelMap::of(&map.pixels).map_err(|odd| {
        let (x, y) = (odd % map.width + 1, odd / map.width + 1);
        anyhow!("{} is no label map: pixel ({x}, {y}) is {}", path.display(), map.pixels[odd])
    })?;
    Ok(labels.labels.iter().map(|&label| i64::from(label)).collect())
}
