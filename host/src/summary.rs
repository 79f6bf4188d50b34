//! The summary of a run as JSON: what went in, what was done, what came out.

use crate::pipeline::Segmentation;
use crate::provenance::{parameters, shortest};
use crate::read::Image;
use crate::write;
use serde_json::{Map, Value, json};
use skyfront_core::config::Config;
use skyfront_core::outcome::StopReason;

/// CRC-32 of a label map's little-endian bytes: equal maps have equal digests on any machine.
pub fn label_digest(labels: &[u32]) -> u32 {
    let mut digest = crc32fast::Hasher::new();
    for label in labels {
        digest.update(&label.to_le_bytes());
    }
    digest.finalize()
}

/// The summary of a run over an image.
pub fn summary(config: &Config, input: &str, image: &Image, run: &Segmentation) -> Value {
    let outcome = &run.outcome;
    let settings: Map<String, Value> =
        parameters(config).into_iter().map(|parameter| (parameter.name.to_owned(), json_of(parameter.value))).collect();
    let seconds: Map<String, Value> = run
        .seconds
        .iter()
        .map(|(stage, time)| (format!("{stage:?}").to_lowercase(), json!(time.as_secs_f64())))
        .collect();
    json!({
        "program": "skyfront",
        "version": env!("CARGO_PKG_VERSION"),
        "input": {
            "file": input,
            "hdu": image.hdu,
            "checksum": format!("{:08x}", image.checksum),
            "warnings": image.warnings,
        },
        "width": run.width,
        "height": run.height,
        "undefined_pixels": run.width * run.height - outcome.extremes.defined as usize,
        "min": outcome.extremes.least,
        "max": outcome.extremes.greatest,
        "arithmetic": run.arithmetic,
        "parameters": settings,
        "tau": outcome.tau,
        "stop": match outcome.reason {
            StopReason::Rest => "rest",
            StopReason::TimeLimit => "t_max",
        },
        "t": f64::from(outcome.steps) * shortest(config.dt),
        "iterations": outcome.steps,
        "mask_pixels": outcome.mask_pixels,
        "n_sources": outcome.sources,
        "sources_not_in_catalog": outcome.sources - outcome.catalogued,
        "pixels_not_labelled": outcome.unlabelled,
        "labels_crc32": format!("{:08x}", label_digest(&run.labels)),
        "seconds": seconds,
    })
}

fn json_of(value: write::Value) -> Value {
    match value {
        write::Value::Text(text) => json!(text),
        write::Value::Integer(number) => json!(number),
        write::Value::Real(number) => json!(number),
        write::Value::Logical(flag) => json!(flag),
    }
}
