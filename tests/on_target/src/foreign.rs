//! The examples of C and C++ on the Cortex-M7: built by gcc, linked with the core's static library.

use crate::build::{self, folder};
use crate::emulator;
use crate::machines::{MACHINES, Machine};
use crate::report::Report;
use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// The processor that the examples run on.
const MACHINE: &Machine = &MACHINES[0];

/// What gcc is told of the processor, and that nothing may be wrong with header or example.
const FLAGS: [&str; 9] = [
    "-mcpu=cortex-m7",
    "-mthumb",
    "-mfpu=fpv5-d16",
    "-mfloat-abi=hard",
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Werror",
    "-Os",
];

/// Compiles C and C++ and links both: the examples need nothing of C++'s library.
const COMPILER: &str = "arm-none-eabi-gcc";

/// Standard and name of each example.
const EXAMPLES: [(&[&str], &str); 2] =
    [(&["-std=c11"], "star_tracker.c"), (&["-std=c++17", "-fno-exceptions", "-fno-rtti"], "segment.cpp")];

/// What the examples print, together.
///
/// # Errors
/// When one does not build, or does not come to its end within `limit`.
pub fn report(limit: Duration) -> Result<Report> {
    let library = build::static_library(MACHINE)?;
    let mut all = Report::default();
    for (standard, example) in EXAMPLES {
        let image = link(standard, example, &library)?;
        let report = emulator::run_image(MACHINE, &image, limit).with_context(|| example.to_owned())?;
        all.digests.extend(report.digests);
    }
    Ok(all)
}

/// Builds an example with the start-up code.
fn link(standard: &[&str], example: &str, library: &Path) -> Result<PathBuf> {
    let core = folder().join("../../core/c");
    let place = folder().join("target/c");
    std::fs::create_dir_all(&place).with_context(|| place.display().to_string())?;
    let image = place.join(example).with_extension("elf");
    let start = place.join("start.o");
    let script = format!("-T{}", folder().join("c/sections.ld").display());
    let include = format!("-I{}", core.join("include").display());
    run(Command::new(COMPILER).args(FLAGS).args(["-std=c11", "-c", "-o"]).arg(&start).arg(folder().join("c/start.c")))?;
    run(Command::new(COMPILER)
        .args(FLAGS)
        .args(standard)
        .args([&include, "-nostartfiles", "--specs=nano.specs", "--specs=nosys.specs", &script])
        .args(["-Wl,--gc-sections", "-Wl,--no-warn-execstack", "-o"])
        .args([&image, &core.join("examples").join(example), &start])
        .arg(library)
        .arg("-lm"))?;
    Ok(image)
}

fn run(command: &mut Command) -> Result<()> {
    let status = command.status().with_context(|| format!("cannot start {}", command.get_program().display()))?;
    if !status.success() {
        bail!("{command:?} failed");
    }
    Ok(())
}
