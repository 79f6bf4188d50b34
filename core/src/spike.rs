//! Hot pixels and cosmic rays: values that stand alone.

use crate::sort;

/// The most that a pixel's value may exceed its neighbours by, in noise units.
const HEIGHT: f32 = 5.0;
/// A pixel whose neighbours' median reaches this part of it is a star: no optics makes it sharper.
const SHARE: f32 = 0.25;

/// The value at `x` of the middle of three rows of signal-to-noise: its own, or where it is a
/// spike the median of its neighbours. Rows beyond the frame are empty.
pub fn cleaned(rows: [&[f32]; 3], x: usize) -> f32 {
    let [_, row, _] = rows;
    let own = row.get(x).copied().unwrap_or(0.0);
    if own <= HEIGHT {
        return own;
    }
    let (mut near, mut count) = ([0.0; 8], 0);
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
    sort::few(near, |a, b| sort::key(a) < sort::key(b));
    let at = |index: usize| near.get(index).copied().unwrap_or(0.0);
    let median = 0.5 * (at(count / 2) + at(count.saturating_sub(1) / 2));
    let floor = if median > 0.0 { median } else { 0.0 };
    if own - median > HEIGHT && floor + 1.0 < SHARE * own { median } else { own }
}
