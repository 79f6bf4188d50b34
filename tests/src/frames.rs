//! Frames of a star camera, made from a seed: Gaussian stars sampled by pixels, photons, read-out, whole counts.

use skyfront_core::track::Camera;
use std::f64::consts::{PI, SQRT_2};

/// Random numbers (SplitMix64).
#[derive(Clone, Copy, Debug)]
pub struct Random(pub u64);

/// A star's light above the sky.
#[derive(Clone, Copy, Debug)]
pub struct Light {
    /// Column of the centre.
    pub x: f64,
    /// Row of the centre.
    pub y: f64,
    /// All of it, counts.
    pub flux: f64,
}

impl Random {
    /// In (0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 + 1e-17
    }

    /// Of mean 0 and variance 1.
    pub fn gaussian(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (2.0 * PI * self.uniform()).cos()
    }

    /// Photons where `mean` are expected; from 200 on by the nearest Gaussian.
    pub fn photons(&mut self, mean: f64) -> f64 {
        if mean > 200.0 {
            return (mean + mean.sqrt() * self.gaussian()).round().max(0.0);
        }
        let (end, mut product, mut count) = ((-mean).exp(), self.uniform(), 0.0);
        while product > end {
            product *= self.uniform();
            count += 1.0;
        }
        count
    }
}

/// The part of a star's light that falls into a pixel along an axis, and how it grows as the centre moves up.
pub fn along(distance: f64, sigma: f64) -> (f64, f64) {
    let cumulative = |x: f64| 0.5 * libm::erf(x / (sigma * SQRT_2));
    let density = |x: f64| (-0.5 * x * x / (sigma * sigma)).exp() / (sigma * (2.0 * PI).sqrt());
    (cumulative(distance + 0.5) - cumulative(distance - 0.5), density(distance - 0.5) - density(distance + 0.5))
}

/// A frame of stars on a level sky above the camera's black, in counts.
pub fn frame(side: usize, camera: &Camera, sky: f64, stars: &[Light], random: &mut Random) -> Vec<u16> {
    let (gain, sigma) = (f64::from(camera.gain), f64::from(camera.psf_sigma));
    let pixel = |at: usize| {
        let (x, y) = ((at % side) as f64, (at / side) as f64);
        let light = |star: &Light| star.flux * along(x - star.x, sigma).0 * along(y - star.y, sigma).0;
        let electrons = random.photons((sky + stars.iter().map(light).sum::<f64>()) * gain)
            + f64::from(camera.read_noise) * random.gaussian();
        (electrons / gain + f64::from(camera.black)).round().clamp(0.0, 65_535.0) as u16
    };
    (0..side * side).map(pixel).collect()
}

/// The least variances of column and row of a star in a frame (Cramer and Rao), flux unknown: Gaussian noise
/// with the variance of photons, read-out and rounding.
pub fn bound(side: usize, camera: &Camera, sky: f64, star: &Light) -> (f64, f64) {
    let (gain, sigma) = (f64::from(camera.gain), f64::from(camera.psf_sigma));
    let mut information = [[0.0; 3]; 3];
    for at in 0..side * side {
        let (light_x, growth_x) = along((at % side) as f64 - star.x, sigma);
        let (light_y, growth_y) = along((at / side) as f64 - star.y, sigma);
        let read = f64::from(camera.read_noise) / gain;
        let variance = read * read + 1.0 / 12.0 + (sky + star.flux * light_x * light_y) / gain;
        let slopes = [light_x * light_y, star.flux * growth_x * light_y, star.flux * light_x * growth_y];
        for (row, a) in information.iter_mut().zip(slopes) {
            row.iter_mut().zip(slopes).for_each(|(sum, b)| *sum += a * b / variance);
        }
    }
    let [[ff, fx, fy], [_, xx, xy], [_, _, yy]] = information;
    // The flux eliminated, then the other coordinate.
    let (xx, xy, yy) = (xx - fx * fx / ff, xy - fx * fy / ff, yy - fy * fy / ff);
    (1.0 / (xx - xy * xy / yy), 1.0 / (yy - xy * xy / xx))
}
