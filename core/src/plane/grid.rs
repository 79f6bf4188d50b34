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
        self.touching(at, 8)
    }

    /// The first `most` of these directions, as far as the frame goes: with 4, cells that share an edge.
    #[inline]
    pub fn touching(self, at: usize, most: usize) -> impl Iterator<Item = usize> {
        let (near, mut open) = self.around(at, most);
        core::iter::from_fn(move || {
            let next = open.trailing_zeros() as usize;
            open &= open.wrapping_sub(1);
            near.get(next).copied()
        })
    }

    /// The cells in all eight directions, and a bit for each that [`Grid::touching`] has.
    #[inline]
    pub(crate) fn around(self, at: usize, most: usize) -> ([usize; 8], u32) {
        let ((x, y), width) = (self.place(at), self.width.get());
        let (left, right, below, above) = (x > 0, x + 1 < width, y > 0, y + 1 < self.height);
        let (under, over) = (at.wrapping_sub(width), at + width);
        // A bit for each; those of a side where the frame ends are taken away.
        let without = |inside: bool, bits: u32| if inside { 0 } else { bits };
        let beyond = without(left, 0b0101_0001) | without(right, 0b1010_0010);
        let beyond = beyond | without(below, 0b0011_0100) | without(above, 0b1100_1000);
        let open = ((1u32 << most.min(8)) - 1) & !beyond;
        let (before, behind) = (under.wrapping_sub(1), over.wrapping_sub(1));
        ([at.wrapping_sub(1), at + 1, under, over, before, under.wrapping_add(1), behind, over + 1], open)
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
