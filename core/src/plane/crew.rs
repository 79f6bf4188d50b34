//! Who works on the bands of a plane: one after another, or the threads of a caller that has them.
//!
//! A band is written by one hand only, from what no hand changes meanwhile, so that the bits do not depend on
//! how many hands there are or which is first.

use crate::arithmetic::machine::Task;
use crate::plane::grid::Grid;

/// The most bands of a plane.
pub const MOST_BANDS: usize = 64;
/// Bands for each hand: who is done early takes another.
const BANDS: usize = 4;
/// The fewest rows of a band.
const LEAST_ROWS: usize = 16;

/// Those who work.
pub trait Crew: Sync {
    /// How many work at the same time.
    fn hands(&self) -> usize;

    /// Does `work` on every item, in any order and at the same time, and returns when all is done.
    fn each<T: Send>(&self, items: impl Iterator<Item = T> + Send, work: impl Fn(T) + Sync);

    /// Runs a row loop, on wider vector units where their processor has them.
    #[inline(always)]
    fn wide<T: Task>(&self, row: T) -> T::Output {
        row.run()
    }

    /// Rows of a band, the same of all but the last; all there are where one works alone.
    fn rows(&self, grid: Grid) -> usize {
        let bands = if self.hands() > 1 { self.hands().saturating_mul(BANDS).min(MOST_BANDS) } else { 1 };
        let least = grid.height.div_ceil(MOST_BANDS).max(if bands > 1 { LEAST_ROWS } else { 1 });
        grid.height.div_ceil(bands.max(1)).max(least)
    }
}

/// Nobody helps: one item after another.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Crew for Alone {
    fn hands(&self) -> usize {
        1
    }

    fn each<T: Send>(&self, items: impl Iterator<Item = T> + Send, work: impl Fn(T) + Sync) {
        items.for_each(work);
    }
}
