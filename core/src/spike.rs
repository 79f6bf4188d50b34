//! Hot pixels and cosmic rays: values that stand alone.

use crate::arithmetic::{Level, Real};
use crate::sort;

/// The most that a pixel's value may exceed its neighbours by, in noise units.
const HEIGHT: f32 = 5.0;
/// A pixel whose neighbours' median reaches this part of it is a star: no optics makes it sharper.
const SHARE: f32 = 0.25;

/// The value at `x` of the middle of three rows of signal-to-noise: its own, or where it is a
/// spike the median of its neighbours. Rows beyond the frame are empty.
pub fn cleaned<L: Level>(rows: [&[L]; 3], x: usize) -> L {
    let [_, row, _] = rows;
    let own = row.get(x).copied().unwrap_or(L::ZERO);
    let height = L::of(HEIGHT);
    if own <= height {
        return own;
    }
    let (mut near, mut count) = ([L::ZERO; 8], 0);
    for (index, row) in rows.into_iter().enumerate() {
        for column in x.saturating_sub(1)..x + 2 {
            if let (Some(&value), Some(out), false) = (row.get(column), near.get_mut(count), index == 1 && column == x)
            {
                *out = value;
                count += 1;
            }
        }
    }
    let near = near.get_mut(..count).unwrap_or(&mut []);
    sort::few(near, |a, b| a.key() < b.key());
    let at = |index: usize| near.get(index).copied().unwrap_or(L::ZERO);
    let median = (at(count / 2) + at(count.saturating_sub(1) / 2)).scaled(L::Weight::of(0.5));
    let alone = median.positive() + L::ONE < own.scaled(L::Weight::of(SHARE));
    if own - median > height && alone { median } else { own }
}
