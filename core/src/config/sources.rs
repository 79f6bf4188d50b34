//! What a run on signal-to-noise asks of the sky and of a source. "Noise units" are standard
//! deviations of a pixel of empty sky.

/// How sky and noise are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Background {
    /// Not at all: the run is on pixel values, and needs two planes only.
    None,
    /// One level and one noise for the whole frame.
    Frame,
    /// Measured in the cells of a mesh, and smooth between them.
    Mesh {
        /// Side of a cell in pixels, 16 to 4096; a frame has at most
        /// [`MOST_CELLS`](crate::sky::MOST_CELLS) along an axis.
        size: u16,
    },
}

impl Background {
    /// Whether the run is on signal-to-noise.
    pub const fn is_known(self) -> bool {
        !matches!(self, Background::None)
    }

    /// Side of a cell in pixels.
    pub const fn cell(self) -> usize {
        match self {
            Background::None | Background::Frame => 1 << 30,
            Background::Mesh { size } => size as usize,
        }
    }
}

/// The outline of a run on signal-to-noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline {
    /// Where the smoothed image has this many noise units begins a source. 0.1 to 100.
    pub threshold: f32,
    /// Steps of the front of [`Scheme::Region`](super::Scheme::Region); 0 leaves it at the threshold. 0 to 1000.
    pub steps: u32,
    /// Weight of that front's curvature, in pixels times noise units: how smooth the outlines are.
    /// 0 to 1.
    pub curvature: f32,
}

impl Outline {
    /// The default for every kind of sky.
    pub const DEFAULT: Outline = Outline { threshold: 1.0, steps: 5, curvature: 0.6 };
}

/// How the outlined pixels become sources.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separate {
    /// Connected components.
    Components,
    /// The tree of level sets: what touches is divided where it has peaks of its own.
    Tree,
}

/// When the parts of a blend are sources of their own, with [`Separate::Tree`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deblending {
    /// Light of a branch above the saddle that makes it a source, in noise units. 0 to 10^6.
    pub branch: f32,
    /// The same as a part of the brighter neighbour's light. 0 to 1.
    pub contrast: f32,
    /// How much the image is sharpened before it is divided into sources. 0 to 4.
    pub sharpening: f32,
    /// Light that the mirrored host does not explain, in noise of the lightly smoothed image. 0 to
    /// 10^6.
    pub excess: f32,
    /// Pixels of it, at least 1.
    pub reopened_area: u32,
    /// So many knots, as sharp as stars, are part of the galaxy that they touch; 0: none are. 0 to 10^9.
    pub knots: u32,
}

impl Deblending {
    /// The default for every kind of sky.
    pub const DEFAULT: Deblending =
        Deblending { branch: 10.0, contrast: 0.0005, sharpening: 0.6, excess: 5.5, reopened_area: 4, knots: 3 };
}

/// Which sources are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Select {
    /// Those of at least the smallest area.
    Area,
    /// Those of them that noise alone would not make.
    Significance,
}

/// What noise alone would not make, with [`Select::Significance`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Significance {
    /// Peaks of pure noise that may be taken for sources in a frame, on average. 0.001 to 1000.
    pub false_sources: f32,
    /// The share of the sources that may be such peaks, where that is more. 0 to 0.5.
    pub false_share: f32,
    /// A source's peak in the matched image, as a multiple of the threshold: what is hardly above it
    /// there has hardly a pixel inside. 0 to 100.
    pub peak: f32,
    /// Light of a source in all, in noise units. 0 to 10^6.
    pub light: f32,
}

impl Significance {
    /// The default for every kind of sky.
    pub const DEFAULT: Significance = Significance { false_sources: 0.5, false_share: 0.05, peak: 1.42, light: 15.0 };
}

/// Pixels of a part that was divided from another source, five thirds of `min_area`: noise on the
/// light of a bright galaxy makes smaller ones.
pub fn part_area(min_area: u32) -> u32 {
    min_area.saturating_add(min_area.saturating_mul(2) / 3)
}

/// Pixels that will do for a source that stands out and is divided from no other, two thirds of `min_area`: the sharpest
/// stars light hardly four.
pub fn narrow_area(min_area: u32) -> u32 {
    min_area.saturating_sub(min_area / 3)
}
