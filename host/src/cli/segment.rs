//! `skyfront segment`: an image in, a segmentation map, a catalogue and pictures out.

use super::Options;
use crate::pipeline::{Drive, Segmentation, segment};
use crate::provenance::shortest;
use crate::read::{self, HduChoice, Image};
use crate::write::Products;
use crate::{machine::Native, outputs};
use anyhow::{Context, Result};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use skyfront_core::arithmetic::F32;
use skyfront_core::config::Config;
use skyfront_core::outcome::{Progress, StopReason};
use skyfront_core::stage::Stage;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub struct Arguments {
    /// The image: FITS (also .gz, .fz), PGM or PNG.
    image: PathBuf,
    /// Folder for the results; made where it is absent.
    #[arg(long, short)]
    out: PathBuf,
    /// HDU of the image: a number (0 = primary) or a name [default: the first 2-D image].
    #[arg(long, value_name = "N|NAME")]
    hdu: Option<HduChoice>,
    #[command(flatten)]
    options: Options,
    /// Leave out stages.png and overlay.png.
    #[arg(long)]
    no_pictures: bool,
    /// Replace results that exist.
    #[arg(long)]
    overwrite: bool,
    /// Say nothing but errors.
    #[arg(long, short)]
    quiet: bool,
}

/// How results are written and reported.
pub struct Manner {
    pub pictures: bool,
    pub overwrite: bool,
    pub quiet: bool,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let config = arguments.options.config();
    config.validate::<F32<Native>>()?;
    let image = read::image(&arguments.image, arguments.hdu.as_ref())?;
    let name = arguments.image.display().to_string();
    let manner = Manner { pictures: !arguments.no_pictures, overwrite: arguments.overwrite, quiet: arguments.quiet };
    let products = plan(&arguments.out, &manner, &[])?;
    segment_image(&config, &name, &image, products, &manner)
}

/// The products of a run, and `more`, planned in a folder.
pub fn plan(folder: &Path, manner: &Manner, more: &[&str]) -> Result<Products> {
    let pictures: &[&str] = if manner.pictures { &outputs::PICTURES } else { &[] };
    let names: Vec<&str> = outputs::DATA.iter().chain(pictures).chain(more).copied().collect();
    Ok(Products::plan(folder, &names, manner.overwrite)?)
}

/// Segments an image, writes and publishes the products, and says what was done.
pub fn segment_image(
    config: &Config,
    name: &str,
    image: &Image,
    mut products: Products,
    manner: &Manner,
) -> Result<()> {
    if !manner.quiet {
        for warning in &image.warnings {
            eprintln!("warning: {name}: {warning}");
        }
    }
    let bar = progress_bar(config, manner.quiet);
    let mut watch = |progress: &Progress| show(&bar, progress);
    let mut drive = Drive { keep_stages: manner.pictures, watch: Some(&mut watch), ..Drive::default() };
    let run = segment(config, &image.pixels, image.width, image.height, &mut drive).with_context(|| name.to_owned())?;
    bar.finish_and_clear();
    outputs::write(&mut products, config, name, image, &run)?;
    let written = products.publish()?;
    if !manner.quiet {
        report(config, name, &run);
        if let Some(folder) = written.first().and_then(|path| path.parent()) {
            eprintln!("{} files in {}", written.len(), folder.display());
        }
    }
    Ok(())
}

/// A bar on a terminal, nothing elsewhere.
fn progress_bar(config: &Config, quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(u64::from(config.max_steps()));
    bar.set_style(
        ProgressStyle::with_template("{msg:12} {bar:40} {pos}/{len} steps").unwrap_or(ProgressStyle::default_bar()),
    );
    bar
}

fn show(bar: &ProgressBar, progress: &Progress) {
    if let Progress::Working { stage, pass, .. } = progress {
        bar.set_message(format!("{stage:?}").to_lowercase());
        if *stage == Stage::Evolve {
            bar.set_position(u64::from(*pass));
        }
    }
}

fn report(config: &Config, name: &str, run: &Segmentation) {
    let outcome = &run.outcome;
    let t = f64::from(outcome.steps) * shortest(config.dt);
    let reason = match outcome.reason {
        StopReason::Rest => "came to rest",
        StopReason::TimeLimit => "was given up",
    };
    eprintln!(
        "{name}: {} x {} pixels, {} sources; the front {reason} at t = {t:.4} after {} steps",
        run.width, run.height, outcome.sources, outcome.steps
    );
    if outcome.catalogued < outcome.sources {
        eprintln!("warning: the catalogue has room for {} sources only", outcome.catalogued);
    }
    if outcome.unlabelled > 0 {
        eprintln!("warning: {} pixels of sources found no free label", outcome.unlabelled);
    }
}
