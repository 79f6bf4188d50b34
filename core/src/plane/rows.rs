//! The rows of a plane.

use core::ops::Range;

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

/// Some rows of a row-major plane; none where not all of them are there.
#[inline]
pub fn rows_of<'p, T>(plane: &'p [T], rows: &Range<usize>, width: usize) -> &'p [T] {
    plane.get(rows.start.saturating_mul(width)..rows.end.saturating_mul(width)).unwrap_or(&[])
}

/// Some rows of a row-major plane, to write to; none where not all of them are there.
#[inline]
pub fn rows_of_mut<'p, T>(plane: &'p mut [T], rows: &Range<usize>, width: usize) -> &'p mut [T] {
    plane.get_mut(rows.start.saturating_mul(width)..rows.end.saturating_mul(width)).unwrap_or(&mut [])
}

/// Cells that are looked at together for a bit.
const PIECE: usize = 16;

/// The first cell from `from` on that has one of the `bits`: most of a plane of labels has none. Cost: a look at
/// each cell up to there, some at a time.
#[inline]
pub fn next_with(plane: &[u32], from: usize, bits: u32) -> Option<usize> {
    let rest = plane.get(from..)?;
    let has = |cell: &u32| cell & bits != 0;
    if rest.first().is_some_and(has) {
        return Some(from);
    }
    let is_blank = |piece: &&[u32]| piece.iter().fold(0, |any, cell| any | cell) & bits == 0;
    let blank = PIECE * rest.chunks(PIECE).take_while(is_blank).count();
    rest.get(blank..)?.iter().position(has).map(|at| from + blank + at)
}

/// Works on those of the `length` cells of a piece that are `open`, a bit for each, the lowest for the first: forwards or
/// backwards. Where `work` says that one has changed, the one behind it is open too.
#[inline(always)]
pub(crate) fn sweep(open: u32, length: usize, forwards: bool, mut work: impl FnMut(usize) -> bool) {
    let (mut open, all) = (open, whole_piece(length));
    while open != 0 {
        let at = if forwards { open.trailing_zeros() } else { open.ilog2() };
        let bit = 1u32 << at;
        open &= !bit;
        if work(at as usize) {
            open |= if forwards { bit << 1 } else { bit >> 1 };
            open &= all;
        }
    }
}

/// A bit for each of so many cells, fewer than 32.
#[inline(always)]
pub(crate) fn whole_piece(length: usize) -> u32 {
    (1 << (length % 32)) - 1
}

/// The last cell before `end` that has one of the `bits`.
pub fn last_with(plane: &[u32], end: usize, bits: u32) -> Option<usize> {
    let rest = plane.get(..end)?;
    let has = |cell: &u32| cell & bits != 0;
    if rest.last().is_some_and(has) {
        return Some(end - 1);
    }
    let is_blank = |piece: &&[u32]| piece.iter().fold(0, |any, cell| any | cell) & bits == 0;
    let blank = PIECE * rest.rchunks(PIECE).take_while(is_blank).count();
    rest.get(..end.saturating_sub(blank))?.iter().rposition(has)
}

/// The cells that are not 0, with their indices.
#[inline]
pub fn used(plane: &[u32]) -> impl Iterator<Item = (usize, u32)> {
    let mut next = 0;
    core::iter::from_fn(move || {
        let at = next_with(plane, next, u32::MAX)?;
        next = at + 1;
        plane.get(at).map(|&cell| (at, cell))
    })
}

/// The runs of cells that have one value other than 0: first cell, end and value.
#[inline]
pub fn runs(plane: &[u32]) -> impl Iterator<Item = (usize, usize, u32)> {
    let mut next = 0;
    core::iter::from_fn(move || {
        let first = next_with(plane, next, u32::MAX)?;
        let (&value, rest) = plane.get(first..)?.split_first()?;
        next = rest.iter().position(|&other| other != value).map_or(plane.len(), |length| first + 1 + length);
        Some((first, next, value))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_of_one_value_and_leave_nothing_out() {
        let mut state = 1u32;
        for length in [0, 1, 15, 16, 17, 100] {
            for values in [1, 2, 3] {
                let mut plane = [0; 100];
                let plane = &mut plane[..length];
                for cell in plane.iter_mut() {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    *cell = (state >> 16) % values;
                }
                let mut known = [0; 100];
                for (first, end, value) in runs(plane) {
                    assert!(first < end && value != 0);
                    assert_ne!(first.checked_sub(1).map(|before| plane[before]), Some(value));
                    assert_ne!(plane.get(end), Some(&value));
                    known[first..end].fill(value);
                }
                assert_eq!(known[..length], *plane);
            }
        }
    }

    #[test]
    fn every_cell_with_a_bit_is_met_once_in_either_direction() {
        for length in [0, 1, 15, 16, 17, 100] {
            for gap in [1, 2, 16, 17, 40, 1000] {
                let mut plane = [0; 100];
                let plane = &mut plane[..length];
                plane.iter_mut().enumerate().for_each(|(at, cell)| *cell = if at % gap == gap / 2 { 6 } else { 1 });
                let expected = || (0..length).filter(|at| at % gap == gap / 2);
                let next = |from: usize| next_with(plane, from, 2);
                assert!(core::iter::successors(next(0), |at| next(at + 1)).eq(expected()), "{length} {gap}");
                let last = |end: usize| last_with(plane, end, 4);
                assert!(core::iter::successors(last(length), |at| last(*at)).eq(expected().rev()), "{length} {gap}");
                plane.iter_mut().for_each(|cell| *cell &= 2);
                assert!(used(plane).eq(expected().map(|at| (at, 2))), "{length} {gap}");
            }
        }
    }
}
