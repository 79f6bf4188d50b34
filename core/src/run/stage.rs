//! The stages that a run can have; which of them it has, and in which order, tells [`crate::run::plan`].

/// What is done in a step; each is one pass over the rows, or several. As keys they are sorted as declared, which is no
/// order of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Extremes of the pixels (one pass).
    Extremes,
    /// The low percentile (four passes), where asked for.
    LowPercentile,
    /// The high percentile (four passes), where asked for.
    HighPercentile,
    /// Sky and noise of the pixels (up to [`crate::sky::noise::PASSES`] passes), where asked for.
    Sky,
    /// The median, which stands in for undefined pixels (four passes), where there are any.
    Median,
    /// Pixels into the image plane.
    Normalize,
    /// The threshold of `r3`, where a rule finds it: a histogram, or the noise of the image.
    Threshold,
    /// Rescaling in place.
    Rescale,
    /// The filter, one pass a step.
    Filter,
    /// Otsu's threshold of the filtered image, where a start near the objects asks for it, or the four
    /// classes that phases start from.
    StartLevel,
    /// Which pixels lie above the level, where the front starts near the objects.
    StartMark,
    /// Distances to them, spreading to higher rows.
    StartUp,
    /// Distances to them, spreading to lower rows.
    StartDown,
    /// Extremes of the gradient.
    Gradient,
    /// The image plane becomes the edge detector.
    Edge,
    /// `u0` into the front plane, or a check of the caller's.
    Front,
    /// The front moves, one pass a step.
    Evolve,
    /// `u0` becomes times of arrival (fast marching, as the next three).
    Seed,
    /// The first pixels are put into their buckets.
    Sow,
    /// Pixels are settled, as many a row as a row has columns, in passes until none is left.
    March,
    /// Times become the front at `t_max`.
    Arrive,
    /// The front's sign is turned, where it grew: what it enclosed comes to lie above 0. Two fronts become
    /// their phases, ranked by their means: -1 for the darkest, then 1 to 3 (two passes).
    Turn,
    /// Provisional labels (label pass 1).
    Provisional,
    /// Label pass 2, over the table.
    Resolve,
    /// Label pass 3.
    Count,
    /// Label pass 4, over the table.
    Number,
    /// Label pass 5, and the catalogue.
    Measure,
    /// How the values of the frame came about ([`crate::sky::Values`]).
    Values,
    /// Sky and noise, and with them signal-to-noise.
    Background,
    /// Signal-to-noise smoothed, lightly and by need.
    Smooth,
    /// Sources out of the way, so that the sky can be measured without them.
    Mask,
    /// The photon noise ([`crate::sky::photon`]).
    Photon,
    /// The front from the threshold ([`crate::front::outline`]).
    Outline,
    /// The tree of level sets.
    Tree,
    /// Its regions become sources, each one connected piece.
    Deblend,
    /// Connected components in place of a tree.
    Components,
    /// Which sources are kept, and their numbers.
    Select,
    /// Nothing left to do.
    Done,
}

impl Stage {
    /// All stages, in the order in which they are declared.
    pub const ALL: [Stage; 38] = [
        Stage::Extremes,
        Stage::LowPercentile,
        Stage::HighPercentile,
        Stage::Sky,
        Stage::Median,
        Stage::Normalize,
        Stage::Threshold,
        Stage::Rescale,
        Stage::Filter,
        Stage::StartLevel,
        Stage::StartMark,
        Stage::StartUp,
        Stage::StartDown,
        Stage::Gradient,
        Stage::Edge,
        Stage::Front,
        Stage::Evolve,
        Stage::Seed,
        Stage::Sow,
        Stage::March,
        Stage::Arrive,
        Stage::Turn,
        Stage::Provisional,
        Stage::Resolve,
        Stage::Count,
        Stage::Number,
        Stage::Measure,
        Stage::Values,
        Stage::Background,
        Stage::Smooth,
        Stage::Mask,
        Stage::Photon,
        Stage::Outline,
        Stage::Tree,
        Stage::Deblend,
        Stage::Components,
        Stage::Select,
        Stage::Done,
    ];

    /// Whether it is done by a [`Segmenter`](crate::run::segmenter::Segmenter), row by row.
    pub const fn is_of_front(self) -> bool {
        (self as u32) <= Stage::Measure as u32
    }

    /// Whether it makes the filtered image: of several bands, of each.
    pub const fn is_of_band(self) -> bool {
        (self as u32) <= Stage::Filter as u32
    }

    /// Its number in snapshots.
    pub(crate) fn code(self) -> u32 {
        self as u32
    }

    /// The stage with that number; the first where there is none.
    pub(crate) fn from_code(code: u32) -> Stage {
        Stage::ALL.get(code as usize).copied().unwrap_or(Stage::Extremes)
    }
}
