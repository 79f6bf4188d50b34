//! A plane of an image laid onto a canvas: enlarged or reduced, upright, with outlines of labels.

use super::{Canvas, Colour, MARK};

/// How image pixels map to picture pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Zoom {
    /// Every image pixel becomes a square of this side.
    Enlarge(usize),
    /// Squares of this side become one picture pixel.
    Reduce(usize),
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

    /// Draws an image: `colour` gives the colour of the pixel with this index.
    pub fn draw(&self, canvas: &mut Canvas, colour: impl Fn(usize) -> Colour) {
        self.each(|column, row, x, y| canvas.set(column, row, colour(y * self.width + x)));
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
