//! The threshold of greatest entropy of Kapur, Sahoo and Wong (doi:10.1016/0734-189X(85)90125-2), in whole numbers.

use crate::sky::otsu::{BINS, Histogram};

/// Fraction bits of logarithms: as many as leave room for the sum of `n log2 n` over 2^32 values.
const FRACTION: u32 = 27;
/// Sums of entropies within 6e-8 bits of each other are equal: rounding must not choose between them.
const SAME: i64 = 8;

impl Histogram {
    /// The upper edge of the last background bin, where the entropies of background and objects,
    /// each as a distribution of its own, have the greatest sum; the lowest such edge where
    /// several are equal, and 0 where all values share a bin.
    ///
    /// With n values in a bin and N in a class its entropy is `log2 N - (sum of n log2 n) / N`. Cost:
    /// four logarithms and two divisions per bin.
    pub fn kapur(&self) -> f32 {
        let all: u64 = self.0.iter().map(|&n| u64::from(n)).sum();
        // More than 2^32 values are counted in pairs, fours and so on.
        let excess = 32u32.saturating_sub(all.leading_zeros());
        let counts = || self.0.iter().map(|&n| u64::from(n) >> excess);
        let n_log_n = |n: u64| n.saturating_mul(log2(n));
        let (all, information) = counts().fold((0u64, 0u64), |(all, information), n| {
            (all.saturating_add(n), information.saturating_add(n_log_n(n)))
        });
        let (mut best, mut tau) = (i64::MIN, 0.0);
        let (mut below, mut known) = (0u64, 0u64);
        for (bin, n) in counts().enumerate() {
            below = below.saturating_add(n);
            known = known.saturating_add(n_log_n(n));
            let background = entropy(below, known);
            let objects = entropy(all.saturating_sub(below), information.saturating_sub(known));
            let Some((background, objects)) = background.zip(objects) else { continue };
            let entropy = background.saturating_add(objects);
            if entropy > best.saturating_add(SAME) {
                (best, tau) = (entropy, (bin + 1) as f32 / BINS as f32);
            }
        }
        tau
    }
}

/// The entropy of a class of values, in bits with [`FRACTION`]; `None` for one without.
fn entropy(count: u64, n_log_n: u64) -> Option<i64> {
    let mean = n_log_n.checked_div(count)?;
    Some(log2(count).saturating_sub(mean) as i64)
}

/// The logarithm of n < 2^32 with [`FRACTION`] bits, 0 of 0, less by at most 1e-8.
///
/// Squaring doubles a logarithm: whenever the square passes 2, the next bit is a one.
fn log2(n: u64) -> u64 {
    let Some(whole) = n.checked_ilog2() else { return 0 };
    // In [1, 2), with 31 bits behind the point.
    let mantissa = n.wrapping_shl(31u32.saturating_sub(whole));
    let (_, log) = (0..FRACTION).fold((mantissa, u64::from(whole)), |(mantissa, log), _| {
        let square = mantissa.wrapping_mul(mantissa) >> 31;
        let bit = square >> 32;
        (square >> bit, log << 1 | bit)
    });
    log
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_are_as_exact_as_said() {
        let numbers = (1..70_000u64).chain((0..32).flat_map(|i| [(1u64 << i) + 1, (1 << (i + 1)) - 1]));
        for n in numbers.filter(|n| *n < 1 << 32) {
            let (exact, found) = ((n as f64).log2(), log2(n) as f64 / f64::from(1 << FRACTION));
            assert!((0.0..1e-8).contains(&(exact - found)), "{n}: {found}, not {exact}");
        }
        assert_eq!(log2(0), 0);
    }

    #[test]
    fn more_values_than_a_word_counts_have_the_same_threshold() {
        let mut bins = [0; BINS];
        bins[10..40].fill(1 << 5);
        bins[180..210].fill(1 << 5);
        let many = bins.map(|n| n << 26);
        assert_eq!([bins, many].map(|bins| Histogram(bins).kapur()), [40.0 / 256.0; 2]);
    }

    #[test]
    fn both_classes_are_as_even_as_they_can_be() {
        let threshold = |bins: &[(usize, u32)]| {
            let mut histogram = Histogram::EMPTY;
            bins.iter().for_each(|&(bin, count)| histogram.0[bin] = count);
            histogram.kapur() * BINS as f32
        };
        // Two and two: twice ln 2 and not ln 3.
        assert_eq!(threshold(&[(10, 9), (20, 9), (30, 9), (40, 9)]), 21.0);
        // One of three against two equal ones: ln 2, and 0.35 for the others.
        assert_eq!(threshold(&[(10, 8), (20, 1), (30, 1)]), 11.0);
        assert_eq!(threshold(&[(10, 1), (20, 1), (30, 8)]), 21.0);
        assert_eq!((threshold(&[(10, 8)]), threshold(&[])), (0.0, 0.0));
        // Behind the second bin there are 8 and 11 parts of 2^27 more than behind the first: the same, and more.
        assert_eq!(threshold(&[(10, 873_000), (20, 1_000_000), (30, 872_999)]), 11.0);
        assert_eq!(threshold(&[(10, 900_000), (20, 1_000_000), (30, 899_998)]), 21.0);
    }
}
