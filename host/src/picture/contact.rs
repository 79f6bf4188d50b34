//! Many runs on one sheet: for each the front and the segmented image, as the paper shows them.

use super::canvas::TextSize;
use super::outline::{Panel, Zoom};
use super::stages::level_colour;
use super::{Canvas, Stretch};
use crate::pipeline::Segmentation;

/// The longer side of one panel, about.
const SIDE: usize = 300;
/// Between panels.
const GAP: usize = 8;
/// Runs side by side.
const COLUMNS: usize = 4;

/// Draws runs with their captions, each with the image it segmented, left to right and top to bottom.
pub fn contact_sheet(runs: &[(String, &[f32], Segmentation)]) -> Canvas {
    let (_, line) = TextSize::Small.cell();
    let zoom = |run: &Segmentation| Zoom::towards(run.width, run.height, SIDE);
    let tallest = runs.iter().map(|(_, _, run)| zoom(run).length(run.height)).max().unwrap_or(0);
    let widest = runs.iter().map(|(_, _, run)| zoom(run).length(run.width)).max().unwrap_or(0);
    let cell = (2 * (widest + GAP), tallest + line + GAP);
    let mut canvas = Canvas::new(COLUMNS * cell.0 + GAP, runs.len().div_ceil(COLUMNS) * cell.1 + GAP);
    for (index, (caption, pixels, run)) in runs.iter().enumerate() {
        let (left, top) = (GAP + index % COLUMNS * cell.0, GAP + index / COLUMNS * cell.1);
        let front = Panel { left, top: top + line, width: run.width, height: run.height, zoom: zoom(run) };
        let most = run.front.iter().fold(0.0f32, |most, value| most.max(value.abs()));
        front.draw(&mut canvas, |pixel| level_colour(run.front[pixel], most));
        let inside: Vec<u32> = run.front.iter().map(|&u| u32::from(u > 0.0)).collect();
        front.outline(&mut canvas, &inside);
        let stretch = Stretch::of(pixels);
        let mean = |pixel: usize| match run.labels[pixel] {
            0 => 0,
            label => run.sources.get(label as usize - 1).map_or(0, |source| stretch.shade(source.mean()).max(40)),
        };
        Panel { left: left + widest + GAP / 2, ..front }.draw(&mut canvas, |pixel| [mean(pixel); 3]);
        canvas.text(left, top, caption, TextSize::Small, [255; 3]);
    }
    canvas
}
