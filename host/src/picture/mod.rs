//! Pictures for people: the stages of a run side by side, and the outlines over the image.
//!
//! Row 0 of an image is its bottom row, as astronomers draw it. Colours are told apart by
//! colour-blind people too (Okabe and Ito, <https://jfly.uni-koeln.de/color/>).

mod beside;
mod canvas;
mod contact;
mod curves;
mod outline;
mod overlay;
mod stages;
mod stretch;

pub use beside::side_by_side;
pub use canvas::Canvas;
pub use contact::contact_sheet;
pub use curves::{Curve, curves};
pub use outline::{Zoom, reduced};
pub use overlay::{overlay, overlay_in};
pub use stages::{captions, stage, stages};
pub use stretch::Stretch;

/// A colour, red, green, blue.
pub type Colour = [u8; 3];

/// Outlines and other marks: vermilion, which no grey hides.
pub const MARK: Colour = [255, 140, 0];

/// Eight colours for neighbouring sources.
pub const PALETTE: [Colour; 8] = [
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [240, 228, 66],
    [0, 114, 178],
    [213, 94, 0],
    [204, 121, 167],
    [200, 200, 200],
];
