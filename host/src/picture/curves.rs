//! Functions on [0, 1], drawn side by side.

use super::canvas::TextSize;
use super::{Canvas, Colour, PALETTE};

/// Side of a square of axes.
const SIDE: usize = 260;
/// Between squares, and around them.
const GAP: usize = 24;
const AXES: Colour = [120; 3];

/// A function with its name.
pub type Curve<'a> = (&'a str, &'a dyn Fn(f64) -> f64);

/// Draws for each caption some functions from 0 to 1, their values from `least` to 1, with their names.
pub fn curves(panels: &[(&str, f64, &[Curve<'_>])]) -> Canvas {
    let (_, line) = TextSize::Small.cell();
    let most = panels.iter().map(|panel| panel.2.len()).max().unwrap_or(0);
    let height = SIDE + 2 * GAP + (most + 2) * line;
    let mut canvas = Canvas::new(panels.len() * (SIDE + GAP) + GAP, height);
    for (index, &(caption, least, functions)) in panels.iter().enumerate() {
        let (left, top) = (GAP + index * (SIDE + GAP), GAP + line);
        canvas.text(left, GAP / 2, caption, TextSize::Small, [255; 3]);
        for at in 0..SIDE {
            for (x, y) in [(left + at, top), (left + at, top + SIDE - 1), (left, top + at), (left + SIDE - 1, top + at)]
            {
                canvas.set(x, y, AXES);
            }
        }
        for (number, ((name, function), colour)) in functions.iter().zip(PALETTE).enumerate() {
            let row = |x: usize| {
                let value = (function(x as f64 / (SIDE - 1) as f64) - least) / (1.0 - least);
                top + ((1.0 - value.clamp(0.0, 1.0)) * (SIDE - 1) as f64).round() as usize
            };
            for x in 1..SIDE {
                let (before, own) = (row(x - 1), row(x));
                (before.min(own)..=before.max(own)).for_each(|y| canvas.set(left + x, y, colour));
            }
            canvas.text(left, top + SIDE + GAP / 4 + number * line, name, TextSize::Small, colour);
        }
    }
    canvas
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_runs_from_corner_to_corner() {
        let line = |x: f64| x;
        let canvas = curves(&[("a line", 0.0, &[("x", &line)])]);
        let [colour, ..] = PALETTE;
        let at = |x: usize, y: usize| &canvas.rgb()[3 * (y * canvas.width() + x)..][..3];
        let top = GAP + TextSize::Small.cell().1;
        for along in [1, 100, 200] {
            assert_eq!(at(GAP + along, top + SIDE - 1 - along), colour);
            assert_ne!(at(GAP + along, top + (SIDE - along) / 2), colour);
        }
    }
}
