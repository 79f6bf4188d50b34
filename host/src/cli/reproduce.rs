//! `skyfront reproduce`: the paper's figures again, with its times and conclusions beside ours.

use super::memory::image_within;
use super::say::{Stderr, Stdout};
use super::simulated;
use crate::peer::source_extractor;
use crate::picture::{Canvas, contact_sheet, curves, side_by_side};
use crate::pipeline::{Drive, Segmentation, segment};
use crate::provenance::shortest;
use crate::read::Image;
use crate::reference as r;
use crate::reproduce::claims::{DEFAULT, SEXTRACTOR};
use crate::reproduce::page::{Part, Tried, page, same_time, word_of_time};
use crate::reproduce::{Caption, captions};
use crate::score::score;
use crate::truth;
use crate::write::Products;
use anyhow::{Context, Result};
use clap::Args;
use skyfront_core::config::Config;
use skyfront_core::run::outcome::StopReason;
use skyfront_core::simulate::Kind;
use std::path::PathBuf;

/// The page, the contact sheet, and the curves of the rescalings.
const PAGE: &str = "reproduce.md";
const SHEET: &str = "reproduce.png";
const CURVES: &str = "reproduce-curves.png";
/// The size of the paper's images, and the seeds of the two that stand in for them.
const SIDE: usize = 300;
const SEEDS: [(Kind, u32); 2] = [(Kind::Bright, 160), (Kind::Noisy, 160)];

/// Bytes per pixel that the runs of all captions over an image take at most: the sheet shows them side by side.
const BYTES: u64 = 900;

#[derive(Debug, Args)]
pub struct Arguments {
    /// Images for all captions [default: a simulated sky for each of the paper's two tests].
    images: Vec<PathBuf>,
    /// Folder for the page and its pictures; made where it is absent.
    #[arg(long, short, default_value = "skyfront-out")]
    out: PathBuf,
    /// Replace files that exist.
    #[arg(long)]
    overwrite: bool,
}

/// An image that the captions are run on.
struct Subject {
    name: String,
    /// The test that it is for; none for both.
    test: Option<u8>,
    image: Image,
    /// Which object owns which pixel, of a simulated sky.
    truth: Option<Vec<u32>>,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let subjects = if arguments.images.is_empty() { SEEDS.len() } else { arguments.images.len() };
    let pictures: Vec<String> = (1..=subjects).map(|number| format!("reproduce-{number}.png")).collect();
    let files: Vec<&str> = [PAGE, SHEET, CURVES].into_iter().chain(pictures.iter().map(String::as_str)).collect();
    let mut products = Products::plan(&arguments.out, &files, arguments.overwrite)?;
    let subjects = subjects_of(arguments)?;
    writeln!(Stdout, "image\ttest\tcaption\tpaper t\tt\ttime\tsteps\tstop\tmask pixels\tsources")?;
    let (mut runs, mut parts) = (Vec::new(), Vec::new());
    for (subject, picture) in subjects.iter().zip(pictures) {
        let Subject { name, image, .. } = subject;
        let (mut tried, mut best): (_, Option<(usize, &str, Vec<u32>)>) = (Vec::new(), None);
        for caption in captions().into_iter().filter(|caption| subject.test.is_none_or(|test| caption.test == test)) {
            let run = segment(&caption.config, &image.pixels, image.width, image.height, &mut Drive::default())
                .with_context(|| name.clone())?;
            writeln!(Stdout, "{name}\t{}", line(&caption, &run))?;
            let times = Some((caption.t, time(&caption, &run)));
            let own = subject.tried(Some(caption.test), caption.text, times, &run.labels);
            if best.as_ref().is_none_or(|(most, ..)| own.counted() > *most) {
                best = Some((own.counted(), caption.text, run.labels.clone()));
            }
            tried.push(own);
            let title = format!("Test {}: {} t = {:.3}", caption.test, caption.text, time(&caption, &run));
            runs.push((title, image.pixels.as_slice(), run));
        }
        let default = segment(&Config::NOISE_AWARE, &image.pixels, image.width, image.height, &mut Drive::default())?;
        let peer = source_extractor(image).unwrap_or_else(|error| {
            writeln!(Stderr, "{name}: left out: {error}");
            None
        });
        let others = [(DEFAULT, Some(default.labels)), (SEXTRACTOR, peer)];
        let others: Vec<(&str, Vec<u32>)> = others.into_iter().filter_map(|(text, map)| Some((text, map?))).collect();
        tried.extend(others.iter().map(|(text, labels)| subject.tried(None, text, None, labels)));
        let of_paper = best.iter().map(|(_, text, labels)| (*text, Some(labels.as_slice())));
        let panels: Vec<(&str, Option<&[u32]>)> =
            of_paper.chain(others.iter().map(|(text, labels)| (*text, Some(labels.as_slice())))).collect();
        let beside = side_by_side(&image.pixels, (image.width, image.height), &panels);
        products.write(&picture, |out| beside.write_png(out))?;
        let objects = subject.truth.as_ref().map(|truth| {
            truth.iter().copied().filter(|&label| label > 0).collect::<std::collections::BTreeSet<_>>().len()
        });
        parts.push(Part { name: name.clone(), objects, runs: tried, picture });
    }
    let sheet = contact_sheet(&runs);
    products.write(SHEET, |out| sheet.write_png(out))?;
    let drawn = rescalings();
    products.write(CURVES, |out| drawn.write_png(out))?;
    let text = page(&parts, CURVES, SHEET);
    products.write(PAGE, |out| out.write_all(text.as_bytes()))?;
    products.publish()?;
    writeln!(
        Stderr,
        "{} fronts and what the paper concludes of them in {}",
        runs.len(),
        arguments.out.join(PAGE).display()
    );
    Ok(())
}

/// The rescalings of the paper, and its first front along the middle row.
fn rescalings() -> Canvas {
    let power = |alpha: f64| move |x: f64| r::r1(x, alpha);
    let (r1_strong, r1_weak) = (power(0.25), power(0.5));
    let r2 = |x: f64| r::r2(x, 0.25);
    let (r3, r3_weak) = (|x: f64| r::r3(x, 8.0, 0.3), |x: f64| r::r3(x, 4.0, 0.3));
    let half = SIDE as f64 / 2.0;
    let u0 = |x: f64| 1.0 - (x * SIDE as f64 - half).abs() / (half - 2.0);
    curves(&[
        ("r1, r2", 0.0, &[("r1, alpha 0.25", &r1_strong), ("r1, alpha 0.5", &r1_weak), ("r2, alpha 0.25", &r2)]),
        ("r3, tau 0.3", 0.0, &[("beta 8", &r3), ("beta 4", &r3_weak)]),
        ("u0 along a row", -0.1, &[("0 two pixels inside the frame", &u0)]),
    ])
}

impl Subject {
    /// What a run came to.
    fn tried(&self, test: Option<u8>, text: &'static str, times: Option<(Option<f64>, f64)>, labels: &[u32]) -> Tried {
        let of = |labels: &[u32]| labels.iter().map(|&label| i64::from(label)).collect::<Vec<i64>>();
        let found = self.truth.as_ref().map(|truth| score(&of(truth), &of(labels), &self.image.pixels).matched);
        let sources = labels.iter().copied().max().unwrap_or(0) as usize;
        let pixels = labels.iter().filter(|&&label| label > 0).count();
        Tried { test, text, times, pixels, sources, found }
    }
}

fn subjects_of(arguments: &Arguments) -> Result<Vec<Subject>> {
    if arguments.images.is_empty() {
        let skies = (1..).zip(SEEDS).map(|(test, (kind, seed))| {
            let (image, sky) = simulated(kind, seed, SIDE, SIDE);
            let truth = Some(truth::labels(&sky, SIDE, SIDE));
            Subject { name: format!("simulated {kind:?}").to_lowercase(), test: Some(test), image, truth }
        });
        return Ok(skies.collect());
    }
    let bytes = BYTES * arguments.images.len() as u64;
    let read = |path: &PathBuf| {
        let image = image_within(bytes, path, None)?;
        Ok(Subject { name: path.display().to_string(), test: None, image, truth: None })
    };
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
        "{}\t{}\t{paper}\t{:.3}\t{}\t{}\t{stop}\t{}\t{}",
        caption.test,
        caption.text,
        time(caption, run),
        word_of_time(same_time((caption.t, time(caption, run)))),
        outcome.steps,
        outcome.mask_pixels,
        outcome.sources
    )
}
