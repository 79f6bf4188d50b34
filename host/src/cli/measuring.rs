//! The options that say what is measured, and in which files it is told.

use crate::catalogue::{Format, Request};
use crate::measure::Extras;
use clap::Args;

#[derive(Clone, Debug, Args)]
pub struct Measuring {
    /// Radii of circular apertures, pixels; a pixel counts with the exact area inside.
    #[arg(long, value_name = "R1,R2,..", value_delimiter = ',', value_parser = radius, help_heading = "Catalogue")]
    apertures: Vec<f64>,
    /// Electrons in a unit of the image, for the errors [default: GAIN in the header, else unknown].
    #[arg(long, value_name = "E", value_parser = above_zero, help_heading = "Catalogue")]
    gain: Option<f64>,
    /// Pixel value from which pixels are saturated [default: SATURATE in the header, else none].
    #[arg(long, value_name = "LEVEL", value_parser = finite, allow_negative_numbers = true, help_heading = "Catalogue")]
    saturation: Option<f64>,
    /// Magnitude of a flux of 1: adds magnitudes.
    #[arg(long, value_name = "MAG", value_parser = finite, allow_negative_numbers = true, help_heading = "Catalogue")]
    zero_point: Option<f64>,
    /// Formats of the catalogue.
    #[arg(
        long,
        value_enum,
        value_name = "FORMAT,..",
        value_delimiter = ',',
        default_values = ["csv", "fits"],
        help_heading = "Catalogue"
    )]
    catalog_format: Vec<Format>,
    /// Outlines as DS9 polygons: regions.reg in pixels, and regions_sky.reg.
    #[arg(long, help_heading = "Catalogue")]
    regions: bool,
    /// Outlines as outlines.json, in pixels and on the sky.
    #[arg(long, help_heading = "Catalogue")]
    polygons: bool,
    /// The sky and the noise that the noise-aware segmentation found, as background.fits and noise.fits.
    #[arg(long, help_heading = "Catalogue")]
    sky_maps: bool,
    /// Of the maps write segmentation.fits alone, without segmented.fits and front.fits.
    #[arg(long)]
    map_only: bool,
    /// The time at which the front came to each pixel as arrival.fits, in the paper's unit; for
    /// the fast-marching scheme in f32.
    #[arg(long, help_heading = "Front (--method rescaling)")]
    arrival: bool,
}

impl Measuring {
    /// What they amount to.
    pub fn request(&self) -> Request {
        let mut formats = self.catalog_format.clone();
        formats.sort_by_key(|format| format.file());
        formats.dedup();
        Request {
            extras: Extras {
                gain: self.gain,
                saturation: self.saturation,
                zero_point: self.zero_point,
                apertures: self.apertures.clone(),
                ..Extras::default()
            },
            formats,
            regions: self.regions,
            polygons: self.polygons,
            sky: self.sky_maps,
            arrival: self.arrival,
            map_only: self.map_only,
        }
    }
}

/// The largest aperture: a careless one must not take hours.
const LARGEST: f64 = 1e4;

fn radius(text: &str) -> Result<f64, String> {
    above_zero(text).and_then(|r| if r <= LARGEST { Ok(r) } else { Err(format!("must be at most {LARGEST}")) })
}

fn above_zero(text: &str) -> Result<f64, String> {
    finite(text).and_then(|value| if value > 0.0 { Ok(value) } else { Err("must be above 0".to_owned()) })
}

fn finite(text: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| "is not a number".to_owned())
}
