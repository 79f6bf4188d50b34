//! `skyfront segment --strips`: an image larger than memory.

use super::Usage;
use super::arguments::Arguments;
use super::choices::ArithmeticOption;
use super::job::{Done, plan};
use super::memory::{BESIDE, MEGA};
use super::messages::{Volume, about_input, progress_bar, told};
use super::say::Stderr;
use crate::input::Input;
use crate::outputs::{self, Written};
use crate::read::Place;
use crate::strips::{self, Failure, MOST_PIXELS, Strips, Task};
use anyhow::{Context, Result, bail};
use skyfront_core::config::Config;
use std::path::Path;
use std::time::Instant;

/// Whether a run can be made in strips.
///
/// # Errors
/// What needs all of an image.
pub fn validate(arguments: &Arguments, config: &Config) -> Result<()> {
    if !config.sky.is_known() || config.needs_segmenter() {
        bail!(Usage("--strips needs the default's steps: a front or a filter in steps needs all of an image"));
    }
    if arguments.options.arithmetic != ArithmeticOption::F32 {
        bail!(Usage("--strips needs --arithmetic f32"));
    }
    if arguments.has_maps() {
        bail!(Usage("--strips goes with no maps beside the image"));
    }
    let request = arguments.manner().request;
    if request.regions || request.polygons || request.sky {
        bail!(Usage("--regions, --polygons and --sky-maps need all of an image: they do not go with --strips"));
    }
    if arguments.images.len() > 1 || arguments.job_list.is_some() {
        bail!(Usage("--strips goes with one image, and not with --job-list"));
    }
    Ok(())
}

/// Segments an image strip by strip, publishes its products and says what was done.
pub fn segment(arguments: &Arguments, config: &Config, path: &Path) -> Result<Done> {
    let (name, volume) = (path.display().to_string(), arguments.volume());
    let manner = arguments.manner().in_strips();
    let mut products = plan(&arguments.out, &manner, &[])?;
    let (mut pixels, labels) = (products.scratch()?, products.scratch()?);
    let (started, memory) = (Instant::now(), arguments.memory());
    let mut strips = None;
    let mut admit = |width: u64, height: u64| {
        if width.checked_mul(height).is_none_or(|pixels| pixels > MOST_PIXELS) {
            return Err(format!(
                "{width} x {height} pixels are more than {MOST_PIXELS}, the most that can be told apart"
            ));
        }
        let size = (width as usize, height as usize);
        let whole = Strips::new(config, size, size.1).bytes(config);
        let most = memory.most(whole + BESIDE).saturating_sub(BESIDE);
        let refused =
            |need| memory.refusal(need + BESIDE, (width, height)) + " even in strips; cut the image into pieces";
        strips = Some(Strips::within(config, size, most).map_err(refused)?);
        Ok(())
    };
    let (mut count, mut written) = (0, Ok(()));
    let mut take = |values: &[f32]| {
        let put = pixels.put(count, values.iter().map(|value| value.to_bits()));
        count += values.len();
        put.map_err(|error| {
            written = Err(error);
            std::io::Error::from(std::io::ErrorKind::StorageFull)
        })
    };
    let read = Place::new(path).hand_over(arguments.hdu(), &mut admit, &mut take);
    written?;
    let mut input = Input::alone(&name, read?);
    input.reading = started.elapsed();
    let Some(strips) = strips else { bail!("{name}: no image was read") };
    let rows = format!("{} strips of {} rows, with {} around each", strips.count(), strips.rows, strips.halo);
    about_input(&input, volume).iter().for_each(|line| writeln!(Stderr, "{line}"));
    if volume > Volume::Quiet && strips.count() > 1 {
        writeln!(Stderr, "{name}: {rows}, in {} MB", (strips.bytes(config) + BESIDE).div_ceil(MEGA));
    }
    let bar = progress_bar(strips.count() as u64, "strips", volume);
    let mut watch = |round: usize, strip: usize| {
        bar.set_message(format!("round {}", round + 1));
        bar.set_position(strip as u64);
    };
    let request = &manner.request;
    let task = Task { config, input: &input, request, strips, pixels, labels, watch: &mut watch };
    let found = strips::run(task);
    bar.finish_and_clear();
    let mut found = match found {
        Ok(found) => found,
        Err(Failure::Core(error)) => return Err(error).context(name),
        Err(Failure::Files(error)) => return Err(error.into()),
    };
    let Written { summary, warnings, parts } =
        outputs::write_strips(&mut products, config, &input, &mut found, request)?;
    let files = products.publish()?;
    let run = found.run;
    let done = Done {
        width: run.width,
        height: run.height,
        outcome: run.outcome,
        given: false,
        parts,
        summary,
        warnings,
        files,
    };
    told(config, &name, &done, volume);
    Ok(done)
}
