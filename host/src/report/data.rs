//! What the page shows, as one JSON object.

use super::{picture, places};
use crate::catalogue::{Catalogue, Column, Value as Cell};
use crate::extraction::shown;
use crate::input::Input;
use crate::outline::{Ring, rings};
use crate::picture::{captions, stage};
use crate::pipeline::{Segmentation, StagePlanes};
use crate::provenance::{parameters, shortest};
use serde_json::{Value, json};
use skyfront_core::config::{self, Config, Order, Rescale, Scheme};
use skyfront_core::run::outcome::StopReason;
use skyfront_core::sky::otsu::{BINS, Histogram};
use skyfront_core::sources::flags::FLAGS;
use std::fmt::Write;

/// Points of the convergence curve, at most.
const POINTS: usize = 600;

/// A finished run, with all that went into it.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// What was to be done.
    pub config: &'a Config,
    /// The image, and what came with it.
    pub input: &'a Input,
    /// The result.
    pub run: &'a Segmentation,
    /// Its sources as they were measured.
    pub catalogue: &'a Catalogue,
    /// Planes of the steps.
    pub planes: &'a StagePlanes,
}

/// The data of the page.
pub fn page_data(subject: &Subject<'_>) -> Value {
    let Subject { config, input, run, catalogue, .. } = *subject;
    let name = &input.detected.name;
    let title = std::path::Path::new(name).file_name().map_or(name.into(), |name| name.to_string_lossy());
    let columns = in_sight(catalogue);
    json!({
        "title": title,
        "width": run.width,
        "height": run.height,
        "facts": facts(subject),
        "preview": picture::preview(&input.detected.image.pixels, run.width, run.height),
        "sky": catalogue.sky.as_ref().map(|sky| places::places(sky, run.width, run.height)),
        "columns": described(&columns),
        "rows": rows(catalogue, &columns),
        "flags": FLAGS.map(|flag| json!([flag.bit, flag.name])).as_slice(),
        "outlines": outlines(subject),
        "boxes": boxes(run),
        "stages": stages(subject),
        "histogram": histogram(subject),
        "convergence": convergence(config, run),
        "parameters": explained(config),
        "provenance": provenance(subject),
    })
}

/// The head of the page.
fn facts(subject: &Subject<'_>) -> Vec<Value> {
    let outcome = &subject.run.outcome;
    let fact = |name: &str, value: Value| json!({ "name": name, "value": value });
    let alert = |name: &str, value: u32| json!({ "name": name, "value": value, "alert": true });
    let t = f64::from(outcome.steps) * shortest(subject.config.dt);
    let mut facts = vec![
        fact("sources", json!(outcome.sources)),
        fact("pixels", json!(format!("{} × {}", subject.run.width, subject.run.height))),
        fact("pixels in sources", json!(outcome.mask_pixels)),
    ];
    if subject.config.scheme != Scheme::Region {
        facts.push(match outcome.reason {
            StopReason::Rest => fact("the front came to rest at", json!(format!("t = {t:.3}"))),
            StopReason::TimeLimit => {
                json!({ "name": "the front was given up at", "value": format!("t = {t:.3}"), "alert": true })
            }
        });
        facts.push(fact("steps", json!(outcome.steps)));
    }
    if outcome.catalogued < outcome.sources {
        facts.push(alert("sources without room in the catalogue", outcome.sources - outcome.catalogued));
    }
    if outcome.unlabelled > 0 {
        facts.push(alert("pixels without a free label", outcome.unlabelled));
    }
    facts
}

/// Columns that stand first, because most readers look for them.
const FIRST: [&str; 10] = ["label", "x", "y", "ra", "dec", "flux", "flux_err", "mag", "snr", "flags"];

/// The columns of the catalogue, those of [`FIRST`] in front.
fn in_sight(catalogue: &Catalogue) -> Vec<&Column> {
    let place = |column: &&Column| FIRST.iter().position(|name| *name == column.name).unwrap_or(FIRST.len());
    let mut columns: Vec<&Column> = catalogue.columns.iter().collect();
    columns.sort_by_key(place);
    columns
}

/// What the columns are.
fn described(columns: &[&Column]) -> Vec<Value> {
    let digits = |value: &Cell| match value {
        Cell::Integer(_) => None,
        Cell::Real(_, digits) => Some(*digits),
    };
    let column = columns.iter().map(|column| {
        json!({
            "name": column.name,
            "unit": column.unit,
            "description": column.description,
            "digits": digits(&column.value),
        })
    });
    column.collect()
}

/// The catalogue, a row a source; null where there is no value.
fn rows(catalogue: &Catalogue, columns: &[&Column]) -> Vec<Vec<Value>> {
    let cell = |text: String| text.parse().map_or(Value::Null, Value::Number);
    let row = |source| columns.iter().map(|column| cell(column.text(source))).collect();
    catalogue.rows.iter().map(row).collect()
}

/// The parameters of a run with their units and meanings.
fn explained(config: &Config) -> Vec<Value> {
    let told = parameters(config).into_iter().map(|one| {
        let (unit, help) = config::Parameter::named(one.name).map_or(("", ""), |known| (known.unit, known.help));
        json!({ "name": one.name, "value": one.value.to_string(), "unit": unit, "help": help })
    });
    told.collect()
}

/// The boxes around the sources: left, top, right and bottom, in pixels from the upper left corner.
fn boxes(run: &Segmentation) -> Vec<Value> {
    let height = run.height as i64;
    let around = run.sources.iter().map(|source| {
        let (columns, rows) = (source.columns, source.rows);
        json!([columns.0, height - 1 - i64::from(rows.1), columns.1 + 1, height - i64::from(rows.0)])
    });
    around.collect()
}

/// The outline of each source of the catalogue as an SVG path, in hundredths of a pixel from the
/// upper left corner of the image.
fn outlines(subject: &Subject<'_>) -> Vec<String> {
    let Subject { config, run, .. } = *subject;
    let mut paths = vec![String::new(); run.sources.len()];
    for ring in rings(&run.labels, &run.front, run.width, run.height, config.connectivity) {
        if let Some(path) = (ring.label as usize).checked_sub(1).and_then(|index| paths.get_mut(index)) {
            trace(path, &ring, run.height);
        }
    }
    paths
}

/// Appends a ring to a path: an absolute start, then steps, which take fewer letters.
fn trace(path: &mut String, ring: &Ring, height: usize) {
    let hundredths = |value: f64| (value * 100.0).round() as i64;
    let mut last = None;
    for &(x, y) in &ring.points {
        let (x, y) = (hundredths(x + 0.5), hundredths(height as f64 - y - 0.5));
        // Writing to a text does not fail.
        let _ = match last.replace((x, y)) {
            None => write!(path, "M{x} {y}l"),
            Some((before_x, before_y)) => write!(path, "{} {} ", x - before_x, y - before_y),
        };
    }
    path.push('z');
}

/// The pictures of the stages.
fn stages(subject: &Subject<'_>) -> Vec<Value> {
    let shown = captions(subject.config).into_iter().enumerate().filter_map(|(index, (name, note))| {
        let canvas = stage(subject.run, subject.planes, index)?;
        Some(json!({ "name": name, "note": note, "image": picture::of_canvas(&canvas) }))
    });
    shown.collect()
}

/// The histogram of the image in which a threshold decides, and the threshold in it.
fn histogram(subject: &Subject<'_>) -> Value {
    let planes = subject.planes;
    if subject.config.scheme == Scheme::Region {
        let mut histogram = Histogram::EMPTY;
        planes.filtered.iter().for_each(|&value| histogram.add(value));
        return json!({
            "counts": histogram.0.as_slice(),
            "from": shown::LEAST,
            "to": shown::GREATEST,
            "axis": "signal to noise",
            "limit": shortest(subject.config.outline.threshold),
            "limit_name": "threshold",
            "note": format!("The smoothed image in {BINS} bins, values beyond the ends in the first and the last one, with the level of the outlines."),
        });
    }
    let (plane, name) = match subject.config.order {
        Order::FilterFirst if !planes.filtered.is_empty() => (&planes.filtered, "filtered"),
        _ => (&planes.normalised, "normalised"),
    };
    let mut histogram = Histogram::EMPTY;
    plane.iter().for_each(|&value| histogram.add(value));
    let has_tau = matches!(subject.config.rescale, Rescale::R3 { .. });
    let tau = has_tau.then(|| shortest(subject.run.outcome.tau));
    let threshold = if has_tau { "with the threshold τ" } else { "(this rescaling has no threshold)" };
    json!({
        "counts": histogram.0.as_slice(),
        "from": 0,
        "to": 1,
        "axis": "value",
        "limit": tau,
        "limit_name": "τ",
        "note": format!("The {name} image in {BINS} bins {threshold}."),
    })
}

/// The change of every step against its time: the greatest of each stretch where there are many.
/// Null where no front moved in steps.
fn convergence(config: &Config, run: &Segmentation) -> Value {
    if run.convergence.is_empty() || config.scheme == Scheme::FastMarching {
        return Value::Null;
    }
    let dt = shortest(config.dt);
    let stretch = run.convergence.len().div_ceil(POINTS).max(1);
    let points: Vec<Value> = run
        .convergence
        .chunks(stretch)
        .enumerate()
        .map(|(index, changes)| {
            let steps = index * stretch + changes.len();
            let most = changes.iter().fold(0.0f32, |most, &change| if change > most { change } else { most });
            json!([shortest((steps as f64 * dt) as f32), shortest(most)])
        })
        .collect();
    let end = match run.outcome.reason {
        StopReason::Rest => "it came to rest below ε",
        StopReason::TimeLimit => "it was given up at its time limit",
    };
    json!({
        "points": points,
        "eps": shortest(config.eps),
        "note": format!("How much the front moved in each of its {} steps; {end}.", run.outcome.steps),
    })
}

/// Where the result comes from.
fn provenance(subject: &Subject<'_>) -> Vec<Value> {
    let Subject { input, run, .. } = *subject;
    let image = &input.detected.image;
    let name = image.name.as_ref().map_or(String::new(), |name| format!(" ({name})"));
    let defined = run.outcome.extremes.defined as usize;
    let mut list = vec![
        json!(["program", concat!("skyfront ", env!("CARGO_PKG_VERSION"))]),
        json!(["file", input.detected.name]),
        json!(["HDU", format!("{}{name}", image.hdu)]),
        json!(["CRC-32 of the file", format!("{:08x}", image.checksum)]),
        json!(["CRC-32 of the labels", crate::summary::label_digest(&run.labels)]),
        json!(["undefined pixels", (run.width * run.height - defined).to_string()]),
        json!(["pixel values", format!("{} to {}", run.outcome.extremes.least, run.outcome.extremes.greatest)]),
    ];
    list.extend(input.beside.iter().map(|map| json!([map.file, map.comment()])));
    let known = ["OBJECT", "TELESCOP", "INSTRUME", "FILTER", "DATE-OBS", "EXPTIME", "BUNIT"];
    list.extend(known.iter().filter_map(|keyword| {
        let value = image.header.text(keyword).or_else(|| image.real(keyword).map(|value| value.to_string()))?;
        Some(json!([keyword, value.trim()]))
    }));
    let warnings = image.warnings.iter().chain(&run.remarks).cloned().chain(subject.catalogue.warnings());
    list.extend(warnings.map(|warning| json!(["warning", warning])));
    list
}
