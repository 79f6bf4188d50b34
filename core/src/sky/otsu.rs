//! Otsu's threshold (doi:10.1109/TSMC.1979.4310076) from a histogram of constant size.

use crate::config::Tau;

/// Number of bins over [0, 1]; the last one holds 1 as well.
pub const BINS: usize = 256;

/// A histogram of values in [0, 1].
///
/// ```
/// use skyfront_core::sky::otsu::Histogram;
///
/// let mut histogram = Histogram::EMPTY;
/// [0.1, 0.1, 0.1, 0.9, 0.9].into_iter().for_each(|value| histogram.add(value));
/// let tau = histogram.otsu();
/// assert!(0.1 < tau && tau < 0.9);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Histogram(pub [u32; BINS]);

impl Histogram {
    /// No value yet.
    pub const EMPTY: Histogram = Histogram([0; BINS]);

    /// Forgets all values.
    pub fn clear(&mut self) {
        self.0.fill(0);
    }

    /// Counts a value; values outside [0, 1] count in the outermost bins.
    #[inline]
    pub fn add(&mut self, value: f32) {
        let bin = ((value * BINS as f32) as usize).min(BINS - 1);
        if let Some(count) = self.0.get_mut(bin) {
            *count = count.saturating_add(1);
        }
    }

    /// The threshold of a rule that needs no more than a histogram; Otsu's for the others.
    pub fn threshold(&self, rule: Tau) -> f32 {
        match rule {
            Tau::Kapur => self.kapur(),
            Tau::Rosin => self.rosin(),
            Tau::Otsu | Tau::Noise { .. } | Tau::Value(_) => self.otsu(),
        }
    }

    /// The upper edge of the last background bin, where the variance between the two classes is
    /// greatest; the lowest such edge where several are equal, and 0 where all values share a bin.
    ///
    /// The class means differ by an exact integer over the product of the class sizes, so only
    /// the last two divisions and a product are rounded.
    pub fn otsu(&self) -> f32 {
        let (count, sum) = (0u64..).zip(&self.0).fold((0u64, 0u64), |(count, sum), (bin, &n)| {
            (count.saturating_add(u64::from(n)), sum.saturating_add(bin.saturating_mul(u64::from(n))))
        });
        let (mut best, mut tau) = (0.0f32, 0.0f32);
        let (mut count_below, mut sum_below) = (0u64, 0u64);
        for (bin, &n) in (0u64..).zip(&self.0) {
            count_below = count_below.saturating_add(u64::from(n));
            sum_below = sum_below.saturating_add(bin.saturating_mul(u64::from(n)));
            let count_above = count.saturating_sub(count_below);
            if count_below == 0 || count_above == 0 {
                continue;
            }
            let distance = sum.saturating_mul(count_below).abs_diff(sum_below.saturating_mul(count)) as f32;
            let between = (distance / count_below as f32) * (distance / count_above as f32);
            if between > best {
                best = between;
                tau = bin.saturating_add(1) as f32 / BINS as f32;
            }
        }
        tau
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(bins: &[(usize, u32)]) -> Histogram {
        let mut histogram = Histogram::EMPTY;
        bins.iter().for_each(|&(bin, count)| histogram.0[bin] = count);
        histogram
    }

    #[test]
    fn the_variance_between_the_classes_decides() {
        // Behind bin 10 it is 6 * 4 * 100^2, behind bin 20 it is 8 * 2 * 187.5^2.
        assert_eq!(counted(&[(10, 6), (20, 2), (200, 2)]).otsu(), 21.0 / 256.0);
        // Behind bin 10 it is 4 * 6 * 160^2, behind bin 150 it is 6 * 4 * 123.3^2.
        assert_eq!(counted(&[(10, 4), (150, 2), (180, 4)]).otsu(), 11.0 / 256.0);
        // Behind bin 10 it is 50 * 51 * 10.4^2, behind bin 20, where the means lie farther apart, 100 * 1 * 25^2.
        assert_eq!(counted(&[(10, 50), (20, 50), (40, 1)]).otsu(), 11.0 / 256.0);
        // The same behind both, and behind all bins between.
        assert_eq!(counted(&[(10, 1), (20, 1), (30, 1)]).otsu(), 11.0 / 256.0);
        assert_eq!((counted(&[(77, 5)]).otsu(), Histogram::EMPTY.otsu()), (0.0, 0.0));
    }

    #[test]
    fn values_count_in_their_bins() {
        let mut histogram = Histogram::EMPTY;
        [-1.0, 0.0, 0.5, 0.499, 1.0, 7.0].into_iter().for_each(|value| histogram.add(value));
        assert_eq!(histogram, counted(&[(0, 2), (127, 1), (128, 1), (255, 2)]));
        histogram.clear();
        assert_eq!(histogram, Histogram::EMPTY);
    }

    #[test]
    fn each_rule_has_its_own_threshold() {
        let histogram = counted(&[(10, 60), (20, 20), (21, 9), (60, 1), (200, 2)]);
        let own = [Tau::Kapur, Tau::Rosin, Tau::Otsu].map(|rule| histogram.threshold(rule));
        assert_eq!(own, [histogram.kapur(), histogram.rosin(), histogram.otsu()]);
        assert!(own[0] != own[1] && own[1] != own[2] && own[0] != own[2], "{own:?}");
    }
}
