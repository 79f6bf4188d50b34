//! Fluxes within ellipses and circles, by the exact area that each pixel shares with them.

use super::overlap::circle_polygon;
use super::{Flux, Scene};
use skyfront_core::flags;

/// No point of a pixel is farther from its centre.
pub(super) const CORNER: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The length of a vector; its parts are pixels, far from any overflow.
pub(super) fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// An ellipse, in pixels that count from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aperture {
    /// Column of its centre.
    pub x: f64,
    /// Row of its centre.
    pub y: f64,
    /// The first semi-axis.
    pub a: f64,
    /// The other semi-axis.
    pub b: f64,
    /// Sine and cosine of the angle from the x axis towards y to the first semi-axis.
    direction: (f64, f64),
    /// The greatest distance of a pixel's corner from its centre, in units of the semi-axes.
    reach: f64,
}

impl Aperture {
    /// A circle.
    pub fn circle(x: f64, y: f64, radius: f64) -> Aperture {
        Aperture { x, y, a: radius, b: radius, direction: (0.0, 1.0), reach: CORNER / radius }
    }

    /// An ellipse around (x, y) with the semi-axes (a, b), the first in the direction `theta` from
    /// the x axis towards y, radians.
    pub fn ellipse((x, y): (f64, f64), (a, b): (f64, f64), theta: f64) -> Aperture {
        Aperture { x, y, a, b, direction: libm::sincos(theta), reach: CORNER / a.min(b) }
    }

    /// Calls `each` with the index of every pixel of the image that may lie inside, and its place
    /// (dx, dy) from the centre; whether the bounding box lies within the image.
    pub(super) fn visit(&self, width: usize, height: usize, mut each: impl FnMut(usize, f64, f64)) -> bool {
        let (sin, cos) = self.direction;
        let (wide, high) = (length(self.a * cos, self.b * sin), length(self.a * sin, self.b * cos));
        let range = |centre: f64, half: f64, n: usize| {
            let (low, high) = ((centre - half + 0.5).floor(), (centre + half + 0.5).ceil());
            (low.max(0.0) as usize..(high.max(0.0) as usize).min(n), low >= 0.0 && high <= n as f64)
        };
        let ((columns, inside_x), (rows, inside_y)) = (range(self.x, wide, width), range(self.y, high, height));
        for row in rows {
            for column in columns.clone() {
                each(row * width + column, column as f64 - self.x, row as f64 - self.y);
            }
        }
        inside_x && inside_y
    }

    /// A place (dx, dy) from the centre in units of the semi-axes.
    fn unit(&self, dx: f64, dy: f64) -> (f64, f64) {
        let (sin, cos) = self.direction;
        ((dx * cos + dy * sin) / self.a, (dy * cos - dx * sin) / self.b)
    }

    /// The distance of a place from the centre in units of the semi-axes.
    fn distance(&self, dx: f64, dy: f64) -> f64 {
        let (u, v) = self.unit(dx, dy);
        length(u, v)
    }

    /// The share of a pixel at (dx, dy) from the centre that lies inside.
    pub(super) fn share(&self, dx: f64, dy: f64) -> f64 {
        let distance = self.distance(dx, dy);
        if distance + self.reach <= 1.0 {
            1.0
        } else if distance >= 1.0 + self.reach {
            0.0
        } else {
            let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, y)| self.unit(dx + x, dy + y));
            circle_polygon(&corners) * self.a * self.b
        }
    }

    /// Flux above the background within the aperture, and the flags it earns. Undefined pixels
    /// and those of sources other than `label` are left out.
    pub fn flux(&self, scene: &Scene<'_>, label: u32) -> (Flux, u32) {
        let (mut flux, mut variance, mut flags) = (0.0, 0.0, 0);
        let complete = self.visit(scene.width, scene.height, |index, dx, dy| {
            let share = self.share(dx, dy);
            if share <= 0.0 {
                return;
            }
            match scene.value_for(index, label) {
                Ok(value) => {
                    flux += share * value;
                    variance += share * scene.variance(index);
                }
                Err(flag) => flags |= flag,
            }
        });
        (scene.flux(flux, variance), flags | if complete { 0 } else { flags::APERTURE })
    }

    /// Kron's first moment: the mean distance of the light from the centre, in units of the
    /// semi-axes, over the pixels whose centres lie inside (Kron 1980, doi:10.1086/190669); none
    /// where there is no light.
    pub fn first_moment(&self, scene: &Scene<'_>, label: u32) -> Option<f64> {
        let (mut light, mut moment) = (0.0, 0.0);
        self.visit(scene.width, scene.height, |index, dx, dy| {
            let distance = self.distance(dx, dy);
            if let (true, Ok(value)) = (distance <= 1.0, scene.value_for(index, label)) {
                light += value;
                moment += value * distance;
            }
        });
        (light > 0.0 && moment > 0.0).then(|| moment / light)
    }
}
