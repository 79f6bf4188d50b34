//! The sky around a pixel, flat enough for the shape of a source.

use crate::measure::Ellipse;

/// Where one pixel along each axis leads: arcseconds east and north.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Along x.
    pub along_x: [f64; 2],
    /// Along y.
    pub along_y: [f64; 2],
}

impl Patch {
    /// Square arcseconds of a pixel.
    pub fn area(&self) -> f64 {
        (self.along_x[0] * self.along_y[1] - self.along_x[1] * self.along_y[0]).abs()
    }

    /// The pixels along x and y that lead so many arcseconds east and north; none where the patch is
    /// a line.
    pub fn pixels(&self, east: f64, north: f64) -> Option<(f64, f64)> {
        let ([ex, nx], [ey, ny]) = (self.along_x, self.along_y);
        let determinant = ex * ny - nx * ey;
        let place = ((east * ny - north * ey) / determinant, (north * ex - east * nx) / determinant);
        (place.0.is_finite() && place.1.is_finite()).then_some(place)
    }

    /// The ellipse of second moments xx, yy, xy in pixels: semi-axes in arcseconds, angle from north
    /// through east.
    pub fn ellipse(&self, (xx, yy, xy): (f64, f64, f64)) -> Ellipse {
        let ([ex, nx], [ey, ny]) = (self.along_x, self.along_y);
        Ellipse::of((
            nx * nx * xx + ny * ny * yy + 2.0 * nx * ny * xy,
            ex * ex * xx + ey * ey * yy + 2.0 * ex * ey * xy,
            ex * nx * xx + ey * ny * yy + (ex * ny + ey * nx) * xy,
        ))
    }
}
