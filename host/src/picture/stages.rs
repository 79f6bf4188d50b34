//! The steps of a run side by side, each with its name.

use super::canvas::TextSize;
use super::outline::{Panel, Zoom};
use super::{Canvas, Colour, PALETTE, Stretch};
use crate::pipeline::{Segmentation, StagePlanes};
use skyfront_core::config::{Config, Scheme};

/// The longer side of one panel, about.
const SIDE: usize = 400;
/// Between panels.
const GAP: usize = 8;
/// Panels in a row.
const COLUMNS: usize = 3;

/// A stage: its name, and what its picture shows.
pub type Caption = (&'static str, &'static str);

/// The stages of the paper, in order.
const PAPER: [Caption; 6] = [
    ("normalised", "pixel values between 0 and 1"),
    ("rescaled", "contrast raised between sky and sources"),
    ("filtered", "noise smoothed away"),
    ("edge detector", "dark where the front is held"),
    ("front", "blue where it has passed, outlined where it stopped"),
    ("segments", "each source in a colour of its own"),
];
/// Those of a front by regions, in the same places; nothing is rescaled.
const BY_REGION: [Caption; 6] = [
    ("signal to noise", "above the sky, in units of a pixel's noise"),
    ("", ""),
    ("smoothed", "noise smoothed away where no detail is lost"),
    ("sources and surroundings", "white where the sky is not measured"),
    ("level", "blue below the outline's level, grey above"),
    ("segments", "what is significant, each source in a colour of its own"),
];

/// Those of four phases, which no edge holds.
const PHASES: [Caption; 6] = [
    PAPER[0],
    PAPER[1],
    PAPER[2],
    ("", ""),
    ("phases", "blue for the darkest, the brighter ones lighter and outlined"),
    PAPER[5],
];

/// The stages of a configuration, in order; those without a name have no picture.
pub fn captions(config: &Config) -> [Caption; 6] {
    match config.scheme {
        Scheme::Region => BY_REGION,
        Scheme::Multiphase => PHASES,
        _ => PAPER,
    }
}

/// Draws one stage by its place in [`captions`], if there is anything to draw.
pub fn stage(run: &Segmentation, planes: &StagePlanes, index: usize) -> Option<Canvas> {
    let zoom = Zoom::towards(run.width, run.height, SIDE);
    let panel = Panel { left: 0, top: 0, width: run.width, height: run.height, zoom };
    let mut canvas = Canvas::new(zoom.length(run.width), zoom.length(run.height));
    draw(&mut canvas, &panel, run, planes, index).then_some(canvas)
}

/// Draws the stages of a run that kept its planes.
pub fn stages(config: &Config, run: &Segmentation, planes: &StagePlanes) -> Canvas {
    let zoom = Zoom::towards(run.width, run.height, SIDE);
    let (_, line) = TextSize::Large.cell();
    let (wide, high) = (zoom.length(run.width), zoom.length(run.height));
    let cell = ((wide + GAP).max(180), high + line + GAP);
    let mut canvas = Canvas::new(COLUMNS * cell.0 + GAP, 2 * cell.1 + GAP);
    let named = captions(config).into_iter().enumerate().filter(|(_, (caption, _))| !caption.is_empty());
    for (place, (index, (caption, _))) in named.enumerate() {
        let (left, top) = (GAP + place % COLUMNS * cell.0, GAP + place / COLUMNS * cell.1);
        let panel = Panel { left, top: top + line, width: run.width, height: run.height, zoom };
        let drawn = draw(&mut canvas, &panel, run, planes, index);
        let caption = if drawn { caption.to_owned() } else { format!("{caption}: none") };
        canvas.text(left, top, &caption, TextSize::Large, [255; 3]);
    }
    canvas
}

/// Levels beyond this are drawn alike: a bright source must not darken all others.
const MOST_LEVEL: f32 = 10.0;

/// Draws one panel; whether there was anything to draw.
fn draw(canvas: &mut Canvas, panel: &Panel, run: &Segmentation, planes: &StagePlanes, index: usize) -> bool {
    let mut grey = |plane: &[f32], stretch: &Stretch| {
        if !plane.is_empty() {
            panel.draw_image(canvas, plane, stretch);
        }
        !plane.is_empty()
    };
    match index {
        0 => grey(&planes.normalised, &Stretch::of(&planes.normalised)),
        1 => grey(&planes.rescaled, &Stretch::of(&planes.rescaled)),
        2 => grey(&planes.filtered, &Stretch::of(&planes.filtered)),
        3 => grey(&planes.edge, &Stretch::linear(0.0, 1.0)),
        4 => {
            let most = run.front.iter().fold(0.0f32, |most, value| most.max(value.abs())).min(MOST_LEVEL);
            panel.draw(canvas, |pixel| level_colour(run.front[pixel], most));
            let inside: Vec<u32> = run.front.iter().map(|&u| u32::from(u > 0.0)).collect();
            panel.outline(canvas, &inside);
            true
        }
        _ => {
            panel.draw(canvas, |pixel| match run.labels[pixel] {
                0 => [0; 3],
                label => PALETTE[label as usize % PALETTE.len()],
            });
            true
        }
    }
}

/// Blue where the front has passed (u < 0), white where objects are (u > 0), darker near zero.
pub(super) fn level_colour(u: f32, most: f32) -> Colour {
    let strength = 60.0 + 160.0 * (u.abs() / most.max(f32::MIN_POSITIVE)).min(1.0);
    if u > 0.0 { [strength as u8; 3] } else { [0, (strength * 0.45) as u8, strength as u8] }
}
