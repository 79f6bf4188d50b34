//! Which pieces of the front can still move.
//!
//! The front plane is divided into tiles of [`COLUMNS`] columns and some rows. A step of a scheme
//! looks a few pixels far, so a tile can change only if it changed in the step before, or if a
//! neighbour did within those few pixels. All others are skipped, and the result is the same as if
//! they had been computed.

use crate::arithmetic::Cell;
use crate::arithmetic::vectors::COLUMNS;
use crate::plane::rows::{row_of, row_of_mut};
use core::ops::Range;

/// More rows of tiles than this are never made: tiles of very high frames are higher.
const MOST_ROWS: usize = 128;

/// Rows of a tile in a frame of `height` rows: 8, or as many as keep the flags few.
pub const fn rows_of_tile(height: usize) -> usize {
    let rows = height.div_ceil(MOST_ROWS);
    if rows > 8 { rows } else { 8 }
}

/// Bytes of the flags of a frame: one a tile, and one for each row of tiles.
pub const fn flags_len(width: usize, height: usize) -> usize {
    (width.div_ceil(COLUMNS) + 1) * height.div_ceil(rows_of_tile(height))
}

/// The tile is computed in this step.
const ACTIVE: u8 = 1;
/// A bit of the tile changed in this step.
const CHANGED: u8 = 2;
/// A bit changed that neighbours on the left look at, and so on.
const LEFT: u8 = 4;
const RIGHT: u8 = 8;
const BOTTOM: u8 = 16;
const TOP: u8 = 32;

/// The flags of all tiles of a band, in the caller's memory. Behind each row of tiles stands the
/// union of its flags, so that a row at rest costs one look.
#[derive(Debug)]
pub struct Tiles<'a> {
    flags: &'a mut [u8],
    width: usize,
    tile_rows: usize,
    /// Whether a change at a tile's corner matters to the tile beyond it.
    corners: bool,
}

impl<'a> Tiles<'a> {
    /// The flags of a band of `width` columns in tiles of `tile_rows` rows; [`flags_len`] bytes.
    pub fn new(flags: &'a mut [u8], width: usize, tile_rows: usize) -> Self {
        Tiles { flags, width, tile_rows: tile_rows.max(1), corners: true }
    }

    /// Flags of a row of tiles, its union included.
    fn stride(&self) -> usize {
        self.width.div_ceil(COLUMNS) + 1
    }

    /// Says whether the step that is to be noted looks at pixels that are neither in the row nor in
    /// the column of the new one.
    pub(crate) fn look_at_corners(&mut self, corners: bool) {
        self.corners = corners;
    }

    /// Makes every tile active: before the first step, and whenever the planes were touched.
    pub fn wake(&mut self) {
        self.flags.fill(ACTIVE);
    }

    /// The row of tiles that pixel row `y` lies in.
    pub fn row_at(&self, y: usize) -> usize {
        y / self.tile_rows.max(1)
    }

    /// The first pixel row of a row of tiles.
    pub fn start(&self, row: usize) -> usize {
        row * self.tile_rows
    }

    fn row(&self, row: usize) -> &[u8] {
        row_of(self.flags, self.stride(), row)
    }

    /// Whether a tile is computed in this step; tiles outside the band are not.
    pub fn is_active(&self, row: usize, column: usize) -> bool {
        let tiles = self.row(row).split_last().map_or(&[][..], |(_, tiles)| tiles);
        tiles.get(column).is_some_and(|flag| flag & ACTIVE != 0)
    }

    /// The tiles of some `columns` of a row of tiles that are not computed in this step.
    pub(crate) fn at_rest(&self, row: usize, columns: Range<usize>) -> impl Iterator<Item = usize> {
        let flags = self.border(row).get(columns.start..).unwrap_or(&[]);
        columns.zip(flags).filter(|(_, flag)| *flag & ACTIVE == 0).map(|(column, _)| column)
    }

    /// The next run of active tiles in a row of tiles, from tile `from` on.
    pub fn next_run(&self, row: usize, from: usize) -> Option<Range<usize>> {
        let (union, tiles) = self.row(row).split_last()?;
        let rest = if union & ACTIVE == 0 { &[] } else { tiles.get(from..)? };
        let start = rest.iter().position(|flag| flag & ACTIVE != 0)?;
        let length = rest.iter().skip(start).take_while(|&flag| flag & ACTIVE != 0).count();
        Some(from + start..from + start + length)
    }

    /// The pixel columns of a run of tiles.
    pub fn columns(&self, run: &Range<usize>) -> Range<usize> {
        (run.start * COLUMNS).min(self.width)..(run.end * COLUMNS).min(self.width)
    }

    /// Pixel rows of a tile.
    pub(crate) fn tile_rows(&self) -> usize {
        self.tile_rows
    }

    /// The flags of a run of tiles.
    #[inline(always)]
    pub(crate) fn flags_of(&mut self, row: usize, run: &Range<usize>) -> &mut [u8] {
        let stride = self.stride();
        row_of_mut(self.flags, stride, row).get_mut(run.clone()).unwrap_or(&mut [])
    }

    /// The flags of a row of tiles, for [`Tiles::turn`] of the band before or after it.
    pub fn border(&self, row: usize) -> &[u8] {
        self.row(row).split_last().map_or(&[], |(_, tiles)| tiles)
    }

    /// Ends a step: tiles that changed or that face a changed margin are the next step's active
    /// ones. Where the band is a part of the frame, `before` and `after` are the flags of the
    /// adjoining rows of tiles.
    pub fn turn(&mut self, before: &[u8], after: &[u8]) {
        let stride = self.stride();
        let rows = self.flags.len() / stride;
        for flags in self.flags.chunks_exact_mut(stride) {
            if let Some((union, tiles)) = flags.split_last_mut()
                && *union & ACTIVE != 0
            {
                *union = tiles.iter().fold(0, |union, flag| union | flag);
            }
        }
        for row in 0..rows {
            let start = row * stride;
            let (below, rest) = self.flags.split_at_mut_checked(start).unwrap_or((&mut [], &mut []));
            let (flags, above) = rest.split_at_mut_checked(stride).unwrap_or((&mut [], &mut []));
            let below = if row == 0 { before } else { below.get(start - stride..).unwrap_or(&[]) };
            let above = if row + 1 == rows { after } else { above.get(..stride).unwrap_or(&[]) };
            turn_row(flags, below, above, self.corners);
        }
        self.flags.iter_mut().for_each(|flag| *flag &= ACTIVE);
    }
}

/// Tells the flags of a tile from what changes in one of its rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Marker {
    /// Set where any cell of the row changes.
    row: u8,
}

impl Marker {
    /// The marker of row `line` of tiles of `tile_rows` rows, where a step looks at the rows and
    /// columns up to `N / 2` around a pixel.
    #[inline(always)]
    pub(crate) fn new<const N: usize>(line: usize, tile_rows: usize) -> Marker {
        let bottom = if line < N / 2 { BOTTOM } else { 0 };
        let top = if line + N / 2 >= tile_rows { TOP } else { 0 };
        Marker { row: CHANGED | bottom | top }
    }

    /// Whether `flag` has all that a change in this row can set.
    #[inline(always)]
    pub(crate) fn is_complete(self, flag: u8) -> bool {
        let all = self.row | LEFT | RIGHT;
        flag & all == all
    }

    /// Adds to `flag` what a change of the cells sets whose bits are set, the first cell's lowest.
    #[inline(always)]
    pub(crate) fn mark_bits<const N: usize>(self, flag: &mut u8, bits: u32) {
        let margin = (1 << (N / 2)) - 1;
        if bits != 0 {
            self.set(flag, bits & margin != 0, bits & margin << (COLUMNS - N / 2) != 0);
        }
    }

    /// Adds to `flag` what a change from `old` to `new` in this row of the tile sets.
    #[inline(always)]
    pub(crate) fn mark<C: Cell, const N: usize>(self, flag: &mut u8, old: &[C], new: &[C]) {
        // Where the front moves, most tiles have all their flags after a row or two.
        if self.is_complete(*flag) {
            return;
        }
        let differ = |(v, w): (&C, &C)| v.bits() != w.bits();
        if old.iter().zip(new).fold(0, |bits, (v, w)| bits | (v.bits() ^ w.bits())) != 0 {
            let left = old.iter().zip(new).take(N / 2).any(differ);
            let right = old.iter().zip(new).skip(new.len().saturating_sub(N / 2)).any(differ);
            self.set(flag, left, right);
        }
    }

    /// Adds to `flag` what a change sets, at the tile's `left` or `right` margin too.
    #[inline(always)]
    fn set(self, flag: &mut u8, left: bool, right: bool) {
        *flag |= self.row | if left { LEFT } else { 0 } | if right { RIGHT } else { 0 };
    }
}

/// The active tiles of one row of tiles (its union behind it), from what changed in it, in the
/// row of tiles below and in the one above.
fn turn_row(flags: &mut [u8], below: &[u8], above: &[u8], corners: bool) {
    let Some((union, tiles)) = flags.split_last_mut() else { return };
    let any_has = |row: &[u8], side: u8| row.iter().fold(0, |all, flag| all | flag) & side != 0;
    let (under, over) = (any_has(below, TOP), any_has(above, BOTTOM));
    if *union & (ACTIVE | CHANGED) == 0 && !under && !over {
        return;
    }
    let at = |row: &[u8], column: usize| row.get(column).copied().unwrap_or(0);
    let has = |flag: u8, bits: u8| flag & bits == bits;
    let (mut any, mut left) = (0, 0);
    for column in 0..tiles.len() {
        let (before, after) = (column.wrapping_sub(1), column + 1);
        let faces = |row: &[u8], side: u8| {
            let at_corner = || has(at(row, before), side | RIGHT) || has(at(row, after), side | LEFT);
            has(at(row, column), side) || corners && at_corner()
        };
        let flag = at(tiles, column);
        let beside = (flag & CHANGED) | (left & RIGHT) | (at(tiles, after) & LEFT) != 0;
        let active = u8::from(beside || under && faces(below, TOP) || over && faces(above, BOTTOM));
        left = flag;
        if let Some(tile) = tiles.get_mut(column) {
            *tile = (flag & !ACTIVE) | active;
        }
        any |= active;
    }
    *union = (*union & !ACTIVE) | any;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The active tiles of a frame of 5 x 5 tiles after a step in which one pixel changed.
    fn woken(x: usize, y: usize) -> [[bool; 5]; 5] {
        woken_by(x, y, true)
    }

    fn woken_by(x: usize, y: usize, corners: bool) -> [[bool; 5]; 5] {
        let (width, height) = (5 * COLUMNS - 3, 38);
        let mut flags = [0; 30];
        assert_eq!(flags.len(), flags_len(width, height));
        let mut tiles = Tiles::new(&mut flags, width, rows_of_tile(height));
        tiles.wake();
        tiles.look_at_corners(corners);
        assert_eq!(tiles.next_run(0, 0), Some(0..5));
        let (old, mut new) = ([0.0f32; COLUMNS], [0.0f32; COLUMNS]);
        new[x % COLUMNS] = 1e-45;
        let column = x / COLUMNS;
        let flag = &mut tiles.flags_of(y / 8, &(column..column + 1))[0];
        Marker::new::<11>(y % 8, 8).mark::<_, 11>(flag, &old, &new);
        tiles.turn(&[], &[]);
        let woken = core::array::from_fn(|row| core::array::from_fn(|column| tiles.is_active(row, column)));
        tiles.turn(&[], &[]);
        assert_eq!(flags, [0; 30], "all sleep, and their rows, after a step without a change");
        woken
    }

    /// Every tile of `rows` and `columns` must be active; none two tiles away from them may be.
    fn check(woken: [[bool; 5]; 5], rows: Range<usize>, columns: Range<usize>) {
        let near = |range: &Range<usize>, i: usize| range.start <= i + 1 && i <= range.end;
        for (row, flags) in woken.iter().enumerate() {
            for (column, &active) in flags.iter().enumerate() {
                let needed = rows.contains(&row) && columns.contains(&column);
                let allowed = near(&rows, row) && near(&columns, column);
                assert!(active || !needed, "tile ({column}, {row}) looks at the change and sleeps: {woken:?}");
                assert!(!active || allowed, "tile ({column}, {row}) is far from the change: {woken:?}");
            }
        }
    }

    #[test]
    fn a_change_wakes_its_tile_and_those_that_look_at_it() {
        let row = 2 * 8;
        check(woken(3 * COLUMNS + 9, row), 1..3, 3..4);
        check(woken(3 * COLUMNS, row), 1..3, 2..4);
        check(woken(4 * COLUMNS - 1, row + 7), 2..4, 3..5);
        check(woken(4 * COLUMNS - 5, row + 7), 2..4, 3..5);
        check(woken(5 * COLUMNS - 4, 37), 4..5, 4..5);
        check(woken(0, 0), 0..1, 0..1);
    }

    #[test]
    fn a_corner_wakes_the_tile_beyond_it_where_a_step_looks_there() {
        for (x, row, column) in [(2 * COLUMNS, 1, 1), (3 * COLUMNS - 1, 1, 3)] {
            assert_eq!([true, false].map(|corners| woken_by(x, 16, corners)[row][column]), [true, false]);
        }
    }
}
