//! The curve of growth of a source: its light within circles around the centroid.

use super::aperture::{CORNER, length};
use super::{Aperture, Scene};

/// Pixels around a source by their distance, with the light up to each.
pub struct Growth {
    pixels: Vec<Pixel>,
    /// Light of the pixels before each one, and of all.
    before: Vec<f64>,
}

/// A pixel, relative to the centroid.
struct Pixel {
    distance: f64,
    dx: f64,
    dy: f64,
    value: f64,
}

impl Growth {
    /// The light of source `label` up to `reach` pixels around (x, y). Undefined pixels and those
    /// of other sources are left out.
    pub fn new(scene: &Scene<'_>, label: u32, (x, y): (f64, f64), reach: f64) -> Growth {
        let mut pixels = Vec::new();
        Aperture::circle(x, y, reach).visit(scene.width, scene.height, |index, dx, dy| {
            let distance = length(dx, dy);
            if let (true, Ok(value)) = (distance < reach + CORNER, scene.value_for(index, label)) {
                pixels.push(Pixel { distance, dx, dy, value });
            }
        });
        pixels.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        let mut before = vec![0.0];
        for (at, pixel) in pixels.iter().enumerate() {
            before.push(before[at] + pixel.value);
        }
        Growth { pixels, before }
    }

    /// Light within a circle, by the exact area of the pixels it cuts.
    pub fn within(&self, radius: f64) -> f64 {
        let circle = Aperture::circle(0.0, 0.0, radius);
        let first = |distance: f64| self.pixels.partition_point(|pixel| pixel.distance < distance);
        let (whole, end) = (first(radius - CORNER), first(radius + CORNER));
        let cut = self.pixels[whole..end].iter().map(|pixel| pixel.value * circle.share(pixel.dx, pixel.dy));
        self.before[whole] + cut.sum::<f64>()
    }
}
