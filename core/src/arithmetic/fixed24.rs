//! The number that both fixed-point arithmetics compute in.

use super::Real;
use core::ops::{Add, Mul, Neg, Sub};
use fixed::types::I8F24;

/// A fixed-point number in [-128, 128) with step 2^-24.
///
/// Every operation saturates at the ends of the range and never wraps; products and quotients are
/// rounded to nearest, halves away from zero, so that `-(a b)` is `(-a) b`, bit for bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fixed24(pub I8F24);

/// Fraction bits.
pub(super) const FRACTION: u32 = I8F24::FRAC_NBITS;

/// 1 as bits.
pub(super) const ONE: u32 = 1 << FRACTION;

impl Fixed24 {
    /// The number `bits / 2^24`.
    #[inline(always)]
    pub const fn from_bits(bits: i32) -> Self {
        Fixed24(I8F24::from_bits(bits))
    }

    /// The number times 2^24.
    #[inline(always)]
    pub const fn to_bits(self) -> i32 {
        self.0.to_bits()
    }

    /// The number `bits / 2^24`, saturated.
    #[inline(always)]
    pub(super) fn saturated(bits: u64) -> Self {
        Fixed24::from_bits(bits.min(i32::MAX as u64) as i32)
    }

    /// The distance from 0 as bits, at most `i32::MAX`.
    #[inline(always)]
    pub(super) fn size(self) -> u32 {
        self.0.saturating_abs().to_bits() as u32
    }
}

impl Add for Fixed24 {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Fixed24(self.0.saturating_add(other.0))
    }
}

impl Sub for Fixed24 {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Fixed24(self.0.saturating_sub(other.0))
    }
}

impl Neg for Fixed24 {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Fixed24(self.0.saturating_neg())
    }
}

impl Mul for Fixed24 {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let product = self.0.wide_mul(other.0).to_bits();
        // The product is at most 2^62: a half can be added. The sign makes halves go outwards.
        let rounded = product.wrapping_add((1 << (FRACTION - 1)) + (product >> 63)) >> FRACTION;
        Fixed24::from_bits(rounded.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32)
    }
}

impl Real for Fixed24 {
    const ZERO: Self = Fixed24(I8F24::ZERO);
    const ONE: Self = Fixed24(I8F24::ONE);

    /// Nearest, halves up; a NaN becomes 0.
    #[inline]
    fn of(x: f32) -> Self {
        let scaled = x * ONE as f32;
        // The conversion cuts towards zero and saturates; what it cut off is exact.
        let whole = scaled as i32;
        let rest = scaled - whole as f32;
        let step = i32::from(rest >= 0.5) - i32::from(rest < -0.5);
        Fixed24::from_bits(whole.saturating_add(step))
    }

    #[inline]
    fn to_f32(self) -> f32 {
        self.to_bits() as f32 / ONE as f32
    }

    #[inline]
    fn bits(self) -> u32 {
        self.to_bits() as u32
    }

    #[inline]
    fn from_bits(bits: u32) -> Self {
        Fixed24::from_bits(bits as i32)
    }

    /// Cost: one division of 64 by 32 bits.
    #[inline]
    fn ratio(self, divisor: Self) -> Self {
        if divisor <= Self::ZERO {
            return Self::ZERO;
        }
        let by = u64::from(divisor.size()).max(1);
        let quotient = ((u64::from(self.size()) << FRACTION) + (by >> 1)) / by;
        let size = Fixed24::saturated(quotient);
        if self < Self::ZERO { -size } else { size }
    }

    #[inline(always)]
    fn split(self, limit: usize) -> (usize, Self) {
        let whole = (self.to_bits().max(0) as usize >> FRACTION).min(limit);
        (whole, self - Fixed24::from_bits((whole as i32) << FRACTION))
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
