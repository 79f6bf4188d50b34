//! A frame that is a part of an image: what depends on all of the image, its parts find together.
//!
//! Each part lays the pixels around its own beside them, as far as its sources reach, so that all else comes out as in
//! one piece. A run over a part asks for the answers as it comes to them; while one is missing it tells what its
//! own pixels contribute, and ends. Answers are kept outside, so that a run can begin anew with what is known.

use crate::arithmetic::Level;
use crate::plane::sort::{Keys, SAMPLES};
use crate::plane::walk::Walk;
use core::fmt::Debug;
use core::num::NonZero;
use core::ops::Range;

/// What depends on all of an image, in the order of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// A sample of the values: sorted keys.
    Values,
    /// Pixels with the value that may be filling, and those followed by another: sums.
    Filling,
    /// Pixels that are defined, and filled: sums.
    Defined,
    /// The least value that neighbours reach together: sorted keys, the first of them.
    Least,
    /// The greatest: the last of them.
    Greatest,
    /// Sky of the cells of the mesh in a round: [`CELL_WORDS`] words per cell.
    Cells(u32),
    /// Measured noise in units of the given one, of a sample: sorted keys.
    Relative(u32),
    /// Noise of the lightly smoothed image in a round: sorted keys.
    Fine(u32),
    /// Sums of its powers.
    FinePowers(u32),
    /// Noise of what stronger smoothing takes away: sorted keys.
    Details(u32),
    /// Sums of its powers.
    DetailPowers(u32),
    /// Scatter of the sky: sorted keys.
    PhotonSky,
    /// Scatter at a level of brightness: sorted keys.
    Photons(u32),
    /// The brightest sources and the light around them: see [`crate::sources::typical`].
    Typical,
    /// Noise of the narrow image: sorted keys.
    Narrow,
    /// Sums of its powers.
    NarrowPowers,
    /// Noise of the matched image: sorted keys.
    Matched,
    /// Sums of its powers.
    MatchedPowers,
    /// Differences of neighbours in the matched image: sorted keys.
    Slope,
    /// Sums of their powers.
    SlopePowers,
    /// How far up in significance what may be a source is one: sorted keys.
    Reaches,
}

/// Words of a cell in the answer to [`Question::Cells`]: its index, by which they are sorted, its pixels, those that
/// are defined and that are sky, and the bits of level and noise, and of the noise if most cells are crowded.
pub const CELL_WORDS: usize = 7;

/// The whole of an image, asked by one of its parts.
pub trait Whole: Debug + Sync {
    /// Where the part lies.
    fn part(&self) -> Part;

    /// The answer in words. `own` gives what the part contributes, and is asked only while there is no answer.
    fn words(&self, question: Question, own: &mut dyn Iterator<Item = u32>) -> Option<&[u32]>;

    /// The answer in sums over all parts of what `own` gives.
    fn sums(&self, question: Question, own: &mut dyn FnMut() -> [f64; 4]) -> Option<[f64; 4]>;

    /// Whether there is an answer.
    fn knows(&self, question: Question) -> bool;

    /// Whether an answer is missing that has been asked for.
    fn is_waiting(&self) -> bool;
}

/// Where a part lies in an image, and which of its pixels are its own; the others are its neighbours'.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Columns and rows of the image.
    pub image: (usize, usize),
    /// Column and row of the part's first pixel in the image.
    pub origin: (usize, usize),
    /// The part's own columns, counted in the part.
    pub columns: Range<usize>,
    /// Its own rows.
    pub rows: Range<usize>,
}

impl Part {
    /// Its own pixels, by their index in the part, whose rows have `width` pixels.
    pub fn own(&self, width: usize) -> impl Iterator<Item = usize> + use<> {
        let columns = self.columns.clone();
        self.rows.clone().flat_map(move |y| columns.clone().map(move |x| y * width + x))
    }

    /// Of these every `stride`th of the image.
    pub fn sample(&self, width: usize, stride: usize) -> impl Iterator<Item = usize> + use<> {
        let (columns, (left, bottom), across) = (self.columns.clone(), self.origin, self.image.0);
        let stride = NonZero::new(stride).unwrap_or(NonZero::<usize>::MIN);
        self.rows.clone().flat_map(move |y| {
            let first = (bottom + y) * across + left + columns.start;
            let before = (stride.get() - first % stride) % stride;
            (columns.start + before..columns.end).step_by(stride.get()).map(move |x| y * width + x)
        })
    }

    /// Whether a pixel is its own.
    pub fn owns(&self, (x, y): (usize, usize)) -> bool {
        self.columns.contains(&x) && self.rows.contains(&y)
    }

    /// The place in the image of a place in the part.
    pub fn place(&self, (x, y): (usize, usize)) -> (usize, usize) {
        (self.origin.0 + x, self.origin.1 + y)
    }

    /// Pixels of the image.
    pub fn pixels(&self) -> usize {
        self.image.0.saturating_mul(self.image.1)
    }

    /// The stride at which the image is sampled, as [`Keys::stride`] has it in one piece.
    pub fn stride(&self) -> usize {
        let pixels = self.pixels();
        pixels.div_ceil(pixels.clamp(1, SAMPLES)) | 1
    }
}

/// The keys of the values of a frame of `count` pixels, or of all parts of an image, the least first: of a
/// sample, or of all pixels. Within, `None` while the parts have not answered.
pub(crate) fn sorted<'k, L: Level>(
    walk: &mut Walk,
    whole: Option<(&'k dyn Whole, Question)>,
    (count, width, sampled): (usize, usize, bool),
    keys: &'k mut Keys<'_>,
    value: impl Fn(usize) -> Option<L>,
) -> Option<Option<&'k [u32]>> {
    let Some((whole, question)) = whole else {
        let stride = if sampled { keys.stride(count) } else { 1 };
        let values = |items: Range<usize>| items.filter_map(|item| value(item.saturating_mul(stride)));
        return keys.gather(walk, (count.div_ceil(stride.max(1)), 1), values).map(Some);
    };
    let part = whole.part();
    let stride = if sampled { part.stride() } else { 1 };
    Some(whole.words(question, &mut part.sample(width, stride).filter_map(|at| value(at).map(Level::key))))
}

#[cfg(test)]
mod tests {
    use super::*;

    extern crate std;
    use std::vec::Vec;

    #[test]
    fn parts_sample_what_the_whole_samples() {
        let (width, height, stride) = (23, 11, 7);
        let mut found = Vec::new();
        for (left, right) in [(0, 9), (9, 23)] {
            for (bottom, top) in [(0, 5), (5, 11)] {
                // With a pixel of its neighbours on every side.
                let (x0, y0) = (left.max(1) - 1, bottom.max(1) - 1);
                let row = right.min(width - 1) + 1 - x0;
                let part = Part {
                    image: (width, height),
                    origin: (x0, y0),
                    columns: left - x0..right - x0,
                    rows: bottom - y0..top - y0,
                };
                assert_eq!(part.own(row).count(), (right - left) * (top - bottom));
                assert!(part.own(row).all(|at| part.owns((at % row, at / row))));
                found.extend(part.sample(row, stride).map(|at| {
                    let (x, y) = part.place((at % row, at / row));
                    y * width + x
                }));
            }
        }
        found.sort_unstable();
        assert_eq!(found, (0..width * height).step_by(stride).collect::<Vec<_>>());
    }
}
