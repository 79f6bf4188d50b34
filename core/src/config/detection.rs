//! What the noise-aware segmentation asks of a source: immutable, checked once.

use crate::config::{Config, Connectivity};
use crate::error::Error;

/// The settings of [`crate::run::detect::detect`]. "Noise units" are standard deviations of a pixel of
/// empty sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// The outline: where the smoothed image has this many noise units. 0.1 to 100.
    pub outline: f32,
    /// Steps of the front that starts at the outline; 0 leaves it there. 0 to 1000.
    pub front_steps: u32,
    /// Weight of the front's curvature, in pixels times noise units: how smooth the outlines are.
    /// 0 to 1.
    pub curvature: f32,
    /// A source's peak in the matched image, as a multiple of the outline: what is hardly above it
    /// there has hardly a pixel inside. 0 to 100.
    pub peak: f32,
    /// Peaks of pure noise that may be taken for sources in a frame, on average. 0.001 to 1000.
    pub false_sources: f32,
    /// The share of the sources that may be such peaks, where that is more. 0 to 0.5.
    pub false_share: f32,
    /// Light of a branch above the saddle that makes it a source, in noise units. 0 to 10^6.
    pub branch: f32,
    /// The same as a part of the brighter neighbour's light. 0 to 1.
    pub contrast: f32,
    /// Light of a source in all, in noise units. 0 to 10^6.
    pub light: f32,
    /// Pixels of a source, at least 1.
    pub min_area: u32,
    /// Light that the mirrored host does not explain, in noise of the lightly smoothed image. 0 to
    /// 10^6.
    pub excess: f32,
    /// Pixels of it, at least 1.
    pub reopened_area: u32,
    /// How much the image is sharpened before it is divided into sources. 0 to 4.
    pub sharpening: f32,
    /// Which pixels of a source touch.
    pub connectivity: Connectivity,
}

impl Detection {
    /// The default for every kind of sky.
    pub const DEFAULT: Detection = Detection {
        outline: 1.0,
        front_steps: 5,
        curvature: 0.6,
        peak: 1.42,
        false_sources: 0.5,
        false_share: 0.05,
        branch: 10.0,
        contrast: 0.0005,
        light: 15.0,
        min_area: 6,
        excess: 5.5,
        reopened_area: 4,
        sharpening: 0.5,
        connectivity: Connectivity::Eight,
    };

    /// Pixels of a part that was divided from another source, five thirds of [`Detection::min_area`]:
    /// noise on the light of a bright galaxy makes smaller ones.
    pub fn part_area(&self) -> u32 {
        self.min_area.saturating_add(self.min_area.saturating_mul(2) / 3)
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// [`Error::Parameter`] names the first that is out of bounds.
    pub fn validate(&self) -> Result<(), Error> {
        Config { detection: Some(*self), ..Config::NOISE_AWARE }.validate_values()
    }
}
