//! One engine for every step that looks at neighbours: a row kernel swept over a plane, in place.
//!
//! A kernel is a pure function from the `N = 2R + 1` old rows around a row to the new row. The
//! engine overwrites the plane row by row and keeps the old rows that are still needed in a ring
//! of `N` rows, each padded by `R` cells on both sides. Beyond the frame every row and column is
//! repeated (homogeneous Neumann conditions), here and nowhere else.

use crate::arithmetic::Arithmetic;
use core::ops::Range;

/// A pure function from old rows to a new row; `N` is odd.
pub trait Kernel<A: Arithmetic, const N: usize> {
    /// Computes one row.
    ///
    /// `old[i]` is the row `i - N/2` rows away, W + N - 1 cells with N/2 repeated cells on each
    /// side; `aux` is the matching row of the other plane (W cells, or none); `new` starts as the
    /// old row itself, W cells.
    fn row(&mut self, old: &[&[A::Cell]; N], aux: &[A::Cell], new: &mut [A::Cell]);
}

/// Rows that stand in for the frame's edge where a plane is only a band of the frame: each slice
/// holds `N/2` padded rows, in order of y. Empty where the band ends at the frame's edge.
#[derive(Clone, Copy, Debug)]
pub struct Halo<'a, C> {
    /// The rows before the band's first.
    pub before: &'a [C],
    /// The rows after the band's last.
    pub after: &'a [C],
}

impl<C> Halo<'_, C> {
    /// The whole frame: its edges are repeated.
    pub const NONE: Self = Halo { before: &[], after: &[] };
}

/// Cells of the ring that a sweep of `N` rows needs for rows of `width` cells.
pub const fn ring_len(width: usize, n: usize) -> usize {
    n * (width + n - 1)
}

/// Row `y` of a row-major plane; empty beyond its end.
#[inline]
pub fn row_of<T>(plane: &[T], width: usize, y: usize) -> &[T] {
    let start = y.saturating_mul(width);
    plane.get(start..start.saturating_add(width)).unwrap_or(&[])
}

/// Row `y` of a row-major plane, to write to; empty beyond its end.
#[inline]
pub fn row_of_mut<T>(plane: &mut [T], width: usize, y: usize) -> &mut [T] {
    let start = y.saturating_mul(width);
    plane.get_mut(start..start.saturating_add(width)).unwrap_or(&mut [])
}

/// Copies `row` into `slot` with `pad` repeated cells on each side.
pub fn pad_row<T: Copy>(row: &[T], slot: &mut [T], pad: usize) {
    let (Some(&first), Some(&last)) = (row.first(), row.last()) else { return };
    let (left, rest) = slot.split_at_mut_checked(pad).unwrap_or((&mut [], &mut []));
    let (middle, right) = rest.split_at_mut_checked(row.len()).unwrap_or((&mut [], &mut []));
    left.fill(first);
    middle.iter_mut().zip(row).for_each(|(to, &from)| *to = from);
    right.fill(last);
}

/// Applies `kernel` in place to `rows` of a band of `width` columns.
///
/// `ring` has at least [`ring_len`] cells and keeps the old rows between two calls; the calls of
/// one sweep take the rows in order, from 0 to the band's height. `aux` may be empty.
/// Cost: one copy and one kernel call a row.
pub fn advance<A, K, const N: usize>(
    kernel: &mut K,
    plane: &mut [A::Cell],
    aux: &[A::Cell],
    ring: &mut [A::Cell],
    width: usize,
    rows: Range<usize>,
    halo: Halo<'_, A::Cell>,
) where
    A: Arithmetic,
    K: Kernel<A, N>,
{
    let radius = N / 2;
    let stride = width + N - 1;
    let height = plane.len() / width.max(1);
    for y in rows {
        let first_load = if y == 0 { 0 } else { y + radius };
        for load in first_load..(y + radius + 1).min(height) {
            pad_row(row_of(plane, width, load), row_of_mut(ring, stride, load % N), radius);
        }
        let old: [&[A::Cell]; N] = core::array::from_fn(|i| {
            let (row, last) = (y + i, height + radius);
            if row < radius && !halo.before.is_empty() {
                row_of(halo.before, stride, row)
            } else if row >= last && !halo.after.is_empty() {
                row_of(halo.after, stride, row - last)
            } else {
                let inside = row.saturating_sub(radius).min(height.saturating_sub(1));
                row_of(ring, stride, inside % N)
            }
        });
        let (aux, new) = (row_of(aux, width, y), row_of_mut(plane, width, y));
        A::wide(|| kernel.row(&old, aux, new));
    }
}

/// The pixel and its four neighbours in a window of three padded rows, as rows of equal length.
pub struct Cross<'a, C> {
    /// The row itself.
    pub centre: &'a [C],
    /// x - 1.
    pub left: &'a [C],
    /// x + 1.
    pub right: &'a [C],
    /// y - 1.
    pub below: &'a [C],
    /// y + 1.
    pub above: &'a [C],
}

/// The five-point neighbourhood of a window.
#[inline(always)]
pub fn cross<'a, C>(old: &[&'a [C]; 3]) -> Cross<'a, C> {
    let [below, centre, above] = *old;
    Cross {
        centre: shifted(centre, 1),
        left: centre,
        right: shifted(centre, 2),
        below: shifted(below, 1),
        above: shifted(above, 1),
    }
}

/// The row from cell `by` on.
#[inline(always)]
pub fn shifted<C>(row: &[C], by: usize) -> &[C] {
    row.get(by..).unwrap_or(&[])
}
