//! Centroids under a Gaussian window, as SExtractor's `XWIN_IMAGE`: nearly as precise as a fit of the
//! profile, and little moved by a neighbour or by where the outline happens to lie.

use super::aperture::largest;
use super::{Aperture, Scene};
use skyfront_core::sources::catalog::Source;
use std::f64::consts::PI;

/// From a half-light radius to the window's standard deviation, as SExtractor has it.
const SIGMA: f64 = 2.0 / 2.35;
/// The window ends at so many standard deviations.
const REACH: f64 = 4.0;
/// No window is narrower, pixels.
const NARROWEST: f64 = 0.5;
/// A step goes twice as far as the moment says, because the window pulls towards its own centre.
const FACTOR: f64 = 2.0;
/// Steps, and the length of the last one, pixels.
const STEPS: usize = 16;
const SHORTEST: f64 = 1e-4;

/// A windowed centroid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Windowed {
    /// Column, from 0; NaN where none was found.
    pub x: f64,
    /// Row, from 0.
    pub y: f64,
    /// Its variances xx, yy, xy, pixels squared.
    pub errors: (f64, f64, f64),
}

impl Windowed {
    /// No centroid.
    pub const NONE: Windowed = Windowed { x: f64::NAN, y: f64::NAN, errors: (f64::NAN, f64::NAN, f64::NAN) };

    /// The windowed centroid of a source with a half-light radius, from a first centroid on; none
    /// where the steps leave the window around it or end in darkness. No window has more pixels than
    /// an aperture of the source may have.
    pub fn of(scene: &Scene<'_>, source: &Source, (x, y): (f64, f64), half_light: f64) -> Windowed {
        if !half_light.is_finite() {
            return Windowed::NONE;
        }
        let widest = (largest(source.area) / PI).sqrt() / REACH;
        let sigma = (SIGMA * half_light).clamp(NARROWEST, widest);
        let reach = REACH * sigma;
        let mut found = Windowed { x, y, ..Windowed::NONE };
        for _ in 0..STEPS {
            let sums = Sums::of(scene, source.label, &Aperture::circle(found.x, found.y, reach), sigma);
            let (dx, dy) = (FACTOR * sums.x / sums.light, FACTOR * sums.y / sums.light);
            let far = (found.x + dx - x).abs() > reach || (found.y + dy - y).abs() > reach;
            if sums.light <= 0.0 || far || !(dx.is_finite() && dy.is_finite()) {
                return Windowed::NONE;
            }
            let scale = (FACTOR / sums.light).powi(2);
            let (xx, yy, xy) = sums.errors;
            found = Windowed { x: found.x + dx, y: found.y + dy, errors: (scale * xx, scale * yy, scale * xy) };
            if dx * dx + dy * dy < SHORTEST * SHORTEST {
                break;
            }
        }
        found
    }
}

/// The light under a window and its first moments, with the second moments of the variance.
#[derive(Default)]
struct Sums {
    light: f64,
    x: f64,
    y: f64,
    errors: (f64, f64, f64),
}

impl Sums {
    fn of(scene: &Scene<'_>, label: u32, circle: &Aperture, sigma: f64) -> Sums {
        let bell = |d: f64| libm::exp(-0.5 * d * d / (sigma * sigma));
        // The window is a product of one factor per column and one per row.
        let first = (circle.x - circle.a).floor();
        let columns: Vec<f64> = (0..2 * circle.a as usize + 4).map(|n| bell(first + n as f64 - circle.x)).collect();
        let (mut row, mut across) = (usize::MAX, 0.0);
        let mut sums = Sums::default();
        circle.lights(scene, label, |spot, light, share| {
            if spot.y != row {
                (row, across) = (spot.y, bell(spot.dy));
            }
            let along = columns.get((spot.x as f64 - first) as usize).copied().unwrap_or(0.0);
            let weight = share * along * across;
            sums.light += weight * light.value;
            sums.x += weight * light.value * spot.dx;
            sums.y += weight * light.value * spot.dy;
            let variance = weight * weight * scene.variance_with(light.variance, light.value);
            let (xx, yy, xy) = sums.errors;
            let (dx, dy) = (spot.dx, spot.dy);
            sums.errors = (xx + variance * dx * dx, yy + variance * dy * dy, xy + variance * dx * dy);
        });
        sums
    }
}
