//! What the pixels of a segment tell: flux, centroid, second moments, and where it stands.

use super::{Flux, Scene};
use skyfront_core::catalog::Source;
use skyfront_core::flags;

/// Sums over the pixels of one source, relative to its first pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    area: f64,
    defined: f64,
    peak: Option<(f32, (u32, u32))>,
    flux: f64,
    variance: f64,
    background: f64,
    noise: f64,
    edge: f64,
    edge_pixels: f64,
    weight: f64,
    first: (f64, f64),
    second: (f64, f64, f64),
    flags: u32,
}

/// What the pixels of a source hold, background included; NaN where none is defined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Values {
    /// Their sum.
    pub sum: f64,
    /// Their mean.
    pub mean: f64,
    /// The greatest.
    pub peak: f64,
    /// Column and row of the first pixel with that value.
    pub peak_at: (u32, u32),
}

/// Moments of a source: centroid in pixels from 0, second moments in pixels squared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Column of the centroid.
    pub x: f64,
    /// Row of the centroid.
    pub y: f64,
    /// Second moments xx, yy, xy.
    pub moments: (f64, f64, f64),
    /// Root mean square along the major axis.
    pub a: f64,
    /// Root mean square along the minor axis.
    pub b: f64,
    /// From the x axis to the major axis, towards y, radians in (-pi/2, pi/2].
    pub theta: f64,
}

/// One pass over the image: the sums of every catalogued source.
pub fn sums(scene: &Scene<'_>, sources: &[Source]) -> Vec<Sums> {
    let mut all = vec![Sums::default(); sources.len()];
    for (index, &label) in scene.labels.iter().enumerate().filter(|(_, label)| **label != 0) {
        let at = label as usize - 1;
        if let (Some(sums), Some(source)) = (all.get_mut(at), sources.get(at)) {
            let origin = (source.x0 as f64, source.y0 as f64);
            sums.add(scene, index, label, origin);
        }
    }
    all
}

impl Sums {
    fn add(&mut self, scene: &Scene<'_>, index: usize, label: u32, origin: (f64, f64)) {
        let (x, y) = (index % scene.width, index / scene.width);
        let around = scene.around(x, y, label);
        self.flags |= around;
        self.area += 1.0;
        let Some(value) = scene.value(index) else {
            self.flags |= flags::MASKED;
            return;
        };
        if scene.saturated(index) {
            self.flags |= flags::SATURATED;
        }
        self.defined += 1.0;
        let pixel = scene.pixel(index);
        if self.peak.is_none_or(|(peak, _)| pixel > peak) {
            self.peak = Some((pixel, (x as u32, y as u32)));
        }
        self.flux += value;
        self.variance += scene.variance(index);
        self.background += scene.background.at(index);
        self.noise += scene.noise.at(index);
        if around & OUTLINE != 0 {
            self.edge += value;
            self.edge_pixels += 1.0;
        }
        self.moments_of(value.max(0.0), x as f64 - origin.0, y as f64 - origin.1);
    }

    fn moments_of(&mut self, weight: f64, x: f64, y: f64) {
        self.weight += weight;
        self.first = (self.first.0 + weight * x, self.first.1 + weight * y);
        let (xx, yy, xy) = self.second;
        self.second = (xx + weight * x * x, yy + weight * y * y, xy + weight * x * y);
    }

    /// The pixel values; the peak of a source without any is at its first pixel.
    pub fn values(&self, source: &Source) -> Values {
        let sum = if self.defined > 0.0 { self.flux + self.background } else { f64::NAN };
        let (peak, peak_at) = self.peak.unwrap_or((f32::NAN, (source.x0, source.y0)));
        Values { sum, mean: sum / self.defined, peak: f64::from(peak), peak_at }
    }

    /// Flux of the segment above the background.
    pub fn flux(&self, scene: &Scene<'_>) -> Flux {
        scene.flux(self.flux, self.variance)
    }

    /// Mean background and mean noise under the source, and the mean value above the background
    /// of the pixels along its outline.
    pub fn levels(&self) -> (f64, f64, f64) {
        let mean = |sum: f64, n: f64| if n > 0.0 { sum / n } else { f64::NAN };
        (mean(self.background, self.defined), mean(self.noise, self.defined), mean(self.edge, self.edge_pixels))
    }

    /// The flags of the pixels.
    pub fn flags(&self) -> u32 {
        let dark = if self.weight > 0.0 { 0 } else { flags::NO_FLUX };
        (self.flags & !OUTLINE) | dark
    }

    /// Centroid and moments, weighted by the values above the background. Without any such value
    /// the middle of the bounding box, and no extent.
    pub fn shape(&self, source: &Source) -> Shape {
        if self.weight <= 0.0 {
            let middle = |(from, to): (u32, u32)| 0.5 * (f64::from(from) + f64::from(to));
            let (x, y) = (middle(source.columns), middle(source.rows));
            return Shape { x, y, moments: (0.0, 0.0, 0.0), a: 0.0, b: 0.0, theta: 0.0 };
        }
        let (dx, dy) = (self.first.0 / self.weight, self.first.1 / self.weight);
        let (xx, yy, xy) = self.second;
        let xx = (xx / self.weight - dx * dx).max(0.0);
        let yy = (yy / self.weight - dy * dy).max(0.0);
        let xy = xy / self.weight - dx * dy;
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let spread = (half * half + xy * xy).sqrt();
        Shape {
            x: f64::from(source.x0) + dx,
            y: f64::from(source.y0) + dy,
            moments: (xx, yy, xy),
            a: (mean + spread).sqrt(),
            b: (mean - spread).max(0.0).sqrt(),
            theta: if spread > 0.0 { 0.5 * libm::atan2(xy, half) } else { 0.0 },
        }
    }
}

impl Shape {
    /// Semi-axes that no aperture may fall below: where the moments are those of less than a
    /// pixel's width, a pixel's own (1/12) are added, as SExtractor does.
    pub fn wide_axes(&self) -> (f64, f64) {
        let (a, b) = (self.a * self.a, self.b * self.b);
        let pixel = 1.0 / 12.0;
        if a * b < pixel * pixel { ((a + pixel).sqrt(), (b + pixel).sqrt()) } else { (self.a, self.b) }
    }
}

/// Not a flag of a source: the pixel lies along its outline.
pub(super) const OUTLINE: u32 = 1 << 31;
