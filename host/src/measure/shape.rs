//! What the pixels of a segment tell: flux, centroid, second moments, and where it stands.

use super::scene::OUTLINE;
use super::{Flux, Local, Scene};
use crate::workers::in_groups;
use skyfront_core::plane::rows::used;
use skyfront_core::sources::catalog::Source;
use skyfront_core::sources::measure::{Around, Centroid, Pixel, Sums};

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

/// One pass over the image: the core's sums of every catalogued source.
pub fn sums(scene: &Scene<'_>, count: usize, threads: usize) -> Vec<Sums> {
    let mut all = vec![Sums::default(); count];
    in_groups(&mut all, threads, |first, group| {
        for (y, row) in scene.rows.clone().zip(scene.labels.chunks(scene.width.max(1))) {
            for (x, label) in used(row) {
                if let Some(sums) = (label as usize).checked_sub(first).and_then(|index| group.get_mut(index)) {
                    let around = scene.around(x, y, label);
                    let around = Around { flags: around & !OUTLINE, is_outline: around & OUTLINE != 0 };
                    let pixel = pixel(scene, scene.index(x, y));
                    sums.add((x as u32, y as u32), around, pixel, scene.gain());
                }
            }
        }
    });
    all
}

/// A pixel of a source as the core sums it up; `None` where it is undefined.
#[inline]
fn pixel(scene: &Scene<'_>, index: usize) -> Option<Pixel> {
    let (background, noise) = (scene.background.at(index), scene.noise.at(index));
    scene.defined(index).map(|_| Pixel {
        value: scene.pixel(index),
        background,
        noise,
        is_saturated: scene.saturated(index),
    })
}

impl Values {
    /// The pixel values; the peak of a source without any is at its first pixel.
    pub fn of(sums: &Sums, source: &Source) -> Values {
        let (peak, peak_at) = sums.peak.unwrap_or((f32::NAN, (source.x0, source.y0)));
        Values { sum: sums.total(), mean: sums.total() / sums.defined(), peak: f64::from(peak), peak_at }
    }
}

/// Flux of the segment above the background beside the source.
pub fn flux_beside(sums: &Sums, scene: &Scene<'_>, local: &Local) -> Flux {
    let value = sums.total() - sums.defined() * local.background;
    scene.flux(value, sums.defined() * local.noise * local.noise)
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
    /// What the sums of a source tell.
    pub fn of(sums: &Sums) -> Shape {
        let Centroid { x, y, moments: (xx, yy, xy), errors } = sums.centroid();
        let Ellipse { a, b, theta } = Ellipse::of((xx, yy, xy));
        Shape { x, y, moments: (xx, yy, xy), a, b, theta, errors }
    }

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

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn moments_are_those_of_a_turned_ellipse() {
        for degrees in [-80.0, -45.0, -10.0, 0.0, 30.0, 45.0, 60.0, 90.0] {
            let theta = degrees * PI / 180.0;
            let (sin, cos) = theta.sin_cos();
            let ellipse =
                Ellipse::of((9.0 * cos * cos + 4.0 * sin * sin, 9.0 * sin * sin + 4.0 * cos * cos, 5.0 * sin * cos));
            assert!((ellipse.a - 3.0).abs() < 1e-12 && (ellipse.b - 2.0).abs() < 1e-12, "{degrees}: {ellipse:?}");
            assert!((ellipse.theta - theta).abs() < 1e-12, "{degrees}: {ellipse:?}");
        }
        assert_eq!(Ellipse::of((4.0, 4.0, 0.0)), Ellipse { a: 2.0, b: 2.0, theta: 0.0 });
    }

    #[test]
    fn no_axis_is_narrower_than_a_pixel() {
        let axes = |a: f64, b: f64| Shape { a, b, ..Shape::at(0.0, 0.0) }.wide_axes();
        assert_eq!((axes(2.0, 0.3), axes(0.3, 0.3)), ((2.0, 0.3), (0.3, 0.3)));
        let (a, b) = axes(2.0, 0.0);
        assert!((a * a - 4.0 - 1.0 / 12.0).abs() < 1e-12 && (b * b - 1.0 / 12.0).abs() < 1e-12, "{a} {b}");
    }
}
