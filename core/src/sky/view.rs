//! A frame with what is known of it beforehand: which pixels are observations, and maps of sky and noise.

use crate::arithmetic::Level;
use crate::error::Error;
use crate::plane::camera::Camera;
use crate::plane::grid::Grid;
use crate::plane::mask::Mask;
use crate::plane::part::{Question, Whole};
use crate::plane::raster::{BadPixel, Raster, Sample};
use crate::plane::sort::Keys;
use crate::plane::walk::Walk;
use crate::sky::Values;
use crate::sky::tail::{Shape, Tail};
use crate::sky::values::Look;

/// What is known of the sky beforehand; what is not is measured on the image.
///
/// ```
/// use skyfront_core::plane::raster::BadPixel;
/// use skyfront_core::sky::view::Known;
///
/// // A column that has died from row 5 on, and a noise map; the background is measured.
/// let bad = [5, 6, 7].map(|y| BadPixel { x: 3, y });
/// let noise = [2.5; 8 * 8];
/// let known = Known { noise: Some(&noise), bad: &bad, ..Known::default() };
/// assert!(known.background.is_none() && !known.relative);
/// ```
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
    /// Pixels that are undefined whatever they hold, row by row and along these.
    pub bad: &'a [BadPixel],
    /// The camera: its gain counts in the errors of sources, and its saturation in their flags. Sky, noise and the width
    /// of stars are measured.
    pub camera: Option<&'a Camera>,
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

    /// Checks the camera, and that the list of bad pixels is in order.
    ///
    /// # Errors
    /// [`Error::Parameter`] names what is out of bounds, or the first pixel that lies before the one before it.
    pub(crate) fn check(&self) -> Result<(), Error> {
        self.camera.map_or(Ok(()), Camera::validate)?;
        let before = |pair: &[BadPixel]| pair.first().map(BadPixel::place) > pair.get(1).map(BadPixel::place);
        let unordered = self.bad.windows(2).position(before).and_then(|at| self.bad.get(at..)?.first_chunk());
        let Some(&[before, bad]) = unordered else { return Ok(()) };
        let (name, value, limit) = match bad.y == before.y {
            true => ("column of a bad pixel", bad.x, before.x),
            false => ("row of a bad pixel", bad.y, before.y),
        };
        Err(Error::Parameter {
            name,
            value: f32::from(value),
            bound: "at least that of the one before,",
            limit: f32::from(limit),
        })
    }

    /// Whether the pixel is in the list of bad ones. Cost: `log2` of its length.
    #[inline]
    fn is_bad(&self, grid: Grid, at: usize) -> bool {
        if self.bad.is_empty() {
            return false;
        }
        let (x, y) = grid.place(at);
        self.bad.binary_search_by(|bad| bad.place().cmp(&(y as u16, x as u16))).is_ok()
    }
}

/// A frame with what is known of it.
#[derive(Debug)]
pub struct View<'a, P = f32> {
    /// W x H.
    pub frame: Raster<'a, P>,
    /// Its shape.
    pub grid: Grid,
    /// Sky and noise that were given.
    pub known: Known<'a>,
    /// How its values came about.
    pub values: Values,
}

impl<P> Clone for View<'_, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<P> Copy for View<'_, P> {}

impl<'a, P: Sample> View<'a, P> {
    /// Looks at a frame.
    pub fn of(frame: Raster<'a, P>, grid: Grid, known: Known<'a>, keys: Keys<'_>) -> View<'a, P> {
        let (mut look, mut view) = (Look::NOTHING, View { frame, grid, known, values: Values::UNKNOWN });
        let _ = view.look(&mut Walk::whole(), &mut look, keys);
        view
    }

    /// The same in parts.
    pub(crate) fn look(&mut self, walk: &mut Walk, look: &mut Look, keys: Keys<'_>) -> Option<()> {
        let View { frame, grid, known, .. } = *self;
        let allowed = |at: usize| known.allows(at) && !known.is_bad(grid, at);
        look.step(walk, known.whole, &frame, allowed, keys)?;
        self.values = look.values;
        Some(())
    }

    /// Columns and rows of the image that the frame is, or is a part of.
    pub(crate) fn image(&self) -> (usize, usize) {
        self.known.image((self.grid.width.get(), self.grid.height))
    }

    /// Column and row of the image at which the frame begins.
    pub(crate) fn origin(&self) -> (usize, usize) {
        self.known.whole.map_or((0, 0), |whole| whole.part().origin)
    }

    /// Finds the tail of a plane's noise, asked by these questions where the frame is a part; means nothing while others
    /// have yet to answer.
    pub(crate) fn tail<L: Level>(
        &self,
        walk: &mut Walk,
        (tail, questions): (&mut Tail<L>, [Question; 2]),
        value: impl Fn(usize) -> L,
        masked: Mask<'_>,
        keys: Keys<'_>,
    ) -> Option<()> {
        let whole = self.known.whole.map(|whole| (whole, questions));
        let shape = Shape { piled: self.values.piled, coarse: self.values.coarse };
        tail.step(walk, (whole, self.grid), value, (masked, shape), keys)
    }

    /// Whether a pixel is an observation that may be used.
    #[inline]
    pub fn is_defined(&self, at: usize) -> bool {
        self.frame.value(at).is_some_and(|pixel| self.values.holds(pixel))
            && self.known.allows(at)
            && !self.known.is_bad(self.grid, at)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_pixels_are_listed_row_by_row() {
        let check = |bad: &[(u16, u16)]| {
            let bad: heapless::Vec<BadPixel, 4> = bad.iter().map(|&(x, y)| BadPixel { x, y }).collect();
            Known { bad: &bad, ..Known::default() }.check().is_ok()
        };
        assert!(check(&[]) && check(&[(3, 0), (5, 0), (5, 0), (1, 1)]));
        assert!(!check(&[(3, 0), (2, 0)]) && !check(&[(3, 0), (5, 1), (9, 0)]));
    }
}
