//! Many images in one run: each in a folder of its own, a table of all, and none stops the others.

use super::arguments::Arguments;
use super::folders::folders;
use super::job::{guarded, plan, process};
use super::memory::Memory;
use super::messages::{Volume, about_input, progress_bar, report, warnings};
use super::say::{Stderr, Stdout};
use super::table::{self, Facts, Row};
use crate::workers::in_order;
use crate::write::Products;
use anyhow::{Result, bail};
use indicatif::ProgressBar;
use skyfront_core::config::Config;
use std::path::Path;
use std::process::ExitCode;

/// The table of all images.
const TABLE: &str = "summary.csv";

/// Segments every image; the exit code tells whether all of them could be.
pub fn run(arguments: &Arguments, config: &Config) -> Result<ExitCode> {
    let mut products = Products::plan(&arguments.out, &[TABLE], arguments.manner().overwrite)?;
    let folders = folders(&arguments.images, TABLE);
    let memory = arguments.memory();
    let bar = progress_bar(arguments.images.len() as u64, "images", arguments.volume());
    // One at a time for each job: at most so many images are in memory.
    let rows = in_order(arguments.images.len(), 1, arguments.jobs.get(), |index, ()| {
        let row = one(arguments, config, &memory, &arguments.images[index], &folders[index], &bar);
        bar.inc(1);
        row
    });
    bar.finish_and_clear();
    products.write(TABLE, |out| table::write_csv(&rows, out))?;
    products.publish()?;
    if arguments.json {
        rows.iter().try_for_each(|row| writeln!(Stdout, "{}", row.json()))?;
    }
    let failed = rows.iter().filter(|row| row.result.is_err()).count();
    if arguments.volume() > Volume::Quiet {
        table::lines(&rows).iter().for_each(|line| writeln!(Stderr, "{line}"));
        writeln!(
            Stderr,
            "{} images segmented, {failed} failed; {TABLE} in {}",
            rows.len() - failed,
            arguments.out.display()
        );
    }
    Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Writes which image goes into which folder, a line each, for jobs that others start.
pub fn list(arguments: &Arguments, list: &Path) -> Result<ExitCode> {
    let mut lines = String::new();
    for (image, folder) in arguments.images.iter().zip(folders(&arguments.images, TABLE)) {
        let line = [image.as_path(), &arguments.out.join(folder)].map(|path| path.display().to_string());
        // Nobody who takes such lines knows of quotes.
        if let Some(odd) = line.iter().find(|name| name.contains([',', '"', '\n', '\r'])) {
            bail!("{odd}: a job list cannot hold a name with a comma, a quotation mark or a line break");
        }
        lines += &(line.join(",") + "\n");
    }
    if list == Path::new("-") {
        write!(Stdout, "{lines}")?;
        return Ok(ExitCode::SUCCESS);
    }
    let folder = list.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = list.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut products = Products::plan(folder, &[&name], arguments.manner().overwrite)?;
    products.write(&name, |out| out.write_all(lines.as_bytes()))?;
    products.publish()?;
    Ok(ExitCode::SUCCESS)
}

/// One image of many; what goes wrong becomes its row, and one line on stderr at once.
fn one(arguments: &Arguments, config: &Config, memory: &Memory, path: &Path, folder: &str, bar: &ProgressBar) -> Row {
    let work = || segmented(arguments, config, memory, path, &arguments.out.join(folder), bar);
    let result = guarded(work).map_err(|error| {
        let reason = format!("{error:#}");
        bar.suspend(|| writeln!(Stderr, "skyfront: {reason}"));
        reason
    });
    Row { image: path.display().to_string(), folder: folder.to_owned(), result }
}

/// Segments an image into its folder; what remains are the facts of its summary.
fn segmented(
    arguments: &Arguments,
    config: &Config,
    memory: &Memory,
    path: &Path,
    folder: &Path,
    bar: &ProgressBar,
) -> Result<Facts> {
    let name = path.display().to_string();
    let (input, _share) = arguments.read(path, config, memory)?;
    let manner = arguments.manner();
    let products = plan(folder, &manner, &[])?;
    let done = process(config, &input, products, &manner, &mut |_| ())?;
    let lines = match arguments.volume() {
        Volume::Quiet => Vec::new(),
        Volume::Normal => warnings(&name, &done),
        Volume::Verbose => report(config, &name, &done, Volume::Verbose),
    };
    let about_input = about_input(&input, arguments.volume());
    bar.suspend(|| about_input.iter().chain(&lines).for_each(|line| writeln!(Stderr, "{line}")));
    Ok(Facts::of(&done.summary, arguments.json))
}
