//! What a call asks for, and the run that it means.

use crate::array::{Marked, Plane, plane};
use crate::error::Failure;
use numpy::PyArray2;
use pyo3::prelude::*;
use skyfront::catalogue::{Choice, Request};
use skyfront::choices::{ArithmeticOption, Preset};
use skyfront::input::{Beside, Combine, Input, LabelMap, Observed, StartMap, WeightType, same_field};
use skyfront::measure::{Extras, Neighbours};
use skyfront::mosaic::Answers;
use skyfront::read::{Card, Header, Image};
use skyfront::settings;
use skyfront_core::config::{Config, Numbers, PARAMETERS, Parameter, Value};
use skyfront_core::plane::part::Part;

/// An array, and whether its bytes are in the other order than this machine's.
pub type Array<'py> = (Bound<'py, PyAny>, bool);

/// A call, as the Python side has brought it into order.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Job<'py> {
    pixels: Array<'py>,
    /// `BITPIX` of a FITS file with such numbers.
    bitpix: i64,
    /// Cards of the image's header.
    cards: Vec<String>,
    /// True where a pixel must not be used.
    mask: Option<Bound<'py, PyArray2<bool>>>,
    background: Option<Array<'py>>,
    weight: Option<(Array<'py>, String)>,
    start: Option<Array<'py>>,
    labels: Option<Array<'py>>,
    bands: Vec<BandArray<'py>>,
    combine: Option<String>,
    preset: String,
    arithmetic: String,
    /// Names of the table of parameters, and values as on the command line.
    settings: Vec<(String, String)>,
    gain: Option<f64>,
    saturation: Option<f64>,
    zero_point: Option<f64>,
    apertures: Vec<f64>,
    neighbours: String,
    columns: Vec<String>,
    /// None for all processors.
    threads: Option<usize>,
    stages: bool,
    /// Of a mosaic: where the pixels lie in it, and what all its parts know together.
    part: Option<Place>,
    answers: Vec<(String, Vec<u8>)>,
}

/// A further image of the same pixels.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct BandArray<'py> {
    pixels: Array<'py>,
    bitpix: i64,
    cards: Vec<String>,
    mask: Option<Bound<'py, PyArray2<bool>>>,
}

/// Its numbers, copied, with what else must be known of it.
struct Further {
    pixels: Plane,
    bitpix: i64,
    cards: Vec<String>,
    mask: Option<Marked>,
}

impl BandArray<'_> {
    fn copied(&self) -> PyResult<Further> {
        let mask = self.mask.as_ref().map(Marked::of).transpose()?;
        let pixels = plane(&self.pixels.0, self.pixels.1)?;
        Ok(Further { pixels, bitpix: self.bitpix, cards: self.cards.clone(), mask })
    }
}

/// Where the pixels of a part lie: columns before rows.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Place {
    /// Columns and rows of the mosaic.
    image: (usize, usize),
    /// Column and row of the first pixel in the mosaic.
    origin: (usize, usize),
    /// The part's own columns, counted in the part.
    columns: (usize, usize),
    /// Its own rows.
    rows: (usize, usize),
}

/// A run that can be made without the interpreter.
pub struct Task {
    /// The settings.
    pub config: Config,
    /// The numbers to compute in.
    pub arithmetic: ArithmeticOption,
    /// The image, and what came with it.
    pub input: Input,
    /// What is to be measured.
    pub request: Request,
    /// Whether the planes of the steps are wanted.
    pub stages: bool,
    /// Where the image lies in a mosaic, and the answers of all its parts.
    pub part: Option<(Part, Answers)>,
}

impl Job<'_> {
    /// The run.
    ///
    /// # Errors
    /// An option that cannot be had, by its name.
    pub fn task(&self) -> PyResult<Result<Task, Failure>> {
        let pixels = plane(&self.pixels.0, self.pixels.1)?;
        let size = pixels.size();
        let mask = self.mask.as_ref().map(Marked::of).transpose()?;
        let read =
            |array: &Option<Array<'_>>| array.as_ref().map(|(array, swapped)| plane(array, *swapped)).transpose();
        let (background, start, labels) = (read(&self.background)?, read(&self.start)?, read(&self.labels)?);
        let weight = match &self.weight {
            Some(((array, swapped), kind)) => Some((plane(array, *swapped)?, kind.as_str())),
            None => None,
        };
        let bands = self.bands.iter().map(BandArray::copied).collect::<PyResult<Vec<_>>>()?;
        let whole = || -> Result<Task, Failure> {
            let arithmetic = named(&ArithmeticOption::ALL, ArithmeticOption::name, "arithmetic", &self.arithmetic)?;
            let config = self.config(arithmetic, size, start.is_some())?;
            let mut input = Input::alone("array", image_of(pixels, self.bitpix, &self.cards));
            let known = background.is_some() || weight.is_some();
            // Most images come alone: then two looks at every pixel are spared.
            if mask.is_some() || background.is_some() || weight.is_some() {
                let before = defined(&input.detected.image);
                lay_over(&mut input, mask, background, weight)?;
                input.removed = before - defined(&input.detected.image);
            }
            input.start = start.map(|map| self.start(&map, size)).transpose()?;
            self.find_with(bands, known, &config, arithmetic, &mut input)?;
            input.segmentation = labels.map(|map| label_map(&map, size)).transpose()?;
            let part = self.part(&config, arithmetic)?;
            Ok(Task { config, arithmetic, input, request: self.request()?, stages: self.stages, part })
        };
        Ok(whole())
    }

    fn part(&self, config: &Config, arithmetic: ArithmeticOption) -> Result<Option<(Part, Answers)>, Failure> {
        let Some(place) = &self.part else { return Ok(None) };
        if !config.sky.is_known() || config.needs_segmenter() {
            return Err(Failure::Option(
                "preset",
                "a front or a filter in steps has no parts: mosaics need the default's steps".to_owned(),
            ));
        }
        if arithmetic != ArithmeticOption::F32 {
            return Err(Failure::Option("arithmetic", "mosaics are segmented in f32".to_owned()));
        }
        let mut answers = Answers::default();
        self.answers.iter().for_each(|(name, bytes)| answers.take(name, bytes));
        let (columns, rows) = (place.columns.0..place.columns.1, place.rows.0..place.rows.1);
        Ok(Some((Part { image: place.image, origin: place.origin, columns, rows }, answers)))
    }

    /// The preset with the settings.
    fn config(&self, arithmetic: ArithmeticOption, size: (usize, usize), map: bool) -> Result<Config, Failure> {
        let preset = named(&Preset::ALL, Preset::name, "preset", &self.preset)?;
        let mut given: Vec<(&Parameter, Value)> = Vec::new();
        for parameter in PARAMETERS {
            let text = self.setting(parameter.name);
            let value = match (parameter.name, text) {
                ("start", _) if map => Some(Value::word("map")),
                (_, None) => None,
                (name, Some(text)) => {
                    let wrong = || Failure::Option(name, format!("{text:?} is none of {}", parameter.forms()));
                    Some(parameter.parse(text).ok_or_else(wrong)?)
                }
            };
            given.extend(value.map(|value| (parameter, value)));
        }
        let config = arithmetic.adapted(settings::apply(preset.config(), &given)?, self.setting("band").is_some());
        Ok(match self.setting("t-max") {
            Some(_) => config,
            None => config.with_time_for(size.0, size.1),
        })
    }

    fn setting(&self, name: &str) -> Option<&str> {
        self.settings.iter().find(|(known, _)| known == name).map(|(_, text)| text.as_str())
    }

    /// Has sources found in the image and its bands together, as `--with` does.
    fn find_with(
        &self,
        bands: Vec<Further>,
        known: bool,
        config: &Config,
        arithmetic: ArithmeticOption,
        input: &mut Input,
    ) -> Result<(), Failure> {
        let how = match &self.combine {
            Some(name) => named(&Combine::ALL, Combine::name, "combine", name)?,
            None => Combine::default(),
        };
        let refused = |option, reason: &str| Err(Failure::Option(option, reason.to_owned()));
        match (bands.is_empty(), &self.combine, &self.part) {
            (true, Some(_), _) => return refused("combine", "it needs bands"),
            (true, None, _) => return Ok(()),
            (false, _, Some(_)) => return refused("bands", "a mosaic has one"),
            (false, _, None) if known => return refused("bands", "background, noise and weight do not go with them"),
            _ => {}
        }
        if how == Combine::Vector {
            arithmetic.serves(config, bands.len() + 1)?;
        }
        let (image, before) = (&input.detected.image, defined(&input.detected.image));
        let size = (image.width, image.height);
        let mut others = Vec::new();
        for (number, band) in bands.into_iter().enumerate() {
            let name = format!("bands[{number}]");
            let differs = |reason: String| Failure::Option("bands", format!("{name}: {reason}"));
            let Further { pixels, bitpix, cards, mask } = band;
            same_shape(pixels.size(), size).map_err(differs)?;
            let mut other = image_of(pixels, bitpix, &cards);
            if let Some(mask) = mask {
                same_shape(mask.size, size).map_err(differs)?;
                mask.places.into_iter().for_each(|at| other.pixels[at] = f32::NAN);
            }
            same_field(image, &other, &name).map_err(|reason| Failure::Option("bands", reason.to_string()))?;
            others.push(Observed { name, image: other, background: None, noise: None, relative: false });
        }
        input.find_with(others, how);
        input.removed += before - defined(&input.detected.image);
        let (option, keyword) = ("combine".to_owned(), "SFCOMBIN".to_owned());
        input.beside.push(Beside { option, keyword, file: how.name().to_owned(), checksum: None });
        Ok(())
    }

    fn start(&self, map: &Plane, size: (usize, usize)) -> Result<StartMap, Failure> {
        same_size("start", map.size(), size)?;
        if !map.values.iter().any(|&value| value > 0.0) {
            return Err(Failure::Option("start", "the map marks no pixel: all are 0 or undefined".to_owned()));
        }
        let margin = Parameter::named("margin").zip(self.setting("margin"));
        let margin = margin.and_then(|(margin, text)| margin.parse(text)).map(|value| value.numbers);
        let margin = if let Some(Numbers::One(margin)) = margin { margin } else { StartMap::MARGIN };
        Ok(StartMap::of(&map.values, size.0, margin))
    }

    fn threads(&self) -> Result<usize, Failure> {
        match self.threads {
            None => Ok(std::thread::available_parallelism().map_or(1, usize::from)),
            Some(threads @ 1..=65_535) => Ok(threads),
            Some(other) => Err(Failure::Option("threads", format!("{other} must be 1 to 65535"))),
        }
    }

    fn request(&self) -> Result<Request, Failure> {
        let columns = Choice::new(&self.columns).map_err(|reason| Failure::Option("columns", reason))?;
        if self.zero_point.is_none() && columns.magnitudes() {
            return Err(Failure::Option("columns", "a magnitude needs zero_point".to_owned()));
        }
        if self.apertures.is_empty() && columns.apertures() {
            return Err(Failure::Option("columns", "a flux within a circle needs apertures".to_owned()));
        }
        let extras = Extras {
            gain: self.gain,
            saturation: self.saturation,
            zero_point: self.zero_point,
            apertures: self.apertures.clone(),
            neighbours: named(&Neighbours::ALL, Neighbours::name, "neighbours", &self.neighbours)?,
            threads: self.threads()?,
            ..Extras::default()
        };
        Ok(Request { extras, columns, ..Request::default() })
    }
}

/// An array as an image, with the cards of its header.
fn image_of(pixels: Plane, bitpix: i64, cards: &[String]) -> Image {
    let Plane { values, width, height } = pixels;
    Image {
        width,
        height,
        pixels: values,
        header: Header::new(cards.iter().map(|card| Card::new(card)).collect()),
        primary: Header::default(),
        hdu: 0,
        name: None,
        bitpix,
        checksum: 0,
        warnings: Vec::new(),
    }
}

/// One of the values by its name.
fn named<T: Copy>(all: &[T], name: fn(T) -> &'static str, option: &'static str, given: &str) -> Result<T, Failure> {
    let found = all.iter().copied().find(|&value| name(value) == given);
    found.ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|&value| name(value)).collect();
        Failure::Option(option, format!("{given:?} is none of {}", names.join(", ")))
    })
}

/// Takes from the image what the maps forbid, in the order of the command line: mask, background, weight.
fn lay_over(
    input: &mut Input,
    mask: Option<Marked>,
    background: Option<Plane>,
    weight: Option<(Plane, &str)>,
) -> Result<(), Failure> {
    let observed = &mut input.detected;
    let size = (observed.image.width, observed.image.height);
    if let Some(mask) = mask {
        same_size("mask", mask.size, size)?;
        let pixels = &mut observed.image.pixels;
        mask.places.into_iter().for_each(|at| pixels[at] = f32::NAN);
        left("mask", &observed.image)?;
    }
    if let Some(map) = background {
        same_size("background", map.size(), size)?;
        remove(&mut observed.image, &map.values);
        left("background", &observed.image)?;
        observed.background = Some(map.values);
    }
    if let Some((map, kind)) = weight {
        let option = if kind == NOISE { "noise" } else { "weight" };
        same_size(option, map.size(), size)?;
        let kind = named(&WeightType::ALL, WeightType::name, "weight_type", if kind == NOISE { "rms" } else { kind })?;
        let noise = kind.noise(&map.values, &observed.image);
        remove(&mut observed.image, &noise);
        left(option, &observed.image)?;
        (observed.noise, observed.relative) = (Some(noise), kind.is_relative());
    }
    Ok(())
}

/// The kind of a weight that came as `noise`.
const NOISE: &str = "noise";

/// Whether a map has the columns and rows of the image.
fn same_size(option: &'static str, map: (usize, usize), image: (usize, usize)) -> Result<(), Failure> {
    same_shape(map, image).map_err(|reason| Failure::Option(option, reason))
}

/// The same, or what is wrong in words.
fn same_shape(map: (usize, usize), image: (usize, usize)) -> Result<(), String> {
    let shape = |(width, height)| (height, width);
    let differs = || format!("its shape is {:?}, that of the image {:?}", shape(map), shape(image));
    if map == image { Ok(()) } else { Err(differs()) }
}

fn remove(image: &mut Image, by: &[f32]) {
    let bad = image.pixels.iter_mut().zip(by).filter(|(_, value)| !value.is_finite());
    bad.for_each(|(pixel, _)| *pixel = f32::NAN);
}

fn left(option: &'static str, image: &Image) -> Result<(), Failure> {
    if defined(image) > 0 { Ok(()) } else { Err(Failure::Option(option, "it leaves no pixel of the image".to_owned())) }
}

fn defined(image: &Image) -> usize {
    image.pixels.iter().filter(|pixel| pixel.is_finite()).count()
}

fn label_map(map: &Plane, size: (usize, usize)) -> Result<LabelMap, Failure> {
    same_size("labels", map.size(), size)?;
    LabelMap::of(&map.values).map_err(|at| {
        let (x, y, value) = (at % map.width, at / map.width, map.values[at]);
        Failure::Option("labels", format!("labels[{y}, {x}] is {value}; labels are whole numbers from 0 to 16777215"))
    })
}
