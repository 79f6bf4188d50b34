//! All that goes into a run: the image, and the maps that say more about its pixels.

mod combine;
mod error;
mod labels;
mod maps;
mod positions;
mod start;
mod weight;

pub use combine::{Combine, same_field};
pub use error::{MapError, Reason};
pub use labels::LabelMap;
pub use maps::{Given, Maps};
pub use positions::{At, Positions};
pub use start::StartMap;
pub use weight::WeightType;

use crate::read::Image;
use crate::write::Entry;
use serde_json::{Value, json};
use std::time::Duration;

/// An image with its name and, where they are given, its sky and its noise.
#[derive(Clone, Debug)]
pub struct Observed {
    /// Name of the file.
    pub name: String,
    /// The pixels; those that must not be used are NaN.
    pub image: Image,
    /// The sky background of every pixel, in units of the image.
    pub background: Option<Vec<f32>>,
    /// Standard deviation of every pixel's noise, in units of the image; NaN where a pixel must not be used.
    pub noise: Option<Vec<f32>>,
    /// Whether that noise was only scaled to the image: it came as weights.
    pub relative: bool,
}

/// What a run works on.
#[derive(Clone, Debug)]
pub struct Input {
    /// The image that is segmented.
    pub detected: Observed,
    /// The images of the same pixels in which the sources are measured, where those are others.
    pub bands: Vec<Observed>,
    /// The pixels of further images, of the same size, that one front goes by together with the segmented one.
    pub with: Vec<Vec<f32>>,
    /// Where the front starts, where a map says it.
    pub start: Option<StartMap>,
    /// A label map that takes the place of the segmentation.
    pub segmentation: Option<LabelMap>,
    /// Places that are measured instead of sources.
    pub positions: Option<Positions>,
    /// Pixels that the mask and the weight map took from the segmented image.
    pub removed: usize,
    /// The files beside the image.
    pub beside: Vec<Beside>,
    /// Time it took to read all of it.
    pub reading: Duration,
}

/// A file, or a number in its place, that came beside the image.
#[derive(Clone, Debug)]
pub struct Beside {
    /// What it is: the option that named it; of several equal ones, from the second on, with its number.
    pub option: String,
    /// Its keyword in headers.
    pub keyword: String,
    /// As it was named.
    pub file: String,
    /// CRC-32 of the file.
    pub checksum: Option<u32>,
}

impl Beside {
    /// What it is, in words.
    pub fn comment(&self) -> String {
        let checksum = self.checksum.map(|checksum| format!(", CRC-32 {checksum:08x}"));
        format!("--{}{}", self.option, checksum.unwrap_or_default())
    }
}

impl Input {
    /// An image alone.
    pub fn alone(name: &str, image: Image) -> Input {
        let detected = Observed { name: name.to_owned(), image, background: None, noise: None, relative: false };
        Input {
            detected,
            bands: Vec::new(),
            with: Vec::new(),
            start: None,
            segmentation: None,
            positions: None,
            removed: 0,
            beside: Vec::new(),
            reading: Duration::ZERO,
        }
    }

    /// Whether nothing is to be found, because what is to be measured was given.
    pub fn is_given(&self) -> bool {
        self.segmentation.is_some() || self.positions.is_some()
    }

    /// The label that a source has in maps and catalogues: that of a given map, if there is one.
    pub fn name_of(&self, label: u32) -> u32 {
        self.segmentation.as_ref().map_or(label, |map| map.name(label))
    }

    /// What headers tell of the files beside the image.
    pub fn entries(&self) -> impl Iterator<Item = Entry> {
        self.beside.iter().map(|map| Entry::new(&map.keyword, map.file.as_str(), &map.comment()))
    }

    /// The same as JSON, by option.
    pub fn beside_json(&self) -> Value {
        let file = |map: &Beside| json!({ "file": map.file, "checksum": map.checksum.map(|checksum| format!("{checksum:08x}")) });
        self.beside
            .iter()
            .map(|map| (map.option.replace('-', "_"), file(map)))
            .collect::<serde_json::Map<_, _>>()
            .into()
    }
}
