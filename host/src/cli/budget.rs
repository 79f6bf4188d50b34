//! `skyfront budget`: what a run will need at most, before there is an image.

use super::Usage;
use super::choices::ArithmeticOption;
use super::instructions::needs;
use super::memory::{MOST_PIXELS, of_segmenter};
use super::options::Options;
use super::say::Stdout;
use crate::extraction;
use anyhow::{Result, bail};
use clap::Args;
use skyfront_core::arithmetic::{Arithmetic, Cell, F32, Q11, Q24};
use skyfront_core::config::{Config, Scheme};
use skyfront_core::run::budget;
use skyfront_core::run::memory::{self, SEGMENTER_BYTES};
use skyfront_core::run::stage::Stage;
use skyfront_core::sources::catalog::Source;
use std::fmt::Write;

/// Bytes of a pixel of the image, which this program keeps and a camera need not.
const IMAGE_BYTES: usize = size_of::<f32>();

#[derive(Debug, Args)]
pub struct Arguments {
    /// Columns of the frame.
    #[arg(long)]
    width: usize,
    /// Rows of the frame.
    #[arg(long)]
    height: usize,
    /// Sources in the catalogue [default: as many as stay within 64 bytes a column].
    #[arg(long)]
    sources: Option<usize>,
    #[command(flatten)]
    options: Options,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let pixels = arguments.width.checked_mul(arguments.height);
    if pixels.is_none_or(|pixels| pixels as u64 > MOST_PIXELS) {
        bail!(Usage("--width times --height must be at most 2^30 pixels, the most that can be labelled"));
    }
    if arguments.sources.is_some_and(|sources| sources as u64 > MOST_PIXELS) {
        bail!(Usage("--sources must be at most 2^30"));
    }
    let size = (arguments.width, arguments.height);
    let config = arguments.options.for_frame(arguments.options.config()?, size.0, size.1);
    if config.sky.is_known() {
        arguments.options.arithmetic.validate(&config)?;
        write!(Stdout, "{}", on_signal(&config, size)?)?;
        return Ok(());
    }
    let text = match arguments.options.arithmetic {
        ArithmeticOption::F32 => budget_of::<F32>(&config, size, arguments.sources),
        ArithmeticOption::Q24 => budget_of::<Q24>(&config, size, arguments.sources),
        ArithmeticOption::Q11 => budget_of::<Q11>(&config, size, arguments.sources),
    }?;
    write!(Stdout, "{text}")?;
    Ok(())
}

/// The budget of a run on signal-to-noise as text.
fn on_signal(config: &Config, (width, height): (usize, usize)) -> Result<String> {
    let mut parts = extraction::memory(config, width, height).to_vec();
    if config.needs_segmenter() {
        let moved = of_segmenter(config, width, height);
        // What it goes over, and what it leaves.
        parts.push((moved + 2 * IMAGE_BYTES * width * height, "planes of the front or the filter, and its catalogue"));
    }
    let mut text = format!("{width} x {height} pixels, on signal-to-noise, in f32 or q24\n");
    for (bytes, what) in &parts {
        writeln!(text, "{bytes:>14} bytes  {what}")?;
    }
    let total: usize = parts.iter().map(|(bytes, _)| bytes).sum();
    writeln!(text, "{total:>14} bytes  all memory, beside the program and about 1 kB a source")?;
    Ok(text)
}

/// The budget as text.
fn budget_of<A: Arithmetic>(
    config: &Config,
    (width, height): (usize, usize),
    sources: Option<usize>,
) -> Result<String> {
    config.validate::<A>()?;
    let sl_curvature = config.scheme == Scheme::SlCurvature;
    let cell = A::Cell::BYTES;
    let sources = sources.unwrap_or_else(|| memory::catalogue_room(width, height, cell, sl_curvature));
    let total = memory::bytes(width, height, cell, sl_curvature, sources);
    let mut text = String::new();
    writeln!(text, "{width} x {height} pixels in {}", A::NAME)?;
    let catalogue = sources * size_of::<Source>();
    let planes = 2 * cell * width * height;
    for (bytes, what) in [
        (planes, "two planes".to_owned()),
        (total - planes - catalogue, "rows, flags and counts".to_owned()),
        (catalogue, format!("catalogue of {sources} sources")),
        (SEGMENTER_BYTES, "state, at most".to_owned()),
        (total + SEGMENTER_BYTES, "all memory".to_owned()),
        (total + IMAGE_BYTES * width * height, "here, with the image, beside the program and its libraries".to_owned()),
    ] {
        writeln!(text, "{bytes:>14} bytes  {what}")?;
    }
    for stage in Stage::ALL {
        let (passes, rows) = (budget::passes(config, stage), budget::rows(config, height, stage));
        if rows > 0 {
            let name = format!("{stage:?}").to_lowercase();
            writeln!(text, "{rows:>14} rows   {name}, at most {passes} passes")?;
        }
    }
    writeln!(text, "{:>14} rows   the whole run, at most", budget::total_rows(config, height))?;
    for need in needs(config, A::NAME, width * height) {
        let lacking =
            if need.unknown.is_empty() { String::new() } else { format!("; not counted: {}", need.unknown.join(", ")) };
        writeln!(text, "{:>14.4e} instructions on {}, at most{lacking}", need.instructions, need.machine)?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use skyfront_core::config::Filter;

    fn total(config: &Config) -> u64 {
        let text = on_signal(config, (200, 100)).expect("a text");
        let line = text.lines().last().and_then(|line| line.split_whitespace().next());
        line.and_then(|bytes| bytes.parse().ok()).expect("a number")
    }

    #[test]
    fn fronts_and_filters_in_steps_have_planes_of_their_own() {
        let default = total(&Config::NOISE_AWARE);
        assert_eq!(total(&Config { filter: Filter::Gauss, ..Config::NOISE_AWARE }), default);
        for config in [Config::RSA, Config { filter: Filter::Median, ..Config::NOISE_AWARE }] {
            assert!(total(&config) > default + 4 * 4 * 200 * 100);
        }
    }
}
