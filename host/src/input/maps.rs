//! The maps that a command line names, read and checked against the image.

use super::combine::same_field;
use super::{At, Beside, Combine, Input, LabelMap, MapError, Observed, Positions, Reason, StartMap, WeightType};
use crate::read::{Image, Place};
use crate::sky::Sky;
use crate::write::entry::numbered;
use std::fmt;
use std::path::{Path, PathBuf};

/// The maps of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Maps {
    /// Pixels that must not be used: those that are not 0.
    pub mask: Option<Place>,
    /// Sky of the image that is segmented.
    pub background: Option<Given>,
    /// Its noise.
    pub weight: Option<(Given, WeightType)>,
    /// Images of the same pixels that are combined with the image, so that sources are found in all of them.
    pub with: Vec<Place>,
    /// How.
    pub combine: Combine,
    /// The images in which the sources are measured; with [`Maps::with`] and none here, all that are combined.
    pub measure: Vec<Place>,
    /// The sky of each; none, or one for each.
    pub measure_background: Vec<Given>,
    /// The noise of each; none, or one for each.
    pub measure_weight: Vec<(Given, WeightType)>,
    /// A label map whose sources are measured instead of segmenting.
    pub segmentation: Option<Place>,
    /// A table of places that are measured instead of sources.
    pub positions: Option<PathBuf>,
    /// Where the front starts, and its margin, pixels.
    pub start: Option<(Place, f32)>,
}

/// A quantity of every pixel: one number, or a map.
#[derive(Clone, Debug, PartialEq)]
pub enum Given {
    /// The same for all.
    Level(f32),
    /// One value per pixel.
    Map(Place),
}

impl Given {
    /// A number where the text reads as one, else the name of a map.
    pub fn new(text: impl Into<std::path::PathBuf>) -> Given {
        let text = text.into();
        let number = text.to_str().and_then(|text| text.parse().ok());
        number.map_or_else(|| Given::Map(Place::new(text)), Given::Level)
    }
}

impl fmt::Display for Given {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Given::Level(level) => level.fmt(f),
            Given::Map(place) => place.fmt(f),
        }
    }
}

impl Maps {
    /// How many there are.
    pub fn count(&self) -> usize {
        let given = [self.mask.is_some(), self.background.is_some(), self.weight.is_some(), self.start.is_some()];
        let with = self.with.len();
        // The combination needs as many planes again; a front that goes by each, two more of each and two of the image.
        let together = if self.combine == Combine::Vector && with > 0 { 3 * with + 2 } else { 2 * with };
        let of_bands = [together, self.measure.len(), self.measure_background.len(), self.measure_weight.len()];
        given.into_iter().filter(|&given| given).count() + of_bands.iter().sum::<usize>()
    }

    /// Reads the maps and lays them over an image.
    ///
    /// # Errors
    /// [`MapError`] for a map that cannot be read, has another shape or content than it must have,
    /// or leaves nothing of the image.
    pub fn over(&self, name: &str, image: Image) -> Result<Input, MapError> {
        if *self == Maps::default() {
            return Ok(Input::alone(name, image));
        }
        let before = defined(&image);
        let mut loader = Loader { size: (image.width, image.height), band: 0, beside: Vec::new() };
        let mut input = Input::alone(name, image);
        for (band, place) in self.measure.iter().enumerate() {
            loader.band = band;
            let image = loader.image("measure", "SFMEAS", place)?;
            let name = place.to_string();
            input.bands.push(Observed { name, image, background: None, noise: None, relative: false });
        }
        let mut others = Vec::new();
        for (band, place) in self.with.iter().enumerate() {
            loader.band = band;
            let (image, name) = (loader.image("with", "SFWITH", place)?, place.to_string());
            same_field(&input.detected.image, &image, &name).map_err(|reason| MapError { option: "with", reason })?;
            others.push(Observed { name, image, background: None, noise: None, relative: false });
        }
        loader.band = 0;
        if let Some(place) = &self.mask {
            let mask = loader.image("mask", "SFMASK", place)?;
            mask_out(&mask, place, &mut input).map_err(|reason| MapError { option: "mask", reason })?;
        }
        let own = (self.background.as_ref(), self.weight.as_ref());
        loader.observe(&mut input.detected, &OF_DETECTED, own)?;
        for (band, observed) in input.bands.iter_mut().enumerate() {
            loader.band = band;
            let own = (self.measure_background.get(band), self.measure_weight.get(band));
            loader.observe(observed, &OF_MEASURED, own)?;
        }
        loader.band = 0;
        if let Some(place) = &self.segmentation {
            let map = loader.image("segmentation", "SFSEGMAP", place)?;
            let labels = LabelMap::of(&map.pixels).map_err(|at| Reason::Content {
                file: place.to_string(),
                x: at % map.width + 1,
                y: at / map.width + 1,
                value: map.pixels[at],
                wanted: "labels are whole numbers from 0 to 16777215",
            });
            input.segmentation = Some(labels.map_err(|reason| MapError { option: "segmentation", reason })?);
        }
        if let Some(path) = &self.positions {
            let refused = |reason| MapError { option: "positions", reason: Reason::Table(reason) };
            input.positions = Some(Positions::read(path).map_err(refused)?);
            let file = path.display().to_string();
            loader.note("positions", "SFPLACES", file, None);
        }
        if let Some((place, margin)) = &self.start {
            let file = place.to_string();
            let map = if Path::new(&file).extension().is_some_and(|extension| extension == "csv") {
                loader.note("start", "SFSTMAP", file.clone(), None);
                marks(&file, &input.detected.image).map_err(|reason| MapError { option: "start", reason })?
            } else {
                loader.image("start", "SFSTMAP", place)?.pixels
            };
            if !map.iter().any(|&value| value > 0.0) {
                return Err(MapError { option: "start", reason: Reason::Empty(file) });
            }
            input.start = Some(StartMap::of(&map, loader.size.0, *margin));
        }
        if !others.is_empty() {
            loader.note("combine", "SFCOMBIN", self.combine.name().to_owned(), None);
            input.find_with(others, self.combine);
        }
        input.removed = before - defined(&input.detected.image);
        input.beside = loader.beside;
        Ok(input)
    }
}

/// Why a weight map can leave nothing.
const NO_WEIGHT: &str = "where its values are above 0 and finite, no pixel is defined; is --weight-type right?";

/// Options and keywords of the sky and the noise of an image.
struct Names {
    sky: (&'static str, &'static str),
    noise: (&'static str, &'static str),
}

const OF_DETECTED: Names = Names { sky: ("background", "SFBGMAP"), noise: ("weight", "SFWEIGHT") };
const OF_MEASURED: Names = Names { sky: ("measure-background", "SFMBGMAP"), noise: ("measure-weight", "SFMWEIGH") };

/// Reads maps of one size and keeps account of them.
struct Loader {
    size: (usize, usize),
    /// The number of the measured image that is read, from 0.
    band: usize,
    beside: Vec<Beside>,
}

impl Loader {
    /// Keeps account of a file or a number; from the second measured image on with its number.
    fn note(&mut self, option: &str, keyword: &str, file: String, checksum: Option<u32>) {
        let (option, keyword) = match self.band {
            0 => (option.to_owned(), keyword.to_owned()),
            band => (format!("{option}-{}", band + 1), numbered(keyword, band + 1)),
        };
        self.beside.push(Beside { option, keyword, file, checksum });
    }

    /// Lays its sky and its noise over an image.
    fn observe(
        &mut self,
        observed: &mut Observed,
        names: &Names,
        (background, weight): (Option<&Given>, Option<&(Given, WeightType)>),
    ) -> Result<(), MapError> {
        let (option, keyword) = names.sky;
        if let Some(given) = background {
            let plane = self.plane(option, keyword, given)?;
            remove(&mut observed.image, plane.iter().map(|level| !level.is_finite()));
            left(&observed.image, given, "it is nowhere defined where the image is")
                .map_err(|reason| MapError { option, reason })?;
            observed.background = Some(plane);
        }
        let (option, keyword) = names.noise;
        if let Some((given, kind)) = weight {
            let noise = kind.noise(&self.plane(option, keyword, given)?, &observed.image);
            remove(&mut observed.image, noise.iter().map(|sigma| sigma.is_nan()));
            left(&observed.image, given, NO_WEIGHT).map_err(|reason| MapError { option, reason })?;
            (observed.noise, observed.relative) = (Some(noise), kind.is_relative());
        }
        Ok(())
    }

    fn image(&mut self, option: &'static str, keyword: &'static str, place: &Place) -> Result<Image, MapError> {
        let map = sized(place, self.size).map_err(|reason| MapError { option, reason })?;
        self.note(option, keyword, place.to_string(), Some(map.checksum));
        Ok(map)
    }

    fn plane(&mut self, option: &'static str, keyword: &'static str, given: &Given) -> Result<Vec<f32>, MapError> {
        match given {
            Given::Map(place) => Ok(self.image(option, keyword, place)?.pixels),
            Given::Level(level) => {
                self.note(option, keyword, level.to_string(), None);
                Ok(vec![*level; self.size.0 * self.size.1])
            }
        }
    }
}

/// Reads a map of the image's size.
fn sized(place: &Place, (image_width, image_height): (usize, usize)) -> Result<Image, Reason> {
    let mut other = None;
    let mut admit = |width, height| {
        other = Some((width, height)).filter(|&size| size != (image_width as u64, image_height as u64));
        if other.is_none() { Ok(()) } else { Err(String::new()) }
    };
    let map = place.read_if(&mut admit);
    match other {
        Some((width, height)) => {
            Err(Reason::Shape { file: place.to_string(), width, height, image_width, image_height })
        }
        None => Ok(map?),
    }
}

/// The pixels of the places of a table, as a map.
fn marks(file: &str, image: &Image) -> Result<Vec<f32>, Reason> {
    let table = Positions::read(Path::new(file)).map_err(Reason::Table)?;
    let sky = Sky::of(&image.header).ok().flatten();
    let mut map = vec![0.0; image.pixels.len()];
    for (number, place) in (1..).zip(&table.places) {
        let at = match *place {
            At::Pixel(x, y) => Some((x - 1.0, y - 1.0)),
            At::Sky(ra, dec) => sky.as_ref().and_then(|sky| sky.pixel(ra, dec)),
        };
        let index = |at: f64, length: usize| (0..length).find(|&pixel| (at - pixel as f64).abs() <= 0.5);
        let pixel = at.and_then(|(x, y)| Some(index(y, image.height)? * image.width + index(x, image.width)?));
        let pixel = pixel.ok_or_else(|| Reason::Table(format!("{file}: place {number} is not in the image")))?;
        map[pixel] = 1.0;
    }
    Ok(map)
}

/// Takes masked pixels from all images. A mask holds flags; an image in its place would remove
/// whatever is not exactly 0.
fn mask_out(mask: &Image, place: &Place, input: &mut Input) -> Result<(), Reason> {
    if let Some(at) = mask.pixels.iter().position(|value| value.is_finite() && value.fract() != 0.0) {
        return Err(Reason::Content {
            file: place.to_string(),
            x: at % mask.width + 1,
            y: at / mask.width + 1,
            value: mask.pixels[at],
            wanted: "a mask holds whole numbers: 0 for good, another for bad",
        });
    }
    for observed in std::iter::once(&mut input.detected).chain(&mut input.bands) {
        remove(&mut observed.image, mask.pixels.iter().map(|&value| value != 0.0));
        left(&observed.image, place, "where it is 0, and 0 is a good pixel, no pixel is defined")?;
    }
    Ok(())
}

fn remove(image: &mut Image, bad: impl Iterator<Item = bool>) {
    image.pixels.iter_mut().zip(bad).filter(|(_, bad)| *bad).for_each(|(pixel, _)| *pixel = f32::NAN);
}

fn defined(image: &Image) -> usize {
    image.pixels.iter().filter(|pixel| pixel.is_finite()).count()
}

fn left(image: &Image, file: &impl fmt::Display, why: &'static str) -> Result<(), Reason> {
    if image.pixels.iter().any(|pixel| pixel.is_finite()) {
        Ok(())
    } else {
        Err(Reason::NothingLeft { file: file.to_string(), why })
    }
}
