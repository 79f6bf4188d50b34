//! The image in a readable stretch with the outlines of its sources, numbered where few.

use super::canvas::TextSize;
use super::outline::{Panel, Zoom};
use super::{Canvas, PALETTE, Stretch};
use skyfront_core::sources::catalog::Source;

/// The longer side of the picture, about.
const SIDE: usize = 1200;
/// With more sources than this, numbers would hide the image.
const MOST_NUMBERS: usize = 150;

/// Draws the overlay of an image, row-major, with labels of the same shape.
pub fn overlay(pixels: &[f32], labels: &[u32], width: usize, height: usize, sources: &[Source]) -> Canvas {
    let panel = Panel { left: 0, top: 0, width, height, zoom: Zoom::towards(width, height, SIDE) };
    let (columns, rows) = panel.size();
    let mut canvas = Canvas::new(columns, rows);
    let stretch = Stretch::of(pixels);
    panel.draw(&mut canvas, |index| [stretch.shade(pixels[index]); 3]);
    panel.outline(&mut canvas, labels);
    if sources.len() <= MOST_NUMBERS {
        for source in sources {
            number(&mut canvas, &panel, source);
        }
    }
    canvas
}

/// Writes a source's label beside the upper right corner of its bounding box.
fn number(canvas: &mut Canvas, panel: &Panel, source: &Source) {
    let text = source.label.to_string();
    let (wide, high) = TextSize::Small.cell();
    let (x, y) = panel.position(f64::from(source.columns.1) + 1.0, f64::from(source.rows.1) + 1.0);
    let x = (x.max(0.0) as usize).min(canvas.width().saturating_sub(wide * text.len()));
    let y = (y.max(0.0) as usize).saturating_sub(high).min(canvas.height().saturating_sub(high));
    canvas.text(x, y, &text, TextSize::Small, PALETTE[1]);
}
