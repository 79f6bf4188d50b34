//! `skyfront segment`: images in; segmentation maps, catalogues and pictures out.

use super::arguments::Arguments;
use super::choices::ArithmeticOption;
use super::job::{Done, Manner, guarded, plan, process};
use super::messages::{Course, Volume, about_input, progress_bar, show, told};
use super::say::{Stderr, Stdout};
use super::{Usage, batch, strips};
use crate::input::Input;
use crate::write::Products;
use anyhow::{Result, bail};
use skyfront_core::config::{Config, Scheme};
use std::path::Path;
use std::process::ExitCode;

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let config = arguments.options.config()?;
    arguments.options.arithmetic.validate(&config)?;
    arguments.measuring.validate()?;
    arguments.beside.validate(&config, arguments.options.arithmetic)?;
    let marches = config.scheme == Scheme::FastMarching && arguments.options.arithmetic == ArithmeticOption::F32;
    if arguments.manner().request.arrival && !marches {
        bail!(Usage("--arrival needs --scheme fast-marching in f32: only there each pixel has a time of arrival"));
    }
    if arguments.manner().request.sky && !config.sky.is_known() {
        bail!(Usage("--sky-maps is not used by --sky none; it needs --sky mesh or frame"));
    }
    if arguments.strips {
        strips::validate(arguments, &config)?;
    }
    if let Some(list) = &arguments.job_list {
        return batch::list(arguments, list);
    }
    match arguments.images.as_slice() {
        [path] => {
            let done = match arguments.strips {
                true => guarded(|| strips::segment(arguments, &config, path))?,
                false => segment_whole(arguments, &config, path)?,
            };
            if arguments.json {
                writeln!(Stdout, "{}", done.summary)?;
            }
            Ok(ExitCode::SUCCESS)
        }
        _ => batch::run(arguments, &config),
    }
}

fn segment_whole(arguments: &Arguments, config: &Config, path: &Path) -> Result<Done> {
    let memory = arguments.memory();
    let (input, _share) = arguments.read(path, config, &memory)?;
    let manner = arguments.manner();
    let products = plan(&arguments.out, &manner, &[])?;
    guarded(|| segment_image(config, &input, products, &manner, arguments.volume()))
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
    told(config, name, &done, volume);
    Ok(done)
}
