//! The ring of old rows: what a sweep saves of a row before it is overwritten, and the window of
//! rows that a kernel sees.

use super::{Band, Halo, row_stride};
use crate::arithmetic::machine::VECTORS;
use crate::arithmetic::vectors::COLUMNS;
use crate::plane::beside::Beside;
use crate::plane::rows::row_of;
use core::ops::Range;

/// Some columns of a band, row after row: keeps the ring and cuts the windows. Without vectors one
/// function each for all kernels of a size: a call a row saves a quarter of the flash.
pub(super) struct Run<'a, C, const N: usize> {
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
    pub fn new(band: &'a mut Band<'_, C>, columns: &Range<usize>, y: usize) -> Self {
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
    pub fn next_row(&mut self, y: usize) -> ([&[C]; N], &[C], &mut [C]) {
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
pub(super) struct Saved {
    columns: Range<usize>,
    /// Cells of the slot before them.
    padding: usize,
    /// The frame ends before them, or behind them: its edge is repeated so often.
    edges: [usize; 2],
}

impl Saved {
    /// `columns` of a row of `width` cells, and `margin` columns on both sides of them.
    #[inline(always)]
    pub fn new<const N: usize>(width: usize, columns: &Range<usize>, margin: usize) -> Self {
        let (first, last) = (columns.start.saturating_sub(margin), (columns.end + margin).min(width));
        let edges = [if first == 0 { N / 2 } else { 0 }, if last == width { N / 2 } else { 0 }];
        Saved { columns: first..last, padding: first + N / 2 - columns.start, edges }
    }

    /// Saves the row that starts at cell `start` of the plane; nothing beyond its end.
    #[inline(always)]
    pub fn row<C: Copy>(&self, slot: &mut [C], plane: &[C], start: usize) {
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
