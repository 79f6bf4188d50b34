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
    #[inline]
    pub fn neighbours(self, at: usize) -> impl Iterator<Item = usize> {
        let ((x, y), width) = (self.place(at), self.width.get());
        let (left, right, below, above) = (x > 0, x + 1 < width, y > 0, y + 1 < self.height);
        let (under, over) = (at.wrapping_sub(width), at + width);
        [
            (left, at.wrapping_sub(1)),
            (right, at + 1),
            (below, under),
            (above, over),
            (below && left, under.wrapping_sub(1)),
            (below && right, under.wrapping_add(1)),
            (above && left, over.wrapping_sub(1)),
            (above && right, over + 1),
        ]
        .into_iter()
        .filter_map(|(inside, near)| inside.then_some(near))
    }
}
