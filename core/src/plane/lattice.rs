//! Sweeps that look two rows up and down, or two steps of a wider spacing.
//!
//! Rows whose numbers differ by a multiple of the spacing are a lattice of their own: lattices are
//! swept one after another, so that three saved rows are enough for any spacing. Beyond the frame
//! the last row of a lattice is repeated, and along a row the last column: with spacing 1 the
//! homogeneous Neumann conditions of [`crate::plane::sweep`].

use crate::plane::rows::{row_of, row_of_mut};
use core::num::NonZero;
use core::ops::Range;

/// Five rows of a lattice before the sweep has changed them, and the middle one as it is to be
/// changed.
#[derive(Debug)]
pub struct Five<'a, C> {
    /// Two before; of no use afterwards, so that it may be written to.
    pub far_before: &'a mut [C],
    /// One before.
    pub before: &'a [C],
    /// The row itself.
    pub centre: &'a [C],
    /// One after.
    pub after: &'a [C],
    /// Two after.
    pub far_after: &'a [C],
    /// The row itself, to be overwritten; until then the same.
    pub new: &'a mut [C],
    /// Which row it is.
    pub y: usize,
}

/// The lattice of the `n`th row of a sweep over `height` rows: its first row, and which of its rows
/// it is.
fn place(n: usize, height: usize, spacing: NonZero<usize>) -> (usize, usize) {
    let (rows, longer) = (height / spacing, height % spacing);
    // Those that begin first have one row more.
    let in_longer = longer.saturating_mul(rows.saturating_add(1));
    if n < in_longer {
        let length = NonZero::new(rows.saturating_add(1)).unwrap_or(NonZero::<usize>::MIN);
        (n / length, n % length)
    } else {
        let (n, length) = (n.saturating_sub(in_longer), NonZero::new(rows).unwrap_or(NonZero::<usize>::MIN));
        (longer.saturating_add(n / length), n % length)
    }
}

/// Calls `each` for `steps` of a sweep over the rows of a plane, 0 to its height: those of one
/// sweep in order. `ring` has at least three rows of the plane and keeps old rows between two
/// calls. Cost: a copy of each row.
pub fn sweep<C: Copy>(
    plane: &mut [C],
    ring: &mut [C],
    width: usize,
    spacing: usize,
    steps: Range<usize>,
    mut each: impl FnMut(Five<'_, C>),
) {
    let height = plane.len() / width.max(1);
    let spacing = NonZero::new(spacing).unwrap_or(NonZero::<usize>::MIN);
    for step in steps {
        let (first, index) = place(step, height, spacing);
        let y = first.saturating_add(index.saturating_mul(spacing.get()));
        let Some((slots, _)) = ring.split_at_mut_checked(width.saturating_mul(3)) else { return };
        let (one, rest) = slots.split_at_mut_checked(width).unwrap_or((&mut [], &mut []));
        let (two, three) = rest.split_at_mut_checked(width).unwrap_or((&mut [], &mut []));
        let (centre, before, far_before) = match index % 3 {
            0 => (one, three, two),
            1 => (two, one, three),
            _ => (three, two, one),
        };
        let end = y.saturating_add(1).saturating_mul(width);
        let (until, later) = plane.split_at_mut_checked(end).unwrap_or((&mut [], &mut []));
        let new = row_of_mut(until, width, y);
        copy(new, centre);
        if index == 0 {
            copy(new, before);
        }
        if index < 2 {
            copy(before, far_before);
        }
        // The first row of `later` is row y + 1.
        let beyond = |rows: usize| rows.saturating_mul(spacing.get()).saturating_sub(1);
        let after = [row_of(later, width, beyond(1)), &*centre].into_iter().find(|row| !row.is_empty()).unwrap_or(&[]);
        let far_after = [row_of(later, width, beyond(2)), after].into_iter().find(|row| !row.is_empty()).unwrap_or(&[]);
        each(Five { far_before, before, centre, after, far_after, new, y });
    }
}

fn copy<C: Copy>(from: &[C], to: &mut [C]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
}

/// The cells two and one before, at, one and two after column `x` of a lattice of columns; the last
/// of them beyond the row's ends. `None` where the row has no such column.
#[inline(always)]
pub fn five_columns<C: Copy>(row: &[C], x: usize, spacing: usize) -> Option<[C; 5]> {
    let centre = *row.get(x)?;
    let at = |place: Option<usize>, inner: C| place.and_then(|x| row.get(x)).copied().unwrap_or(inner);
    let left = at(x.checked_sub(spacing), centre);
    let right = at(x.checked_add(spacing), centre);
    let far_left = at(x.checked_sub(spacing.saturating_mul(2)), left);
    let far_right = at(x.checked_add(spacing.saturating_mul(2)), right);
    Some([far_left, left, centre, right, far_right])
}

#[cfg(test)]
mod tests {
    use super::*;

    extern crate std;
    use std::vec::Vec;
    use std::{assert_eq, vec};

    /// The rows that a sweep over rows which hold their own number saw around each, in its order.
    fn seen(height: usize, spacing: usize, slice: usize) -> Vec<[u32; 5]> {
        let (width, mut seen) = (2, Vec::new());
        let mut plane: Vec<u32> = (0..height as u32).flat_map(|y| [y; 2]).collect();
        let mut ring = vec![77; 3 * width];
        for start in (0..height).step_by(slice) {
            let steps = start..(start + slice).min(height);
            sweep(&mut plane, &mut ring, width, spacing, steps, |five| {
                let rows = [&*five.far_before, five.before, five.centre, five.after, five.far_after];
                assert!(rows.iter().all(|row| row.len() == width) && *five.new == *five.centre);
                assert_eq!(five.centre[1], five.y as u32);
                seen.push(rows.map(|row| row[1]));
                five.new.fill(99);
                five.far_before.fill(55);
            });
        }
        assert!(plane.iter().all(|&cell| cell == 99), "every row was swept");
        seen
    }

    #[test]
    fn old_rows_of_a_lattice_are_seen_whatever_the_slices() {
        for height in 1..12 {
            for spacing in [1, 2, 3, 4, 16] {
                let whole = seen(height, spacing, height);
                assert_eq!(seen(height, spacing, 1), whole);
                assert_eq!(seen(height, spacing, 3), whole);
                for rows in whole {
                    let y = rows[2] as usize;
                    let before = if y >= spacing { y - spacing } else { y };
                    let far_before = if y >= 2 * spacing { y - 2 * spacing } else { before };
                    let after = if y + spacing < height { y + spacing } else { y };
                    let far_after = if y + 2 * spacing < height { y + 2 * spacing } else { after };
                    assert_eq!(rows.map(|row| row as usize), [far_before, before, y, after, far_after]);
                }
            }
        }
    }

    #[test]
    fn columns_are_repeated_beyond_the_ends() {
        let row = [10, 11, 12, 13, 14, 15];
        assert_eq!(five_columns(&row, 2, 1), Some([10, 11, 12, 13, 14]));
        assert_eq!(five_columns(&row, 0, 1), Some([10, 10, 10, 11, 12]));
        assert_eq!(five_columns(&row, 3, 2), Some([11, 11, 13, 15, 15]));
        assert_eq!(five_columns(&row, 4, 4), Some([10, 10, 14, 14, 14]));
        assert_eq!(five_columns(&row, 6, 1), None);
    }
}
