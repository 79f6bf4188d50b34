//! What the pixels of a segment tell: flux, centroid, second moments, and where it stands.

use super::scene::{Light, OUTLINE};
use super::{Flux, Local, Scene};
use crate::workers::in_groups;
use skyfront_core::plane::rows::used;
use skyfront_core::sources::catalog::Source;
use skyfront_core::sources::flags;

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
    /// The same moments of the variance.
    noisy: f64,
    noisy_first: (f64, f64),
    noisy_second: (f64, f64, f64),
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
    /// Variances of the centroid xx, yy, xy, pixels squared.
    pub errors: (f64, f64, f64),
}

/// One pass over the image: the sums of every catalogued source.
pub fn sums(scene: &Scene<'_>, sources: &[Source], threads: usize) -> Vec<Sums> {
    let mut all = vec![Sums::default(); sources.len()];
    in_groups(&mut all, threads, |first, group| {
        for (y, row) in scene.labels.chunks(scene.width.max(1)).enumerate() {
            for (x, label) in used(row) {
                let sums = (label as usize).checked_sub(first).and_then(|index| group.get_mut(index));
                if let (Some(sums), Some(source)) = (sums, sources.get(label as usize - 1)) {
                    sums.add(scene, (x, y), label, (f64::from(source.x0), f64::from(source.y0)));
                }
            }
        }
    });
    all
}

impl Sums {
    fn add(&mut self, scene: &Scene<'_>, (x, y): (usize, usize), label: u32, origin: (f64, f64)) {
        let index = y * scene.width + x;
        let around = scene.around(x, y, label);
        self.flags |= around;
        self.area += 1.0;
        let Some(Light { value, variance: of_sky, .. }) = scene.defined(index) else {
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
        self.variance += of_sky;
        self.background += scene.background.at(index);
        self.noise += scene.noise.at(index);
        if around & OUTLINE != 0 {
            self.edge += value;
            self.edge_pixels += 1.0;
        }
        let (dx, dy) = (x as f64 - origin.0, y as f64 - origin.1);
        let light = value.max(0.0);
        self.weight += light;
        add_moments(&mut self.first, &mut self.second, light, dx, dy);
        let variance = scene.variance_with(of_sky, value);
        self.noisy += variance;
        add_moments(&mut self.noisy_first, &mut self.noisy_second, variance, dx, dy);
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

    /// Flux of the segment above the background beside the source.
    pub fn flux_beside(&self, scene: &Scene<'_>, local: &Local) -> Flux {
        let value = self.flux + self.background - self.defined * local.background;
        scene.flux(value, self.defined * local.noise * local.noise)
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
            let errors = (f64::NAN, f64::NAN, f64::NAN);
            return Shape { x, y, moments: (0.0, 0.0, 0.0), a: 0.0, b: 0.0, theta: 0.0, errors };
        }
        let (dx, dy) = (self.first.0 / self.weight, self.first.1 / self.weight);
        let (xx, yy, xy) = self.second;
        let xx = (xx / self.weight - dx * dx).max(0.0);
        let yy = (yy / self.weight - dy * dy).max(0.0);
        let xy = xy / self.weight - dx * dy;
        let Ellipse { a, b, theta } = Ellipse::of((xx, yy, xy));
        Shape {
            x: f64::from(source.x0) + dx,
            y: f64::from(source.y0) + dy,
            moments: (xx, yy, xy),
            a,
            b,
            theta,
            errors: self.errors((dx, dy), xx * yy - xy * xy),
        }
    }

    /// Variances of the centroid at `(dx, dy)`: those of its pixels, by their distance from it. Where
    /// the moments are those of less than a pixel, each is uncertain by a pixel's own width too, as
    /// SExtractor has it (`ERRX2_IMAGE`).
    fn errors(&self, (dx, dy): (f64, f64), determinant: f64) -> (f64, f64, f64) {
        let square = self.weight * self.weight;
        let (n, (nx, ny), (nxx, nyy, nxy)) = (self.noisy, self.noisy_first, self.noisy_second);
        let xx = ((nxx - 2.0 * dx * nx + dx * dx * n) / square).max(0.0);
        let yy = ((nyy - 2.0 * dy * ny + dy * dy * n) / square).max(0.0);
        let xy = (nxy - dx * ny - dy * nx + dx * dy * n) / square;
        let least = n / square / 12.0;
        if determinant < 1.0 / 144.0 && xx * yy - xy * xy < least * least {
            (xx + least, yy + least, xy)
        } else {
            (xx, yy, xy)
        }
    }
}

/// Adds a weight at a place to first and second moments.
fn add_moments(first: &mut (f64, f64), second: &mut (f64, f64, f64), weight: f64, x: f64, y: f64) {
    *first = (first.0 + weight * x, first.1 + weight * y);
    *second = (second.0 + weight * x * x, second.1 + weight * y * y, second.2 + weight * x * y);
}

/// The ellipse with given second moments.
///
/// ```
/// use skyfront::measure::Ellipse;
///
/// // Moments of 9 along x, of 4 along y, and none of both.
/// let ellipse = Ellipse::of((9.0, 4.0, 0.0));
/// assert_eq!((ellipse.a, ellipse.b, ellipse.theta), (3.0, 2.0, 0.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Root mean square along the major axis.
    pub a: f64,
    /// Root mean square along the minor axis.
    pub b: f64,
    /// From the first axis to the major axis, towards the second, radians in (-pi/2, pi/2].
    pub theta: f64,
}

impl Ellipse {
    /// The ellipse of the moments xx, yy, xy.
    pub fn of((xx, yy, xy): (f64, f64, f64)) -> Ellipse {
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let spread = (half * half + xy * xy).sqrt();
        Ellipse {
            a: (mean + spread).sqrt(),
            b: (mean - spread).max(0.0).sqrt(),
            theta: if spread > 0.0 { 0.5 * libm::atan2(xy, half) } else { 0.0 },
        }
    }
}

impl Shape {
    /// A place without a shape.
    pub fn at(x: f64, y: f64) -> Shape {
        const NONE: (f64, f64, f64) = (f64::NAN, f64::NAN, f64::NAN);
        Shape { x, y, moments: NONE, a: f64::NAN, b: f64::NAN, theta: f64::NAN, errors: NONE }
    }

    /// Semi-axes that no aperture may fall below: where the moments are those of less than a
    /// pixel's width, a pixel's own (1/12) are added, as SExtractor does.
    pub fn wide_axes(&self) -> (f64, f64) {
        let (a, b) = (self.a * self.a, self.b * self.b);
        let pixel = 1.0 / 12.0;
        if a * b < pixel * pixel { ((a + pixel).sqrt(), (b + pixel).sqrt()) } else { (self.a, self.b) }
    }
}
