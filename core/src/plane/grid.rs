//! The shape of a plane that is addressed by index: columns, of which there is at least one, and rows.

use core::num::NonZero;

/// Columns and rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Columns.
    pub width: NonZero<usize>,
    /// Rows.
    pub height: usize,
}

impl Grid {
    /// The whole rows of `count` cells; `None` where a row has none.
    pub fn of(count: usize, width: usize) -> Option<Grid> {
        NonZero::new(width).map(|width| Grid { width, height: count / width })
    }

    /// Number of cells.
    pub fn cells(self) -> usize {
        self.width.get() * self.height
    }

    /// Column and row of an index.
    #[inline]
    pub fn place(self, at: usize) -> (usize, usize) {
        (at % self.width, at / self.width)
    }

    /// The four cells that share an edge with the one at an index, and then the four that share a corner.
    pub fn neighbours(self, at: usize) -> impl Iterator<Item = usize> {
        const STEPS: [(isize, isize); 8] = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];
        let (x, y) = self.place(at);
        STEPS.into_iter().filter_map(move |(dx, dy)| {
            let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
            (x < self.width.get() && y < self.height).then_some(y * self.width.get() + x)
        })
    }
}
