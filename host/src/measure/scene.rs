//! The image as measurements see it: values above the background, their variance, and neighbours.

use super::shape::OUTLINE;
use super::{Extras, Flux, Level, estimate};
use skyfront_core::flags;

/// Pixels and labels of one shape, row-major, with background and noise.
#[derive(Debug)]
pub struct Scene<'a> {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    pixels: &'a [f32],
    pub(super) labels: &'a [u32],
    /// Background in use.
    pub background: Level<'a>,
    /// Noise in use.
    pub noise: Level<'a>,
    gain: Option<f64>,
    saturation: f64,
}

impl<'a> Scene<'a> {
    /// A scene; what `extras` does not give is estimated from the pixels outside all sources.
    pub fn new(pixels: &'a [f32], labels: &'a [u32], width: usize, height: usize, extras: &Extras<'a>) -> Scene<'a> {
        let known = extras.background.is_some() && extras.noise.is_some();
        let (background, noise) = if known { (0.0, 0.0) } else { estimate(pixels, labels) };
        Scene {
            width,
            height,
            pixels,
            labels,
            background: extras.background.clone().unwrap_or(Level::Constant(background)),
            noise: extras.noise.clone().unwrap_or(Level::Constant(noise)),
            gain: extras.gain.filter(|&gain| gain > 0.0),
            saturation: extras.saturation.unwrap_or(f64::INFINITY),
        }
    }

    /// A pixel as it is.
    pub(super) fn pixel(&self, index: usize) -> f32 {
        self.pixels[index]
    }

    /// The value above the background of a defined pixel.
    pub(super) fn value(&self, index: usize) -> Option<f64> {
        let value = f64::from(self.pixels[index]) - self.background.at(index);
        (value.is_finite() && self.noise.at(index).is_finite()).then_some(value)
    }

    /// The value of a pixel that an aperture of source `label` may count, or why it may not.
    pub(super) fn value_for(&self, index: usize, label: u32) -> Result<f64, u32> {
        match self.labels[index] {
            other if other != 0 && other != label => Err(flags::NEIGHBOUR),
            _ => self.value(index).ok_or(flags::APERTURE),
        }
    }

    /// Variance of the background at a pixel.
    pub(super) fn variance(&self, index: usize) -> f64 {
        let sigma = self.noise.at(index);
        sigma * sigma
    }

    /// Whether a pixel reaches the saturation level.
    pub(super) fn saturated(&self, index: usize) -> bool {
        f64::from(self.pixels[index]) >= self.saturation
    }

    /// A flux with its error, from its sum and the sum of the background's variances.
    pub(super) fn flux(&self, value: f64, variance: f64) -> Flux {
        let photons = self.gain.map_or(0.0, |gain| value.max(0.0) / gain);
        Flux { value, error: (variance + photons).sqrt() }
    }

    /// What lies around a pixel of source `label`: flags, and whether it is on the outline.
    pub(super) fn around(&self, x: usize, y: usize, label: u32) -> u32 {
        let mut found = 0;
        for (dx, dy) in [(1, 0), (0, 1), (usize::MAX, 0), (0, usize::MAX)] {
            let (x, y) = (x.wrapping_add(dx), y.wrapping_add(dy));
            if x >= self.width || y >= self.height {
                found |= flags::TRUNCATED | OUTLINE;
                continue;
            }
            let index = y * self.width + x;
            found |= match self.labels[index] {
                same if same == label => 0,
                0 if self.value(index).is_none() => flags::MASKED | OUTLINE,
                0 => OUTLINE,
                _ => flags::BLENDED | OUTLINE,
            };
        }
        found
    }
}
