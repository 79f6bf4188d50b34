//! The summary of a run as JSON: what went in, what was done, what came out.

use crate::input::Input;
use crate::pipeline::{Segmentation, room_for_sources};
use crate::provenance::{of_run, shortest};
use crate::write;
use serde_json::{Map, Value, json};
use skyfront_core::config::{Config, Scheme};
use skyfront_core::run::outcome::StopReason;
use std::time::Duration;

/// CRC-32 of a label map's little-endian bytes: equal maps have equal digests on any machine.
#[derive(Clone, Debug, Default)]
pub struct LabelDigest(crc32fast::Hasher);

impl LabelDigest {
    /// Takes in the next labels.
    pub fn add(&mut self, labels: &[u32]) {
        // In pieces: a call for every label would take longer than the sum itself.
        let mut bytes = [[0; 4]; 4096];
        for piece in labels.chunks(bytes.len()) {
            bytes.iter_mut().zip(piece).for_each(|(place, label)| *place = label.to_le_bytes());
            self.0.update(bytes[..piece.len()].as_flattened());
        }
    }

    /// The digest as summaries have it.
    pub fn text(&self) -> String {
        format!("{:08x}", self.0.clone().finalize())
    }
}

/// The digest of a whole map.
pub fn label_digest(labels: &[u32]) -> String {
    let mut digest = LabelDigest::default();
    digest.add(labels);
    digest.text()
}

/// A part of a run, and the time it took.
pub type Part = (String, Duration);

/// The summary of a run over an image, and of the parts that are done by now.
pub fn summary(config: &Config, input: &Input, run: &Segmentation, parts: &[Part]) -> Value {
    let image = &input.detected.image;
    let outcome = &run.outcome;
    let settings: Map<String, Value> =
        of_run(config, input).into_iter().map(|one| (one.name.replace('-', "_"), json_of(one.value))).collect();
    let mut seconds = Map::new();
    // A stage may come more than once.
    for (part, time) in parts {
        let before = seconds.get(part).and_then(Value::as_f64).unwrap_or(0.0);
        seconds.insert(part.clone(), json!(before + time.as_secs_f64()));
    }
    // The region's own front has neither tau nor a rule to stop by.
    let moved = |value: Value| if config.scheme != Scheme::Region { value } else { Value::Null };
    json!({
        "program": "skyfront",
        "version": env!("CARGO_PKG_VERSION"),
        "input": {
            "file": input.detected.name,
            "hdu": image.hdu,
            "checksum": format!("{:08x}", image.checksum),
            "warnings": image.warnings,
            "beside": input.beside_json(),
        },
        "width": run.width,
        "height": run.height,
        "undefined_pixels": run.width * run.height - outcome.extremes.defined as usize,
        "pixels_removed_by_maps": input.removed,
        "min": outcome.extremes.least,
        "max": outcome.extremes.greatest,
        "background": run.sky.as_ref().map(|sky| middle(&sky.level)),
        "noise": run.sky.as_ref().map(|sky| middle(&sky.noise)),
        "arithmetic": run.arithmetic,
        "parameters": settings,
        "tau": moved(json!(outcome.tau)),
        "stop": moved(json!(match outcome.reason {
            StopReason::Rest => "rest",
            StopReason::TimeLimit => "t_max",
        })),
        "t": moved(json!(f64::from(outcome.steps) * shortest(config.dt))),
        "iterations": moved(json!(outcome.steps)),
        "mask_pixels": outcome.mask_pixels,
        "n_sources": outcome.sources,
        "catalog_room": if config.sky.is_known() { Value::Null } else { json!(room_for_sources(run.width * run.height)) },
        "sources_not_in_catalog": outcome.sources - outcome.catalogued,
        "pixels_not_labelled": outcome.unlabelled,
        "pixels_not_reached": outcome.unreached,
        "labels_crc32": label_digest(&run.labels),
        "seconds": seconds,
    })
}

/// The most values of a map that are looked at: it is smooth.
const SAMPLE: usize = 1 << 16;

/// The median of the known values of a map, of a large one a sample; null where there is none.
fn middle(map: &[f32]) -> Value {
    let sample = map.iter().step_by(map.len().div_ceil(SAMPLE) | 1).copied();
    let mut known: Vec<f32> = sample.filter(|value| value.is_finite()).collect();
    let half = known.len() / 2;
    match half < known.len() {
        true => json!(shortest(*known.select_nth_unstable_by(half, f32::total_cmp).1)),
        false => Value::Null,
    }
}

fn json_of(value: write::Value) -> Value {
    match value {
        write::Value::Text(text) => json!(text),
        write::Value::Integer(number) => json!(number),
        write::Value::Real(number) => json!(number),
        write::Value::Logical(flag) => json!(flag),
    }
}
