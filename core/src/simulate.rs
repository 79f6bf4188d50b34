//! Simulated skies from a seed: the same pixels on every processor.
//!
//! Only integer hashing and the four basic operations on `f32`, so that a microcontroller makes
//! the very frame that the workstation makes. Stars are Moffat profiles with beta = 2, galaxies
//! elliptical profiles of the same family with longer wings; noise is a sum of uniform numbers.
//! [`Conditions`] are what a real telescope and camera make of such a sky.
//!
//! ```
//! use skyfront_core::run::frame::Frame;
//! use skyfront_core::simulate::{Conditions, Kind, Optics, Sky};
//!
//! let conditions = Conditions { optics: Optics::Coma, full_well: 500.0, ..Conditions::PERFECT };
//! let mut sky = Sky::new(Kind::Stars, 1, 64, 64).under(conditions)?;
//! let mut row = [0.0; 64];
//! let Ok(()) = sky.row(20, &mut row);
//! assert!(row.iter().all(|&pixel| pixel <= 500.0 * sky.sigma()));
//! # Ok::<(), skyfront_core::error::Error>(())
//! ```

use crate::error::Error;
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

/// What optics make of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Optics {
    /// A round core with wings.
    #[default]
    Round,
    /// A head with a tail that points away from the middle of the frame and grows with the distance from there: up to
    /// four core radii half a frame away.
    Coma,
    /// A line twelve core radii long: the telescope moved.
    Trail,
    /// A ring of two and a half core radii: the focus is off.
    Ring,
}

/// What a telescope and a camera make of a sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// The shape of a point.
    pub optics: Optics,
    /// Galaxies have up to three times as much light on one side as opposite, where nothing else changes their shape.
    pub lopsided: bool,
    /// How much brighter the sky is in the last column than in the first, in noise units.
    pub gradient: f32,
    /// No pixel is brighter, in noise units; what a star has beyond it bleeds along its column. Infinite for no bound.
    pub full_well: f32,
    /// The distance of two values, in noise units; 0 for as many as there are numbers.
    pub step: f32,
}

impl Conditions {
    /// As the sky is.
    pub const PERFECT: Conditions =
        Conditions { optics: Optics::Round, lopsided: false, gradient: 0.0, full_well: f32::INFINITY, step: 0.0 };

    /// Whether a sky can be seen so.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a gradient beyond 1e6 up or down, a full well of 0 or less, and a step below 0 or above
    /// 1e6; NaN is none of these numbers.
    pub fn validate(&self) -> Result<(), Error> {
        let Conditions { gradient, full_well, step, .. } = *self;
        let bounds = [
            ("gradient", gradient, gradient >= -MOST, "at least", -MOST),
            ("gradient", gradient, gradient <= MOST, "at most", MOST),
            ("full_well", full_well, full_well > 0.0, "above", 0.0),
            ("step", step, step >= 0.0, "at least", 0.0),
            ("step", step, step <= MOST, "at most", MOST),
        ];
        let refused = bounds.into_iter().find(|(_, _, holds, _, _)| !holds);
        refused.map_or(Ok(()), |(name, value, _, bound, limit)| Err(Error::Parameter { name, value, bound, limit }))
    }
}

/// The most noise units of a gradient or a step.
const MOST: f32 = 1e6;

/// A part of the image of a point: where it lies, and its share of the light.
struct Part {
    along: f32,
    across: f32,
    share: f32,
}

const fn part(along: f32, across: f32, share: f32) -> Part {
    Part { along, across, share }
}

const ROUND: [Part; 1] = [part(0.0, 0.0, 1.0)];
const COMA: [Part; 6] = [
    part(0.0, 0.0, 0.4),
    part(0.2, 0.0, 0.22),
    part(0.4, 0.0, 0.15),
    part(0.6, 0.0, 0.1),
    part(0.8, 0.0, 0.08),
    part(1.0, 0.0, 0.05),
];
const TRAIL: [Part; 8] = [
    part(-1.0, 0.0, 0.125),
    part(-0.714, 0.0, 0.125),
    part(-0.429, 0.0, 0.125),
    part(-0.143, 0.0, 0.125),
    part(0.143, 0.0, 0.125),
    part(0.429, 0.0, 0.125),
    part(0.714, 0.0, 0.125),
    part(1.0, 0.0, 0.125),
];
const TWELFTH: f32 = 1.0 / 12.0;
/// Points of the circle with rational places, nearly evenly.
const RING: [Part; 12] = [
    part(1.0, 0.0, TWELFTH),
    part(0.8, 0.6, TWELFTH),
    part(0.6, 0.8, TWELFTH),
    part(0.0, 1.0, TWELFTH),
    part(-0.6, 0.8, TWELFTH),
    part(-0.8, 0.6, TWELFTH),
    part(-1.0, 0.0, TWELFTH),
    part(-0.8, -0.6, TWELFTH),
    part(-0.6, -0.8, TWELFTH),
    part(0.0, -1.0, TWELFTH),
    part(0.6, -0.8, TWELFTH),
    part(0.8, -0.6, TWELFTH),
];
/// Core radii from the head of a coma to the end of its tail, half a frame from the middle.
const COMA_RADII: f32 = 4.0;
/// From the middle of a trail to its ends.
const TRAIL_RADII: f32 = 6.0;
/// From the middle of a ring.
const RING_RADII: f32 = 2.5;
/// Half the difference of a lopsided galaxy's sides, in their mean.
const LOPSIDED: f32 = 0.5;
/// A star bleeds so many core radii along its column for each full well beyond the first, and ...
const BLEED_RADII: f32 = 1.0;
/// ... so many at most.
const MOST_BLEED_RADII: f32 = 30.0;

/// A simulated sky; a [`Frame`] of any size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    kind: Kind,
    conditions: Conditions,
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
        Sky { kind, conditions: Conditions::PERFECT, seed, width, height, objects }
    }

    /// The same sky as other conditions show it.
    ///
    /// # Errors
    /// What [`Conditions::validate`] refuses.
    pub fn under(self, conditions: Conditions) -> Result<Sky, Error> {
        conditions.validate()?;
        Ok(Sky { conditions, ..self })
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

    /// Adds the light of object `index` alone to row `y`, that which bleeds too; says whether it reaches that row.
    pub fn add_light(&self, index: u32, y: usize, row: &mut [f32]) -> bool {
        self.add(&self.object(index), y, row)
    }

    /// Adds an object to row `y`; says whether it reaches that row.
    fn add(&self, object: &Object, y: usize, row: &mut [f32]) -> bool {
        let (parts, axis) = self.optics(object);
        let spread = magnitude(axis.0) + magnitude(axis.1);
        let reach = object.reach(self.sigma()) + spread;
        let dy = y as f32 - object.y;
        let is_near = dy <= reach && -dy <= reach;
        if is_near {
            for (x, pixel) in columns(row, object.x, reach) {
                let dx = x as f32 - object.x;
                for Part { along, across, share } in parts {
                    let (right, up) = (along * axis.0 - across * axis.1, along * axis.1 + across * axis.0);
                    *pixel += share * self.profile(object, dx - right, dy - up);
                }
            }
        }
        let bleed = self.bleed(object);
        let bleeds = magnitude(dy) < bleed;
        if bleeds {
            let full = self.conditions.full_well * self.sigma();
            columns(row, object.x, 1.0).for_each(|(_, pixel)| *pixel += full);
        }
        is_near || bleeds
    }

    /// The parts of an object's image, and the way from its centre that those with the place (1, 0) are away.
    fn optics(&self, object: &Object) -> (&'static [Part], (f32, f32)) {
        let radius = self.kind.recipe().blur;
        let half = 0.5 * if self.width > self.height { self.width } else { self.height }.max(1) as f32;
        let from_middle = |at: f32, length: usize| (at - 0.5 * length as f32) / half;
        match self.conditions.optics {
            Optics::Round => (&ROUND, (0.0, 0.0)),
            Optics::Coma => {
                let tail = COMA_RADII * radius;
                (&COMA, (tail * from_middle(object.x, self.width), tail * from_middle(object.y, self.height)))
            }
            Optics::Trail => (&TRAIL, (0.8 * TRAIL_RADII * radius, 0.6 * TRAIL_RADII * radius)),
            Optics::Ring => (&RING, (RING_RADII * radius, 0.0)),
        }
    }

    /// An object's profile before the optics.
    fn profile(&self, object: &Object, dx: f32, dy: f32) -> f32 {
        let light = object.value(dx, dy);
        if object.star || !self.conditions.lopsided {
            return light;
        }
        let along = dx * object.direction.0 + dy * object.direction.1;
        light * (1.0 + LOPSIDED * along / (object.radius + magnitude(along)))
    }

    /// How far a star bleeds along its column; 0 for what does not.
    fn bleed(&self, object: &Object) -> f32 {
        let excess = object.peak / (self.conditions.full_well * self.sigma()) - 1.0;
        if !object.star || excess <= 0.0 {
            return 0.0;
        }
        let radii = BLEED_RADII * excess;
        object.radius * if radii < MOST_BLEED_RADII { radii } else { MOST_BLEED_RADII }
    }

    /// What the camera makes of a pixel in column `x`.
    fn read_out(&self, pixel: f32, x: usize) -> f32 {
        let Conditions { gradient, full_well, step, .. } = self.conditions;
        let (sigma, last) = (self.sigma(), self.width.saturating_sub(1).max(1));
        let above = if gradient == 0.0 { pixel } else { pixel + sigma * gradient * (x as f32 / last as f32) };
        let full = full_well * sigma;
        let kept = if above < full { above } else { full };
        if step > 0.0 { step * sigma * libm::rintf(kept / (step * sigma)) } else { kept }
    }
}

/// The pixels of a row that are at most so far from a place.
fn columns(row: &mut [f32], place: f32, distance: f32) -> impl Iterator<Item = (usize, &mut f32)> {
    let first = if place > distance { (place - distance) as usize } else { 0 };
    let last = (place + distance) as usize;
    row.iter_mut().enumerate().take(last.saturating_add(1)).skip(first)
}

fn magnitude(value: f32) -> f32 {
    if value < 0.0 { -value } else { value }
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
            self.add_light(index, y, out);
        }
        let (sigma, noise_seed) = (self.sigma(), hash(self.seed, 0x6E6F, 0x6973));
        for (x, pixel) in out.iter_mut().enumerate() {
            *pixel = self.read_out(*pixel + sigma * gaussian(noise_seed, x as u32, y as u32), x);
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

    const SIDE: usize = 96;

    extern crate std;
    use std::vec::Vec;

    fn seen(sky: Sky, conditions: Conditions) -> Sky {
        sky.under(conditions).expect("it can be seen so")
    }

    #[test]
    fn what_cannot_be_is_refused_by_name() {
        let perfect = Conditions::PERFECT;
        let refused = [
            ("gradient", Conditions { gradient: f32::NAN, ..perfect }),
            ("gradient", Conditions { gradient: 2e6, ..perfect }),
            ("gradient", Conditions { gradient: -2e6, ..perfect }),
            ("full_well", Conditions { full_well: f32::NAN, ..perfect }),
            ("full_well", Conditions { full_well: 0.0, ..perfect }),
            ("step", Conditions { step: f32::NAN, ..perfect }),
            ("step", Conditions { step: -0.5, ..perfect }),
            ("step", Conditions { step: f32::INFINITY, ..perfect }),
        ];
        for (wanted, conditions) in refused {
            let refusal = Sky::new(Kind::Stars, 3, SIDE, SIDE).under(conditions);
            assert!(matches!(refusal, Err(Error::Parameter { name, .. }) if name == wanted), "{conditions:?}");
        }
        for gradient in [-1e6, 1e6] {
            assert_eq!(Conditions { gradient, step: 1e6, ..perfect }.validate(), Ok(()));
        }
    }

    fn pixels(kind: Kind, conditions: Conditions) -> Vec<f32> {
        let mut sky = seen(Sky::new(kind, 3, SIDE, SIDE), conditions);
        let mut pixels = std::vec![0.0; SIDE * SIDE];
        for (y, row) in pixels.chunks_exact_mut(SIDE).enumerate() {
            let Ok(()) = sky.row(y, row);
        }
        pixels
    }

    /// The light of an object alone, and its first and second moments about its centre along both axes.
    fn moments(sky: &Sky, index: u32) -> ([f32; 3], [f32; 2]) {
        let object = sky.object(index);
        let ([mut light, mut right, mut up], mut squares) = ([0.0; 3], [0.0; 2]);
        for y in 0..SIDE {
            let mut row = [0.0; SIDE];
            sky.add_light(index, y, &mut row);
            for (x, value) in row.into_iter().enumerate() {
                let (dx, dy) = (x as f32 - object.x, y as f32 - object.y);
                (light, right, up) = (light + value, right + value * dx, up + value * dy);
                (squares[0], squares[1]) = (squares[0] + value * dx * dx, squares[1] + value * dy * dy);
            }
        }
        ([light, right / light, up / light], squares.map(|square| square / light))
    }

    /// A star well inside the frame and away from its middle.
    fn inner(sky: &Sky) -> u32 {
        let is_inner = |at: f32| (25.0..40.0).contains(&at);
        let found = (0..1000).find(|&index| is_inner(sky.object(index).x) && is_inner(sky.object(index).y));
        found.expect("one of many")
    }

    #[test]
    fn optics_keep_the_light_and_change_its_shape() {
        let round = Sky::new(Kind::Stars, 3, SIDE, SIDE);
        let index = inner(&round);
        let ([light, right, up], [wide, high]) = moments(&round, index);
        assert!(magnitude(right) < 0.3 && magnitude(up) < 0.3 && (wide / high - 1.0).abs() < 0.2);
        let shaped = |optics| moments(&seen(round, Conditions { optics, ..Conditions::PERFECT }), index);
        for optics in [Optics::Coma, Optics::Trail, Optics::Ring] {
            let ([shaped, ..], _) = shaped(optics);
            assert!((shaped / light - 1.0).abs() < 0.1, "{optics:?}: {shaped}, not {light}");
        }
        let ([_, right, up], _) = shaped(Optics::Coma);
        assert!(right < -0.3 && up < -0.3, "away from the middle: {right}, {up}");
        let (_, [trailed, _]) = shaped(Optics::Trail);
        assert!(trailed > wide + 20.0, "{trailed} along, {wide} of a round star");
        let middle = |optics| {
            let (sky, object) = (seen(round, Conditions { optics, ..Conditions::PERFECT }), round.object(index));
            let mut row = [0.0; SIDE];
            sky.add_light(index, object.y as usize, &mut row);
            row[object.x as usize]
        };
        assert!(middle(Optics::Ring) < 0.2 * middle(Optics::Round));
    }

    #[test]
    fn a_lopsided_galaxy_has_its_light_on_one_side() {
        let even = Sky::new(Kind::Bright, 3, SIDE, SIDE);
        let lopsided = seen(even, Conditions { lopsided: true, ..Conditions::PERFECT });
        let galaxy = (0..300).find(|&n| {
            !even.object(n).star && (30.0..60.0).contains(&even.object(n).x) && (30.0..60.0).contains(&even.object(n).y)
        });
        let index = galaxy.expect("one of a hundred");
        let along = |sky: &Sky| {
            let ([_, right, up], _) = moments(sky, index);
            right * even.object(index).direction.0 + up * even.object(index).direction.1
        };
        assert!(along(&lopsided) > along(&even) + 0.3, "{} and {}", along(&lopsided), along(&even));
    }

    #[test]
    fn a_full_well_bleeds_along_the_column() {
        let kind = Kind::Stars;
        let (sky, full_well) = (Sky::new(kind, 3, SIDE, SIDE), 100.0);
        let full = full_well * sky.sigma();
        let pixels = pixels(kind, Conditions { full_well, ..Conditions::PERFECT });
        assert!(pixels.iter().all(|&pixel| pixel <= full), "no pixel is brighter");
        let brightest = (0..sky.objects()).max_by(|&a, &b| sky.object(a).peak.total_cmp(&sky.object(b).peak));
        let star = sky.object(brightest.expect("there are stars"));
        assert!(star.peak > 2.0 * full, "a star of {} for {full}", star.peak);
        let column = star.x as usize;
        let longest = |along: &mut dyn Iterator<Item = f32>| {
            along.fold((0, 0), |(run, most), v| if v >= full { (run + 1, most.max(run + 1)) } else { (0, most) }).1
        };
        let trail = longest(&mut (0..SIDE).map(|y| pixels[y * SIDE + column]));
        let row = star.y as usize;
        let width = longest(&mut (0..SIDE).map(|x| pixels[row * SIDE + x]));
        assert!(trail > width + 2, "{trail} along the column, {width} along the row");
    }

    #[test]
    fn gradient_and_step_are_the_camera_s() {
        let (kind, step) = (Kind::Noisy, 0.5);
        let perfect = pixels(kind, Conditions::PERFECT);
        let sigma = Sky::new(kind, 3, SIDE, SIDE).sigma();
        let sloped = pixels(kind, Conditions { gradient: 10.0, ..Conditions::PERFECT });
        for (at, (sloped, perfect)) in sloped.iter().zip(&perfect).enumerate() {
            let rise = 10.0 * sigma * (at % SIDE) as f32 / (SIDE - 1) as f32;
            assert!((sloped - perfect - rise).abs() < 1e-4 * sigma.max(*perfect));
        }
        let stepped = pixels(kind, Conditions { step, ..Conditions::PERFECT });
        for (stepped, perfect) in stepped.iter().zip(&perfect) {
            let steps = stepped / (step * sigma);
            assert!((steps - libm::rintf(steps)).abs() < 1e-3 && (stepped - perfect).abs() <= 0.51 * step * sigma);
        }
        assert!(stepped.iter().zip(&perfect).any(|(stepped, perfect)| stepped != perfect));
    }
}
