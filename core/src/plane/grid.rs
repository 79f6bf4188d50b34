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
        self.touching(at, 8)
    }

    /// The first `most` of these directions, as far as the frame goes: with 4, cells that share an edge.
    pub fn touching(self, at: usize, most: usize) -> impl Iterator<Item = usize> {
        const STEPS: [(isize, isize); 8] = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];
        let (x, y) = self.place(at);
        STEPS.into_iter().take(most).filter_map(move |(dx, dy)| {
            let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
            (x < self.width.get() && y < self.height).then_some(y * self.width.get() + x)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_a_border_no_corner_takes_the_place_of_an_edge() {
        let grid = Grid { width: NonZero::new(3).expect("not 0"), height: 3 };
        let near = |at: usize, most: usize| {
            let (mut cells, mut count) = ([0; 8], 0);
            for (cell, near) in cells.iter_mut().zip(grid.touching(at, most)) {
                (*cell, count) = (near, count + 1);
            }
            (count, cells)
        };
        assert_eq!(near(0, 4), (2, [1, 3, 0, 0, 0, 0, 0, 0]));
        assert_eq!(near(1, 4), (3, [0, 2, 4, 0, 0, 0, 0, 0]));
        assert_eq!(near(0, 8), (3, [1, 3, 4, 0, 0, 0, 0, 0]));
        assert_eq!(near(4, 8), (8, [3, 5, 1, 7, 0, 2, 6, 8]));
    }
}
