//! The options that name maps beside the image.

use super::choices::ArithmeticOption;
use super::{Options, Usage};
use crate::input::{Combine, Given, Maps, WeightType};
use crate::read::Place;
use anyhow::{Result, bail};
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use skyfront_core::config::Config;
use std::path::PathBuf;

/// More images would leave no letters in a keyword.
const MOST_BANDS: usize = 99;

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Maps beside the image (FILE or FILE[HDU], of the image's shape)")]
pub struct Beside {
    /// Bad pixels: those that are not 0 are left out, and sources beside them get the flag masked.
    #[arg(long, value_name = "MAP", value_parser = place())]
    mask: Option<Place>,
    /// Sky of the image, a map or a number; a sky that is not given is measured.
    #[arg(long, value_name = "MAP|LEVEL", value_parser = given(), allow_negative_numbers = true)]
    background: Option<Given>,
    /// Noise of the image, a map or a number; pixels without a positive finite value are left out.
    #[arg(long, value_name = "MAP|LEVEL", value_parser = given(), requires = "weight_type")]
    weight: Option<Given>,
    /// What the values of weight maps are.
    #[arg(long, value_enum, value_name = "TYPE")]
    weight_type: Option<WeightType>,
    /// Measure the sources of this label map instead of segmenting: a pixel's value is its source, 0
    /// is none. No maps but that of the labels are written.
    #[arg(long, value_name = "LABELS", value_parser = place(), conflicts_with_all = ["start", "arrival"])]
    segmentation: Option<Place>,
    /// Measure circles (--apertures) at the places of this table instead of sources: comma-separated
    /// values with a line of names, x and y (pixels from 1) or ra and dec (degrees) among them.
    #[arg(long, value_name = "CSV", requires = "apertures", conflicts_with_all = ["start", "arrival"])]
    positions: Option<PathBuf>,
    /// Find sources in this image and the segmented one together, and measure them in each of both, or where
    /// --measure says. Of the same pixels and coordinates; can be given many times.
    #[arg(long, value_name = "IMAGE2", value_parser = place(),
        conflicts_with_all = ["segmentation", "positions", "background", "weight"])]
    with: Vec<Place>,
    /// How they are searched together [default: weighted].
    #[arg(long, value_enum, value_name = "HOW", requires = "with")]
    combine: Option<Combine>,
    /// Measure the sources in this image of the same pixels: fluxes, shapes, GAIN, SATURATE and
    /// coordinates are its own. Given many times, the columns of the second image begin with m2_, and so on.
    #[arg(long, value_name = "IMAGE2", value_parser = place())]
    measure: Vec<Place>,
    /// Sky of that image; of several in turn, for each of them.
    #[arg(long, value_name = "MAP|LEVEL", value_parser = given(), allow_negative_numbers = true, requires = "measure")]
    measure_background: Vec<Given>,
    /// Noise of that image; of several in turn, for each of them.
    #[arg(long, value_name = "MAP|LEVEL", value_parser = given(), requires_all = ["measure", "weight_type"])]
    measure_weight: Vec<Given>,
}

impl Beside {
    /// Whether nothing is to be found, because what is to be measured is given.
    pub fn is_given(&self) -> bool {
        self.segmentation.is_some() || self.positions.is_some()
    }

    /// Whether the maps go together.
    ///
    /// # Errors
    /// More images than can be told apart, maps of some of them only, or a front that does not go by several.
    pub fn validate(&self, config: &Config, arithmetic: ArithmeticOption) -> Result<()> {
        let bands = self.measure.len();
        if bands > MOST_BANDS || self.with.len() >= MOST_BANDS {
            bail!(Usage("--measure can be given 99 times at most, --with 98 times"));
        }
        if ![0, bands].contains(&self.measure_background.len()) || ![0, bands].contains(&self.measure_weight.len()) {
            bail!(Usage("--measure-background and --measure-weight are given once for each --measure, or not at all"));
        }
        if self.combine == Some(Combine::Vector) {
            arithmetic.serves(config, self.with.len() + 1)?;
        }
        Ok(())
    }

    /// The maps, with that of the start.
    pub fn maps(&self, options: &Options) -> Maps {
        let weighed = |given: &Option<Given>| given.clone().zip(self.weight_type);
        let of_bands = self.measure_weight.iter().cloned();
        Maps {
            mask: self.mask.clone(),
            background: self.background.clone(),
            weight: weighed(&self.weight),
            with: self.with.clone(),
            combine: self.combine.unwrap_or_default(),
            measure: self.measure.clone(),
            measure_background: self.measure_background.clone(),
            measure_weight: of_bands.zip(self.weight_type.iter().copied().cycle()).collect(),
            segmentation: self.segmentation.clone(),
            positions: self.positions.clone(),
            start: options.start_map(),
        }
    }
}

/// Names of files are taken as they are, Unicode or not.
pub fn place() -> impl TypedValueParser<Value = Place> {
    PathBufValueParser::new().map(Place::new)
}

fn given() -> impl TypedValueParser<Value = Given> {
    PathBufValueParser::new().map(Given::new)
}
