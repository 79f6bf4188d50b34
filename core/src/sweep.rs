//! One engine for every step that looks at neighbours: a row kernel swept over a plane, in place.
//!
//! A kernel is a pure function from the `N = 2R + 1` old rows around a row to the new row. The
//! engine overwrites the plane row by row and keeps the old rows that are still needed in a ring
//! of `N` rows, each padded by `R` cells on both sides. Beyond the frame every row and column is
//! repeated (homogeneous Neumann conditions), here and nowhere else.

use crate::arithmetic::Arithmetic;
use crate::machine::Task;
use crate::tiles::{COLUMNS, Tiles};
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

/// A band of rows of a plane, with what a sweep over it needs.
#[derive(Debug)]
pub struct Band<'a, C> {
    /// The plane's rows, each of `width` cells.
    pub plane: &'a mut [C],
    /// The matching rows of the other plane, or empty.
    pub aux: &'a [C],
    /// At least [`ring_len`] cells: keeps the old rows between two calls of one sweep.
    pub ring: &'a mut [C],
    /// Columns.
    pub width: usize,
    /// The rows beyond the band.
    pub halo: Halo<'a, C>,
}

impl<C: Copy> Band<'_, C> {
    fn height(&self) -> usize {
        self.plane.len() / self.width.max(1)
    }

    /// Saves the old `columns` of row `y`, and `margin` columns on both sides; nothing beyond the
    /// band.
    fn save<const N: usize>(&mut self, y: usize, columns: &Range<usize>, margin: usize) {
        let (radius, stride) = (N / 2, self.width + N - 1);
        if y >= self.height() || columns.is_empty() {
            return;
        }
        let row = row_of(self.plane, self.width, y);
        let slot = row_of_mut(self.ring, stride, y % N);
        let (first, last) = (columns.start.saturating_sub(margin), (columns.end + margin).min(self.width));
        let (from, to) = (row.get(first..last).unwrap_or(&[]), slot.get_mut(first + radius..last + radius));
        if let Some(to) = to
            && to.len() == from.len()
        {
            to.copy_from_slice(from);
        }
        if let (true, Some(&edge)) = (first == 0, row.first()) {
            slot.get_mut(..radius).unwrap_or(&mut []).fill(edge);
        }
        if let (true, Some(&edge)) = (last == self.width, row.last()) {
            slot.get_mut(last + radius..).unwrap_or(&mut []).fill(edge);
        }
    }

    /// The window of saved rows around `columns` of row `y`, the matching piece of the other
    /// plane, and the piece to write.
    #[inline(always)]
    fn window<const N: usize>(&mut self, y: usize, columns: &Range<usize>) -> ([&[C]; N], &[C], &mut [C]) {
        let (radius, stride, height) = (N / 2, self.width + N - 1, self.height());
        let mut old: [&[C]; N] = [&[]; N];
        for (row, slot) in (y..).zip(&mut old) {
            let last = height + radius;
            let row = if row < radius && !self.halo.before.is_empty() {
                row_of(self.halo.before, stride, row)
            } else if row >= last && !self.halo.after.is_empty() {
                row_of(self.halo.after, stride, row - last)
            } else {
                let inside = row.saturating_sub(radius).min(height.saturating_sub(1));
                row_of(self.ring, stride, inside % N)
            };
            *slot = row.get(columns.start..columns.end + 2 * radius).unwrap_or(&[]);
        }
        let aux = row_of(self.aux, self.width, y).get(columns.clone()).unwrap_or(&[]);
        let new = row_of_mut(self.plane, self.width, y).get_mut(columns.clone()).unwrap_or(&mut []);
        (old, aux, new)
    }
}

/// Applies `kernel` in place to `rows` of a band. The calls of one sweep take the rows in order,
/// from 0 to the band's height. Cost: one copy and one kernel call a row.
pub fn advance<A, K, const N: usize>(kernel: &mut K, band: &mut Band<'_, A::Cell>, rows: Range<usize>)
where
    A: Arithmetic,
    K: Kernel<A, N>,
{
    let columns = 0..band.width;
    for y in rows {
        let first = if y == 0 { 0 } else { y + N / 2 };
        for row in first..=y + N / 2 {
            band.save::<N>(row, &columns, N / 2);
        }
        let (old, aux, new) = band.window::<N>(y, &columns);
        A::wide(Row::<A, K, N> { kernel, old, aux, new });
    }
}

/// [`advance`] for active tiles only; notes which of them change. Tiles at rest cost nothing.
pub fn advance_active<A, K, const N: usize>(
    kernel: &mut K,
    band: &mut Band<'_, A::Cell>,
    tiles: &mut Tiles<'_>,
    rows: Range<usize>,
) where
    A: Arithmetic,
    K: Kernel<A, N>,
{
    let mut y = rows.start;
    while y < rows.end {
        let tile_row = tiles.row_at(y);
        let end = tiles.start(tile_row + 1).min(rows.end);
        let mut from = 0;
        while let Some(run) = tiles.next_run(tile_row, from) {
            from = run.end;
            if y == tiles.start(tile_row) {
                enter::<A, N>(band, tiles, tile_row, &run);
            }
            let columns = tiles.columns(&run);
            for y in y..end {
                band.save::<N>(y + N / 2, &columns, N / 2);
                let (old, aux, new) = band.window::<N>(y, &columns);
                let run = &run;
                A::wide(ActiveRow { row: Row::<A, K, N> { kernel, old, aux, new }, tiles, y, run });
            }
        }
        y = end;
    }
}

/// One call of a kernel.
struct Row<'a, A: Arithmetic, K, const N: usize> {
    kernel: &'a mut K,
    old: [&'a [A::Cell]; N],
    aux: &'a [A::Cell],
    new: &'a mut [A::Cell],
}

impl<A: Arithmetic, K: Kernel<A, N>, const N: usize> Task for Row<'_, A, K, N> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.kernel.row(&self.old, self.aux, self.new);
    }
}

/// One call of a kernel for a run of tiles of row `y`.
struct ActiveRow<'a, 't, A: Arithmetic, K, const N: usize> {
    row: Row<'a, A, K, N>,
    tiles: &'a mut Tiles<'t>,
    y: usize,
    run: &'a Range<usize>,
}

impl<A: Arithmetic, K: Kernel<A, N>, const N: usize> Task for ActiveRow<'_, '_, A, K, N> {
    type Output = ();

    /// Tile by tile: the compiler unrolls loops of constant length, and keeps what it computes in
    /// a tile's own array in registers until it is compared and stored.
    #[inline(always)]
    fn run(self) {
        let Row { kernel, old, aux, new } = self.row;
        let marker = self.tiles.marker(self.y, N / 2);
        let (pieces, rest) = new.as_chunks_mut::<COLUMNS>();
        let (whole, mut x) = (pieces.len(), 0);
        let flags = self.tiles.flags_of(self.y, self.run);
        for (flag, new) in flags.iter_mut().zip(pieces) {
            let Some(aux) = aux.get(x..x + COLUMNS) else { break };
            let Some(old) = old.each_cut(x) else { break };
            let before = *new;
            let mut after = before;
            kernel.row(&old, aux, &mut after);
            marker.mark(flag, &before, &after);
            *new = after;
            x += COLUMNS;
        }
        if let Some(flag) = flags.get_mut(whole)
            && !rest.is_empty()
        {
            let old = old.map(|row| shifted(row, x));
            kernel.row(&old, shifted(aux, x), rest);
            marker.mark(flag, centre_of(&old, rest.len()), rest);
        }
    }
}

/// A window of rows as the window of one tile in them.
trait EachCut<'a, C, const N: usize> {
    fn each_cut(&self, x: usize) -> Option<[&'a [C]; N]>;
}

impl<'a, C, const N: usize> EachCut<'a, C, N> for [&'a [C]; N] {
    #[inline(always)]
    fn each_cut(&self, x: usize) -> Option<[&'a [C]; N]> {
        let mut cut: [&[C]; N] = [&[]; N];
        for (cut, row) in cut.iter_mut().zip(self) {
            *cut = row.get(x..x + (COLUMNS + N - 1))?;
        }
        Some(cut)
    }
}

/// Saves the rows around the first row of a run of tiles. Rows of the tiles before have been
/// overwritten where those were active, and were saved there; elsewhere the plane has them still.
fn enter<A: Arithmetic, const N: usize>(
    band: &mut Band<'_, A::Cell>,
    tiles: &Tiles<'_>,
    tile_row: usize,
    run: &Range<usize>,
) {
    let (radius, first) = (N / 2, tiles.start(tile_row));
    if let Some(row_before) = tile_row.checked_sub(1) {
        for column in run.start.saturating_sub(1)..=run.end {
            if !tiles.is_active(row_before, column) {
                let columns = tiles.columns(&(column..column + 1));
                (first.saturating_sub(radius)..first).for_each(|y| band.save::<N>(y, &columns, 0));
            }
        }
    }
    let columns = tiles.columns(run);
    (first..first + radius).for_each(|y| band.save::<N>(y, &columns, radius));
}

/// The row itself, without its padding, in a window of padded rows.
#[inline(always)]
pub fn centre_of<'a, C, const N: usize>(old: &[&'a [C]; N], width: usize) -> &'a [C] {
    old.get(N / 2).and_then(|row| row.get(N / 2..N / 2 + width)).unwrap_or(&[])
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
