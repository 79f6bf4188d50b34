//! The catalogue: what each segment measures on the original pixels.

use crate::arithmetic::codec::Codec;
use crate::arithmetic::machine::{Machine, Plain};
use crate::arithmetic::sum::Sum;

/// One source, as it is summed up row by row.
///
/// Pixel centres have whole coordinates, from (0, 0) for the first pixel of row 0; FITS
/// coordinates are larger by 1. Moments are weighted by the pixel value above `floor`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Source {
    /// Its label in the segmentation, from 1, in raster order of first pixels.
    pub label: u32,
    /// Number of pixels.
    pub area: u32,
    /// Column of its first pixel.
    pub x0: u32,
    /// Row of its first pixel.
    pub y0: u32,
    /// Columns of its bounding box, both included.
    pub columns: (u32, u32),
    /// Rows of its bounding box, both included.
    pub rows: (u32, u32),
    /// The greatest pixel value, in units of the image.
    pub peak: f32,
    /// Column and row of the first pixel with that value.
    pub peak_at: (u32, u32),
    sum: Sum,
    weight: Sum,
    moment_x: Sum,
    moment_y: Sum,
    moment_xx: Sum,
    moment_xy: Sum,
    moment_yy: Sum,
}

/// The ellipse with the second moments of a source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Root mean square along the major axis, pixels.
    pub a: f32,
    /// Root mean square along the minor axis, pixels.
    pub b: f32,
    /// From the x axis to the major axis, towards y, radians in (-pi/2, pi/2].
    pub theta: f32,
}

impl Source {
    /// A source without pixels yet.
    pub const fn empty(label: u32) -> Source {
        const NONE: Sum = Sum::ZERO;
        Source {
            label,
            area: 0,
            x0: 0,
            y0: 0,
            columns: (0, 0),
            rows: (0, 0),
            peak: 0.0,
            peak_at: (0, 0),
            sum: NONE,
            weight: NONE,
            moment_x: NONE,
            moment_y: NONE,
            moment_xx: NONE,
            moment_xy: NONE,
            moment_yy: NONE,
        }
    }

    /// The list of fields, out or in; a peak that is no number comes in as 0.
    pub(crate) fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        let (columns, rows, peak_at) = (&mut self.columns, &mut self.rows, &mut self.peak_at);
        for word in [
            &mut self.label,
            &mut self.area,
            &mut self.x0,
            &mut self.y0,
            &mut columns.0,
            &mut columns.1,
            &mut rows.0,
            &mut rows.1,
            &mut peak_at.0,
            &mut peak_at.1,
        ] {
            codec.word(word)?;
        }
        codec.real(&mut self.peak)?;
        if !self.peak.is_finite() {
            self.peak = 0.0;
        }
        for sum in [
            &mut self.sum,
            &mut self.weight,
            &mut self.moment_x,
            &mut self.moment_y,
            &mut self.moment_xx,
            &mut self.moment_xy,
            &mut self.moment_yy,
        ] {
            sum.code(codec)?;
        }
        Ok(())
    }

    /// Takes in the place of a pixel and nothing of its value; pixels come in raster order.
    #[inline]
    pub fn extend(&mut self, x: u32, y: u32) {
        if self.area == 0 {
            (self.x0, self.y0) = (x, y);
            (self.columns, self.rows) = ((x, x), (y, y));
        }
        self.area = self.area.saturating_add(1);
        self.columns = (self.columns.0.min(x), self.columns.1.max(x));
        self.rows.1 = y;
    }

    /// Takes in a pixel; pixels come in raster order.
    pub fn add(&mut self, x: u32, y: u32, pixel: f32, floor: f32) {
        if self.area == 0 {
            (self.peak, self.peak_at) = (pixel, (x, y));
        }
        self.extend(x, y);
        if pixel > self.peak {
            (self.peak, self.peak_at) = (pixel, (x, y));
        }
        self.sum.add(pixel);
        let weight = pixel - floor;
        if weight > 0.0 && weight.is_finite() {
            let (dx, dy) = (x as f32 - self.x0 as f32, y as f32 - self.y0 as f32);
            let (wx, wy) = (weight * dx, weight * dy);
            self.weight.add(weight);
            self.moment_x.add(wx);
            self.moment_y.add(wy);
            self.moment_xx.add(wx * dx);
            self.moment_xy.add(wx * dy);
            self.moment_yy.add(wy * dy);
        }
    }

    /// Sum of the pixel values, in units of the image.
    pub fn sum(&self) -> f32 {
        self.sum.value()
    }

    /// Mean of the pixel values.
    pub fn mean(&self) -> f32 {
        self.sum() / self.area.max(1) as f32
    }

    /// Centroid relative to the first pixel `(x0, y0)`, in pixels; that pixel itself where no
    /// pixel stands above the floor.
    pub fn centroid_offset(&self) -> (f32, f32) {
        let weight = self.weight.value();
        if weight > 0.0 { (self.moment_x.value() / weight, self.moment_y.value() / weight) } else { (0.0, 0.0) }
    }

    /// Centroid in pixels, the first pixel of row 0 at (0, 0).
    pub fn centroid(&self) -> (f32, f32) {
        let (dx, dy) = self.centroid_offset();
        (self.x0 as f32 + dx, self.y0 as f32 + dy)
    }

    /// Central second moments (xx, xy, yy), pixels squared.
    pub fn second_moments(&self) -> (f32, f32, f32) {
        let weight = self.weight.value();
        if weight > 0.0 {
            let (dx, dy) = self.centroid_offset();
            let not_below_zero = |value: f32| if value > 0.0 { value } else { 0.0 };
            (
                not_below_zero(self.moment_xx.value() / weight - dx * dx),
                self.moment_xy.value() / weight - dx * dy,
                not_below_zero(self.moment_yy.value() / weight - dy * dy),
            )
        } else {
            (0.0, 0.0, 0.0)
        }
    }

    /// The ellipse of the second moments.
    pub fn ellipse(&self) -> Ellipse {
        let (xx, xy, yy) = self.second_moments();
        let (mean, half) = ((xx + yy) * 0.5, (xx - yy) * 0.5);
        let spread = Plain::sqrt(half * half + xy * xy);
        let minor = if mean > spread { mean - spread } else { 0.0 };
        Ellipse {
            a: Plain::sqrt(mean + spread),
            b: Plain::sqrt(minor),
            theta: if spread > 0.0 { libm::atan2f(xy, half) * 0.5 } else { 0.0 },
        }
    }
}

/// A catalogue with room for `N` sources, as [`crate::run::memory::Memory::sources`] wants it; after the
/// run `truncate` it to [`crate::run::outcome::Outcome::catalogued`].
pub fn room_for<const N: usize>() -> heapless::Vec<Source, N> {
    let mut room = heapless::Vec::new();
    while room.push(Source::empty(0)).is_ok() {}
    room
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_of_three_pixels() {
        let mut source = Source::empty(1);
        for (x, value) in [(10, 1.0), (11, 3.0), (12, 1.0)] {
            source.add(x, 7, value, 0.0);
        }
        assert_eq!(source.area, 3);
        assert_eq!(source.sum(), 5.0);
        assert_eq!(source.centroid(), (11.0, 7.0));
        assert_eq!((source.peak, source.peak_at), (3.0, (11, 7)));
        assert_eq!((source.columns, source.rows), ((10, 12), (7, 7)));
        let ellipse = source.ellipse();
        assert!((ellipse.a - libm::sqrtf(0.4)).abs() < 1e-6);
        assert_eq!((ellipse.b, ellipse.theta), (0.0, 0.0));
    }
    /// Weights of 1, 2 and 1 above the floor.
    #[test]
    fn three_pixels_askew() {
        let mut source = Source::empty(1);
        for (x, y, value) in [(10, 7, 1.5), (12, 8, 2.5), (13, 9, 1.5)] {
            source.add(x, y, value, 0.5);
        }
        assert_eq!((source.sum(), source.centroid_offset(), source.centroid()), (5.5, (1.75, 1.0), (11.75, 8.0)));
        assert_eq!(source.second_moments(), (1.1875, 0.75, 0.5));
        let (ellipse, spread) = (source.ellipse(), libm::hypotf(0.34375, 0.75));
        assert!((ellipse.a - libm::sqrtf(0.84375 + spread)).abs() < 1e-6, "{ellipse:?}");
        assert!((ellipse.b - libm::sqrtf(0.84375 - spread)).abs() < 1e-6, "{ellipse:?}");
        assert!((ellipse.theta - 0.5 * libm::atan2f(0.75, 0.34375)).abs() < 1e-6, "{ellipse:?}");
    }
}
