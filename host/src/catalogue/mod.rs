//! The catalogue of a run: sources as measured, and one table of them in several formats.

mod choice;
mod columns;
mod fits;
mod gain;
pub mod names;
mod text;
mod votable;

pub use choice::Choice;
pub use columns::{Column, Setting, Value, columns};

use crate::background::SkyMaps;
use crate::input::{At, Input, Observed, Positions};
use crate::measure::{Extras, Level, Measured, Scene, measure, measure_at, run_flags};
use crate::picture::Zoom;
use crate::pipeline::Segmentation;
use crate::provenance::shortest;
use crate::read::header::unit;
use crate::sky::Sky;
use crate::write::entry::numbered;
use crate::write::{Entry, Products, WriteError};
use skyfront_core::sources::flags;

/// A file format of the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Format {
    /// Comma-separated values, one line of names.
    Csv,
    /// CSV with units and descriptions in front, as astropy reads it.
    Ecsv,
    /// FITS binary table.
    Fits,
    /// One JSON object a line.
    Jsonl,
    /// VOTable, as text.
    Votable,
}

impl Format {
    /// The name of the file.
    pub fn file(self) -> &'static str {
        match self {
            Format::Csv => "catalog.csv",
            Format::Ecsv => "catalog.ecsv",
            Format::Fits => "catalog.fits",
            Format::Jsonl => "catalog.jsonl",
            Format::Votable => "catalog.vot",
        }
    }
}

/// What is to be measured, and in which files it is to be told.
#[derive(Clone, Debug)]
pub struct Request {
    /// What is known beside the image.
    pub extras: Extras<'static>,
    /// Its columns.
    pub columns: Choice,
    /// The alternate coordinates that are wanted, by their letter.
    pub wcs: Option<char>,
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
    /// The scale of the overlay; by its size where none is given.
    pub overlay: Option<Zoom>,
    /// Whether the map of labels is enough, without the maps of the sources' means and of the front.
    pub map_only: bool,
}

impl Default for Request {
    fn default() -> Self {
        Request {
            extras: Extras::default(),
            columns: Choice::default(),
            wcs: None,
            formats: vec![Format::Csv, Format::Fits],
            regions: false,
            polygons: false,
            sky: false,
            arrival: false,
            overlay: None,
            map_only: false,
        }
    }
}

/// The sources of a run with their columns.
///
/// ```
/// use skyfront::catalogue::{Catalogue, Choice, Request};
/// use skyfront::input::Input;
/// use skyfront::pipeline::{Drive, segment};
/// use skyfront::truth::simulated;
/// use skyfront_core::config::Config;
/// use skyfront_core::simulate::Kind;
///
/// let input = Input::alone("sky", simulated(Kind::Bright, 5, 96, 96).0);
/// let pixels = &input.detected.image.pixels;
/// let run = segment(&Config::NOISE_AWARE, pixels, 96, 96, &mut Drive::default())?;
/// let names = ["label", "x", "y", "flux_kron"].map(str::to_owned);
/// let columns = Choice::new(&names).expect("there are such columns");
/// let catalogue = Catalogue::of(&input, &run, &Request { columns, ..Request::default() });
/// for row in &catalogue.rows {
///     let texts: Vec<String> = catalogue.columns.iter().map(|column| column.text(row)).collect();
///     println!("{}", texts.join(","));
/// }
/// # assert_eq!(catalogue.rows.len(), run.sources.len());
/// # Ok::<(), skyfront_core::error::Error>(())
/// ```
pub struct Catalogue {
    /// The columns, in order.
    pub columns: Vec<Column>,
    /// The sources, by label.
    pub rows: Vec<Measured>,
    /// Where the image is on the sky, if its header tells.
    pub sky: Option<Sky>,
    /// Why the header's coordinates could not be used.
    pub refused: Option<String>,
    /// Why the header's gain could not be used.
    pub no_gain: Option<String>,
    /// Given places that the coordinates do not lead to.
    pub lost: usize,
    /// How the sources were measured, as header entries.
    pub entries: Vec<Entry>,
}

impl Catalogue {
    /// Measures the sources of a run. Coordinates are those of the image they are measured in, or of the
    /// segmented one where that has none. Of several images the first has the plain names of columns.
    pub fn of(input: &Input, run: &Segmentation, request: &Request) -> Catalogue {
        let (first, others) = match input.bands.as_slice() {
            [first, others @ ..] => (first, others),
            [] => (&input.detected, &[][..]),
        };
        let mut catalogue = Catalogue::in_image(first, input, run, request);
        for (band, observed) in others.iter().enumerate() {
            let more = Catalogue::in_image(observed, input, run, request);
            let of_band = more.columns.into_iter().filter(|column| !column.is_of_map());
            catalogue.columns.extend(of_band.map(|column| column.of_band(band)));
            catalogue.entries.extend(more.entries.into_iter().filter_map(|entry| of_further(entry, band)));
            catalogue.rows.iter_mut().zip(more.rows).for_each(|(row, more)| row.bands.push(more));
            catalogue.refused = catalogue.refused.or(more.refused);
            catalogue.no_gain = catalogue.no_gain.or(more.no_gain);
        }
        catalogue
    }

    /// Measures the sources of a run in one image.
    fn in_image(observed: &Observed, input: &Input, run: &Segmentation, request: &Request) -> Catalogue {
        let image = &observed.image;
        let (sky, refused) = match coordinates(observed, input, request.wcs) {
            Ok(sky) => (sky, None),
            Err(reason) => (None, Some(reason)),
        };
        let mut extras = request.extras.clone();
        // Another image has another sky; it is measured as that of the segmented one was.
        let of_another = run.sky.as_ref().filter(|_| !input.bands.is_empty());
        let of_another = of_another.map(|_| SkyMaps::beside(&image.pixels, &run.labels, run.width));
        let known = |maps: &&SkyMaps| maps.level.iter().all(|level| level.is_finite());
        let maps = of_another.as_ref().or(run.sky.as_ref()).filter(known);
        let level = observed.background.as_ref().or(maps.map(|maps| &maps.level));
        let noise = observed.noise.as_ref().or(maps.map(|maps| &maps.noise));
        extras.background = extras.background.or(level.map(|level| Level::Map(level.into())));
        extras.noise = extras.noise.or(noise.map(|noise| Level::Map(noise.into())));
        let in_header = if extras.gain.is_none() { gain::of_header(image) } else { Ok(None) };
        extras.gain = extras.gain.or_else(|| in_header.clone().ok().flatten());
        extras.saturation = extras.saturation.or_else(|| image.real("SATURATE")).or_else(|| image.limit());
        extras.flags |= run_flags(&run.outcome) | if refused.is_some() { flags::NO_COORDINATES } else { 0 };
        let setting = Setting {
            unit: unit(&image.header).unwrap_or_default(),
            frame: sky.as_ref().map(Sky::frame),
            refused: refused.is_some(),
            places: input.positions.is_some(),
            apertures: extras.apertures.clone(),
            zero_point: extras.zero_point,
        };
        let columns = request.columns.columns(&setting);
        extras.wanted = Choice::wanted(&columns);
        let scene = Scene::new(&image.pixels, &run.labels, run.width, run.height, &extras);
        let mut rows = match &input.positions {
            Some(positions) => at_places(&scene, positions, &extras, sky.as_ref()),
            None => measure(&scene, &run.sources, &extras, sky.as_ref()),
        };
        // A deblender knows better than pixels that touch.
        for (row, &blended) in rows.iter_mut().zip(run.blended.iter().flatten()) {
            row.flags = row.flags & !flags::BLENDED | if blended { flags::BLENDED } else { 0 };
        }
        for (row, _) in rows.iter_mut().zip(&run.plateaus).filter(|(_, plateau)| **plateau) {
            row.flags |= flags::PLATEAU;
        }
        if input.positions.is_none() {
            rows.iter_mut().for_each(|row| row.source.label = input.name_of(row.source.label));
        }
        let lost = rows.iter().filter(|row| row.shape.x.is_nan()).count();
        Catalogue { columns, rows, lost, entries: entries(&scene, &extras), sky, refused, no_gain: in_header.err() }
    }

    /// What a user should know before trusting the columns.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        let text = |reason| format!("the header's coordinates are not supported ({reason}): ra, dec and pa are empty");
        let lost = (self.lost > 0).then(|| format!("{} places are not where the coordinates lead", self.lost));
        self.refused.iter().map(text).chain(self.no_gain.clone()).chain(lost)
    }

    /// How the sources were measured, by FITS keyword, as JSON.
    pub fn settings(&self) -> serde_json::Value {
        let pairs = self.entries.iter().filter_map(|entry| match entry {
            Entry::Key(keyword, value, _) => Some((keyword.clone(), text::json_of(value))),
            Entry::Copy(_) => None,
        });
        serde_json::Value::Object(pairs.collect())
    }

    /// How many sources have each flag, by the flags' names; those that none has are left out.
    pub fn flag_counts(&self) -> serde_json::Value {
        let count = |bit: u32| self.rows.iter().filter(|row| row.flags & bit != 0).count();
        let counts = flags::FLAGS.iter().map(|flag| (flag.name.to_owned(), count(flag.bit)));
        counts.filter(|(_, count)| *count > 0).map(|(name, count)| (name, serde_json::Value::from(count))).collect()
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
            Format::Votable => products.write(format.file(), |out| votable::write(self, &entries(), out)),
            Format::Fits => products.write_path(format.file(), |path| fits::write(self, &entries(), path)),
        }
    }
}

/// Measures the places of a table; those that are not in the image have no flux.
fn at_places(scene: &Scene<'_>, positions: &Positions, extras: &Extras<'_>, sky: Option<&Sky>) -> Vec<Measured> {
    let pixel = |place: &At| match *place {
        At::Pixel(x, y) => (x - 1.0, y - 1.0),
        At::Sky(ra, dec) => sky.and_then(|sky| sky.pixel(ra, dec)).unwrap_or((f64::NAN, f64::NAN)),
    };
    let places: Vec<(f64, f64)> = positions.places.iter().map(pixel).collect();
    let mut rows = measure_at(scene, &places, extras, sky);
    rows.iter_mut().zip(&positions.labels).for_each(|(row, &label)| row.source.label = label);
    rows
}

/// The coordinates of the image that is measured, or of the segmented one.
fn coordinates(observed: &Observed, input: &Input, letter: Option<char>) -> Result<Option<Sky>, String> {
    let of = |header| Sky::alternate(header, letter);
    let sky = match of(&observed.image.header)? {
        None => of(&input.detected.image.header)?,
        sky => sky,
    };
    match letter.filter(|_| sky.is_none()) {
        Some(letter) => Err(format!("there are none with the letter {letter}")),
        None => Ok(sky),
    }
}

/// What an entry tells of a further image, counted from 0; `None` where it is the same for all.
fn of_further(entry: Entry, band: usize) -> Option<Entry> {
    let Entry::Key(keyword, value, comment) = entry else { return None };
    let is_own = OF_IMAGE.contains(&keyword.as_str());
    is_own.then(|| Entry::Key(numbered(&keyword, band + 2), value, format!("{comment}, image {}", band + 2)))
}

/// Keywords of what each measured image has for itself.
const OF_IMAGE: [&str; 4] = ["SFBACK", "SFNOISE", "SFGAIN", "SFSATUR"];

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
    list.push(Entry::new("SFNEIGHB", extras.neighbours.name(), "what apertures count of other sources"));
    list.extend(extras.gain.map(|gain| Entry::new("SFGAIN", gain, "gain of the flux errors")));
    list.extend(extras.zero_point.map(|zero| Entry::new("SFZERO", zero, "magnitude zero point")));
    list.extend(extras.saturation.map(|level| Entry::new("SFSATUR", level, "saturation level")));
    if !extras.apertures.is_empty() {
        let radii: Vec<String> = extras.apertures.iter().map(|&radius| shortest(radius as f32).to_string()).collect();
        list.push(Entry::new("SFAPERT", radii.join(","), "radii of apertures, pixels"));
    }
    list
}
