//! One engine for every step that looks at neighbours: a row kernel swept over a plane, in place.
//!
//! A kernel is a pure function from the `N = 2R + 1` old rows around a row to the new row. The
//! engine overwrites the plane row by row and keeps the old rows that are still needed in a ring
//! of `N` rows, each padded by `R` cells on both sides. Beyond the frame every row and column is
//! repeated (homogeneous Neumann conditions), here and nowhere else.

use crate::arithmetic::{Arithmetic, Cell};
use crate::beside::Beside;
use crate::machine::Task;
use crate::tiles::{COLUMNS, Marker, Tiles};
use core::ops::Range;

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

/// Whether the processor has vector units, which want loops of constant length.
const VECTORS: bool = cfg!(any(target_arch = "x86_64", target_arch = "aarch64"));

/// Cells of the pieces that wide rows are worked on in.
const WIDE: usize = 4 * COLUMNS;

/// A row of a run of tiles.
struct ActiveRow<'a, C, const N: usize> {
    old: [&'a [C]; N],
    aux: &'a [C],
    beside: Beside<'a, C>,
    new: &'a mut [C],
    flags: &'a mut [u8],
    marker: Marker,
}

impl<C: Cell, const N: usize> ActiveRow<'_, C, N> {
    /// The whole row, then its marks: the least instructions where there are no vectors, and the
    /// least code.
    #[inline(always)]
    fn in_one<A: Arithmetic<Cell = C>, K: Kernel<A, N>>(self, kernel: &mut K) {
        let ActiveRow { old, aux, new, flags, marker, .. } = self;
        kernel.row(&old, aux, new);
        let before = centre_of(&old, new.len());
        kernel.settle(before, aux, new);
        let pieces = before.chunks(COLUMNS).zip(new.chunks(COLUMNS));
        for (flag, (before, after)) in flags.iter_mut().zip(pieces) {
            marker.mark::<_, N>(flag, before, after);
        }
    }

    /// Four tiles at a time, then tile by tile: loops of constant length become vectors, and what
    /// waits for a square root in one tile is worked on in the next.
    #[inline(always)]
    fn tile_by_tile<A: Arithmetic<Cell = C>, K: Kernel<A, N>>(mut self, kernel: &mut K) {
        let mut x = 0;
        while !K::AROUND && self.tiles::<A, K, WIDE>(kernel, x) {
            x += WIDE;
        }
        while self.tiles::<A, K, COLUMNS>(kernel, x) {
            x += COLUMNS;
        }
        self.last_tile::<A, K>(kernel, x);
    }

    /// The `W` cells from cell `x` on, whole tiles; `false` where the row has no more so many.
    #[inline(always)]
    fn tiles<A: Arithmetic<Cell = C>, K: Kernel<A, N>, const W: usize>(&mut self, kernel: &mut K, x: usize) -> bool {
        let Some(new) = self.new.get_mut(x..x + W) else { return false };
        let (Some(window), Some(aux)) = (cut::<C, N, W>(&self.old, x), self.aux.get(x..x + W)) else { return false };
        if K::AROUND {
            kernel.row(&window, &self.beside.window(x), new);
        } else {
            kernel.row(&window, aux, new);
        }
        let before = centre_of(&window, W);
        kernel.settle(before, aux, new);
        let flags = self.flags.get_mut(x / COLUMNS..(x + W) / COLUMNS).unwrap_or(&mut []);
        let cells = before.as_chunks::<COLUMNS>().0.iter().zip(new.as_chunks::<COLUMNS>().0);
        for (flag, (before, after)) in flags.iter_mut().zip(cells) {
            self.marker.mark::<_, N>(flag, before, after);
        }
        true
    }

    /// The frame's last tile, made up to a whole one: whatever lies behind the frame does not
    /// count, and nothing changes there.
    #[inline(always)]
    fn last_tile<A: Arithmetic<Cell = C>, K: Kernel<A, N>>(self, kernel: &mut K, x: usize) {
        let rest = self.new.get_mut(x..).unwrap_or(&mut []);
        let (Some(flag), Some(window)) = (self.flags.get_mut(x / COLUMNS), cut::<C, N, COLUMNS>(&self.old, x)) else {
            return;
        };
        if rest.is_empty() {
            return;
        }
        let mut before = whole_tile(centre_of(&window, COLUMNS));
        let mut after = before;
        let made_up;
        let aux = if let Some(aux) = self.aux.get(x..x + COLUMNS) {
            aux
        } else {
            made_up = whole_tile(shifted(self.aux, x));
            &made_up
        };
        if K::AROUND {
            kernel.row(&window, &self.beside.window(x), &mut after);
        } else {
            kernel.row(&window, aux, &mut after);
        }
        for (i, (before, after)) in before.iter_mut().zip(&mut after).enumerate() {
            if i >= rest.len() {
                (*before, *after) = Default::default();
            }
        }
        kernel.settle(&before, aux, &mut after);
        self.marker.mark::<_, N>(flag, &before, &after);
        rest.iter_mut().zip(after).for_each(|(new, after)| *new = after);
    }
}

/// Some columns of a band, row after row: keeps the ring and cuts the windows. Without vectors one
/// function each for all kernels of a size: a call a row saves a quarter of the flash.
struct Run<'a, C, const N: usize> {
    plane: &'a mut [C],
    aux: &'a [C],
    /// The columns' piece of each row of the ring, its padding included; the oldest row first.
    slots: [&'a mut [C]; N],
    halo: Halo<'a, C>,
    columns: Range<usize>,
    /// The columns and what is saved beside them.
    saved: Saved,
    width: usize,
    height: usize,
}

impl<'a, C: Copy, const N: usize> Run<'a, C, N> {
    const RADIUS: usize = N / 2;

    /// A run about to do row `y`.
    #[cfg_attr(any(target_arch = "x86_64", target_arch = "aarch64"), inline(always))]
    #[cfg_attr(not(any(target_arch = "x86_64", target_arch = "aarch64")), inline(never))]
    fn new(band: &'a mut Band<'_, C>, columns: &Range<usize>, y: usize) -> Self {
        let (height, width, columns) = (band.height(), band.width, columns.clone());
        let Beside { plane: beside, row, .. } = band.beside();
        let aux = beside.get(row * width..).unwrap_or(&[]);
        let mut rows = band.ring.chunks_exact_mut(row_stride(width, N));
        let padded = padded::<N>(&columns);
        let mut slots =
            core::array::from_fn(|_| rows.next().and_then(|row| row.get_mut(padded.clone())).unwrap_or(&mut []));
        // Row r is kept in slot r % N; the last turn before row y begins with the one before y - R.
        (0..(y + N - 1 - Self::RADIUS) % N).for_each(|_| turn(&mut slots));
        let saved = Saved::new::<N>(width, &columns, Self::RADIUS);
        Run { plane: band.plane, aux, slots, halo: band.halo, columns, saved, width, height }
    }

    /// Saves the last row that row `y` looks at; the window of old rows around row `y`, the
    /// matching piece of the other plane (in whole tiles, where it goes on), and the piece to write.
    #[cfg_attr(any(target_arch = "x86_64", target_arch = "aarch64"), inline(always))]
    #[cfg_attr(not(any(target_arch = "x86_64", target_arch = "aarch64")), inline(never))]
    fn next_row(&mut self, y: usize) -> ([&[C]; N], &[C], &mut [C]) {
        turn(&mut self.slots);
        if let Some(slot) = self.slots.last_mut() {
            self.saved.row(slot, self.plane, (y + Self::RADIUS) * self.width);
        }
        let mut old = self.slots.each_ref().map(|slot| &**slot);
        if y < Self::RADIUS || y + Self::RADIUS >= self.height {
            // A copy: what other functions are lent must lie in memory, and with it all of the run.
            let halo = self.halo;
            old = beyond(&halo, (padded::<N>(&self.columns), row_stride(self.width, N)), (y, self.height), old);
        }
        let start = y * self.width + self.columns.start;
        let cells = start..start + self.columns.len();
        let tiles = start..(start + self.columns.len().next_multiple_of(COLUMNS)).min(self.aux.len());
        (old, self.aux.get(tiles).unwrap_or(&[]), self.plane.get_mut(cells).unwrap_or(&mut []))
    }
}

/// A window around row `y` of `height` that reaches beyond the band: there are the halo's rows, of
/// `stride` cells, of which it takes the `padded` ones, or the edge is repeated.
#[inline(never)]
fn beyond<'s, C, const N: usize>(
    halo: &Halo<'s, C>,
    (padded, stride): (Range<usize>, usize),
    (y, height): (usize, usize),
    inside: [&'s [C]; N],
) -> [&'s [C]; N] {
    let radius = N / 2;
    let halo_row = |rows: &'s [C], row| row_of(rows, stride, row).get(padded.clone()).unwrap_or(&[]);
    core::array::from_fn(|i| {
        let row = y + i;
        if row < radius && !halo.before.is_empty() {
            halo_row(halo.before, row)
        } else if row >= height + radius && !halo.after.is_empty() {
            halo_row(halo.after, row - height - radius)
        } else {
            let nearest = row.max(radius).min(height + radius - 1) - y;
            inside.get(nearest).copied().unwrap_or(&[])
        }
    })
}

/// Moves every slot one place forward, and the first to the end; much less code than the library's
/// rotation, which is made for long slices.
#[inline(always)]
fn turn<T, const N: usize>(slots: &mut [T; N]) {
    for i in 1..N {
        slots.swap(i - 1, i);
    }
}

/// The cells of a saved row that a kernel of `N` rows looks at for `columns`, in whole tiles.
fn padded<const N: usize>(columns: &Range<usize>) -> Range<usize> {
    columns.start..columns.end.next_multiple_of(COLUMNS) + N - 1
}

/// Which columns of a row are saved, and where in a slot.
struct Saved {
    columns: Range<usize>,
    /// Cells of the slot before them.
    padding: usize,
    /// The frame ends before them, or behind them: its edge is repeated so often.
    edges: [usize; 2],
}

impl Saved {
    /// `columns` of a row of `width` cells, and `margin` columns on both sides of them.
    #[inline(always)]
    fn new<const N: usize>(width: usize, columns: &Range<usize>, margin: usize) -> Self {
        let (first, last) = (columns.start.saturating_sub(margin), (columns.end + margin).min(width));
        let edges = [if first == 0 { N / 2 } else { 0 }, if last == width { N / 2 } else { 0 }];
        Saved { columns: first..last, padding: first + N / 2 - columns.start, edges }
    }

    /// Saves the row that starts at cell `start` of the plane; nothing beyond its end.
    #[inline(always)]
    fn row<C: Copy>(&self, slot: &mut [C], plane: &[C], start: usize) {
        let cells = plane.get(start + self.columns.start..start + self.columns.end).unwrap_or(&[]);
        let Some(saved) = slot.get_mut(self.padding..self.padding + cells.len()) else { return };
        copy(cells, saved);
        if self.edges != [0; 2] {
            repeat(slot, cells, self.padding, self.edges);
        }
    }
}

/// Repeats the frame's edges beside saved `cells`, so often before and behind them.
#[inline(never)]
fn repeat<C: Copy>(slot: &mut [C], cells: &[C], padding: usize, [before, behind]: [usize; 2]) {
    let (Some(left), Some(right)) = (cells.first(), cells.last()) else { return };
    slot.iter_mut().take(before).for_each(|cell| *cell = *left);
    slot.iter_mut().skip(padding + cells.len()).take(behind).for_each(|cell| *cell = *right);
}

/// Copies cells, `from` and `to` being of one length, in whole tiles: where there are vectors the
/// last tile begins among cells that are already copied.
#[inline(always)]
fn copy<C: Copy>(from: &[C], to: &mut [C]) {
    let ((tiles, rest), (to_tiles, to_rest)) = (from.as_chunks::<COLUMNS>(), to.as_chunks_mut::<COLUMNS>());
    to_tiles.iter_mut().zip(tiles).for_each(|(to, from)| *to = *from);
    if !VECTORS || tiles.is_empty() {
        to_rest.iter_mut().zip(rest).for_each(|(to, from)| *to = *from);
    } else if let (Some(from), Some(to)) = (from.last_chunk::<COLUMNS>(), to.last_chunk_mut::<COLUMNS>()) {
        *to = *from;
    }
}

/// The window of `W` cells in a window of rows.
#[inline(always)]
fn cut<'a, C, const N: usize, const W: usize>(rows: &[&'a [C]; N], x: usize) -> Option<[&'a [C]; N]> {
    let mut cut: [&[C]; N] = [&[]; N];
    for (cut, row) in cut.iter_mut().zip(rows) {
        *cut = row.get(x..x + (W + N - 1))?;
    }
    Some(cut)
}

/// A piece of a row made up to a whole tile with empty cells.
#[inline(always)]
fn whole_tile<C: Copy + Default>(cells: &[C]) -> [C; COLUMNS] {
    let mut tile = [C::default(); COLUMNS];
    tile.iter_mut().zip(cells).for_each(|(tile, cell)| *tile = *cell);
    tile
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
