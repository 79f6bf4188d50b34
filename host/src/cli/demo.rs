//! `skyfront demo`: a simulated sky, segmented; no file needed.

use super::choices::ArithmeticOption;
use super::job::{Manner, plan};
use super::messages::Volume;
use super::segment::segment_image;
use crate::catalogue::Request;
use crate::input::Input;
use crate::read::{Header, Image};
use crate::write::Entry;
use crate::write::fits::Writer;
use anyhow::Result;
use clap::Args;
use skyfront_core::config::Config;
use skyfront_core::frame::Frame;
use skyfront_core::simulate::{Kind, Sky};
use std::path::PathBuf;

/// The simulated sky of the demo.
const SEED: u32 = 160;
const SIDE: usize = 300;
const NAME: &str = "sky.fits";

#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder for the results; made where it is absent.
    #[arg(long, short)]
    out: PathBuf,
    /// Replace results that exist.
    #[arg(long)]
    overwrite: bool,
    /// Say nothing but errors.
    #[arg(long, short)]
    quiet: bool,
}

impl Arguments {
    /// What `skyfront` without a command does: a folder of its own, whose files it may renew.
    pub fn into_default_folder() -> Self {
        Arguments { out: PathBuf::from("skyfront-out"), overwrite: true, quiet: false }
    }
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let manner = Manner {
        arithmetic: ArithmeticOption::F32,
        pictures: true,
        own_time: false,
        overwrite: arguments.overwrite,
        threads: 1,
        request: Request::default(),
    };
    let volume = if arguments.quiet { Volume::Quiet } else { Volume::Normal };
    let mut products = plan(&arguments.out, &manner, &[NAME])?;
    let (image, sky) = simulated(Kind::Bright, SEED, SIDE, SIDE);
    let header = [
        Entry::new("OBJECT", "simulated sky", ""),
        Entry::new("SFSEED", i64::from(SEED), "seed of the simulation"),
        Entry::new("SIGMA", f64::from(sky.sigma()), "standard deviation of the noise"),
    ];
    products.write_path(NAME, |path| {
        let mut writer = Writer::create(path)?;
        writer.image((SIDE, SIDE), &header, |y, row: &mut [f32]| {
            row.copy_from_slice(&image.pixels[y * SIDE..(y + 1) * SIDE]);
        })?;
        writer.finish()
    })?;
    if !arguments.quiet {
        eprintln!("A simulated sky of {SIDE} x {SIDE} pixels with {} stars and galaxies (seed {SEED}).", sky.objects());
    }
    segment_image(&Config::PAPER_F160, &Input::alone(NAME, image), products, &manner, volume)?;
    if !arguments.quiet {
        eprintln!(
            "Look at overlay.png first: the image with the outlines of the sources. stages.png shows how it came"
        );
        eprintln!("about, catalog.csv lists the sources, segmentation.fits is the map.");
    }
    Ok(())
}

/// A simulated sky as an image without header.
pub fn simulated(kind: Kind, seed: u32, width: usize, height: usize) -> (Image, Sky) {
    let mut sky = Sky::new(kind, seed, width, height);
    let mut pixels = vec![0.0f32; width * height];
    for (y, row) in pixels.chunks_exact_mut(width).enumerate() {
        let Ok(()) = sky.row(y, row);
    }
    let mut digest = crc32fast::Hasher::new();
    pixels.iter().for_each(|pixel| digest.update(&pixel.to_le_bytes()));
    let image = Image {
        width,
        height,
        pixels,
        header: Header::default(),
        primary: Header::default(),
        hdu: 0,
        name: None,
        bitpix: -32,
        checksum: digest.finalize(),
        warnings: Vec::new(),
    };
    (image, sky)
}
