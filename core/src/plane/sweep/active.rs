//! A row of active tiles: the kernel, the settling of what it computed, and the marks of what changed.

use super::{Cross, Kernel, Tile, centre_of, cross, shifted};
use crate::arithmetic::vectors::COLUMNS;
use crate::arithmetic::vectors::Vectors;
use crate::arithmetic::{Arithmetic, Cell};
use crate::plane::beside::Beside;
use crate::plane::tiles::Marker;

/// Cells of the pieces that wide rows are worked on in.
const WIDE: usize = 4 * COLUMNS;

/// A row of a run of tiles.
pub(super) struct ActiveRow<'a, C, const N: usize> {
    pub old: [&'a [C]; N],
    pub aux: &'a [C],
    pub beside: Beside<'a, C>,
    pub new: &'a mut [C],
    pub flags: &'a mut [u8],
    pub marker: Marker,
}

impl<C: Cell, const N: usize> ActiveRow<'_, C, N> {
    /// The whole row, then its marks: the least instructions where there are no vectors, and the
    /// least code.
    #[inline(always)]
    pub fn in_one<A: Arithmetic<Cell = C>, K: Kernel<A, N>>(self, kernel: &mut K) {
        let ActiveRow { old, aux, new, flags, marker, .. } = self;
        kernel.row(&old, aux, new);
        let before = centre_of(&old, new.len());
        kernel.settle(before, aux, new);
        let pieces = before.chunks(COLUMNS).zip(new.chunks(COLUMNS));
        for (flag, (before, after)) in flags.iter_mut().zip(pieces) {
            marker.mark::<_, N>(flag, before, after);
        }
    }

    /// On vector units where the kernel is written for them; else four tiles at a time, then tile by tile: loops of constant length become vectors, and what
    /// waits for a square root in one tile is worked on in the next.
    #[inline(always)]
    pub fn tile_by_tile<A: Arithmetic<Cell = C>, K: Kernel<A, N>>(mut self, kernel: &mut K) {
        let mut x = 0;
        if K::ON_VECTORS
            && let Some(vectors) = A::vectors()
        {
            x = self.on_vectors::<A, K>(kernel, vectors);
        }
        // What looks around in the other plane sees one tile of it at a time.
        while !K::AROUND && self.tiles::<A, K, WIDE>(kernel, x) {
            x += WIDE;
        }
        while self.tiles::<A, K, COLUMNS>(kernel, x) {
            x += COLUMNS;
        }
        self.last_tile::<A, K>(kernel, x);
    }

    /// The whole tiles, on vector units; the number of cells that are done. One pass for each part
    /// of the work: in short chains from a load to a store more operations overlap.
    #[inline(always)]
    fn on_vectors<A: Arithmetic<Cell = C>, K: Kernel<A, N>>(&mut self, kernel: &mut K, vectors: A::Vectors) -> usize {
        let ActiveRow { old, aux, new, flags, marker, .. } = self;
        let new = new.as_chunks_mut::<COLUMNS>().0;
        let width = new.len() * COLUMNS;
        let Cross { centre, left, right, below, above } = cross(old);
        let [centre, left, right] = [tiles_of(centre, width), tiles_of(left, width), tiles_of(right, width)];
        let sides = left.iter().zip(right).zip(tiles_of(below, width)).zip(tiles_of(above, width));
        let around = centre.iter().zip(sides).zip(tiles_of(aux, width));
        for (new, ((centre, (((left, right), below), above)), beside)) in new.iter_mut().zip(around) {
            let tile = Tile { centre, sides: [left, right, below, above], beside };
            vectors.store(kernel.on_vectors(vectors, &tile), new);
        }
        kernel.settle_on_vectors(vectors, new);
        for ((new, old), flag) in new.iter().zip(centre).zip(flags.iter_mut()) {
            let (old, new) = (vectors.load(old), vectors.load(new));
            kernel.observe_on_vectors(vectors, old, new);
            if !marker.is_complete(*flag) {
                marker.mark_bits::<N>(flag, vectors.differing(old, new));
            }
        }
        width
    }

    /// The `W` cells from cell `x` on, whole tiles; `false` where the row has no more so many.
    #[inline(always)]
    fn tiles<A: Arithmetic<Cell = C>, K: Kernel<A, N>, const W: usize>(&mut self, kernel: &mut K, x: usize) -> bool {
        let Some(new) = self.new.get_mut(x..x + W) else { return false };
        let (Some(window), Some(aux)) = (cut::<C, N, W>(&self.old, x), self.aux.get(x..x + W)) else { return false };
        compute::<A, K, N>(kernel, &window, (aux, self.beside, x), new);
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
        compute::<A, K, N>(kernel, &window, (aux, self.beside, x), &mut after);
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

/// The kernel on a piece of a row that starts at cell `x`: beside it lies `aux`, or the tile around it.
#[inline(always)]
fn compute<A: Arithmetic, K: Kernel<A, N>, const N: usize>(
    kernel: &mut K,
    window: &[&[A::Cell]; N],
    (aux, beside, x): (&[A::Cell], Beside<'_, A::Cell>, usize),
    new: &mut [A::Cell],
) {
    if K::AROUND {
        kernel.row(window, &beside.window(x), new);
    } else {
        kernel.row(window, aux, new);
    }
}

/// The rows of tiles in the first `width` cells of a row.
#[inline(always)]
fn tiles_of<C>(row: &[C], width: usize) -> &[[C; COLUMNS]] {
    row.get(..width).unwrap_or(&[]).as_chunks::<COLUMNS>().0
}

/// The window of `W` cells from cell `x` on in a window of rows.
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
