//! The files of a run.

use crate::catalogue::{Catalogue, Request};
use crate::input::Input;
use crate::outline;
use crate::picture;
use crate::pipeline::{Segmentation, Values};
use crate::provenance;
use crate::read::Image;
use crate::read::header::unit;
use crate::report;
use crate::sky::Sky;
use crate::strips::Found;
use crate::summary::{LabelDigest, Part, summary};
use crate::write::fits::Writer;
use crate::write::{Entry, Products, WriteError, wcs};
use serde_json::json;
use skyfront_core::config::Config;
use skyfront_core::run::outcome::Outcome;
use std::time::Instant;

/// Names of the data products that every run has beside the catalogue, in the order of writing.
pub const DATA: [&str; 2] = ["segmentation.fits", "summary.json"];
/// Every source at its mean and the final front, unless the map of labels is enough.
pub const VALUES: [&str; 2] = ["segmented.fits", "front.fits"];
/// Sky and noise, where they are wanted.
pub const SKY: [&str; 2] = ["background.fits", "noise.fits"];
/// The front's arrival times, where they are wanted.
pub const ARRIVAL: &str = "arrival.fits";
/// What the values of the label map are.
const LABELS: &str = "label, 0 = background";
/// Names of the pictures.
pub const PICTURES: [&str; 3] = ["stages.png", "overlay.png", report::FILE];

/// The names of the files that a request asks for, beside [`DATA`] and [`PICTURES`].
pub fn names(request: &Request) -> Vec<&'static str> {
    let regions: &[&str] = if request.regions { &outline::REGIONS } else { &[] };
    let polygons: &[&str] = if request.polygons { &[outline::POLYGONS] } else { &[] };
    let sky: &[&str] = if request.sky { &SKY } else { &[] };
    let arrival: &[&str] = if request.arrival { &[ARRIVAL] } else { &[] };
    let values: &[&str] = if request.map_only { &[] } else { &VALUES };
    let formats = request.formats.iter().map(|format| format.file());
    formats.chain([values, regions, polygons, sky, arrival].into_iter().flatten().copied()).collect()
}

/// What writing leaves.
pub struct Written {
    /// What summary.json holds.
    pub summary: serde_json::Value,
    /// What a user must know about the catalogue.
    pub warnings: Vec<String>,
    /// The parts of the run, in order. Pictures come after the summary and are not in it.
    pub parts: Vec<Part>,
}

/// Writes every product of a run under its temporary name.
///
/// # Errors
/// The first product that could not be written.
pub fn write(
    products: &mut Products,
    config: &Config,
    input: &Input,
    run: &Segmentation,
    request: &Request,
) -> Result<Written, WriteError> {
    let image = &input.detected.image;
    let mut parts = vec![("read".to_owned(), input.reading)];
    parts.extend(run.seconds.iter().map(|(stage, time)| (format!("{stage:?}").to_lowercase(), *time)));
    let mut clock = Instant::now();
    let mut done = |parts: &mut Vec<Part>, part: &str| {
        parts.push((part.to_owned(), clock.elapsed()));
        clock = Instant::now();
    };
    let header = header(config, input, run.arithmetic);
    let provenance = provenance(config, input, run.arithmetic);
    let (width, height) = (run.width, run.height);
    write_plane(products, DATA[0], (width, height), &with_unit(&header, "", LABELS), |first, row| {
        copy(row, &run.labels[first..], |label| input.name_of(label) as i32)
    })?;
    if !request.map_only {
        let means: Vec<f32> = run.sources.iter().map(|source| source.mean()).collect();
        let mean = |label: u32| match label {
            0 => 0.0,
            label => means.get(label as usize - 1).copied().unwrap_or(f32::NAN),
        };
        write_plane(products, VALUES[0], (width, height), &in_unit_of(image, &header), |first, row| {
            copy(row, &run.labels[first..], mean);
        })?;
    }
    if !run.front.is_empty() {
        let front = |first: usize, row: &mut [f32]| copy(row, &run.front[first..], |value| value);
        write_front(products, config, input, request, &header, &front)?;
    }
    if let (true, Some(sky)) = (request.sky, &run.sky) {
        for (name, map) in SKY.iter().zip([&sky.level, &sky.noise]) {
            write_plane(products, name, (width, height), &in_unit_of(image, &header), |first, row: &mut [f32]| {
                copy(row, &map[first..], |value| value);
            })?;
        }
    }
    done(&mut parts, "write maps");
    let catalogue = Catalogue::of(input, run, request);
    done(&mut parts, "catalogue");
    for &format in &request.formats {
        catalogue.write(format, &provenance, products)?;
    }
    write_outlines(products, config, input, run, request, &catalogue)?;
    done(&mut parts, "write catalogue");
    let (summary, warnings) = write_summary(products, summary(config, input, run, &parts), run, &catalogue)?;
    if let Some(planes) = &run.stages {
        let stages = picture::stages(config, run, planes);
        products.write("stages.png", |out| stages.write_png(out))?;
        let overlay = match request.overlay {
            Some(zoom) => picture::overlay_in(zoom, &image.pixels, (width, height), &run.labels, &run.sources),
            None => picture::overlay(&image.pixels, &run.labels, width, height, &run.sources),
        };
        products.write("overlay.png", |out| overlay.write_png(out))?;
        let subject = report::Subject { config, input, run, catalogue: &catalogue, planes };
        let page = report::page(&report::page_data(&subject));
        products.write(report::FILE, |out| out.write_all(page.as_bytes()))?;
        done(&mut parts, "pictures");
    }
    Ok(Written { summary, warnings, parts })
}

/// Writes the products of a run over strips under their temporary names: the labels, the catalogue and the summary.
///
/// # Errors
/// The first product that could not be written.
pub fn write_strips(
    products: &mut Products,
    config: &Config,
    input: &Input,
    found: &mut Found,
    request: &Request,
) -> Result<Written, WriteError> {
    let mut parts = vec![("read".to_owned(), input.reading), ("questions".to_owned(), found.asking)];
    parts.extend(found.run.seconds.iter().map(|(stage, time)| (format!("{stage:?}").to_lowercase(), *time)));
    let started = Instant::now();
    let header = with_unit(&header(config, input, found.run.arithmetic), "", LABELS);
    let (mut digest, mut mask_pixels) = (LabelDigest::default(), 0);
    products.write_path(DATA[0], |path| {
        let mut writer = Writer::create(path)?;
        let (size, mut read) = ((found.run.width, found.run.height), Ok(()));
        writer.image(size, &header, |y, out: &mut [i32]| {
            if read.is_ok() {
                read = found.row(y, |row| {
                    digest.add(row);
                    mask_pixels += row.iter().filter(|&&label| label > 0).count() as u32;
                    copy(out, row, |label| label as i32);
                });
            }
        })?;
        read?;
        writer.finish()
    })?;
    found.run.outcome.mask_pixels = mask_pixels;
    parts.push(("write maps".to_owned(), started.elapsed()));
    let started = Instant::now();
    let provenance = provenance(config, input, found.run.arithmetic);
    for &format in &request.formats {
        found.catalogue.write(format, &provenance, products)?;
    }
    parts.push(("write catalogue".to_owned(), started.elapsed()));
    if !found.beyond.is_empty() {
        found.run.remarks.push(format!(
            "{} sources, or apertures around them, go on beyond the {} rows around a strip: they may differ from those in \
             one piece; more --max-memory makes strips higher",
            found.beyond.len(),
            found.strips.halo
        ));
    }
    let mut summary = summary(config, input, &found.run, &parts);
    summary["labels_crc32"] = json!(digest.text());
    summary["strips"] = json!(found.strips.count());
    summary["beyond_strips"] = json!(found.beyond);
    let (summary, warnings) = write_summary(products, summary, &found.run, &found.catalogue)?;
    Ok(Written { summary, warnings, parts })
}

/// Writes the summary with what the catalogue tells, and returns it with what a user must know.
fn write_summary(
    products: &mut Products,
    mut summary: serde_json::Value,
    run: &Segmentation,
    catalogue: &Catalogue,
) -> Result<(serde_json::Value, Vec<String>), WriteError> {
    let warnings: Vec<String> =
        run.remarks.iter().cloned().chain(catalogue.warnings()).chain(limits(&run.outcome)).collect();
    summary["measuring"] = catalogue.settings();
    summary["flags"] = catalogue.flag_counts();
    summary["result_warnings"] = json!(warnings);
    products.write(DATA[1], |out| writeln!(out, "{summary:#}"))?;
    Ok((summary, warnings))
}

/// The limits that a run has reached.
pub fn limits(outcome: &Outcome) -> Vec<String> {
    let mut lines = Vec::new();
    if outcome.catalogued < outcome.sources {
        lines.push(format!("the catalogue has room for {} sources only", outcome.catalogued));
    }
    if outcome.unreached > 0 {
        let pixels = outcome.unreached;
        lines.push(format!("{pixels} pixels no front can have reached by t_max: they are no source; raise --t-max"));
    }
    if outcome.unlabelled > 0 {
        lines.push(format!("{} pixels of sources found no free label", outcome.unlabelled));
    }
    lines
}

/// The outlines of the sources, in the files that are wanted.
fn write_outlines(
    products: &mut Products,
    config: &Config,
    input: &Input,
    run: &Segmentation,
    request: &Request,
    catalogue: &Catalogue,
) -> Result<(), WriteError> {
    if !request.regions && !request.polygons {
        return Ok(());
    }
    let mut rings = outline::rings(&run.labels, &run.front, run.width, run.height, config.connectivity);
    rings.iter_mut().for_each(|ring| ring.label = input.name_of(ring.label));
    if request.regions {
        products.write(outline::REGIONS[0], |out| outline::write_regions(&rings, None, out))?;
        if let Some(sky) = &catalogue.sky {
            products.write(outline::REGIONS[1], |out| outline::write_regions(&rings, Some(sky), out))?;
        }
    }
    if request.polygons {
        products.write(outline::POLYGONS, |out| outline::write_polygons(&rings, catalogue.sky.as_ref(), out))?;
    }
    Ok(())
}

/// Writes the final front and the times of its arrival, where they are wanted.
///
/// # Errors
/// What kept it from being written.
pub fn write_front(
    products: &mut Products,
    config: &Config,
    input: &Input,
    request: &Request,
    header: &[Entry],
    front: &Values<'_>,
) -> Result<(), WriteError> {
    let image = &input.detected.image;
    let size = (image.width, image.height);
    if !request.map_only {
        write_plane(products, VALUES[1], size, &with_unit(header, "", "the final front u"), front)?;
    }
    if request.arrival {
        // The marched front is the time left at t_max, in pixels of free motion; above 0 it never came.
        let time = |front: f32| if front > 0.0 { f32::NAN } else { ((front + config.farthest()) * config.dx).max(0.0) };
        let header = with_unit(header, "", "arrival time t of the front; NaN = it never came");
        write_plane(products, ARRIVAL, size, &header, |first, row: &mut [f32]| {
            front(first, row);
            row.iter_mut().for_each(|value| *value = time(*value));
        })?;
    }
    Ok(())
}

/// How a run was made.
fn provenance(config: &Config, input: &Input, arithmetic: &str) -> Vec<Entry> {
    let mut entries = provenance::entries(config, input);
    entries.push(Entry::new("SFARITH", arithmetic, "arithmetic"));
    entries
}

/// The header of a map: the image's coordinates, what is wrong with them, and how the run was made.
pub fn header(config: &Config, input: &Input, arithmetic: &str) -> Vec<Entry> {
    let image = &input.detected.image.header;
    let mut entries = wcs::entries(image);
    entries.extend(Sky::of(image).err().map(|reason| Entry::new("SFWCS", reason, "why coordinates are not used")));
    entries.extend(provenance(config, input, arithmetic));
    entries
}

/// A header with the unit of an image's pixels, where that is known.
fn in_unit_of(image: &Image, header: &[Entry]) -> Vec<Entry> {
    unit(&image.header).map_or_else(|| header.to_vec(), |unit| with_unit(header, &unit, ""))
}

/// A header with the unit of the values, empty for none, and what they are.
fn with_unit(header: &[Entry], unit: &str, meaning: &str) -> Vec<Entry> {
    header.iter().cloned().chain([Entry::new("BUNIT", unit, meaning)]).collect()
}

/// Fills a row from the first of the values.
fn copy<T: Copy, U>(row: &mut [U], values: &[T], to: impl Fn(T) -> U) {
    row.iter_mut().zip(values).for_each(|(out, &value)| *out = to(value));
}

/// Writes a plane of which `values` gives a row, from the index of its first pixel.
fn write_plane<T: crate::write::fits::Sample>(
    products: &mut Products,
    name: &str,
    size: (usize, usize),
    header: &[Entry],
    values: impl Fn(usize, &mut [T]),
) -> Result<(), WriteError> {
    products.write_path(name, |path| {
        let mut writer = Writer::create(path)?;
        writer.image(size, header, |y, row: &mut [T]| values(y * size.0, row))?;
        writer.finish()
    })
}
