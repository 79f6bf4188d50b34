//! The files of a run.

use crate::catalogue::{Catalogue, Request};
use crate::outline;
use crate::picture;
use crate::pipeline::Segmentation;
use crate::provenance;
use crate::read::Image;
use crate::report;
use crate::summary::summary;
use crate::write::fits::Writer;
use crate::write::{Entry, Products, WriteError, wcs};
use serde_json::json;
use skyfront_core::config::Config;

/// Names of the data products beside the catalogue, in the order of writing.
pub const DATA: [&str; 4] = ["segmentation.fits", "segmented.fits", "front.fits", "summary.json"];
/// Names of the pictures.
pub const PICTURES: [&str; 3] = ["stages.png", "overlay.png", report::FILE];

/// Writes every product of a run under its temporary name; gives what summary.json holds, and
/// warnings.
///
/// # Errors
/// The first product that could not be written.
pub fn write(
    products: &mut Products,
    config: &Config,
    input: &str,
    image: &Image,
    run: &Segmentation,
    request: &Request,
) -> Result<(serde_json::Value, Vec<String>), WriteError> {
    let mut header = wcs::entries(&image.header);
    let mut provenance = provenance::entries(config, input, image.checksum);
    provenance.push(Entry::new("SFARITH", run.arithmetic, "arithmetic"));
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
    if !run.front.is_empty() {
        write_front(products, config, input, image, &|index| run.front[index])?;
    }
    let catalogue = Catalogue::of(image, run, &request.extras);
    for &format in &request.formats {
        catalogue.write(format, &provenance, products)?;
    }
    write_outlines(products, config, run, request, &catalogue)?;
    let mut summary = summary(config, input, image, run);
    let warnings: Vec<String> = catalogue.warnings().collect();
    summary["measuring"] = catalogue.settings();
    summary["catalogue_warnings"] = json!(warnings);
    products.write("summary.json", |out| writeln!(out, "{summary:#}"))?;
    if let Some(planes) = &run.stages {
        let stages = picture::stages(run, planes);
        products.write("stages.png", |out| stages.write_png(out))?;
        let overlay = picture::overlay(&image.pixels, &run.labels, width, height, &run.sources);
        products.write("overlay.png", |out| overlay.write_png(out))?;
        let subject = report::Subject { config, input, image, run, catalogue: &catalogue, planes };
        let page = report::page(&report::page_data(&subject));
        products.write(report::FILE, |out| out.write_all(page.as_bytes()))?;
    }
    Ok((summary, warnings))
}

/// The outlines of the sources, in the files that are wanted.
fn write_outlines(
    products: &mut Products,
    config: &Config,
    run: &Segmentation,
    request: &Request,
    catalogue: &Catalogue,
) -> Result<(), WriteError> {
    if !request.regions && !request.polygons {
        return Ok(());
    }
    let rings = outline::rings(&run.labels, &run.front, run.width, run.height, config.connectivity);
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

/// Writes the final front.
///
/// # Errors
/// What kept it from being written.
pub fn write_front(
    products: &mut Products,
    config: &Config,
    input: &str,
    image: &Image,
    front: &dyn Fn(usize) -> f32,
) -> Result<(), WriteError> {
    let mut header = wcs::entries(&image.header);
    header.extend(provenance::entries(config, input, image.checksum));
    write_plane(products, "front.fits", (image.width, image.height), &header, front)
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
