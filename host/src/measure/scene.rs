//! The image as measurements see it: values above the background, their variance, and neighbours.

use super::{Extras, Flux, Level, estimate};
use skyfront_core::sources::flags;
use skyfront_core::sources::measure::variance_with;
use std::ops::Range;

/// Not a flag of a source: the pixel lies along its outline.
pub(super) const OUTLINE: u32 = 1 << 31;

/// What an aperture counts where it meets the pixels of other sources.
///
/// ```
/// use skyfront::measure::{Aperture, Extras, Level, Neighbours, Scene};
///
/// // A neighbour of 100 lies two columns to the right of a faint source.
/// let (mut pixels, mut labels) = ([1.0; 49], [0; 49]);
/// (pixels[26], labels[26], labels[24]) = (100.0, 2, 1);
/// let light = |neighbours| {
///     let (background, noise) = (Some(Level::Constant(0.0)), Some(Level::Constant(1.0)));
///     let extras = Extras { background, noise, neighbours, ..Extras::default() };
///     let scene = Scene::new(&pixels, &labels, 7, 7, &extras);
///     Aperture::circle(3.0, 3.0, 3.0).flux(&scene, 1).0.value
/// };
/// let [correct, mask, keep] = Neighbours::ALL.map(light);
/// assert!((correct - mask - 1.0).abs() < 1e-9 && (keep - correct - 99.0).abs() < 1e-9);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Neighbours {
    /// The light of the pixel opposite to the aperture's centre, as SExtractor's `CORRECT`; nothing
    /// where that one cannot serve either. Undefined pixels are replaced in the same way.
    #[default]
    Correct,
    /// Nothing.
    Mask,
    /// Their light.
    Keep,
}

impl Neighbours {
    /// Every way, the default first.
    pub const ALL: [Neighbours; 3] = [Neighbours::Correct, Neighbours::Mask, Neighbours::Keep];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Neighbours::Correct => "correct",
            Neighbours::Mask => "mask",
            Neighbours::Keep => "keep",
        }
    }
}

/// A pixel, and its place from the centre of an aperture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// Column.
    pub x: usize,
    /// Row.
    pub y: usize,
    /// Columns from the centre.
    pub dx: f64,
    /// Rows from the centre.
    pub dy: f64,
}

/// What a pixel counts in an aperture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Light {
    /// Above the background.
    pub value: f64,
    /// Variance of the background.
    pub variance: f64,
    /// What is to be told of it.
    pub flags: u32,
}

/// Pixels and labels of one shape, row-major, with background and noise.
#[derive(Debug)]
pub struct Scene<'a> {
    /// Columns.
    pub width: usize,
    /// Rows that are there, by their number in the image.
    pub rows: Range<usize>,
    pixels: &'a [f32],
    pub(super) labels: &'a [u32],
    /// Background in use.
    pub background: Level<'a>,
    /// Noise in use.
    pub noise: Level<'a>,
    gain: Option<f64>,
    saturation: f64,
    neighbours: Neighbours,
}

impl<'a> Scene<'a> {
    /// A scene; what `extras` does not give is estimated from the pixels outside all sources.
    pub fn new(pixels: &'a [f32], labels: &'a [u32], width: usize, height: usize, extras: &Extras<'a>) -> Scene<'a> {
        let known = extras.background.is_some() && extras.noise.is_some();
        let (background, noise) = if known { (0.0, 0.0) } else { estimate(pixels, labels) };
        Scene {
            width,
            rows: extras.first_row..extras.first_row + height,
            pixels,
            labels,
            background: extras.background.clone().unwrap_or(Level::Constant(background)),
            noise: extras.noise.clone().unwrap_or(Level::Constant(noise)),
            gain: extras.gain.filter(|&gain| gain > 0.0),
            saturation: extras.saturation.unwrap_or(f64::INFINITY),
            neighbours: extras.neighbours,
        }
    }

    /// The label of the pixel around a place; 0 outside the image.
    pub(super) fn label_at(&self, x: f64, y: f64) -> u32 {
        let (column, row) = (x.round(), y.round());
        let inside = column >= 0.0 && row >= 0.0 && column < self.width as f64 && self.rows.contains(&(row as usize));
        if inside { self.labels[self.index(column as usize, row as usize)] } else { 0 }
    }

    /// The index of a pixel, by its column and row in the image.
    #[inline(always)]
    pub(super) fn index(&self, x: usize, y: usize) -> usize {
        (y - self.rows.start) * self.width + x
    }

    /// A pixel as it is.
    pub(super) fn pixel(&self, index: usize) -> f32 {
        self.pixels[index]
    }

    /// The value above the background of a defined pixel.
    pub(super) fn value(&self, index: usize) -> Option<f64> {
        self.defined(index).map(|light| light.value)
    }

    /// The value of a defined pixel that belongs to no source, background included.
    pub(super) fn sky_pixel(&self, index: usize) -> Option<f64> {
        let free = self.labels[index] == 0 && self.value(index).is_some();
        free.then(|| f64::from(self.pixels[index]))
    }

    /// What a pixel counts in an aperture of source `label`, or the flag that says why it counts nothing.
    #[inline(always)]
    pub(super) fn light(&self, spot: Spot, label: u32) -> Result<Light, u32> {
        self.own(self.index(spot.x, spot.y), label).or_else(|why| self.replaced(spot, label, why))
    }

    /// What counts in place of a pixel that does not, and why.
    #[inline(never)]
    fn replaced(&self, spot: Spot, label: u32, why: u32) -> Result<Light, u32> {
        let index = self.index(spot.x, spot.y);
        let replaced = match self.neighbours {
            Neighbours::Mask => None,
            Neighbours::Keep => self.defined(index),
            Neighbours::Correct => self.opposite(spot).and_then(|index| self.own(index, label).ok()),
        };
        replaced.map(|light| Light { flags: why, ..light }).ok_or(why)
    }

    /// The light of a pixel that belongs to the source or to the sky and is defined.
    #[inline(always)]
    fn own(&self, index: usize, label: u32) -> Result<Light, u32> {
        match self.labels[index] {
            other if other != 0 && other != label => Err(flags::NEIGHBOUR),
            _ => self.defined(index).ok_or(flags::APERTURE),
        }
    }

    /// The light of a defined pixel.
    #[inline(always)]
    pub(super) fn defined(&self, index: usize) -> Option<Light> {
        let sigma = self.noise.at(index);
        let value = f64::from(self.pixels[index]) - self.background.at(index);
        (value.is_finite() && sigma.is_finite()).then_some(Light { value, variance: sigma * sigma, flags: 0 })
    }

    /// The pixel on the other side of the centre.
    fn opposite(&self, spot: Spot) -> Option<usize> {
        let mirrored = |at: usize, from: f64, within: &Range<usize>| {
            let place = at as i64 as f64 - 2.0 * from;
            // Rounded as it is made whole: a call for every pixel would take longer than all else.
            let rounded = (place > -0.5 && place < within.end as f64).then_some((place + 0.5) as i64 as usize);
            rounded.filter(|place| within.contains(place))
        };
        Some(self.index(mirrored(spot.x, spot.dx, &(0..self.width))?, mirrored(spot.y, spot.dy, &self.rows)?))
    }

    /// Whether a pixel reaches the saturation level.
    pub(super) fn saturated(&self, index: usize) -> bool {
        f64::from(self.pixels[index]) >= self.saturation
    }

    /// Electrons in a unit of the image, where they are known.
    pub(super) fn gain(&self) -> Option<f64> {
        self.gain
    }

    /// Variance of a pixel: that of the background, and of the light in it.
    pub(super) fn variance_with(&self, variance: f64, value: f64) -> f64 {
        variance_with(self.gain, variance, value)
    }

    /// A flux with its error, from its sum and the sum of the background's variances.
    pub(super) fn flux(&self, value: f64, variance: f64) -> Flux {
        Flux { value, error: self.variance_with(variance, value).sqrt() }
    }

    /// What lies around a pixel of source `label`: flags, and whether it is on the outline.
    pub(super) fn around(&self, x: usize, y: usize, label: u32) -> u32 {
        let inner = x > 0 && x + 1 < self.width && y > self.rows.start && y + 1 < self.rows.end;
        let at = self.index(x, y);
        if inner && [at - 1, at + 1, at - self.width, at + self.width].iter().all(|&at| self.labels[at] == label) {
            return 0;
        }
        let mut found = 0;
        for (dx, dy) in [(1, 0), (0, 1), (usize::MAX, 0), (0, usize::MAX)] {
            let (x, y) = (x.wrapping_add(dx), y.wrapping_add(dy));
            if x >= self.width || !self.rows.contains(&y) {
                found |= flags::TRUNCATED | OUTLINE;
                continue;
            }
            let index = self.index(x, y);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outside_the_image_is_no_label() {
        let extras = Extras { first_row: 10, ..Extras::default() };
        let scene = Scene::new(&[1.0; 12], &[5; 12], 4, 3, &extras);
        for (x, y) in [(0.0, 10.0), (-0.4, 9.6), (3.4, 12.4)] {
            assert_eq!(scene.label_at(x, y), 5, "at {x}, {y}");
        }
        for (x, y) in [(-0.6, 11.0), (3.6, 11.0), (1.0, 9.4), (1.0, 12.6), (1.0, -11.0), (f64::NAN, 11.0)] {
            assert_eq!(scene.label_at(x, y), 0, "at {x}, {y}");
        }
    }
}
