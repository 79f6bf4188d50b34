//! Test vectors: an image, the parameters and what every stage made of it, for replay on other hardware.
//!
//! A folder with `vectors.json` and raw planes, little-endian and row-major, row 0 first: `input.f32`, and for each
//! arithmetic, scheme and stage one file of cells as the core holds them (4 bytes per cell, or 2), named
//! ARITHMETIC-SCHEME-STAGE.bin; `labels` are cells too. Digests are CRC-32 (IEEE) of the file's bytes.

use crate::arithmetics::{self, Task, adapted};
use crate::planes::Room;
use crate::provenance::{parameters, scheme_name};
use crate::write::Value as Entry;
use serde_json::{Map, Value, json};
use skyfront_core::arithmetic::digest::Digest;
use skyfront_core::arithmetic::{Arithmetic, Cell};
use skyfront_core::config::{Config, Scheme};
use skyfront_core::error::Error;
use skyfront_core::run::frame::SliceFrame;
use skyfront_core::run::outcome::Progress;
use skyfront_core::run::plan::{self, leaves};
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::stage::Stage;

/// The file of the image.
pub const INPUT: &str = "input.f32";
/// The file that describes the others.
pub const MANIFEST: &str = "vectors.json";

/// One plane of a run as the core left it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plane {
    /// The stage.
    pub name: &'static str,
    /// Its cells, little-endian.
    pub bytes: Vec<u8>,
}

/// All planes of one run, or why the arithmetic cannot do it.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Name of the arithmetic.
    pub arithmetic: &'static str,
    /// Steps of the front.
    pub steps: u32,
    /// The planes in the order of the run.
    pub planes: Vec<Plane>,
}

/// CRC-32 of bytes, as eight hexadecimal digits.
pub fn crc(bytes: &[u8]) -> String {
    let mut digest = Digest::default();
    digest.bytes(bytes);
    format!("{:08x}", digest.value())
}

/// The little-endian bytes of an image.
pub fn input_bytes(pixels: &[f32]) -> Vec<u8> {
    pixels.iter().flat_map(|pixel| pixel.to_le_bytes()).collect()
}

/// Runs a configuration in every arithmetic that serves it and keeps every plane.
///
/// # Errors
/// What the core finds wrong with the configuration or the image.
pub fn traces(config: &Config, pixels: &[f32], width: usize, height: usize) -> Result<Vec<Trace>, Error> {
    let mut task = TraceTask { config, pixels, width, height };
    let traces: Result<Vec<_>, _> = arithmetics::each(&mut task).into_iter().collect();
    Ok(traces?.into_iter().flatten().collect())
}

/// [`traces`] in the arithmetic of that name; `None` when there is none or it cannot serve the configuration.
///
/// # Errors
/// Those of [`traces`].
pub fn trace(
    arithmetic: &str,
    config: &Config,
    pixels: &[f32],
    width: usize,
    height: usize,
) -> Result<Option<Trace>, Error> {
    arithmetics::named(arithmetic, &mut TraceTask { config, pixels, width, height }).unwrap_or(Ok(None))
}

struct TraceTask<'a> {
    config: &'a Config,
    pixels: &'a [f32],
    width: usize,
    height: usize,
}

impl Task for TraceTask<'_> {
    type Output = Result<Option<Trace>, Error>;

    fn run<A: Arithmetic>(&mut self) -> Self::Output {
        match trace_in::<A>(&adapted::<A>(self.config), self.pixels, self.width, self.height) {
            Err(Error::Arithmetic { .. }) => Ok(None),
            trace => trace.map(Some),
        }
    }
}

fn trace_in<A: Arithmetic>(config: &Config, pixels: &[f32], width: usize, height: usize) -> Result<Trace, Error> {
    let mut room = Room::<A>::new(config, width, height, 0);
    let mut run = Segmenter::<A>::new(config, width, height, room.memory())?;
    let mut planes = Vec::new();
    loop {
        let stage = run.stage();
        let progress = run.poll(usize::MAX, &mut SliceFrame(pixels))?;
        if run.stage() != stage
            && let Some(name) = name(stage)
        {
            let cells = if leaves(stage) == Some(plan::Plane::Image) { run.image() } else { run.front() };
            planes.push(Plane { name, bytes: cell_bytes(cells) });
        }
        if let Progress::Done(outcome) = progress {
            return Ok(Trace { arithmetic: A::NAME, steps: outcome.steps, planes });
        }
    }
}

/// What a stage's plane is called, where it leaves one.
fn name(stage: Stage) -> Option<&'static str> {
    match stage {
        Stage::Normalize => Some("normalised"),
        Stage::Rescale => Some("rescaled"),
        Stage::Filter => Some("filtered"),
        Stage::Edge => Some("g"),
        Stage::Front => Some("u0"),
        Stage::Evolve | Stage::Arrive => Some("u"),
        Stage::Turn => Some("turned"),
        Stage::Measure => Some("labels"),
        _ => None,
    }
}

fn cell_bytes<C: Cell>(cells: &[C]) -> Vec<u8> {
    cells.iter().flat_map(|cell| cell.bits().to_le_bytes().into_iter().take(C::BYTES)).collect()
}

/// The name of a plane's file.
pub fn file_name(scheme: Scheme, arithmetic: &str, plane: &Plane) -> String {
    format!("{arithmetic}-{}-{}.bin", scheme_name(scheme), plane.name)
}

/// What the manifest says about one configuration: the options that give it, and the digests of its runs.
pub fn describe(config: &Config, traces: &[Trace]) -> Value {
    let options: Map<String, Value> = parameters(config)
        .into_iter()
        .map(|parameter| {
            let value = match parameter.value {
                Entry::Text(text) => json!(text),
                Entry::Integer(number) => json!(number),
                Entry::Real(number) => json!(number),
                Entry::Logical(flag) => json!(flag),
            };
            (parameter.name.to_owned(), value)
        })
        .collect();
    let runs: Vec<Value> = traces
        .iter()
        .map(|trace| {
            let planes: Vec<Value> = trace
                .planes
                .iter()
                .map(|plane| {
                    let file = file_name(config.scheme, trace.arithmetic, plane);
                    json!({ "stage": plane.name, "file": file, "crc32": crc(&plane.bytes) })
                })
                .collect();
            json!({ "arithmetic": trace.arithmetic, "steps": trace.steps, "stages": planes })
        })
        .collect();
    json!({ "options": options, "runs": runs })
}
