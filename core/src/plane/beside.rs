//! The plane beside the one that is swept, for kernels that look at its neighbours too.

use crate::arithmetic::vectors::COLUMNS;
use crate::plane::rows::row_of;

/// Cells of a row of a tile and of one on either side.
const PADDED: usize = COLUMNS + 2;

/// A place in the plane beside a band.
#[derive(Clone, Copy)]
pub(crate) struct Beside<'a, C> {
    /// The band's rows and, where the frame goes on, one more.
    pub plane: &'a [C],
    /// Columns.
    pub width: usize,
    /// The place: a column of the frame and a row of `plane`.
    pub column: usize,
    /// See `column`.
    pub row: usize,
}

impl<C: Copy + Default> Beside<'_, C> {
    /// The window of a tile's row that starts `x` columns from the place: three rows with a cell on
    /// either side, one after another. Beyond the frame its edges are repeated.
    #[inline(always)]
    pub fn window(&self, x: usize) -> [C; 3 * PADDED] {
        let mut window = [C::default(); 3 * PADDED];
        let x = self.column + x;
        let last = (self.plane.len() / self.width.max(1)).saturating_sub(1);
        for (line, cells) in window.chunks_exact_mut(PADDED).enumerate() {
            let row = row_of(self.plane, self.width, (self.row + line).saturating_sub(1).min(last));
            if let Some(inside) = row.get(x.wrapping_sub(1)..x + COLUMNS + 1) {
                cells.iter_mut().zip(inside).for_each(|(cell, inside)| *cell = *inside);
                continue;
            }
            for (i, cell) in cells.iter_mut().enumerate() {
                let column = (x + i).saturating_sub(1).min(self.width.saturating_sub(1));
                *cell = row.get(column).copied().unwrap_or_default();
            }
        }
        window
    }
}

/// The rows of such a window.
#[inline(always)]
pub(crate) fn rows_beside<C>(window: &[C]) -> [&[C]; 3] {
    let mut rows = window.chunks_exact(PADDED);
    core::array::from_fn(|_| rows.next().unwrap_or(&[]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_repeat_the_frames_edges_and_see_the_rows_beyond_a_band() {
        let (width, height) = (COLUMNS + 5, 4);
        let plane: [u32; (COLUMNS + 5) * 4] = core::array::from_fn(|i| (i / width * 100 + i % width) as u32);
        // A band of two rows with one more on either side, and the whole frame.
        for (first, rows) in [(1, 2), (0, height)] {
            for y in 0..rows {
                for x in [0, COLUMNS] {
                    let beside = Beside { plane: &plane, width, column: x, row: first + y };
                    let window = beside.window(0);
                    assert_eq!(window, Beside { column: 0, ..beside }.window(x));
                    for (line, row) in rows_beside(&window).into_iter().enumerate() {
                        for (i, &cell) in row.iter().enumerate() {
                            let line = (first + y + line).saturating_sub(1).min(height - 1);
                            let column = (x + i).saturating_sub(1).min(width - 1);
                            assert_eq!(cell as usize, line * 100 + column, "tile at ({x}, {y})");
                        }
                    }
                }
            }
        }
    }
}
