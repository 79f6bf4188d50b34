//! One engine for every step that looks at neighbours: a row kernel swept over a plane, in place.
//!
//! A kernel is a pure function from the `N = 2R + 1` old rows around a row to the new row. The
//! engine overwrites the plane row by row and keeps the old rows that are still needed in a ring
//! of `N` rows, each padded by `R` cells on both sides. Beyond the frame every row and column is
//! repeated (homogeneous Neumann conditions), here and nowhere else.

mod active;
mod run;

use crate::arithmetic::Arithmetic;
use crate::arithmetic::machine::{Task, VECTORS};
use crate::arithmetic::vectors::COLUMNS;
use crate::arithmetic::vectors::Vectors;
use crate::plane::beside::Beside;
use crate::plane::rows::row_of_mut;
use crate::plane::tiles::{Marker, Tiles};
use active::ActiveRow;
use core::ops::Range;
use run::{Run, Saved};

/// A pure function from old rows to a new row; `N` is odd.
pub trait Kernel<A: Arithmetic, const N: usize> {
    /// Whether a new value depends on pixels that are neither in its row nor in its column.
    const CORNERS: bool = true;
    /// Whether it depends on the neighbours in the other plane too; only in sweeps over tiles.
    const AROUND: bool = false;

    /// Computes one row.
    ///
    /// `old[i]` is the row `i - N/2` rows away, W + N - 1 cells with N/2 repeated cells on each
    /// side; `aux` is the matching row of the other plane (W cells, or none), or with
    /// [`Self::AROUND`] the three rows around it with a cell on either side, one after another;
    /// `new` starts as the old row itself, W cells.
    fn row(&mut self, old: &[&[A::Cell]; N], aux: &[A::Cell], new: &mut [A::Cell]);

    /// Takes note of what was computed, and may adjust it cell by cell; only in sweeps over tiles.
    fn settle(&mut self, old: &[A::Cell], aux: &[A::Cell], new: &mut [A::Cell]) {
        let _ = (old, aux, new);
    }

    /// Whether a row of a tile can be computed on vector units: the methods below are there.
    const ON_VECTORS: bool = false;

    /// [`Self::row`] for a row of a tile.
    #[inline(always)]
    fn on_vectors(&self, vectors: A::Vectors, tile: &Tile<'_, A::Cell>) -> RowOf<A> {
        vectors.load(tile.centre)
    }

    /// What [`Self::settle`] adjusts, for some rows of tiles.
    #[inline(always)]
    fn settle_on_vectors(&self, vectors: A::Vectors, new: &mut [[A::Cell; COLUMNS]]) {
        let _ = (vectors, new);
    }

    /// What [`Self::settle`] takes note of, for a row of a tile.
    #[inline(always)]
    fn observe_on_vectors(&mut self, vectors: A::Vectors, old: RowOf<A>, new: RowOf<A>) {
        let _ = (vectors, old, new);
    }
}

/// The numbers of a row of a tile in vector units.
pub type RowOf<A> = <<A as Arithmetic>::Vectors as Vectors>::Row;

/// A row of a tile and what lies around it, before the step.
pub struct Tile<'a, C> {
    /// The row itself.
    pub centre: &'a [C; COLUMNS],
    /// Its neighbours: left, right, below, above.
    pub sides: [&'a [C; COLUMNS]; 4],
    /// What lies beside it in the other plane.
    pub beside: &'a [C; COLUMNS],
}

/// Rows that stand in for the frame's edge where a plane is only a band of the frame: each slice
/// holds `N/2` padded rows of [`row_stride`] cells, in order of y. Empty where the band ends at the frame's edge.
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

/// Cells of a saved row: made up to whole tiles, and padded for a kernel of `n` rows.
pub const fn row_stride(width: usize, n: usize) -> usize {
    width.next_multiple_of(COLUMNS) + n - 1
}

/// Cells of the ring that a sweep of `N` rows needs for rows of `width` cells.
pub const fn ring_len(width: usize, n: usize) -> usize {
    n * row_stride(width, n)
}

/// A band of rows of a plane, with what a sweep over it needs.
#[derive(Debug)]
pub struct Band<'a, C> {
    /// The plane's rows, each of `width` cells.
    pub plane: &'a mut [C],
    /// The matching rows of the other plane, or empty; on a side with a halo one row more.
    pub aux: &'a [C],
    /// At least [`ring_len`] cells: keeps the old rows between two calls of one sweep.
    pub ring: &'a mut [C],
    /// Columns.
    pub width: usize,
    /// The rows beyond the band.
    pub halo: Halo<'a, C>,
}

impl<'a, C: Copy> Band<'a, C> {
    fn height(&self) -> usize {
        self.plane.len() / self.width.max(1)
    }

    /// The other plane, at the place beside the band's first cell.
    fn beside(&self) -> Beside<'a, C> {
        Beside { plane: self.aux, width: self.width, column: 0, row: usize::from(!self.halo.before.is_empty()) }
    }

    /// Saves `columns` of row `y`, and `margin` columns on both sides, into the ring; nothing
    /// beyond the band.
    fn save<const N: usize>(&mut self, y: usize, columns: &Range<usize>, margin: usize) {
        let slot = row_of_mut(self.ring, row_stride(self.width, N), y % N);
        let slot = slot.get_mut(columns.start..columns.end + N - 1).unwrap_or(&mut []);
        Saved::new::<N>(self.width, columns, margin).row(slot, self.plane, y * self.width);
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
    if rows.start == 0 {
        (0..N / 2).for_each(|y| band.save::<N>(y, &columns, N / 2));
    }
    let mut run = Run::<A::Cell, N>::new(band, &columns, rows.start);
    for y in rows {
        let (old, aux, new) = run.next_row(y);
        let old = old.map(|row| row.get(..new.len() + N - 1).unwrap_or(&[]));
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
    K: Kernel<A, N> + Copy,
{
    tiles.look_at_corners(K::CORNERS);
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
            let (columns, first, tile_rows) = (tiles.columns(&run), tiles.start(tile_row), tiles.tile_rows());
            let (rows, flags) = (y..end, tiles.flags_of(tile_row, &run));
            A::wide(ActiveRun::<A, K, N> { kernel, band, columns, rows, first, tile_rows, flags });
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

/// The rows of a run of active tiles: one piece of work for the machine, so that short runs cost
/// little more than their pixels.
struct ActiveRun<'a, 'b, A: Arithmetic, K, const N: usize> {
    kernel: &'a mut K,
    band: &'a mut Band<'b, A::Cell>,
    /// The pixel columns of the run.
    columns: Range<usize>,
    /// The rows to do now, and the first row and the number of rows of the tiles they lie in.
    rows: Range<usize>,
    first: usize,
    tile_rows: usize,
    /// The flags of the run's tiles.
    flags: &'a mut [u8],
}

impl<A: Arithmetic, K: Kernel<A, N> + Copy, const N: usize> Task for ActiveRun<'_, '_, A, K, N> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let ActiveRun { kernel: shared, band, columns, rows, first, tile_rows, flags } = self;
        // A copy: behind the reference it could change with every cell written.
        let mut kernel = *shared;
        let first_beside = band.beside();
        let mut run = Run::<A::Cell, N>::new(band, &columns, rows.start);
        for y in rows {
            let marker = Marker::new::<N>(y - first, tile_rows);
            let (old, aux, new) = run.next_row(y);
            let beside = Beside { column: columns.start, row: first_beside.row + y, ..first_beside };
            let row = ActiveRow { old, aux, beside, new, flags: &mut *flags, marker };
            if VECTORS || K::AROUND { row.tile_by_tile::<A, K>(&mut kernel) } else { row.in_one::<A, K>(&mut kernel) }
        }
        *shared = kernel;
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
        let around = run.start.saturating_sub(1)..run.end + 1;
        for column in tiles.at_rest(row_before, around) {
            let columns = tiles.columns(&(column..column + 1));
            (first.saturating_sub(radius)..first).for_each(|y| band.save::<N>(y, &columns, 0));
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

/// The pixel and its four neighbours in a window of padded rows, as rows that are long enough.
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

impl<C: Copy> Cross<'_, C> {
    /// The neighbours of each pixel: left, right, below, above.
    #[inline(always)]
    pub fn sides(&self) -> impl Iterator<Item = [C; 4]> {
        let rows = self.left.iter().zip(self.right).zip(self.below).zip(self.above);
        rows.map(|(((&l, &r), &b), &a)| [l, r, b, a])
    }
}

/// The five-point neighbourhood of a window.
#[inline(always)]
pub fn cross<'a, C, const N: usize>(old: &[&'a [C]; N]) -> Cross<'a, C> {
    let radius = N / 2;
    let row = |y: usize, x: usize| old.get(y).map_or(&[][..], |row| shifted(row, x));
    Cross {
        centre: row(radius, radius),
        left: row(radius, radius - 1),
        right: row(radius, radius + 1),
        below: row(radius - 1, radius),
        above: row(radius + 1, radius),
    }
}

/// The row from cell `by` on.
#[inline(always)]
pub fn shifted<C>(row: &[C], by: usize) -> &[C] {
    row.get(by..).unwrap_or(&[])
}
