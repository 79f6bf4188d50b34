//! One image several times, each with the outlines of another map.

use super::canvas::TextSize;
use super::outline::{Panel, Zoom};
use super::{Canvas, Stretch};

/// The longer side of one panel, about.
const SIDE: usize = 600;
/// Between panels.
const GAP: usize = 8;

/// Draws an image of (columns, rows) once for each caption, with the outlines of the labels beside it.
pub fn side_by_side(pixels: &[f32], (width, height): (usize, usize), panels: &[(&str, Option<&[u32]>)]) -> Canvas {
    let (_, line) = TextSize::Large.cell();
    let zoom = Zoom::towards(width, height, SIDE);
    let cell = zoom.length(width) + GAP;
    let mut canvas = Canvas::new(panels.len() * cell + GAP, zoom.length(height) + line + 3 * GAP);
    let stretch = Stretch::of(pixels);
    for (index, (caption, labels)) in panels.iter().enumerate() {
        let left = GAP + index * cell;
        let panel = Panel { left, top: line + 2 * GAP, width, height, zoom };
        panel.draw(&mut canvas, |pixel| [stretch.shade(pixels[pixel]); 3]);
        labels.iter().for_each(|labels| panel.outline(&mut canvas, labels));
        canvas.text(left, GAP, caption, TextSize::Large, [255; 3]);
    }
    canvas
}
