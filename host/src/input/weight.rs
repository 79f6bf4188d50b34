//! From a weight map to the noise of every pixel.

use crate::background::SkyMaps;
use crate::measure::clipped_scatter;
use crate::read::Image;

/// What the values of a weight map are.
///
/// ```
/// use skyfront::input::WeightType;
/// use skyfront::truth::simulated;
/// use skyfront_core::simulate::Kind;
///
/// let (image, _) = simulated(Kind::Noisy, 1, 8, 8);
/// assert_eq!(WeightType::Variance.noise(&[9.0; 64], &image)[0], 3.0);
/// assert!(WeightType::Weight.is_relative() && !WeightType::Variance.is_relative());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum WeightType {
    /// Standard deviations, in units of the image.
    Rms,
    /// Variances, in squared units of the image.
    Variance,
    /// Inverse variances up to a factor, which is measured on the sky.
    Weight,
}

impl WeightType {
    /// Every type.
    pub const ALL: [WeightType; 3] = [WeightType::Rms, WeightType::Variance, WeightType::Weight];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            WeightType::Rms => "rms",
            WeightType::Variance => "variance",
            WeightType::Weight => "weight",
        }
    }

    /// The standard deviation for a value of the map, for `Weight` up to the factor; NaN where the
    /// pixel must not be used.
    fn sigma(self, value: f32) -> f32 {
        let sigma = match self {
            WeightType::Rms => value,
            WeightType::Variance => value.sqrt(),
            WeightType::Weight => value.sqrt().recip(),
        };
        if sigma.is_finite() && sigma > 0.0 { sigma } else { f32::NAN }
    }

    /// Whether the values only say which pixels are noisier than others; those of the other types
    /// are what they say.
    pub fn is_relative(self) -> bool {
        self == WeightType::Weight
    }

    /// The noise of every pixel of an image, in its units; NaN where the map forbids a pixel.
    pub fn noise(self, map: &[f32], image: &Image) -> Vec<f32> {
        let mut noise: Vec<f32> = map.iter().map(|&value| self.sigma(value)).collect();
        if self.is_relative() {
            let factor = sky_scatter(image, &noise) as f32;
            noise.iter_mut().for_each(|sigma| *sigma *= factor);
        }
        noise
    }
}

/// How far the pixels scatter around the sky, in units of a relative noise; 1 where they do not.
fn sky_scatter(image: &Image, noise: &[f32]) -> f64 {
    let sky = SkyMaps::measure(&image.pixels, &[], image.width);
    let pull = |((&pixel, &level), &sigma): ((&f32, &f32), &f32)| f64::from(pixel - level) / f64::from(sigma);
    let scatter = clipped_scatter(image.pixels.iter().zip(&sky.level).zip(noise).map(pull)).1;
    if scatter > 0.0 { scatter } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_gives_the_same_noise() {
        let image = crate::truth::simulated(skyfront_core::simulate::Kind::Bright, 1, 64, 64).0;
        let map = |value: f32| vec![value, 0.0, -1.0, f32::NAN, f32::INFINITY];
        for (kind, value) in [(WeightType::Rms, 2.0), (WeightType::Variance, 4.0)] {
            let noise = kind.noise(&map(value), &image);
            assert_eq!(noise[0], 2.0);
            assert!(!kind.is_relative(), "{kind:?} is what it says");
            assert!(noise[1..].iter().all(|sigma| sigma.is_nan()), "{kind:?} {noise:?}");
        }
    }

    #[test]
    fn relative_weights_are_scaled_to_the_sky() {
        let (mut image, sky) = crate::truth::simulated(skyfront_core::simulate::Kind::Bright, 1, 128, 128);
        // The right half three times as noisy, around its own sky.
        let level = 0.0;
        let weights: Vec<f32> = (0..image.pixels.len()).map(|at| if at % 128 < 64 { 9.0 } else { 1.0 }).collect();
        for (pixel, weight) in image.pixels.iter_mut().zip(&weights) {
            *pixel = (*pixel - level) * 3.0 / weight.sqrt();
        }
        let noise = WeightType::Weight.noise(&weights, &image);
        let (quiet, loud) = (noise[0] / sky.sigma(), noise[127] / sky.sigma());
        assert!((loud / quiet - 3.0).abs() < 1e-5 && (0.9..1.15).contains(&quiet), "{quiet} {loud}");
    }
}
