//! The options that say what is measured, and in which files it is told.

use super::Usage;
use crate::catalogue::{Choice, Format, Request};
use crate::measure::{Extras, Neighbours};
use crate::picture::Zoom;
use anyhow::{Result, bail};
use clap::Args;

#[derive(Clone, Debug, Args)]
pub struct Measuring {
    /// Radii (not diameters) of circular apertures, pixels; a pixel counts with the exact area inside.
    #[arg(long, value_name = "R1,R2,..", value_delimiter = ',', value_parser = radius, help_heading = "Catalogue")]
    apertures: Vec<f64>,
    /// Electrons in a unit of the image, for the errors [default: EGAIN or GAIN in the header, else
    /// unknown; a GAIN above 30 in an image of whole counts is a camera's setting, and not used].
    #[arg(long, value_name = "E", value_parser = above_zero, help_heading = "Catalogue")]
    gain: Option<f64>,
    /// Pixel value from which pixels are saturated [default: SATURATE in the header, else the
    /// greatest value of the pixels' type if they are integers].
    #[arg(long, value_name = "LEVEL", value_parser = finite, allow_negative_numbers = true, help_heading = "Catalogue")]
    saturation: Option<f64>,
    /// Magnitude of a flux of 1: adds magnitudes.
    #[arg(long, value_name = "MAG", value_parser = finite, allow_negative_numbers = true, help_heading = "Catalogue")]
    zero_point: Option<f64>,
    /// What apertures count where they meet other sources: the light opposite to the centre, nothing,
    /// or the light there.
    #[arg(long, value_enum, default_value_t, value_name = "HOW", help_heading = "Catalogue")]
    neighbours: Neighbours,
    /// Columns of the catalogue: names, default, all, or a file of names such as SExtractor's .param;
    /// SExtractor's names are understood too. What no column needs is not measured.
    #[arg(long, value_name = "NAME|FILE,..", value_delimiter = ',', value_parser = column, help_heading = "Catalogue")]
    columns: Vec<String>,
    /// Take the alternate coordinates with this letter.
    #[arg(long, value_name = "A-Z", value_parser = letter, help_heading = "Catalogue")]
    wcs: Option<char>,
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
    /// The sky and the noise that a run on signal-to-noise found, as background.fits and noise.fits.
    #[arg(long, help_heading = "Catalogue")]
    sky_maps: bool,
    /// Of the maps write segmentation.fits alone, without segmented.fits and front.fits.
    #[arg(long)]
    map_only: bool,
    /// Scale of overlay.png: N picture pixels per pixel along each axis, or 1/N [default: near 1200 picture
    /// pixels, up to 2048 for large images].
    #[arg(long, value_name = "N|1/N", conflicts_with = "no_pictures")]
    overlay_scale: Option<Zoom>,
    /// The time at which the front came to each pixel as arrival.fits, in the paper's unit; for
    /// the fast-marching scheme in f32.
    #[arg(long, help_heading = "Front")]
    arrival: bool,
}

impl Measuring {
    /// Whether the columns can be had.
    ///
    /// # Errors
    /// Columns that need another option.
    pub fn validate(&self) -> Result<()> {
        let choice = self.choice();
        if self.zero_point.is_none() && choice.magnitudes() {
            bail!(Usage("--columns names a magnitude, which needs --zero-point"));
        }
        if self.apertures.is_empty() && choice.apertures() {
            bail!(Usage("--columns names a flux within a circle, which needs --apertures"));
        }
        Ok(())
    }

    fn choice(&self) -> Choice {
        Choice::new(&self.columns).unwrap_or_default()
    }

    /// What they amount to, measured by so many threads.
    pub fn request(&self, threads: usize) -> Request {
        let mut formats = self.catalog_format.clone();
        formats.sort_by_key(|format| format.file());
        formats.dedup();
        Request {
            extras: Extras {
                gain: self.gain,
                saturation: self.saturation,
                zero_point: self.zero_point,
                apertures: self.apertures.clone(),
                neighbours: self.neighbours,
                threads,
                ..Extras::default()
            },
            columns: self.choice(),
            wcs: self.wcs,
            formats,
            regions: self.regions,
            polygons: self.polygons,
            sky: self.sky_maps,
            arrival: self.arrival,
            overlay: self.overlay_scale,
            map_only: self.map_only,
        }
    }
}

fn column(text: &str) -> std::result::Result<String, String> {
    Choice::new(&[text.to_owned()]).map(|_| text.to_owned())
}

fn letter(text: &str) -> std::result::Result<char, String> {
    match text.as_bytes() {
        [letter @ b'A'..=b'Z'] => Ok(char::from(*letter)),
        _ => Err("must be one letter, A to Z".to_owned()),
    }
}

/// The largest aperture: a careless one must not take hours.
const LARGEST: f64 = 1e4;

fn radius(text: &str) -> std::result::Result<f64, String> {
    above_zero(text).and_then(|r| if r <= LARGEST { Ok(r) } else { Err(format!("must be at most {LARGEST}")) })
}

fn above_zero(text: &str) -> std::result::Result<f64, String> {
    finite(text).and_then(|value| if value > 0.0 { Ok(value) } else { Err("must be above 0".to_owned()) })
}

fn finite(text: &str) -> std::result::Result<f64, String> {
    text.trim().parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| "is not a number".to_owned())
}
