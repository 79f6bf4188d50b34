//! Fluxes within ellipses and circles, by the exact area that each pixel shares with them.

use super::overlap::circle_polygon;
use super::{Flux, Scene};
use skyfront_core::flags;

/// An ellipse, in pixels that count from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aperture {
    /// Column of its centre.
    pub x: f64,
    /// Row of its centre.
    pub y: f64,
    /// Semi-axis in the direction `theta`.
    pub a: f64,
    /// The other semi-axis.
    pub b: f64,
    /// From the x axis towards y, radians.
    pub theta: f64,
}

impl Aperture {
    /// A circle.
    pub fn circle(x: f64, y: f64, radius: f64) -> Aperture {
        Aperture { x, y, a: radius, b: radius, theta: 0.0 }
    }

    /// Calls `each` with column, row, the distance of the pixel's centre in units of the
    /// semi-axes, and the share of the pixel inside, for every pixel of the image that has one;
    /// whether the bounding box lies within the image.
    fn visit(&self, width: usize, height: usize, mut each: impl FnMut(usize, f64, f64)) -> bool {
        let (sin, cos) = self.theta.sin_cos();
        let unit = |x: f64, y: f64| ((x * cos + y * sin) / self.a, (y * cos - x * sin) / self.b);
        let (wide, high) = ((self.a * cos).hypot(self.b * sin), (self.a * sin).hypot(self.b * cos));
        let range = |centre: f64, half: f64, n: usize| {
            let (low, high) = ((centre - half + 0.5).floor(), (centre + half + 0.5).ceil());
            (low.max(0.0) as usize..(high.max(0.0) as usize).min(n), low >= 0.0 && high <= n as f64)
        };
        let ((columns, inside_x), (rows, inside_y)) = (range(self.x, wide, width), range(self.y, high, height));
        // No corner of a pixel is farther from its centre, in units of the semi-axes.
        let reach = 0.5f64.sqrt() / self.a.min(self.b);
        for row in rows {
            let dy = row as f64 - self.y;
            for column in columns.clone() {
                let dx = column as f64 - self.x;
                let (u, v) = unit(dx, dy);
                let distance = u.hypot(v);
                let share = if distance + reach <= 1.0 {
                    1.0
                } else if distance >= 1.0 + reach {
                    continue;
                } else {
                    let corner = |x: f64, y: f64| unit(dx + x, dy + y);
                    let corners = [corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
                    circle_polygon(&corners) * self.a * self.b
                };
                each(row * width + column, distance, share);
            }
        }
        inside_x && inside_y
    }

    /// Flux above the background within the aperture, and the flags it earns. Undefined pixels
    /// and those of sources other than `label` are left out.
    pub fn flux(&self, scene: &Scene<'_>, label: u32) -> (Flux, u32) {
        let (mut flux, mut variance, mut flags) = (0.0, 0.0, 0);
        let complete = self.visit(scene.width, scene.height, |index, _, share| {
            if share > 0.0 {
                match scene.value_for(index, label) {
                    Ok(value) => {
                        flux += share * value;
                        variance += share * scene.variance(index);
                    }
                    Err(flag) => flags |= flag,
                }
            }
        });
        (scene.flux(flux, variance), flags | if complete { 0 } else { flags::APERTURE })
    }

    /// Kron's first moment: the mean distance of the light from the centre, in units of the
    /// semi-axes, over the pixels whose centres lie inside (Kron 1980, doi:10.1086/190669); none
    /// where there is no light.
    pub fn first_moment(&self, scene: &Scene<'_>, label: u32) -> Option<f64> {
        let (mut light, mut moment) = (0.0, 0.0);
        self.visit(scene.width, scene.height, |index, distance, _| {
            if let (true, Ok(value)) = (distance <= 1.0, scene.value_for(index, label)) {
                light += value;
                moment += value * distance;
            }
        });
        (light > 0.0 && moment > 0.0).then(|| moment / light)
    }
}
