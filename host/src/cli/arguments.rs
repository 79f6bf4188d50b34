//! What `skyfront segment` is asked for, of one image or of many.

use super::job::Manner;
use super::memory::{Memory, Share, amount, need};
use super::messages::Volume;
use super::{Beside, Measuring, Options};
use crate::input::{Input, Maps};
use crate::read::{HduChoice, Place};
use anyhow::Result;
use clap::Args;
use skyfront_core::config::Config;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Debug, Args)]
pub struct Arguments {
    /// The images: FITS (also .gz, .fz), PGM or PNG; - is standard input. [HDU] after a name chooses
    /// an HDU, [X0:X1,Y0:Y1] a section of pixels that count from 1, [*,*,K] the plane K of a cube.
    /// Each of several images gets its own folder below --out, and summary.csv lists them all.
    #[arg(value_name = "IMAGE", required = false, required_unless_present = "dump_config")]
    pub images: Vec<PathBuf>,
    /// Folder for the results; made where it is absent.
    #[arg(long, short, required = false, required_unless_present = "dump_config")]
    pub out: PathBuf,
    /// HDU of the image: a number (0 = primary) or a name [default: the first 2-D image].
    #[arg(long, value_name = "N|NAME")]
    hdu: Option<HduChoice>,
    #[command(flatten)]
    pub options: Options,
    #[command(flatten)]
    pub measuring: Measuring,
    /// Leave out stages.png, overlay.png and report.html.
    #[arg(long)]
    no_pictures: bool,
    /// Threads for sky, smoothing, front and measurements; the result does not depend on it [default: all processors].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Replace results that exist.
    #[arg(long)]
    overwrite: bool,
    /// How many of several images are worked on at a time; each takes its own memory.
    #[arg(long, value_name = "N", default_value = "1")]
    pub jobs: NonZeroUsize,
    /// Bytes that all images worked on at a time may take, with k, M or G for 10^3, 10^6 or 10^9: an image that
    /// needs more is refused, others wait for each other [default: what container and system give].
    #[arg(long, value_name = "BYTES", value_parser = amount)]
    max_memory: Option<u64>,
    /// Work on an image that --max-memory does not hold in strips of whole rows, as high as it allows: the same label map
    /// and catalogue, but for sources larger than what a strip sees, which are counted and flagged truncated. FITS alone,
    /// with the default's steps in f32 and without maps; without pictures, segmented.fits and front.fits. Takes 8 bytes
    /// per pixel of the disk that holds --out while it runs.
    #[arg(long)]
    pub strips: bool,
    /// Write a line IMAGE,FOLDER for each image to this file (- is stdout) and segment none: a job list for Nextflow,
    /// HTCondor or xargs, each job of which is `skyfront segment IMAGE --out FOLDER` with options of its own.
    #[arg(long, value_name = "FILE")]
    pub job_list: Option<PathBuf>,
    /// Print the summary of each image on stdout, as one line of JSON.
    #[arg(long)]
    pub json: bool,
    /// Say more: sky, noise, threshold, how many sources have which flag, the time of every stage.
    #[arg(long, short, conflicts_with = "quiet")]
    verbose: bool,
    /// Say nothing but errors.
    #[arg(long, short)]
    quiet: bool,
    // Last, for its heading stands over all that follow.
    #[command(flatten)]
    pub beside: Beside,
}

impl Arguments {
    /// How much is said.
    pub fn volume(&self) -> Volume {
        match (self.quiet, self.verbose) {
            (true, _) => Volume::Quiet,
            (false, false) => Volume::Normal,
            (false, true) => Volume::Verbose,
        }
    }

    /// How results are written.
    pub fn manner(&self) -> Manner {
        let threads = self.threads.map_or_else(all_processors, usize::from);
        let mut request = self.measuring.request(threads);
        request.map_only |= self.beside.is_given();
        let arithmetic = self.options.arithmetic;
        let own_time = self.options.given.get("t-max").is_some();
        Manner { arithmetic, pictures: !self.no_pictures, own_time, overwrite: self.overwrite, threads, request }
    }

    /// The HDU of the image.
    pub fn hdu(&self) -> Option<&HduChoice> {
        self.hdu.as_ref()
    }

    /// Whether there are maps beside the image.
    pub fn has_maps(&self) -> bool {
        self.beside.maps(&self.options) != Maps::default()
    }

    /// The memory that all runs may take.
    pub fn memory(&self) -> Memory {
        Memory::new(self.max_memory)
    }

    /// Reads an image as it is wanted, with the maps that come with it, once there is memory for its run.
    pub fn read<'m>(&self, path: &Path, config: &Config, memory: &'m Memory) -> Result<(Input, Option<Share<'m>>)> {
        let started = Instant::now();
        let (maps, manner) = (self.beside.maps(&self.options), self.manner());
        let mut share = None;
        let mut admit = |width, height| {
            let size = (width, height);
            share = Some(memory.take(need(config, manner.pictures, maps.count(), size)?, size)?);
            Ok(())
        };
        let image = Place::new(path).read_hdu_if(self.hdu.as_ref(), &mut admit)?;
        let input = maps.over(&path.display().to_string(), image)?;
        Ok((Input { reading: started.elapsed(), ..input }, share))
    }
}

/// The processors that this process may use.
fn all_processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
