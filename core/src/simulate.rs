//! Simulated skies from a seed: the same pixels on every processor.
//!
//! Only integer hashing and the four basic operations on `f32`, so that a microcontroller makes
//! the very frame that the workstation makes. Stars are Moffat profiles with beta = 2, galaxies
//! elliptical profiles of the same family with longer wings; noise is a sum of uniform numbers.

use crate::run::frame::Frame;
use core::convert::Infallible;

/// What kind of sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// High signal to noise, a few bright objects that leave the rest dark.
    Bright,
    /// The same kind of field twelve times noisier and blurred.
    Noisy,
    /// Stars only, many of them.
    Stars,
}

/// A simulated sky; a [`Frame`] of any size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    kind: Kind,
    seed: u32,
    width: usize,
    height: usize,
    objects: u32,
}

/// One object of a sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// Centre, pixels.
    pub x: f32,
    /// Centre, pixels.
    pub y: f32,
    /// Value above the sky at the centre, without noise.
    pub peak: f32,
    /// Core radius along the major axis, pixels.
    pub radius: f32,
    /// Minor over major axis; 1 for a star.
    pub axis_ratio: f32,
    /// Direction of the major axis: cosine and sine of its angle to x.
    pub direction: (f32, f32),
    /// Whether the profile is a star's.
    pub star: bool,
}

/// Constants of a kind of sky.
struct Recipe {
    /// Pixels to one object.
    pixels_per_object: u32,
    /// Standard deviation of the noise.
    sigma: f32,
    /// Peaks lie between these, in units of sigma.
    peaks: (f32, f32),
    /// Core radius of a star, pixels.
    blur: f32,
    /// One object in so many is a galaxy; 0 for none.
    galaxies: u32,
}

impl Kind {
    const fn recipe(self) -> Recipe {
        match self {
            Kind::Bright => {
                Recipe { pixels_per_object: 1500, sigma: 8e-4, peaks: (6.0, 6000.0), blur: 1.8, galaxies: 3 }
            }
            Kind::Noisy => Recipe { pixels_per_object: 1500, sigma: 1e-2, peaks: (2.5, 500.0), blur: 2.6, galaxies: 3 },
            Kind::Stars => Recipe { pixels_per_object: 300, sigma: 10.0, peaks: (3.0, 3000.0), blur: 1.9, galaxies: 0 },
        }
    }
}

/// A hash of three numbers, well mixed (the finaliser of MurmurHash3 on a running value).
fn hash(seed: u32, a: u32, b: u32) -> u32 {
    let mut h = seed ^ 0x9E37_79B9;
    for word in [a, b] {
        h = (h ^ word).wrapping_mul(0x85EB_CA6B);
        h ^= h >> 13;
        h = h.wrapping_mul(0xC2B2_AE35);
        h ^= h >> 16;
    }
    h
}

/// Uniform in [0, 1), from the upper 24 bits.
fn uniform(hash: u32) -> f32 {
    (hash >> 8) as f32 / 16_777_216.0
}

/// Mean 0, variance 1: eight uniform numbers of 16 bits, |value| below 4.9.
fn gaussian(seed: u32, x: u32, y: u32) -> f32 {
    let mut sum = 0u32;
    for stream in 0..4u32 {
        let h = hash(seed.wrapping_add(stream.wrapping_mul(0x632B_E5AB)), x, y);
        sum = sum.wrapping_add((h & 0xFFFF).wrapping_add(h >> 16));
    }
    // The sum of 8 numbers uniform on 0..65535 has mean 4 * 65535 and deviation 65536 sqrt(8/12).
    (sum as f32 - 262_140.0) / 53_509.965
}

impl Sky {
    /// A sky of a kind; the same seed and size give the same pixels everywhere.
    pub fn new(kind: Kind, seed: u32, width: usize, height: usize) -> Sky {
        let pixels = u32::try_from(width.saturating_mul(height)).unwrap_or(u32::MAX);
        let objects = (pixels / kind.recipe().pixels_per_object).max(3);
        Sky { kind, seed, width, height, objects }
    }

    /// Number of objects.
    pub fn objects(&self) -> u32 {
        self.objects
    }

    /// Standard deviation of the noise.
    pub fn sigma(&self) -> f32 {
        self.kind.recipe().sigma
    }

    /// Object `index`, from 0.
    pub fn object(&self, index: u32) -> Object {
        let recipe = self.kind.recipe();
        let draw = |what: u32| uniform(hash(self.seed, index, what));
        let (low, high) = recipe.peaks;
        // Few bright, many faint: the peak falls off with the square of a uniform number.
        let u = draw(2);
        let peak = recipe.sigma * (low + (high - low) * (0.000_5 / (u * u + 0.000_5)));
        let star = recipe.galaxies == 0 || !index.is_multiple_of(recipe.galaxies);
        let (axis_ratio, radius) = if star {
            (1.0, recipe.blur)
        } else {
            (0.3 + 0.7 * draw(3), recipe.blur * (1.0 + 3.0 * draw(4) * draw(5)))
        };
        // A rational point of the circle: no sine needed.
        let t = 2.0 * draw(6) - 1.0;
        let direction = ((1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t));
        let (x, y) = (draw(0) * self.width as f32, draw(1) * self.height as f32);
        Object { x, y, peak, radius, axis_ratio, direction, star }
    }

    /// Adds the light of object `index` alone to row `y`; says whether it reaches that row.
    pub fn add_light(&self, index: u32, y: usize, row: &mut [f32]) -> bool {
        let object = self.object(index);
        let (distance, reach) = (y as f32 - object.y, object.reach(self.sigma()));
        let reached = distance <= reach && -distance <= reach;
        if reached {
            self.add(&object, y, row);
        }
        reached
    }

    /// Adds an object to row `y`.
    fn add(&self, object: &Object, y: usize, row: &mut [f32]) {
        let sigma = self.sigma();
        let reach = object.reach(sigma);
        let dy = y as f32 - object.y;
        if dy > reach || dy < -reach {
            return;
        }
        let first = if object.x > reach { (object.x - reach) as usize } else { 0 };
        let last = (object.x + reach) as usize;
        for (x, pixel) in row.iter_mut().enumerate().take(last.saturating_add(1)).skip(first) {
            *pixel += object.value(x as f32 - object.x, dy);
        }
    }
}

impl Object {
    /// Value above the sky at an offset from the centre, without noise.
    pub fn value(&self, dx: f32, dy: f32) -> f32 {
        let (cos, sin) = self.direction;
        let (along, across) = (dx * cos + dy * sin, (dy * cos - dx * sin) / self.axis_ratio);
        let r2 = (along * along + across * across) / (self.radius * self.radius);
        if self.star {
            let base = 1.0 + r2;
            self.peak / (base * base)
        } else {
            // Shallow in the middle, then steep: between a disc and a bulge.
            let base = 1.0 + 0.5 * r2;
            self.peak / (base * base * base)
        }
    }

    /// Beyond this distance, in pixels, the profile is below a hundredth of the noise, or is cut.
    fn reach(&self, sigma: f32) -> f32 {
        let mut reach = 4.0 * self.radius;
        for _ in 0..8 {
            if self.value(reach, 0.0) < 0.01 * sigma && self.value(0.0, reach) < 0.01 * sigma {
                break;
            }
            reach *= 1.5;
        }
        reach
    }
}

impl Frame for Sky {
    type Error = Infallible;

    /// Cost: one hash of four words per pixel, and each object near the row.
    fn row(&mut self, y: usize, out: &mut [f32]) -> Result<(), Infallible> {
        out.fill(0.0);
        for index in 0..self.objects {
            self.add(&self.object(index), y, out);
        }
        let (sigma, noise_seed) = (self.sigma(), hash(self.seed, 0x6E6F, 0x6973));
        for (x, pixel) in (0u32..).zip(out.iter_mut()) {
            *pixel += sigma * gaussian(noise_seed, x, y as u32);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_mean_zero_and_variance_one() {
        let n = 256u32;
        let values = (0..n * n).map(|i| f64::from(gaussian(7, i % n, i / n)));
        let (sum, squares) = values.fold((0.0, 0.0), |(s, q), v| (s + v, q + v * v));
        let count = f64::from(n * n);
        // Four standard errors of the mean and of the variance.
        let error = 1.0 / libm::sqrt(count);
        assert!((sum / count).abs() < 4.0 * error);
        assert!((squares / count - 1.0).abs() < 4.0 * 1.4 * error);
    }
}
