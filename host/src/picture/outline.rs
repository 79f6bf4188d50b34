//! A plane of an image laid onto a canvas: enlarged or reduced, upright, with outlines of labels.

use super::{Canvas, Colour, MARK, Stretch};
use std::str::FromStr;

/// How image pixels map to picture pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Zoom {
    /// Every image pixel becomes a square of this side.
    Enlarge(usize),
    /// Squares of this side become one picture pixel.
    Reduce(usize),
}

/// The greatest scale, either way.
const MOST: usize = 64;

impl FromStr for Zoom {
    type Err = String;

    /// `4` for squares of 4 picture pixels, `1/4` for picture pixels of 4 x 4 image pixels.
    fn from_str(text: &str) -> Result<Zoom, String> {
        let number = |text: &str| text.trim().parse().ok().filter(|number| (1..=MOST).contains(number));
        let zoom = match text.split_once('/') {
            None => number(text).map(Zoom::Enlarge),
            Some((one, number_of)) => number(number_of).filter(|_| one.trim() == "1").map(Zoom::Reduce),
        };
        zoom.ok_or_else(|| format!("must be N or 1/N with N from 1 to {MOST}"))
    }
}

impl Zoom {
    /// The zoom that brings the longer side of an image near `target` picture pixels.
    pub fn towards(width: usize, height: usize, target: usize) -> Zoom {
        let longer = width.max(height).max(1);
        if longer <= target { Zoom::Enlarge((target / longer).min(8)) } else { Zoom::Reduce(longer.div_ceil(target)) }
    }

    /// Picture pixels for `n` image pixels.
    pub fn length(self, n: usize) -> usize {
        match self {
            Zoom::Enlarge(factor) => n * factor,
            Zoom::Reduce(factor) => n.div_ceil(factor),
        }
    }

    /// The first image pixel, of `n`, behind a picture pixel.
    fn image(self, at: usize, n: usize) -> usize {
        let pixel = match self {
            Zoom::Enlarge(factor) => at / factor,
            Zoom::Reduce(factor) => at * factor,
        };
        pixel.min(n.saturating_sub(1))
    }

    /// The middle of an image pixel, of `n`, on the picture.
    pub fn picture(self, pixel: f64) -> f64 {
        match self {
            Zoom::Enlarge(factor) => (pixel + 0.5) * factor as f64,
            Zoom::Reduce(factor) => (pixel + 0.5) / factor as f64,
        }
    }
}

/// The means of squares of `step` x `step` pixels, from the first row on; NaN where none is finite.
pub fn reduced(pixels: &[f32], width: usize, height: usize, step: usize) -> Vec<f32> {
    let mut means = Vec::with_capacity(width.div_ceil(step) * height.div_ceil(step));
    for bottom in (0..height).step_by(step) {
        for left in (0..width).step_by(step) {
            let across = left..(left + step).min(width);
            let rows = bottom..(bottom + step).min(height);
            means.push(mean(rows.flat_map(|y| across.clone().map(move |x| pixels[y * width + x]))));
        }
    }
    means
}

fn mean(values: impl Iterator<Item = f32>) -> f32 {
    let finite = values.filter(|value| value.is_finite());
    let (sum, count) = finite.fold((0.0, 0u32), |(sum, n), value| (sum + value, n + 1));
    if count > 0 { sum / count as f32 } else { f32::NAN }
}

/// Where on a canvas an image of `width` x `height` pixels lies.
#[derive(Clone, Copy, Debug)]
pub struct Panel {
    /// Left edge on the canvas.
    pub left: usize,
    /// Top edge on the canvas.
    pub top: usize,
    /// Columns of the image.
    pub width: usize,
    /// Rows of the image.
    pub height: usize,
    /// Its zoom.
    pub zoom: Zoom,
}

impl Panel {
    /// Columns and rows on the canvas.
    pub fn size(&self) -> (usize, usize) {
        (self.zoom.length(self.width), self.zoom.length(self.height))
    }

    /// Calls `draw` with every canvas pixel of the panel and the image pixel (x, y) behind it.
    fn each(&self, mut draw: impl FnMut(usize, usize, usize, usize)) {
        let (columns, rows) = self.size();
        for row in 0..rows {
            // The picture's top row is the image's last.
            let y = self.zoom.image(rows - 1 - row, self.height);
            for column in 0..columns {
                draw(self.left + column, self.top + row, self.zoom.image(column, self.width), y);
            }
        }
    }

    /// Calls `see` with every canvas pixel of the panel and the index of the image pixel behind it.
    pub fn each_pixel(&self, mut see: impl FnMut(usize, usize, usize)) {
        self.each(|column, row, x, y| see(column, row, y * self.width + x));
    }

    /// Draws an image: `colour` gives the colour of the pixel with this index.
    pub fn draw(&self, canvas: &mut Canvas, colour: impl Fn(usize) -> Colour) {
        self.each_pixel(|column, row, index| canvas.set(column, row, colour(index)));
    }

    /// Draws the shades of an image in a stretch, the mean of those that share a picture pixel.
    pub fn draw_image(&self, canvas: &mut Canvas, pixels: &[f32], stretch: &Stretch) {
        match self.zoom {
            Zoom::Enlarge(_) => self.draw(canvas, |index| [stretch.shade(pixels[index]); 3]),
            Zoom::Reduce(step) => {
                let means = reduced(pixels, self.width, self.height, step);
                let (columns, rows) = self.size();
                for (at, &mean) in means.iter().enumerate() {
                    let (x, y) = (at % columns, rows - 1 - at / columns);
                    canvas.set(self.left + x, self.top + y, [stretch.shade(mean); 3]);
                }
            }
        }
    }

    /// Draws the outlines of labels: canvas pixels with a neighbour of another label to the right
    /// or below, and, where pixels are enlarged, to the left or above as well (lines of two).
    pub fn outline(&self, canvas: &mut Canvas, labels: &[u32]) {
        let (columns, rows) = self.size();
        let label = |column: usize, row: usize| {
            let (x, y) = (self.zoom.image(column, self.width), self.zoom.image(rows - 1 - row, self.height));
            labels[y * self.width + x]
        };
        for row in 0..rows {
            for column in 0..columns {
                let here = label(column, row);
                let before = [(column.wrapping_sub(1), row), (column, row.wrapping_sub(1))];
                let after = [(column + 1, row), (column, row + 1)];
                let thick = matches!(self.zoom, Zoom::Enlarge(3..));
                let differs = after
                    .iter()
                    .chain(before.iter().filter(|_| thick))
                    .any(|&(c, r)| c < columns && r < rows && label(c, r) != here);
                if differs {
                    canvas.set(self.left + column, self.top + row, MARK);
                }
            }
        }
    }

    /// Where an image position (x, y), first pixel centre (0, 0), lies on the canvas.
    pub fn position(&self, x: f64, y: f64) -> (f64, f64) {
        let (_, rows) = self.size();
        (self.left as f64 + self.zoom.picture(x), self.top as f64 + rows as f64 - self.zoom.picture(y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_read() {
        assert_eq!("4".parse(), Ok(Zoom::Enlarge(4)));
        assert_eq!("1/3".parse(), Ok(Zoom::Reduce(3)));
        for odd in ["0", "65", "2/3", "1/0", "0.5", "x", ""] {
            assert!(odd.parse::<Zoom>().is_err(), "{odd}");
        }
    }

    #[test]
    fn reduced_pixels_are_means_of_what_is_defined() {
        let pixels = [1.0, 3.0, 5.0, 5.0, f32::NAN, 7.0, 7.0, f32::NAN, 9.0];
        let means = reduced(&pixels, 3, 3, 2);
        assert_eq!(means[..3], [3.0, 6.0, 7.0]);
        assert_eq!(means[3], 9.0);
        assert!(reduced(&[f32::NAN], 1, 1, 2)[0].is_nan());
    }
}
