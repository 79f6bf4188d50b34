//! `skyfront demo`: a simulated sky, segmented and compared with its truth; no file needed.

use super::choices::ArithmeticOption;
use super::job::{Manner, plan};
use super::messages::Volume;
use super::say::Stderr;
use super::segment::segment_image;
use crate::catalogue::Request;
use crate::input::Input;
use crate::picture::side_by_side;
use crate::pipeline::{Drive, Segmentation};
use crate::read::Image;
use crate::score::{Score, score};
use crate::truth::{self, simulated};
use crate::write::fits::Writer;
use crate::write::{Entry, Products, WriteError};
use anyhow::Result;
use clap::Args;
use serde_json::{Map, Value, json};
use skyfront_core::config::Config;
use skyfront_core::simulate::Kind;
use std::path::{Path, PathBuf};

/// The simulated sky of the demo.
const SEED: u32 = 160;
const SIDE: usize = 300;
/// The sky, which objects own which of its pixels, and the picture to look at first.
const SKY: &str = "sky.fits";
const TRUTH: &str = "truth.fits";
const PICTURE: &str = "demo.png";
/// What was found, and the checksums of the files: these may be renewed.
const RECORD: &str = "demo.json";

#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder for the results; made where it is absent. The files of an earlier demo are renewed,
    /// others are not touched.
    #[arg(long, short, default_value = "skyfront-demo")]
    out: PathBuf,
    /// Replace any files.
    #[arg(long)]
    overwrite: bool,
    /// Say nothing but errors.
    #[arg(long, short)]
    quiet: bool,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let files = [SKY, TRUTH, PICTURE];
    let manner = Manner {
        arithmetic: ArithmeticOption::F32,
        pictures: true,
        overwrite: arguments.overwrite || all_own(&arguments.out),
        own_time: false,
        threads: 1,
        request: Request::default(),
    };
    let volume = if arguments.quiet { Volume::Quiet } else { Volume::Normal };
    let say = |line: String| {
        if !arguments.quiet {
            writeln!(Stderr, "{line}");
        }
    };
    let mut products = plan(&arguments.out, &manner, &files)?;
    let (image, sky) = simulated(Kind::Bright, SEED, SIDE, SIDE);
    let truth = truth::labels(&sky, SIDE, SIDE);
    say(format!("A simulated sky of {SIDE} x {SIDE} pixels with {} stars and galaxies (seed {SEED}).", sky.objects()));

    let [default, paper] = [Config::NOISE_AWARE, Config::PAPER_F160].map(|config| Trial::of(&config, &image, &truth));
    let (default, paper) = (default?, paper?);
    write_plane(&mut products, SKY, &image.pixels, f64::from(sky.sigma()))?;
    let labels: Vec<f32> = truth.iter().map(|&label| label as f32).collect();
    write_plane(&mut products, TRUTH, &labels, f64::from(sky.sigma()))?;
    let captions = [default.caption("the default"), paper.caption("the paper's setting")];
    let [own, front] = [&default, &paper].map(|trial| Some(trial.run.labels.as_slice()));
    let panels = [("the simulated sky", None), (&*captions[0], own), (&*captions[1], front)];
    let picture = side_by_side(&image.pixels, (SIDE, SIDE), &panels);
    products.write(PICTURE, |out| picture.write_png(out))?;

    let done = segment_image(&Config::NOISE_AWARE, &Input::alone(SKY, image), products, &manner, volume)?;
    record(&arguments.out, &done.files, &default, &paper)?;
    for (name, trial) in [("The default", &default), ("The paper's setting (--preset paper-f160)", &paper)] {
        say(format!("{name} {}.", trial.finding()));
    }
    say(format!(
        "Look at {} first: the sky, the default's outlines and the paper's. catalog.csv lists the sources, \
         segmentation.fits is the map, report.html tells the rest.",
        arguments.out.join(PICTURE).display()
    ));
    Ok(())
}

/// A segmentation of the demo's sky beside the truth.
struct Trial {
    run: Segmentation,
    score: Score,
}

impl Trial {
    fn of(config: &Config, image: &Image, truth: &[u32]) -> Result<Trial> {
        let run = ArithmeticOption::F32.segment(config, image, &mut Drive::default())?;
        let [truth, map] = [truth, &run.labels].map(|labels| labels.iter().map(|&label| i64::from(label)).collect());
        let (truth, map): (Vec<i64>, Vec<i64>) = (truth, map);
        Ok(Trial { score: score(&truth, &map, &image.pixels), run })
    }

    /// Sources that are no object of the sky.
    fn wrong(&self) -> usize {
        self.score.segments - self.score.matched
    }

    fn caption(&self, name: &str) -> String {
        let Score { matched, objects, .. } = self.score;
        format!("{name}: {matched} of {objects} found, {} false", self.wrong())
    }

    fn finding(&self) -> String {
        let Score { matched, objects, segments, .. } = self.score;
        format!("finds {matched} of the {objects} objects, and {} of its {segments} sources false", self.wrong())
    }

    fn json(&self) -> Value {
        let Score { matched, objects, segments, .. } = self.score;
        json!({ "objects": objects, "found": matched, "sources": segments, "false": self.wrong() })
    }
}

fn write_plane(products: &mut Products, name: &str, pixels: &[f32], sigma: f64) -> Result<(), WriteError> {
    let header = [
        Entry::new("OBJECT", "simulated sky", ""),
        Entry::new("SFSEED", i64::from(SEED), "seed of the simulation"),
        Entry::new("SIGMA", sigma, "standard deviation of the noise"),
    ];
    products.write_path(name, |path| {
        let mut writer = Writer::create(path)?;
        writer.image((SIDE, SIDE), &header, |y, row: &mut [f32]| {
            row.copy_from_slice(&pixels[y * SIDE..(y + 1) * SIDE]);
        })?;
        writer.finish()
    })
}

/// Writes what was found, and by which files the next demo knows its own.
fn record(folder: &Path, files: &[PathBuf], default: &Trial, paper: &Trial) -> Result<()> {
    let name = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned());
    let sums: Map<String, Value> =
        files.iter().filter_map(|path| Some((name(path)?, json!(checksum(path)?)))).collect();
    let text = json!({ "program": "skyfront demo", "default": default.json(), "paper": paper.json(), "crc32": sums });
    let mut products = Products::plan(folder, &[RECORD], true)?;
    products.write(RECORD, |out| writeln!(out, "{text:#}"))?;
    products.publish()?;
    Ok(())
}

/// Whether every file in a folder that has a demo's record is as that demo left it, or none of its.
fn all_own(folder: &Path) -> bool {
    let record = std::fs::read(folder.join(RECORD)).ok();
    let Some(record) = record.and_then(|text| serde_json::from_slice::<Value>(&text).ok()) else { return false };
    let sums = record["crc32"].as_object().filter(|_| record["program"] == "skyfront demo");
    sums.is_some_and(|sums| {
        sums.iter().all(|(name, sum)| {
            let path = folder.join(name);
            !path.exists() || checksum(&path).is_some_and(|now| *sum == json!(now))
        })
    })
}

/// CRC-32 of a file.
fn checksum(path: &Path) -> Option<String> {
    let bytes = std::fs::read(path).ok()?;
    Some(format!("{:08x}", crc32fast::hash(&bytes)))
}
