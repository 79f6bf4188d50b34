//! `skyfront segment`: images in; segmentation maps, catalogues and pictures out.

use super::choices::ArithmeticOption;
use super::job::{Done, Manner, guarded, plan, process};
use super::memory::{Memory, Share, amount, need};
use super::messages::{Course, Volume, about_input, progress_bar, report, show};
use super::say::{Stderr, Stdout};
use super::{Beside, Measuring, Options, Usage, batch};
use crate::input::Input;
use crate::read::{HduChoice, Place};
use crate::write::Products;
use anyhow::{Result, bail};
use clap::Args;
use skyfront_core::config::{Config, Scheme};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

#[derive(Debug, Args)]
pub struct Arguments {
    /// The images: FITS (also .gz, .fz), PGM or PNG; - is standard input. [HDU] after a name chooses
    /// an HDU, [X0:X1,Y0:Y1] a section of pixels that count from 1. Each of several images gets its
    /// own folder below --out, and summary.csv lists them all.
    #[arg(value_name = "IMAGE", required = false, required_unless_present = "dump_config")]
    pub images: Vec<PathBuf>,
    /// Folder for the results; made where it is absent.
    #[arg(long, short, required = false, required_unless_present = "dump_config")]
    pub out: PathBuf,
    /// HDU of the image: a number (0 = primary) or a name [default: the first 2-D image].
    #[arg(long, value_name = "N|NAME")]
    hdu: Option<HduChoice>,
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    measuring: Measuring,
    /// Leave out stages.png, overlay.png and report.html.
    #[arg(long)]
    no_pictures: bool,
    /// Threads that move the front; the result does not depend on it [default: all processors].
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
    beside: Beside,
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

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let config = arguments.options.config()?;
    arguments.options.arithmetic.validate(&config)?;
    arguments.measuring.validate()?;
    arguments.beside.validate()?;
    let marches = config.scheme == Scheme::FastMarching && arguments.options.arithmetic == ArithmeticOption::F32;
    if arguments.manner().request.arrival && !marches {
        bail!(Usage("--arrival needs --scheme fast-marching in f32: only there each pixel has a time of arrival"));
    }
    if arguments.manner().request.sky && !config.sky.is_known() {
        bail!(Usage("--sky-maps is not used by --sky none; it needs --sky mesh or frame"));
    }
    if let Some(list) = &arguments.job_list {
        return batch::list(arguments, list);
    }
    match arguments.images.as_slice() {
        [path] => {
            let memory = arguments.memory();
            let (input, _share) = arguments.read(path, &config, &memory)?;
            let manner = arguments.manner();
            let products = plan(&arguments.out, &manner, &[])?;
            let done = guarded(|| segment_image(&config, &input, products, &manner, arguments.volume()))?;
            if arguments.json {
                writeln!(Stdout, "{}", done.summary)?;
            }
            Ok(ExitCode::SUCCESS)
        }
        _ => batch::run(arguments, &config),
    }
}

/// Segments a single image and says what was done.
pub fn segment_image(
    config: &Config,
    input: &Input,
    products: Products,
    manner: &Manner,
    volume: Volume,
) -> Result<Done> {
    let name = &input.detected.name;
    about_input(input, volume).iter().for_each(|line| writeln!(Stderr, "{line}"));
    let mut course = Course::of(config);
    let bar = progress_bar(course.length, "steps", volume);
    let done = process(config, input, products, manner, &mut |progress| show(&bar, &mut course, progress));
    bar.finish_and_clear();
    let done = done?;
    for line in report(config, name, &done, volume) {
        writeln!(Stderr, "{line}");
    }
    if let Some(folder) = done.files.first().and_then(|path| path.parent()).filter(|_| volume > Volume::Quiet) {
        writeln!(Stderr, "{} files in {}", done.files.len(), folder.display());
    }
    Ok(done)
}

/// The processors that this process may use.
fn all_processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
