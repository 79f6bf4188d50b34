//! Four classes of values, from a histogram.

use super::otsu::{BINS, Histogram};
use core::ops::Range;

/// Bins of the histogram in one of those that are looked at.
const POOLED: usize = 4;
const POOLS: usize = BINS / POOLED;

/// Number and sum of the values below each pool, in pools.
type Below = [(u64, u64); POOLS + 1];

/// How much less variance two classes have than one, and where they part.
#[derive(Clone, Copy)]
struct Parted {
    gain: f32,
    at: usize,
}

impl Histogram {
    /// The means of the four classes of values with the least variance within them, from dark to
    /// bright, as the histogram tells them in steps of 1/64: for each border between the middle two the
    /// best borders on both sides of it. A class without values has the mean of the one below it, or
    /// of the first that has values.
    ///
    /// Cost: 4096 comparisons.
    pub fn four_classes(&self) -> [f32; 4] {
        let below = self.below();
        let (mut best, mut borders) = (0.0f32, [0, POOLS, POOLS, POOLS, POOLS]);
        for middle in 1..=POOLS {
            let (low, high) = (parted(&below, 0..middle), parted(&below, middle..POOLS));
            let gain = gain(&below, 0..POOLS, middle) + (low.gain + high.gain);
            if gain > best {
                (best, borders) = (gain, [0, low.at, middle, high.at, POOLS]);
            }
        }
        let [zero, one, two, three, end] = borders;
        let classes = [zero..one, one..two, two..three, three..end];
        let middle = |class: &Range<usize>| mean(&below, class.clone()).map(|mean| (mean + 0.5) / POOLS as f32);
        let mut last = classes.iter().find_map(middle).unwrap_or(0.0);
        classes.map(|class| {
            last = middle(&class).unwrap_or(last);
            last
        })
    }

    fn below(&self) -> Below {
        let (mut below, mut sum) = ([(0, 0); POOLS + 1], (0u64, 0u64));
        for ((at, below), pool) in (0u64..).zip(below.iter_mut().skip(1)).zip(self.0.chunks(POOLED)) {
            let count = pool.iter().fold(0u64, |sum, &count| sum.saturating_add(u64::from(count)));
            sum = (sum.0.saturating_add(count), sum.1.saturating_add(at.saturating_mul(count)));
            *below = sum;
        }
        below
    }
}

/// Number and sum of the values in some pools.
fn within(below: &Below, pools: Range<usize>) -> (u64, u64) {
    let at = |place: usize| below.get(place).copied().unwrap_or((0, 0));
    let ((count, sum), (first_count, first_sum)) = (at(pools.end), at(pools.start));
    (count.saturating_sub(first_count), sum.saturating_sub(first_sum))
}

fn mean(below: &Below, pools: Range<usize>) -> Option<f32> {
    let (count, sum) = within(below, pools);
    (count > 0).then(|| sum as f32 / count as f32)
}

/// What parting some pools at one of them takes off the sum of the squared distances from the mean.
fn gain(below: &Below, pools: Range<usize>, at: usize) -> f32 {
    let (low, high) = (pools.start..at, at..pools.end);
    let (Some(dark), Some(bright)) = (mean(below, low.clone()), mean(below, high.clone())) else { return 0.0 };
    let (low, high) = (within(below, low).0 as f32, within(below, high).0 as f32);
    let apart = bright - dark;
    low * (high / (low + high)) * (apart * apart)
}

/// The border that parts some pools best, the lowest of several; their end where none does.
fn parted(below: &Below, pools: Range<usize>) -> Parted {
    let none = Parted { gain: 0.0, at: pools.end };
    pools.clone().skip(1).fold(none, |best, at| {
        let gain = gain(below, pools.clone(), at);
        if gain > best.gain { Parted { gain, at } } else { best }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn classes(values: &[(f32, u32)]) -> [f32; 4] {
        let mut histogram = Histogram::EMPTY;
        for &(value, count) in values {
            (0..count).for_each(|_| histogram.add(value));
        }
        histogram.four_classes()
    }

    #[test]
    fn four_levels_are_four_classes_however_few_pixels_they_have() {
        let levels = [0.05, 0.2, 0.6, 0.95];
        for counts in [[10, 10, 10, 10], [9000, 300, 40, 10], [10, 40, 300, 9000]] {
            let found = classes(&core::array::from_fn::<_, 4, _>(|at| (levels[at], counts[at])));
            for (found, level) in found.into_iter().zip(levels) {
                assert!((found - level).abs() <= 0.5 / POOLS as f32, "{found}, not {level}");
            }
        }
    }

    /// No other borders leave less variance.
    #[test]
    fn no_borders_are_better() {
        let count = |at: usize| (at * 7919 % 101 + if at < 12 { 400 } else { 0 }) as u32;
        let values: [(f32, u32); POOLS] = core::array::from_fn(|at| ((at as f32 + 0.5) / POOLS as f32, count(at)));
        let within = |first: usize, end: usize| {
            let part = &values[first..end];
            let count = part.iter().map(|value| f64::from(value.1)).sum::<f64>();
            let mean = part.iter().map(|value| f64::from(value.0) * f64::from(value.1)).sum::<f64>() / count.max(1.0);
            part.iter().map(|value| f64::from(value.1) * (f64::from(value.0) - mean).powi(2)).sum::<f64>()
        };
        let mut least = f64::INFINITY;
        for a in 1..POOLS {
            for b in a..POOLS {
                let low = within(0, a) + within(a, b);
                least = (b..POOLS).fold(least, |least, c| least.min(low + within(b, c) + within(c, POOLS)));
            }
        }
        let means = classes(&values).map(f64::from);
        let nearest = |value: f64| means.iter().map(|mean| (value - mean).powi(2)).fold(f64::INFINITY, f64::min);
        let found = values.iter().map(|value| f64::from(value.1) * nearest(f64::from(value.0))).sum::<f64>();
        assert!(found <= least * (1.0 + 1e-6), "{found}, not {least}");
    }

    #[test]
    fn fewer_levels_leave_classes_without_values() {
        assert_eq!(classes(&[(0.5, 7)]), [0.507_812_5; 4]);
        let [dark, .., bright] = classes(&[(0.1, 7), (0.9, 3)]);
        assert!((dark - 0.1).abs() < 0.01 && (bright - 0.9).abs() < 0.01);
        assert_eq!(classes(&[]), [0.0; 4]);
    }
}
