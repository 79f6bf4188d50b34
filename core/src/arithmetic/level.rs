//! The numbers for signal-to-noise, which the noise-aware segmentation computes in.

use super::{Cell, Fixed14, Fixed24, Real, roots, sealed::Sealed};
use core::fmt::Debug;
use core::ops::{Add, Sub};

/// A signal-to-noise, or a place in pixels; 32 bits.
///
/// ```
/// use skyfront_core::arithmetic::{Fixed14, Level, Real};
///
/// fn mean_of_positive<L: Level>(light: &[f32]) -> f32 {
///     let positive = light.iter().map(|&value| L::signal(value)).filter(|&value| value > L::ZERO);
///     positive.fold(L::ZERO, |sum, value| sum + value).to_f32() / light.len() as f32
/// }
/// let light = [1.5, -2.0, 0.25, 4.25];
/// assert_eq!([mean_of_positive::<f32>(&light), mean_of_positive::<Fixed14>(&light)], [1.5; 2]);
/// assert_eq!(Fixed14::signal(1e9).to_f32(), 32768.0, "no more fits beside its neighbours");
/// ```
pub trait Level: Real + Cell + Sealed {
    /// The name of the arithmetic on the command line.
    const NAME: &'static str;
    /// Its number in snapshots.
    const CODE: u32;
    /// The sum of nothing.
    const NOTHING: Self::Sum;
    /// The most pixels along an axis.
    const LONGEST: usize;

    /// A factor below 128.
    type Weight: Real;
    /// A sum over as many as 2^30 pixels.
    type Sum: Copy + Debug + PartialOrd + Add<Output = Self::Sum> + Sub<Output = Self::Sum> + Send + Sync;

    /// A word that sorts as the number does.
    fn key(self) -> u32;
    /// The number that has the key.
    fn of_key(key: u32) -> Self;
    /// A signal-to-noise, as near as the range allows: sums of two, also of sharpened ones, must be within it.
    fn signal(value: f32) -> Self;
    /// The number of a column or row, or twice it.
    fn whole(pixels: usize) -> Self;
    /// The number times a factor.
    fn scaled(self, factor: Self::Weight) -> Self;
    /// The square root of a number that is not below 0.
    fn root(self) -> Self;
    /// The sum of so many of it.
    fn times(self, count: u32) -> Self::Sum;
    /// The part, from 0 to 10^6, of a sum.
    fn share(sum: Self::Sum, part: f32) -> Self::Sum;
    /// The `f32` nearest to a sum.
    fn sum_to_f32(sum: Self::Sum) -> f32;
    /// The bits of a sum.
    fn sum_bits(sum: Self::Sum) -> u64;
    /// The sum that has these bits; 0 where they are no number's.
    fn sum_of_bits(bits: u64) -> Self::Sum;
}

impl Sealed for f32 {}

impl Level for f32 {
    const NAME: &'static str = "f32";
    const CODE: u32 = 1;
    const NOTHING: f64 = 0.0;
    const LONGEST: usize = 1 << 30;

    type Weight = f32;
    type Sum = f64;

    #[inline]
    fn key(self) -> u32 {
        let bits = self.to_bits();
        if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
    }

    #[inline]
    fn of_key(key: u32) -> f32 {
        f32::from_bits(if key >> 31 == 1 { key & !(1 << 31) } else { !key })
    }

    #[inline(always)]
    fn signal(value: f32) -> f32 {
        value
    }

    #[inline(always)]
    fn whole(pixels: usize) -> f32 {
        // No side has 2^31 pixels.
        pixels as u32 as f32
    }

    #[inline(always)]
    fn scaled(self, factor: f32) -> f32 {
        self * factor
    }

    #[inline]
    fn root(self) -> f32 {
        libm::sqrtf(self)
    }

    #[inline]
    fn times(self, count: u32) -> f64 {
        f64::from(count) * f64::from(self)
    }

    #[inline]
    fn share(sum: f64, part: f32) -> f64 {
        sum * f64::from(part)
    }

    #[inline]
    fn sum_to_f32(sum: f64) -> f32 {
        sum as f32
    }

    fn sum_bits(sum: f64) -> u64 {
        sum.to_bits()
    }

    fn sum_of_bits(bits: u64) -> f64 {
        let sum = f64::from_bits(bits);
        if sum.is_finite() { sum } else { 0.0 }
    }
}

impl Sealed for Fixed14 {}

/// 32768 noise units, a quarter of the range.
const BRIGHTEST: i32 = 1 << 29;

/// The light of a pixel is within 2^-14 of a noise unit; what is brighter than 32768 of them counts as
/// that. Sums are exact.
impl Level for Fixed14 {
    const NAME: &'static str = "q24";
    const CODE: u32 = 2;
    const NOTHING: i64 = 0;
    /// Twice a place must be within the range.
    const LONGEST: usize = 1 << 16;

    type Weight = Fixed24;
    type Sum = i64;

    #[inline]
    fn key(self) -> u32 {
        self.to_bits() as u32 ^ 1 << 31
    }

    #[inline]
    fn of_key(key: u32) -> Self {
        Fixed14::from_bits((key ^ 1 << 31) as i32)
    }

    #[inline(always)]
    fn signal(value: f32) -> Self {
        Fixed14::from_bits(Self::of(value).to_bits().clamp(-BRIGHTEST, BRIGHTEST))
    }

    #[inline(always)]
    fn whole(pixels: usize) -> Self {
        Fixed14::saturated((pixels as u64) << 14)
    }

    #[inline(always)]
    fn scaled(self, factor: Fixed24) -> Self {
        self.by(factor)
    }

    /// Rounded to nearest.
    #[inline]
    fn root(self) -> Self {
        Fixed14::saturated(u64::from(roots::nearest64(u64::from(self.positive().size()) << 14)))
    }

    #[inline]
    fn times(self, count: u32) -> i64 {
        i64::from(self.to_bits()).wrapping_mul(i64::from(count))
    }

    /// Rounded down; the part to 2^-24.
    #[inline]
    fn share(sum: i64, part: f32) -> i64 {
        let part = (part * 16_777_216.0) as i64;
        let share = (i128::from(sum) * i128::from(part)) >> 24;
        share.clamp(i128::from(i64::MIN), i128::from(i64::MAX)) as i64
    }

    #[inline]
    fn sum_to_f32(sum: i64) -> f32 {
        sum as f32 / 16384.0
    }

    fn sum_bits(sum: i64) -> u64 {
        sum as u64
    }

    fn sum_of_bits(bits: u64) -> i64 {
        bits as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sorts_by_key<L: Level>(values: &[f32]) {
        for pair in values.windows(2) {
            let [low, high] = [pair[0], pair[1]].map(L::of);
            assert!(low.key() <= high.key(), "{pair:?}");
            assert_eq!(L::of_key(low.key()), low);
        }
    }

    #[test]
    fn keys_sort_as_values() {
        let values = [-1e9, -131_072.0, -3.5, -1e-4, 0.0, 1e-4, 0.5, 131_071.9, 1e9];
        sorts_by_key::<f32>(&values);
        sorts_by_key::<Fixed14>(&values);
    }

    #[test]
    fn fixed_point_follows_single_precision() {
        for i in 1..2000u16 {
            let value = f32::from(i) * f32::from(i) / 31.0;
            let fixed = Fixed14::of(value);
            assert!((fixed.root().to_f32() - value.root()).abs() < 1e-4, "{value}");
            let factor = 0.0005 * f32::from(i % 7);
            let (scaled, exact) = (fixed.scaled(Fixed24::of(factor)).to_f32(), value * factor);
            assert!((scaled - exact).abs() < 1e-4 + exact * 1e-4, "{value} {factor}");
            let (share, exact) = (Fixed14::share(fixed.times(1000), factor), f32::share(value.times(1000), factor));
            assert!((share as f64 / 16384.0 - exact).abs() < 0.1 + exact * 1e-4, "{value} {factor}");
        }
        assert_eq!(Fixed14::whole(65_536 * 2).to_bits(), i32::MAX);
        assert_eq!([1e9, -1e9, 32_767.5].map(|v| Fixed14::signal(v).to_f32()), [32_768.0, -32_768.0, 32_767.5]);
        assert_eq!(Fixed14::share(i64::MAX, 1e6), i64::MAX);
    }
}
