//! The 32-bit fixed-point numbers that are computed in.

use super::{Bits, Cell, Real};
use core::fmt::Debug;
use core::ops::{Add, Mul, Neg, Sub};
use fixed::FixedI32;
use fixed::types::extra::{LeEqU32, U14, U24};

/// A fixed-point number of 32 bits, `F` of them behind the point.
///
/// Every operation saturates at the ends of the range and never wraps; products and quotients are
/// rounded to nearest, halves away from zero, so that `-(a b)` is `(-a) b`, bit for bit.
///
/// ```
/// use skyfront_core::arithmetic::{Fixed14, Real};
///
/// let (three, tiny) = (Fixed14::of(3.0), Fixed14::of(1e-9));
/// assert_eq!(three.ratio(Fixed14::of(8.0)).to_f32(), 0.375);
/// assert_eq!(three.ratio(tiny), Fixed14::ZERO, "a divisor of 0 gives 0");
/// assert_eq!((Fixed14::of(1e5) + Fixed14::of(1e5)).to_bits(), i32::MAX, "sums saturate");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fixed<F: Fraction>(FixedI32<F>);

/// In [-128, 128) with step 2^-24: images, fronts, weights.
pub type Fixed24 = Fixed<U24>;

/// In [-131072, 131072) with step 2^-14: signal-to-noise, places.
pub type Fixed14 = Fixed<U14>;

/// How many bits are behind the point.
pub trait Fraction: LeEqU32 + Debug + PartialOrd + Send + Sync {}

impl<F: LeEqU32 + Debug + PartialOrd + Send + Sync> Fraction for F {}

/// 1 as bits of a [`Fixed24`].
pub(super) const ONE: u32 = 1 << 24;

impl<F: Fraction> Fixed<F> {
    /// The number that has these bits.
    #[inline(always)]
    pub const fn from_bits(bits: i32) -> Self {
        Fixed(FixedI32::from_bits(bits))
    }

    /// Its bits: the number times 2^F.
    #[inline(always)]
    pub const fn to_bits(self) -> i32 {
        self.0.to_bits()
    }

    /// The number that has these bits, saturated.
    #[inline(always)]
    pub(super) fn saturated(bits: u64) -> Self {
        Fixed::from_bits(bits.min(i32::MAX as u64) as i32)
    }

    /// The distance from 0 as bits, at most `i32::MAX`.
    #[inline(always)]
    pub(super) fn size(self) -> u32 {
        self.0.saturating_abs().to_bits() as u32
    }

    /// The product with a number that has `G` bits behind the point.
    #[inline(always)]
    pub(super) fn by<G: Fraction>(self, other: Fixed<G>) -> Self {
        let product = i64::from(self.to_bits()).wrapping_mul(i64::from(other.to_bits()));
        // The product is at most 2^62: a half can be added. The sign makes halves go outwards.
        let rounded = product.wrapping_add((1 << (G::U32 - 1)) + (product >> 63)) >> G::U32;
        Fixed::from_bits(rounded.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32)
    }
}

impl<F: Fraction> Add for Fixed<F> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Fixed(self.0.saturating_add(other.0))
    }
}

impl<F: Fraction> Sub for Fixed<F> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Fixed(self.0.saturating_sub(other.0))
    }
}

impl<F: Fraction> Neg for Fixed<F> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Fixed(self.0.saturating_neg())
    }
}

impl<F: Fraction> Mul for Fixed<F> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.by(other)
    }
}

impl<F: Fraction> Bits for Fixed<F> {
    #[inline]
    fn bits(self) -> u32 {
        self.to_bits() as u32
    }

    #[inline]
    fn from_bits(bits: u32) -> Self {
        Fixed::from_bits(bits as i32)
    }
}

impl<F: Fraction> Real for Fixed<F> {
    const ZERO: Self = Fixed(FixedI32::ZERO);
    const ONE: Self = Fixed::from_bits(1 << F::U32);

    /// Nearest, halves up; a NaN becomes 0.
    #[inline]
    fn of(x: f32) -> Self {
        let scaled = x * (1u32 << F::U32) as f32;
        // The conversion cuts towards zero and saturates; what it cut off is exact.
        let whole = scaled as i32;
        let rest = scaled - whole as f32;
        let step = i32::from(rest >= 0.5) - i32::from(rest < -0.5);
        Fixed::from_bits(whole.saturating_add(step))
    }

    #[inline]
    fn to_f32(self) -> f32 {
        self.to_bits() as f32 / (1u32 << F::U32) as f32
    }

    /// Cost: one division of 64 by 32 bits.
    #[inline]
    fn ratio(self, divisor: Self) -> Self {
        if divisor <= Self::ZERO {
            return Self::ZERO;
        }
        let by = u64::from(divisor.size()).max(1);
        let quotient = ((u64::from(self.size()) << F::U32) + (by >> 1)) / by;
        let size = Fixed::saturated(quotient);
        if self < Self::ZERO { -size } else { size }
    }

    #[inline(always)]
    fn split(self, limit: usize) -> (usize, Self) {
        let whole = (self.to_bits().max(0) as usize >> F::U32).min(limit);
        (whole, self - Fixed::from_bits((whole as i32) << F::U32))
    }
}

impl<F: Fraction + Default> Cell for Fixed<F> {
    /// As many as f32 can hold, so that both stop at the same images.
    const MAX_LABEL: u32 = 1 << 24;
    const BYTES: usize = 4;
    const BLANK: Self = Fixed(FixedI32::ZERO);

    #[inline]
    fn from_label(label: u32) -> Self {
        Fixed::from_bits(label.min(Self::MAX_LABEL) as i32)
    }

    #[inline]
    fn label(self) -> u32 {
        self.to_bits() as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENDS: [i32; 9] = [i32::MIN, i32::MIN + 1, -(1 << 24), -1, 0, 1, 1 << 24, i32::MAX - 1, i32::MAX];

    #[test]
    fn nothing_wraps_and_everything_is_rounded_to_nearest() {
        let spread = (0..300u32).map(|i| (i.wrapping_mul(0x9E37_79B1) as i32) >> (i % 31));
        let values: [i32; 309] = core::array::from_fn(|i| ENDS.get(i).copied().unwrap_or(0));
        let mut values = values;
        values.iter_mut().skip(ENDS.len()).zip(spread).for_each(|(to, from)| *to = from);
        for a in values {
            for b in values {
                let (x, y) = (Fixed24::from_bits(a), Fixed24::from_bits(b));
                let exact = |bits: f64| bits.clamp(f64::from(i32::MIN), f64::from(i32::MAX));
                assert_eq!(f64::from((x + y).to_bits()), exact(f64::from(a) + f64::from(b)));
                assert_eq!(f64::from((x - y).to_bits()), exact(f64::from(a) - f64::from(b)));
                let product = i128::from(a) * i128::from(b);
                let half = if product < 0 { -(1 << 23) } else { 1 << 23 };
                let nearest = ((product + half) / (1 << 24)).clamp(i32::MIN.into(), i32::MAX.into());
                assert_eq!(i128::from((x * y).to_bits()), nearest, "{a} * {b}");
                if a > i32::MIN {
                    let quotient = exact(f64::from(a) / f64::from(b.max(1)) * 16_777_216.0).max(-f64::from(i32::MAX));
                    let found = f64::from(x.ratio(y).to_bits());
                    assert!(if b <= 0 { found == 0.0 } else { (found - quotient).abs() <= 0.500_001 }, "{a} / {b}");
                }
            }
        }
    }

    #[test]
    fn conversions_from_and_to_f32() {
        let step = 1.0 / 16_777_216.0;
        for (x, bits) in [
            (0.0, 0),
            (0.49 * step, 0),
            (0.5 * step, 1),
            (-0.51 * step, -1),
            (1.0, 1 << 24),
            (-127.5, -127 * (1 << 24) - (1 << 23)),
            (128.0, i32::MAX),
            (-1e9, i32::MIN),
            (f32::INFINITY, i32::MAX),
            (f32::NEG_INFINITY, i32::MIN),
            (f32::NAN, 0),
        ] {
            assert_eq!(Fixed24::of(x).to_bits(), bits, "{x}");
        }
        assert_eq!(Fixed24::from_bits(3 << 22).to_f32(), 0.75);
        assert_eq!(Fixed24::of(4.75).split(5), (4, Fixed24::of(0.75)));
        assert_eq!(Fixed24::of(7.5).split(5), (5, Fixed24::of(2.5)));
    }
}
