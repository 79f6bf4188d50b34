//! The catalogue of a run: sources as measured, and one table of them in several formats.

mod columns;
mod fits;
mod text;

pub use columns::{Column, Setting, Value, columns};

use crate::background::SkyMaps;
use crate::input::Input;
use crate::measure::{Extras, Level, Measured, Scene, measure, run_flags};
use crate::pipeline::Segmentation;
use crate::provenance::shortest;
use crate::sky::Sky;
use crate::write::{Entry, Products, WriteError};
use skyfront_core::flags;

/// A file format of the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// Comma-separated values, one line of names.
    Csv,
    /// CSV with units and descriptions in front, as astropy reads it.
    Ecsv,
    /// FITS binary table.
    Fits,
    /// One JSON object a line.
    Jsonl,
}

impl Format {
    /// The name of the file.
    pub fn file(self) -> &'static str {
        match self {
            Format::Csv => "catalog.csv",
            Format::Ecsv => "catalog.ecsv",
            Format::Fits => "catalog.fits",
            Format::Jsonl => "catalog.jsonl",
        }
    }
}

/// What is to be measured, and in which files it is to be told.
#[derive(Clone, Debug)]
pub struct Request {
    /// What is known beside the image.
    pub extras: Extras<'static>,
    /// Formats of the catalogue.
    pub formats: Vec<Format>,
    /// Whether DS9 region files are wanted.
    pub regions: bool,
    /// Whether outlines in JSON are wanted.
    pub polygons: bool,
    /// Whether maps of sky and noise are wanted.
    pub sky: bool,
    /// Whether the front's arrival times are wanted.
    pub arrival: bool,
    /// Whether the map of labels is enough, without the maps of the sources' means and of the front.
    pub map_only: bool,
}

impl Default for Request {
    fn default() -> Self {
        Request {
            extras: Extras::default(),
            formats: vec![Format::Csv, Format::Fits],
            regions: false,
            polygons: false,
            sky: false,
            arrival: false,
            map_only: false,
        }
    }
}

impl Request {
    /// The files that will be written.
    pub fn files(&self) -> Vec<&'static str> {
        let regions: &[&str] = if self.regions { &crate::outline::REGIONS } else { &[] };
        let polygons: &[&str] = if self.polygons { &[crate::outline::POLYGONS] } else { &[] };
        let sky: &[&str] = if self.sky { &crate::outputs::SKY } else { &[] };
        let arrival: &[&str] = if self.arrival { &[crate::outputs::ARRIVAL] } else { &[] };
        let values: &[&str] = if self.map_only { &[] } else { &crate::outputs::VALUES };
        self.formats
            .iter()
            .map(|format| format.file())
            .chain(values.iter().copied())
            .chain(regions.iter().copied())
            .chain(polygons.iter().copied())
            .chain(sky.iter().chain(arrival).copied())
            .collect()
    }
}

/// The sources of a run with their columns.
pub struct Catalogue {
    /// The columns, in order.
    pub columns: Vec<Column>,
    /// The sources, by label.
    pub rows: Vec<Measured>,
    /// Where the image is on the sky, if its header tells.
    pub sky: Option<Sky>,
    /// Why the header's coordinates could not be used.
    pub refused: Option<String>,
    /// How the sources were measured, as header entries.
    pub entries: Vec<Entry>,
}

impl Catalogue {
    /// Measures the sources of a run. Coordinates are those of the image they are measured in, or
    /// of the segmented one where that has none.
    pub fn of(input: &Input, run: &Segmentation, extras: &Extras<'_>) -> Catalogue {
        let observed = input.measured();
        let image = &observed.image;
        let sky = Sky::of(&image.header).transpose().or_else(|| Sky::of(&input.detected.image.header).transpose());
        let (sky, refused) = match sky.transpose() {
            Ok(sky) => (sky, None),
            Err(reason) => (None, Some(reason)),
        };
        let mut extras = extras.clone();
        // Another image has another sky; it is measured as that of the segmented one was.
        let of_another = run.sky.as_ref().filter(|_| input.measured.is_some());
        let of_another = of_another.map(|_| SkyMaps::beside(&image.pixels, &run.labels, run.width));
        let known = |maps: &&SkyMaps| maps.level.iter().all(|level| level.is_finite());
        let maps = of_another.as_ref().or(run.sky.as_ref()).filter(known);
        let level = observed.background.as_ref().or(maps.map(|maps| &maps.level));
        let noise = observed.noise.as_ref().or(maps.map(|maps| &maps.noise));
        extras.background = extras.background.or(level.map(|level| Level::Map(level.into())));
        extras.noise = extras.noise.or(noise.map(|noise| Level::Map(noise.into())));
        extras.gain = extras.gain.or_else(|| image.real("GAIN")).filter(|&gain| gain > 0.0);
        extras.saturation = extras.saturation.or_else(|| image.real("SATURATE"));
        extras.flags |= run_flags(&run.outcome) | if refused.is_some() { flags::NO_COORDINATES } else { 0 };
        let scene = Scene::new(&image.pixels, &run.labels, run.width, run.height, &extras);
        let setting = Setting {
            unit: image.header.text("BUNIT").unwrap_or_default().trim().to_owned(),
            frame: sky.as_ref().map(Sky::frame),
            apertures: extras.apertures.clone(),
            zero_point: extras.zero_point,
        };
        let mut rows = measure(&scene, &run.sources, &extras, sky.as_ref());
        // A deblender knows better than pixels that touch.
        for (row, &blended) in rows.iter_mut().zip(run.blended.iter().flatten()) {
            row.flags = row.flags & !flags::BLENDED | if blended { flags::BLENDED } else { 0 };
        }
        for (row, _) in rows.iter_mut().zip(&run.plateaus).filter(|(_, plateau)| **plateau) {
            row.flags |= flags::PLATEAU;
        }
        Catalogue { columns: columns(&setting), rows, entries: entries(&scene, &extras), sky, refused }
    }

    /// What a user should know before trusting the columns.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        let text = |reason| format!("the header's coordinates are not supported ({reason}): no ra, dec and pa");
        self.refused.iter().map(text)
    }

    /// How the sources were measured, by FITS keyword, as JSON.
    pub fn settings(&self) -> serde_json::Value {
        let pairs = self.entries.iter().filter_map(|entry| match entry {
            Entry::Key(keyword, value, _) => Some((keyword.clone(), text::json_of(value))),
            Entry::Copy(_) => None,
        });
        serde_json::Value::Object(pairs.collect())
    }

    /// Writes one format; `provenance` goes into headers that can hold it.
    ///
    /// # Errors
    /// What the file system reports.
    pub fn write(&self, format: Format, provenance: &[Entry], products: &mut Products) -> Result<(), WriteError> {
        let entries = || provenance.iter().chain(&self.entries).cloned().collect::<Vec<Entry>>();
        match format {
            Format::Csv => products.write(format.file(), |out| text::csv(self, out)),
            Format::Ecsv => products.write(format.file(), |out| text::ecsv(self, &entries(), out)),
            Format::Jsonl => products.write(format.file(), |out| text::jsonl(self, out)),
            Format::Fits => products.write_path(format.file(), |path| fits::write(self, &entries(), path)),
        }
    }
}

/// How the sources were measured.
fn entries(scene: &Scene<'_>, extras: &Extras<'_>) -> Vec<Entry> {
    use crate::measure::Level::{Constant, Map};
    let level = |keyword: &str, what: &str, level: &crate::measure::Level<'_>| match level {
        Constant(value) => Entry::new(keyword, *value, what),
        Map(_) => Entry::new(keyword, "map", what),
    };
    let mut list = vec![
        level("SFBACK", "background of the fluxes", &scene.background),
        level("SFNOISE", "noise of the flux errors", &scene.noise),
    ];
    list.extend(extras.gain.map(|gain| Entry::new("SFGAIN", gain, "gain of the flux errors")));
    list.extend(extras.zero_point.map(|zero| Entry::new("SFZERO", zero, "magnitude zero point")));
    list.extend(extras.saturation.map(|level| Entry::new("SFSATUR", level, "saturation level")));
    if !extras.apertures.is_empty() {
        let radii: Vec<String> = extras.apertures.iter().map(|&radius| shortest(radius as f32).to_string()).collect();
        list.push(Entry::new("SFAPERT", radii.join(","), "radii of apertures, pixels"));
    }
    list
}
