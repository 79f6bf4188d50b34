//! A frame with what is known of it beforehand: which pixels are observations, and maps of sky and noise.

use crate::arithmetic::Level;
use crate::plane::grid::Grid;
use crate::plane::mask::Mask;
use crate::plane::part::{Question, Whole};
use crate::plane::sort::Keys;
use crate::sky::Values;
use crate::sky::tail::Tail;

/// What is known of the sky beforehand; what is not is measured on the image.
#[derive(Clone, Copy, Debug, Default)]
pub struct Known<'a> {
    /// W x H: the background, in units of the image. Where it is not finite, the pixel is undefined.
    pub background: Option<&'a [f32]>,
    /// W x H: the standard deviation of each pixel. Where it is not finite or not above 0, the
    /// pixel is undefined.
    pub noise: Option<&'a [f32]>,
    /// Whether `noise` says only which pixels are noisier than others, as weight maps do: it is
    /// then multiplied by one factor, so that it agrees with the noise that is measured.
    pub relative: bool,
    /// The image that the frame is a part of, which knows what depends on all of it.
    pub whole: Option<&'a dyn Whole>,
}

impl Known<'_> {
    /// Columns and rows of the image that a frame of this size is, or is a part of.
    pub(crate) fn image(&self, frame: (usize, usize)) -> (usize, usize) {
        self.whole.map_or(frame, |whole| whole.part().image)
    }

    #[inline]
    pub(crate) fn value(map: Option<&[f32]>, at: usize) -> Option<f32> {
        map.and_then(|map| map.get(at).copied())
    }

    /// Whether the maps leave the pixel defined.
    #[inline]
    pub(crate) fn allows(&self, at: usize) -> bool {
        Self::value(self.background, at).is_none_or(f32::is_finite)
            && Self::value(self.noise, at).is_none_or(|noise| noise.is_finite() && noise > 0.0)
    }
}

/// A frame with what is known of it.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// W x H, row-major.
    pub pixels: &'a [f32],
    /// Its shape.
    pub grid: Grid,
    /// Sky and noise that were given.
    pub known: Known<'a>,
    /// How its values came about.
    pub values: Values,
}

impl<'a> View<'a> {
    /// Looks at a frame.
    pub fn of(pixels: &'a [f32], grid: Grid, known: Known<'a>, keys: Keys<'_>) -> View<'a> {
        let values = Values::asked(known.whole, pixels, grid.width.get(), |at| known.allows(at), keys);
        View { pixels, grid, known, values: values.unwrap_or(Values::UNKNOWN) }
    }

    /// Columns and rows of the image that the frame is, or is a part of.
    pub(crate) fn image(&self) -> (usize, usize) {
        self.known.image((self.grid.width.get(), self.grid.height))
    }

    /// The tail of a plane's noise, asked by these questions where the frame is a part; means nothing while others
    /// have yet to answer.
    pub(crate) fn tail<L: Level>(
        &self,
        questions: [Question; 2],
        value: impl Fn(usize) -> L,
        masked: Mask<'_>,
        keys: Keys<'_>,
    ) -> Tail<L> {
        let whole = self.known.whole.map(|whole| (whole, questions));
        Tail::asked(whole, self.grid, value, masked, self.values.piled, keys).unwrap_or(Tail::UNKNOWN)
    }

    /// Whether a pixel is an observation that may be used.
    #[inline]
    pub fn is_defined(&self, at: usize) -> bool {
        self.pixels.get(at).is_some_and(|&pixel| self.values.holds(pixel)) && self.known.allows(at)
    }

    /// Whether every pixel is defined, of all of the image where this is a part.
    pub(crate) fn is_whole(&self) -> bool {
        let (columns, rows) = self.image();
        self.values.defined as usize == columns * rows
    }

    /// The two defined pixels of its row, or else of its column, between which an undefined one lies.
    pub(crate) fn between(&self, at: usize) -> Option<[usize; 2]> {
        let (Grid { width, height }, (x, y)) = (self.grid, self.grid.place(at));
        let defined = |pair: &[usize; 2]| pair.iter().all(|&at| self.is_defined(at));
        let row = (x > 0 && x + 1 < width.get()).then(|| [at - 1, at + 1]).filter(defined);
        let column = || (y > 0 && y + 1 < height).then(|| [at - width.get(), at + width.get()]).filter(defined);
        row.or_else(column)
    }

    /// Whether there is a signal: the pixel is defined, or lies between two that are.
    pub fn has_signal(&self, at: usize) -> bool {
        self.is_defined(at) || self.between(at).is_some()
    }
}
