//! The files of a run.

use crate::catalogue;
use crate::picture;
use crate::pipeline::Segmentation;
use crate::provenance;
use crate::read::Image;
use crate::summary::summary;
use crate::write::fits::Writer;
use crate::write::{Entry, Products, WriteError, wcs};
use skyfront_core::config::Config;

/// Names of the data products, in the order of writing.
pub const DATA: [&str; 6] =
    ["segmentation.fits", "segmented.fits", "front.fits", "catalog.csv", "catalog.fits", "summary.json"];
/// Names of the pictures.
pub const PICTURES: [&str; 2] = ["stages.png", "overlay.png"];

/// Writes every product of a run under its temporary name; gives what summary.json holds.
///
/// # Errors
/// The first product that could not be written.
pub fn write(
    products: &mut Products,
    config: &Config,
    input: &str,
    image: &Image,
    run: &Segmentation,
) -> Result<serde_json::Value, WriteError> {
    let mut header = wcs::entries(&image.header);
    let provenance = provenance::entries(config, input, image.checksum);
    header.extend(provenance.iter().cloned());
    let (width, height) = (run.width, run.height);
    write_plane(
        products,
        "segmentation.fits",
        (width, height),
        &with_unit(&header, "label, 0 = background"),
        |index| run.labels[index] as i32,
    )?;
    let means: Vec<f32> = run.sources.iter().map(|source| source.mean()).collect();
    write_plane(products, "segmented.fits", (width, height), &header, |index| match run.labels[index] {
        0 => 0.0,
        label => means.get(label as usize - 1).copied().unwrap_or(f32::NAN),
    })?;
    write_plane(products, "front.fits", (width, height), &header, |index| run.front[index])?;
    products.write("catalog.csv", |out| catalogue::write_csv(&run.sources, out))?;
    products.write_path("catalog.fits", |path| catalogue::write_fits(&run.sources, &provenance, path))?;
    let summary = summary(config, input, image, run);
    products.write("summary.json", |out| writeln!(out, "{summary:#}"))?;
    if let Some(planes) = &run.stages {
        let stages = picture::stages(run, planes);
        products.write("stages.png", |out| stages.write_png(out))?;
        let overlay = picture::overlay(&image.pixels, &run.labels, width, height, &run.sources);
        products.write("overlay.png", |out| overlay.write_png(out))?;
    }
    Ok(summary)
}

fn with_unit(header: &[Entry], unit: &str) -> Vec<Entry> {
    header.iter().cloned().chain([Entry::new("BUNIT", unit, "")]).collect()
}

fn write_plane<T: crate::write::fits::Sample>(
    products: &mut Products,
    name: &str,
    size: (usize, usize),
    header: &[Entry],
    value: impl Fn(usize) -> T,
) -> Result<(), WriteError> {
    products.write_path(name, |path| {
        let mut writer = Writer::create(path)?;
        writer.image(size, header, |y, row: &mut [T]| {
            for (x, out) in row.iter_mut().enumerate() {
                *out = value(y * size.0 + x);
            }
        })?;
        writer.finish()
    })
}
