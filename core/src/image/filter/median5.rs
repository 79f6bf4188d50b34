//! The median of 5 x 5 pixels: what [`Median`](super::median::Median) does, for clumps of up to
//! twelve pixels (J. W. Tukey 1977, Exploratory Data Analysis).

use super::window::Window;
use crate::arithmetic::{Arithmetic, Real};

/// Each pixel becomes the median of the 5 x 5 pixels around it; a pass is one step.
#[derive(Clone, Copy, Debug)]
pub struct Median5;

/// More than half of the 25: the least and the greatest of so many are not their median.
const KEPT: usize = 14;

/// Brings the least of some values to the front and the greatest to the back.
#[inline(always)]
fn part<R: Real>(values: &mut [R]) {
    if let [first, rest @ ..] = values {
        for value in rest {
            (*first, *value) = (first.least(*value), value.greatest(*first));
        }
    }
    if let [rest @ .., last] = values {
        for value in rest {
            (*value, *last) = (value.least(*last), last.greatest(*value));
        }
    }
}

/// The median of 25 values: the least and the greatest of those kept are dropped and one more is
/// taken in, until three are left. The same comparisons whatever the values.
#[inline(always)]
fn median<R: Real>(values: &mut [R; 25]) -> R {
    let (mut kept, rest) = values.split_at_mut_checked(KEPT).unwrap_or((&mut [], &mut []));
    for value in rest {
        part(kept);
        kept = kept.split_last_mut().map_or(&mut [], |(_, shorter)| shorter);
        if let Some(first) = kept.first_mut() {
            *first = *value;
        }
    }
    part(kept);
    if let [_, median, _] = kept { *median } else { R::ZERO }
}

impl<A: Arithmetic> Window<A> for Median5 {
    #[inline(always)]
    fn pixel(&self, around: [[A::Real; 5]; 5]) -> A::Real {
        let mut values = [A::Real::ZERO; 25];
        values.iter_mut().zip(around.iter().flatten()).for_each(|(value, &around)| *value = around);
        median(&mut values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_thirteenth_of_25() {
        for seed in 0..200u32 {
            let value = |at: u32| ((at * 7919 + seed * 104_729) % (9 + seed)) as f32 / 32.0;
            let mut values: [f32; 25] = core::array::from_fn(|at| value(at as u32));
            let mut sorted = values;
            sorted.sort_by(f32::total_cmp);
            assert_eq!(median(&mut values), sorted[12], "{seed}: {sorted:?}");
        }
    }
}
