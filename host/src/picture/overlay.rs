//! The image in a readable stretch with the outlines of its sources, and their numbers where there is room.

use super::canvas::TextSize;
use super::outline::{Panel, Zoom};
use super::{Canvas, PALETTE, Stretch};
use skyfront_core::sources::catalog::Source;

/// With more numbers than one on so many picture pixels, or than 150 in all, they would hide the image.
const ROOM_OF_A_NUMBER: usize = 10_000;
/// Numbers that even a small picture may have.
const FEW_NUMBERS: usize = 150;
/// The longer side of the picture, about.
const SIDE: usize = 1200;
/// That of large images, whose sources would be lost otherwise.
const MOST_SIDE: usize = 2048;

/// Draws the overlay of an image, row-major, with labels of the same shape, near 1200 picture pixels, up to 2048
/// for large ones.
pub fn overlay(pixels: &[f32], labels: &[u32], width: usize, height: usize, sources: &[Source]) -> Canvas {
    let side = width.max(height).clamp(SIDE, MOST_SIDE);
    overlay_in(Zoom::towards(width, height, side), pixels, (width, height), labels, sources)
}

/// Draws the overlay of an image of (columns, rows) at a scale.
pub fn overlay_in(
    zoom: Zoom,
    pixels: &[f32],
    (width, height): (usize, usize),
    labels: &[u32],
    sources: &[Source],
) -> Canvas {
    let panel = Panel { left: 0, top: 0, width, height, zoom };
    let (columns, rows) = panel.size();
    let mut canvas = Canvas::new(columns, rows);
    panel.draw_image(&mut canvas, pixels, &Stretch::of(pixels));
    panel.outline(&mut canvas, labels);
    let mut room = Room { taken: vec![false; columns * rows], columns, rows };
    panel.each_pixel(|column, row, index| room.taken[row * columns + column] = labels[index] != 0);
    let mut brightest: Vec<&Source> = sources.iter().collect();
    brightest.sort_by(|one, other| other.peak.total_cmp(&one.peak));
    brightest.truncate((columns * rows / ROOM_OF_A_NUMBER).max(FEW_NUMBERS));
    brightest.into_iter().for_each(|source| number(&mut canvas, &panel, &mut room, source));
    canvas
}

/// Which picture pixels hold a source or a number already.
struct Room {
    taken: Vec<bool>,
    columns: usize,
    rows: usize,
}

impl Room {
    /// Takes a rectangle if all of it is on the picture and free.
    fn take(&mut self, (left, top): (usize, usize), (wide, high): (usize, usize)) -> bool {
        if left + wide > self.columns || top + high > self.rows {
            return false;
        }
        let rows = (top..top + high).map(|row| row * self.columns + left);
        let free = rows.clone().all(|start| !self.taken[start..start + wide].contains(&true));
        if free {
            rows.for_each(|start| self.taken[start..start + wide].fill(true));
        }
        free
    }
}

/// Writes a source's label at the first corner of its bounding box that has room, or not at all.
fn number(canvas: &mut Canvas, panel: &Panel, room: &mut Room, source: &Source) {
    let text = source.label.to_string();
    let (wide, high) = TextSize::Small.cell();
    let (wide, high) = (wide as f64 * text.len() as f64, high as f64);
    let (left, bottom) = panel.position(f64::from(source.columns.0) - 1.0, f64::from(source.rows.0) - 1.0);
    let (right, top) = panel.position(f64::from(source.columns.1) + 1.0, f64::from(source.rows.1) + 1.0);
    let corners = [(right, top - high), (right, bottom), (left - wide, top - high), (left - wide, bottom)];
    for (x, y) in corners.into_iter().filter(|&(x, y)| x >= 0.0 && y >= 0.0) {
        let at = (x as usize, y as usize);
        if room.take(at, (wide as usize, high as usize)) {
            canvas.text(at.0, at.1, &text, TextSize::Small, PALETTE[1]);
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of sources in rows of boxes; which picture pixels have the numbers' colour.
    fn numbered(side: usize, boxes: &[(u32, u32)], zoom: Zoom) -> Vec<bool> {
        let mut labels = vec![0; side * side];
        let mut sources = Vec::new();
        for (label, &(x, y)) in (1..).zip(boxes) {
            labels[y as usize * side + x as usize] = label;
            let mut source = Source::empty(label);
            source.add(x, y, label as f32, 0.0);
            sources.push(source);
        }
        let pixels = vec![0.0; side * side];
        let canvas = overlay_in(zoom, &pixels, (side, side), &labels, &sources);
        canvas.rgb().chunks_exact(3).map(|pixel| pixel == PALETTE[1]).collect()
    }

    #[test]
    fn numbers_keep_apart_or_are_left_out() {
        let count = |boxes: &[(u32, u32)]| numbered(60, boxes, Zoom::Enlarge(1)).iter().filter(|&&is| is).count();
        let [one, seven] = [count(&[(30, 30)]), count(&[(30, 30); 1])];
        assert!(one > 5 && one == seven);
        let apart = count(&[(10, 30), (40, 30)]);
        let near = count(&[(30, 30), (31, 30), (30, 31)]);
        assert!(apart > one && near > one, "there is room at other corners: {apart}, {near}, {one}");
        // A field full of sources leaves room for none.
        let full: Vec<(u32, u32)> =
            (0..3600).map(|at| (at % 60, at / 60)).filter(|(x, y)| x % 4 == 0 && y % 4 == 0).collect();
        assert_eq!(count(&full), 0);
    }

    #[test]
    fn large_images_are_drawn_larger_and_any_scale_can_be_had() {
        let drawn = |side: usize| overlay(&vec![0.0; side * side], &vec![0; side * side], side, side, &[]).width();
        assert_eq!([100, 300, 1300, 2048, 4096].map(drawn), [800, 1200, 1300, 2048, 2048]);
        let scaled = |zoom| overlay_in(zoom, &[0.0; 400], (20, 20), &[0; 400], &[]).width();
        assert_eq!([scaled(Zoom::Enlarge(3)), scaled(Zoom::Reduce(3))], [60, 7]);
    }
}
