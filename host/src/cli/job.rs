//! One image, from pixels to published products.

use super::choices::ArithmeticOption;
use super::memory::need_of_sources;
use crate::catalogue::Request;
use crate::given;
use crate::input::Input;
use crate::outputs::{self, Written};
use crate::pipeline::{Drive, Values};
use crate::planes::can_be_had;
use crate::summary::Part;
use crate::write::Products;
use anyhow::{Context, Result, anyhow, bail};
use serde_json::Value;
use skyfront_core::config::Config;
use skyfront_core::run::outcome::{Outcome, Progress};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// In which numbers a run is made, and how its results are written.
#[derive(Clone, Debug)]
pub struct Manner {
    /// Numbers to compute in.
    pub arithmetic: ArithmeticOption,
    /// Pictures too.
    pub pictures: bool,
    /// `t_max` is the user's own, whatever the frame.
    pub own_time: bool,
    /// Files that exist are replaced.
    pub overwrite: bool,
    /// Threads for the evolution.
    pub threads: usize,
    /// What is measured, and in which files it is told.
    pub request: Request,
}

impl Manner {
    /// The same without what needs all of an image at once.
    pub fn in_strips(self) -> Manner {
        Manner { pictures: false, request: Request { map_only: true, ..self.request }, ..self }
    }
}

/// What remains of a segmented image when its planes are gone.
pub struct Done {
    pub width: usize,
    pub height: usize,
    pub outcome: Outcome,
    /// Whether what was measured was given.
    pub given: bool,
    /// Time of each part.
    pub parts: Vec<Part>,
    /// What summary.json holds.
    pub summary: Value,
    /// What a user must know about the catalogue.
    pub warnings: Vec<String>,
    /// The published products.
    pub files: Vec<PathBuf>,
}

/// Does some work; a panic, which can only be a fault of this program, becomes an error.
pub fn guarded<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().copied().or_else(|| panic.downcast_ref().map(String::as_str));
        Err(anyhow!("internal error: {}", text.unwrap_or("a panic without words")))
    })
}

/// The products of an image, and `more`, planned in a folder.
pub fn plan(folder: &Path, manner: &Manner, more: &[&str]) -> Result<Products> {
    let pictures: &[&str] = if manner.pictures { &outputs::PICTURES } else { &[] };
    let names: Vec<&str> =
        outputs::DATA.iter().chain(&outputs::names(&manner.request)).chain(pictures).chain(more).copied().collect();
    Ok(Products::plan(folder, &names, manner.overwrite)?)
}

/// Segments an image, writes and publishes its products.
pub fn process(
    config: &Config,
    input: &Input,
    mut products: Products,
    manner: &Manner,
    watch: &mut dyn FnMut(&Progress),
) -> Result<Done> {
    let (width, height) = (input.detected.image.width, input.detected.image.height);
    let config = &if manner.own_time { *config } else { config.with_time_for(width, height) };
    let bands: Vec<&[f32]> = input.with.iter().map(Vec::as_slice).collect();
    let mut drive = Drive {
        bands: &bands,
        background: input.detected.background.as_deref(),
        noise: input.detected.noise.as_deref(),
        relative: input.detected.relative,
        start: input.start.as_ref(),
        keep_stages: manner.pictures,
        // Pictures and the map of means show them.
        keep_sums: manner.pictures || !manner.request.map_only,
        threads: manner.threads,
        watch: Some(watch),
        ..Drive::default()
    };
    // Without pictures and outlines the front goes to its file as soon as it is there, and is not kept.
    let mut written = Ok(());
    let mut take = |front: &Values<'_>| {
        let header = outputs::header(config, input, manner.arithmetic.name());
        written = outputs::write_front(&mut products, config, input, &manner.request, &header, front);
    };
    if !input.is_given() && !manner.pictures && !manner.request.regions && !manner.request.polygons {
        drive.take_front = Some(&mut take);
    }
    let run = if input.is_given() {
        given::segment(input, manner.arithmetic.name(), manner.pictures)
    } else {
        let segmented = manner.arithmetic.segment(config, &input.detected.image, &mut drive);
        segmented.with_context(|| input.detected.name.clone())?
    };
    written?;
    let need = need_of_sources(&run);
    if !can_be_had(need) {
        let (name, sources) = (&input.detected.name, run.sources.len());
        bail!("{name}: {sources} sources need {need} bytes of memory, which the system does not give; cut the image");
    }
    let Written { summary, warnings, parts } = outputs::write(&mut products, config, input, &run, &manner.request)?;
    let files = products.publish()?;
    let given = input.is_given();
    Ok(Done { width: run.width, height: run.height, outcome: run.outcome, given, parts, summary, warnings, files })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error() {
        let words = |work: fn() -> Result<()>| guarded(work).map_err(|error| error.to_string());
        assert_eq!(words(|| Ok(())), Ok(()));
        assert_eq!(words(|| panic!("as the test wants it")), Err("internal error: as the test wants it".to_owned()));
        assert_eq!(words(|| panic!("{}", 7)), Err("internal error: 7".to_owned()));
    }
}
