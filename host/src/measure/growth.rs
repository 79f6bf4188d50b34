//! The curve of growth of a source: the light of its Kron aperture within circles around the
//! centroid.

use super::Aperture;
use super::aperture::{CORNER, length};
use std::ops::Range;

/// The relative accuracy of a radius.
const ACCURACY: f64 = 1e-10;
/// Steps towards a radius; a handful is enough.
const STEPS: usize = 60;

/// The half-widths, in pixels, of the rings of pixels in which a radius is looked for in turn.
const WIDTHS: [usize; 3] = [2, 8, 64];

/// The light around a centre by whole pixels of distance, and single pixels where a radius is looked
/// for: memory grows with the radius, not with its square. One is filled again for every source.
#[derive(Debug, Default)]
pub struct Growth {
    /// The light of the pixels at less than each whole distance.
    before: Vec<f64>,
    /// The pixels of a ring.
    ring: Vec<Pixel>,
    /// The light of those nearer than all of the ring.
    inside: f64,
}

/// A pixel, relative to the centre.
#[derive(Clone, Copy, Debug)]
struct Pixel {
    distance: f64,
    dx: f64,
    dy: f64,
    value: f64,
}

impl Growth {
    /// Forgets all light.
    pub fn clear(&mut self) {
        self.before.clear();
        self.before.push(0.0);
    }

    /// Takes in the light of a pixel.
    pub fn add(&mut self, dx: f64, dy: f64, value: f64) {
        let behind = length(dx, dy) as usize + 1;
        if behind >= self.before.len() {
            self.before.resize(behind + 1, 0.0);
        }
        self.before[behind] += value;
    }

    /// Sums up what was taken in.
    pub fn settle(&mut self) {
        let mut sum = 0.0;
        for light in &mut self.before {
            sum += *light;
            *light = sum;
        }
    }

    /// The radius of the first circle with so much light, above 0, by the exact area of the pixels it
    /// cuts; NaN where none has. `between` tells the pixels of a range of distances again: column and
    /// row from the centre, and light.
    pub fn radius_of(&mut self, light: f64, mut between: impl FnMut(Range<f64>, &mut dyn FnMut(f64, f64, f64))) -> f64 {
        let Some(at) = self.before.iter().position(|&sum| sum >= light) else { return f64::NAN };
        for width in WIDTHS {
            let nearest = at.saturating_sub(width + 1);
            let Growth { before, ring, inside } = self;
            *inside = before[nearest];
            ring.clear();
            between(nearest as f64..(at + width + 1) as f64, &mut |dx, dy, value| {
                ring.push(Pixel { distance: length(dx, dy), dx, dy, value });
            });
            let radius = self.crossing(light, at.saturating_sub(width) as f64, at as f64, (at + width) as f64);
            if let Some(radius) = radius {
                return radius;
            }
        }
        f64::NAN
    }

    /// Light within a circle that ends in the ring.
    fn within(&self, radius: f64) -> f64 {
        if radius <= 0.0 {
            return 0.0;
        }
        let circle = Aperture::circle(0.0, 0.0, radius);
        let share = |pixel: &Pixel| {
            if pixel.distance <= radius - CORNER {
                pixel.value
            } else if pixel.distance < radius + CORNER {
                pixel.value * circle.share(pixel.dx, pixel.dy)
            } else {
                0.0
            }
        };
        self.inside + self.ring.iter().map(share).sum::<f64>()
    }

    /// The radius near `start` from which on a circle has so much light; none where it is not between
    /// `least` and `most`.
    fn crossing(&self, light: f64, least: f64, start: f64, most: f64) -> Option<f64> {
        let missing = |radius: f64| self.within(radius) - light;
        let at = |radius: f64| (radius, missing(radius));
        let mut high = at(start);
        while high.1 < 0.0 {
            high = at(high.0 + 1.0);
            if high.0 > most {
                return None;
            }
        }
        let mut low = at((high.0 - 1.0).max(0.0));
        while low.0 > 0.0 && low.1 >= 0.0 {
            (low, high) = (at((low.0 - 1.0).max(0.0)), low);
            if low.0 < least {
                return None;
            }
        }
        Some(crossing(missing, low, high))
    }
}

/// Where a function that is below 0 at `low` and not at `high`, both with their values, crosses 0, by the Illinois
/// variant of false position.
fn crossing(
    function: impl Fn(f64) -> f64,
    (mut low, mut at_low): (f64, f64),
    (mut high, mut at_high): (f64, f64),
) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A growth of which the circle with the radius 2 has this light, and all around it is dark.
    fn within_two(light: f64) -> Growth {
        let pixel = |(dx, dy): (f64, f64)| Pixel { distance: length(dx, dy), dx, dy, value: light / 4.0 };
        let ring = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(pixel).to_vec();
        Growth { ring, ..Growth::default() }
    }

    #[test]
    fn a_radius_is_looked_for_up_to_the_greatest_itself() {
        let growth = within_two(4.0);
        // The corners of the pixels reach as far as 2.121.
        let radius = growth.crossing(3.5, 0.0, 1.0, 2.0).expect("one below 2");
        assert!((growth.within(radius) - 3.5).abs() < 1e-8, "{radius}");
        assert_eq!(growth.crossing(3.5, 0.0, 1.0, 1.9), None);
        assert_eq!(growth.crossing(4.1, 0.0, 1.0, 2.0), None);
    }

    /// Both ends are kept in turn: each function bends the other way.
    #[test]
    fn a_crossing_is_found_in_a_few_steps_however_the_function_bends() {
        type Function = fn(f64) -> f64;
        let bends: [(Function, f64); 4] = [
            (|x| 1e-3 * (x * x * x - 0.5), libm::cbrt(0.5)),
            (|x| 1e-3 * (0.5 - (1.0 - x) * (1.0 - x) * (1.0 - x)), 1.0 - libm::cbrt(0.5)),
            (|x| 1e3 * (libm::exp(5.0 * x) - 2.0), 0.2 * libm::log(2.0)),
            (|x| x - 0.25, 0.25),
        ];
        for (function, expected) in bends {
            let calls = std::cell::Cell::new(0);
            let counted = |x: f64| {
                calls.set(calls.get() + 1);
                function(x)
            };
            let found = crossing(counted, (0.0, function(0.0)), (1.0, function(1.0)));
            assert!((found / expected - 1.0).abs() < 1e-9, "{found}, not {expected}");
            assert!(calls.get() <= 15, "{} steps to {expected}", calls.get());
        }
    }
}
