//! `skyfront reproduce`: the paper's figures again, with its times beside ours.

use super::memory::image_within;
use super::say::{Stderr, Stdout};
use super::simulated;
use crate::picture::contact_sheet;
use crate::pipeline::{Drive, Segmentation, segment};
use crate::provenance::shortest;
use crate::read::Image;
use crate::reproduce::{Caption, captions};
use crate::write::Products;
use anyhow::{Context, Result};
use clap::Args;
use skyfront_core::run::outcome::StopReason;
use skyfront_core::simulate::Kind;
use std::path::PathBuf;

/// The contact sheet.
const SHEET: &str = "reproduce.png";
/// The size of the paper's images, and the seeds of the two that stand in for them.
const SIDE: usize = 300;
const SEEDS: [(Kind, u32); 2] = [(Kind::Bright, 160), (Kind::Noisy, 160)];

/// Bytes per pixel that the runs of all captions over an image take at most: the sheet shows them side by side.
const BYTES: u64 = 900;

#[derive(Debug, Args)]
pub struct Arguments {
    /// Images for all captions [default: a simulated sky for each of the paper's two tests].
    images: Vec<PathBuf>,
    /// Folder for the contact sheet; made where it is absent.
    #[arg(long, short, default_value = "skyfront-out")]
    out: PathBuf,
    /// Replace a contact sheet that exists.
    #[arg(long)]
    overwrite: bool,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let mut products = Products::plan(&arguments.out, &[SHEET], arguments.overwrite)?;
    let images = images(arguments)?;
    writeln!(Stdout, "image\ttest\tcaption\tpaper t\tt\tsteps\tstop\tmask pixels\tsources")?;
    let mut runs = Vec::new();
    for (name, test, image) in &images {
        for caption in captions().into_iter().filter(|caption| test.is_none_or(|test| caption.test == test)) {
            let run = segment(&caption.config, &image.pixels, image.width, image.height, &mut Drive::default())
                .with_context(|| name.clone())?;
            writeln!(Stdout, "{name}\t{}", line(&caption, &run))?;
            let title = format!("Test {}: {} t = {:.3}", caption.test, caption.text, time(&caption, &run));
            runs.push((title, image.pixels.as_slice(), run));
        }
    }
    let sheet = contact_sheet(&runs);
    products.write(SHEET, |out| sheet.write_png(out))?;
    products.publish()?;
    writeln!(Stderr, "{} fronts and segmented images in {}", runs.len(), arguments.out.join(SHEET).display());
    Ok(())
}

/// The images, each with its name and the test that it is for; `None` for both.
fn images(arguments: &Arguments) -> Result<Vec<(String, Option<u8>, Image)>> {
    if arguments.images.is_empty() {
        let skies = (1..).zip(SEEDS).map(|(test, (kind, seed))| {
            (format!("simulated {kind:?}").to_lowercase(), Some(test), simulated(kind, seed, SIDE, SIDE).0)
        });
        return Ok(skies.collect());
    }
    let bytes = BYTES * arguments.images.len() as u64;
    let read = |path: &PathBuf| Ok((path.display().to_string(), None, image_within(bytes, path, None)?));
    arguments.images.iter().map(read).collect()
}

fn time(caption: &Caption, run: &Segmentation) -> f64 {
    f64::from(run.outcome.steps) * shortest(caption.config.dt)
}

/// A line of the table, columns separated by tabs.
fn line(caption: &Caption, run: &Segmentation) -> String {
    let paper = caption.t.map_or("-".to_owned(), |t| t.to_string());
    let stop = match run.outcome.reason {
        StopReason::Rest => "rest",
        StopReason::TimeLimit => "t_max",
    };
    let outcome = &run.outcome;
    format!(
        "{}\t{}\t{paper}\t{:.3}\t{}\t{stop}\t{}\t{}",
        caption.test,
        caption.text,
        time(caption, run),
        outcome.steps,
        outcome.mask_pixels,
        outcome.sources
    )
}
