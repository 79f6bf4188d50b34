//! The threshold of greatest entropy of Kapur, Sahoo and Wong (doi:10.1016/0734-189X(85)90125-2).

use crate::sky::otsu::{BINS, Histogram};

/// Sums of entropies nearer than this are equal: rounding must not choose between them.
const SAME: f64 = 1e-9;

impl Histogram {
    /// The upper edge of the last background bin, where the entropies of background and objects,
    /// each as a distribution of its own, have the greatest sum; the lowest such edge where
    /// several are equal, and 0 where all values share a bin.
    ///
    /// With n values in a bin and N in a class its entropy is `ln N - (sum of n ln n) / N`. Cost:
    /// three logarithms a bin.
    pub fn kapur(&self) -> f32 {
        let n_ln_n = |n: u32| f64::from(n) * ln(u64::from(n));
        let all: u64 = self.0.iter().map(|&n| u64::from(n)).sum();
        let information: f64 = self.0.iter().map(|&n| n_ln_n(n)).sum();
        let (mut best, mut tau) = (f64::NEG_INFINITY, 0.0);
        let (mut below, mut known) = (0u64, 0.0f64);
        for (bin, &n) in self.0.iter().enumerate() {
            below = below.saturating_add(u64::from(n));
            known += n_ln_n(n);
            let above = all.saturating_sub(below);
            if below == 0 || above == 0 {
                continue;
            }
            let entropy = (ln(below) - known / below as f64) + (ln(above) - (information - known) / above as f64);
            if entropy > best + SAME {
                (best, tau) = (entropy, (bin + 1) as f32 / BINS as f32);
            }
        }
        tau
    }
}

/// The natural logarithm; 0 of 0, which only ever stands beside a factor 0.
fn ln(n: u64) -> f64 {
    if n == 0 { 0.0 } else { libm::log(n as f64) }
}
