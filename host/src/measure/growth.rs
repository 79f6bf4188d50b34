//! The curve of growth of a source: the light of its Kron aperture within circles around the
//! centroid.

use super::Aperture;
use super::aperture::{CORNER, length};

/// The relative accuracy of a radius.
const ACCURACY: f64 = 1e-10;
/// Steps towards a radius; a handful is enough.
const STEPS: usize = 60;

/// Pixels around a centre by their distance, and the light up to each. One is filled again for
/// every source.
#[derive(Debug, Default)]
pub struct Growth {
    arrived: Vec<Pixel>,
    /// The same by whole pixels of distance.
    pixels: Vec<Pixel>,
    /// Where the pixels of each whole distance begin, and behind the last.
    starts: Vec<usize>,
    /// The light before each of them.
    before: Vec<f64>,
}

/// A pixel, relative to the centre.
#[derive(Clone, Copy, Debug, Default)]
struct Pixel {
    distance: f64,
    dx: f64,
    dy: f64,
    value: f64,
}

impl Growth {
    /// Forgets all pixels.
    pub fn clear(&mut self) {
        self.arrived.clear();
    }

    /// Takes in the light of a pixel.
    pub fn add(&mut self, dx: f64, dy: f64, value: f64) {
        self.arrived.push(Pixel { distance: length(dx, dy), dx, dy, value });
    }

    /// Puts the pixels in order. Cost: two passes.
    pub fn settle(&mut self) {
        let ring = |pixel: &Pixel| pixel.distance as usize;
        let rings = self.arrived.iter().map(ring).max().map_or(0, |last| last + 1);
        self.starts.clear();
        self.starts.resize(rings + 1, 0);
        self.before.clear();
        self.before.resize(rings + 1, 0.0);
        for pixel in &self.arrived {
            self.starts[ring(pixel) + 1] += 1;
            self.before[ring(pixel) + 1] += pixel.value;
        }
        for ring in 0..rings {
            self.starts[ring + 1] += self.starts[ring];
            self.before[ring + 1] += self.before[ring];
        }
        self.pixels.clear();
        self.pixels.resize(self.arrived.len(), Pixel::default());
        let mut next = self.starts.clone();
        for pixel in &self.arrived {
            let place = &mut next[ring(pixel)];
            self.pixels[*place] = *pixel;
            *place += 1;
        }
    }

    /// Light within a circle, by the exact area of the pixels it cuts.
    pub fn within(&self, radius: f64) -> f64 {
        if radius <= 0.0 {
            return 0.0;
        }
        let circle = Aperture::circle(0.0, 0.0, radius);
        let rings = self.starts.len() - 1;
        let whole = ((radius - CORNER).max(0.0) as usize).min(rings);
        let end = ((radius + CORNER) as usize + 1).min(rings);
        let cut = self.pixels[self.starts[whole]..self.starts[end]].iter();
        self.before[whole] + cut.map(|pixel| pixel.value * circle.share(pixel.dx, pixel.dy)).sum::<f64>()
    }

    /// The radius of the first circle with so much light, above 0; NaN where none has.
    pub fn radius_of(&self, light: f64) -> f64 {
        let Some(ring) = self.before.iter().position(|&sum| sum >= light) else { return f64::NAN };
        let missing = |radius: f64| self.within(radius) - light;
        let last = self.before.len() as f64 + 1.0;
        let mut high = ring as f64;
        while missing(high) < 0.0 {
            if high > last {
                return f64::NAN;
            }
            high += 1.0;
        }
        let mut low = (high - 1.0).max(0.0);
        while low > 0.0 && missing(low) >= 0.0 {
            (low, high) = ((low - 1.0).max(0.0), low);
        }
        crossing(missing, low, high)
    }
}

/// Where a function that is below 0 at `low` and not at `high` crosses 0, by the Illinois variant of
/// false position.
fn crossing(function: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let (mut at_low, mut at_high) = (function(low), function(high));
    let mut last_below = None;
    for _ in 0..STEPS {
        let guess = low - at_low * (high - low) / (at_high - at_low);
        let value = function(guess);
        let below = value < 0.0;
        let step = if below { guess - low } else { high - guess };
        match (below, last_below == Some(below)) {
            (true, again) => {
                (low, at_low) = (guess, value);
                at_high *= if again { 0.5 } else { 1.0 };
            }
            (false, again) => {
                (high, at_high) = (guess, value);
                at_low *= if again { 0.5 } else { 1.0 };
            }
        }
        if value == 0.0 || step <= ACCURACY * guess || high - low <= ACCURACY * high {
            return guess;
        }
        last_below = Some(below);
    }
    0.5 * (low + high)
}
