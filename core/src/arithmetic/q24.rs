//! 32-bit fixed point: planes of I8F24, 8 bytes per pixel.

use super::fixed32::Fixed24;
use super::{Arithmetic, Exponent, Real, elementary, roots, sealed::Sealed};
use crate::arithmetic::vectors::NoVectors;

/// Fixed point with 24 fraction bits in planes and kernels: range [-128, 128), step 2^-24.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Q24;

impl Sealed for Q24 {}

impl Arithmetic for Q24 {
    const NAME: &'static str = "q24";
    const CODE: u8 = 2;
    const CHANGE_UNITS: f32 = 16_777_216.0;
    const NEEDS_BAND: Option<f32> = None;
    const LIMIT: f32 = 128.0;
    const LEAST_CURVATURE: f32 = 0.0;

    type Real = Fixed24;
    type Cell = Fixed24;
    type Vectors = NoVectors<Fixed24, Fixed24>;

    #[inline(always)]
    fn pixel(cell: Fixed24) -> Fixed24 {
        cell
    }

    #[inline(always)]
    fn to_pixel(value: Fixed24) -> Fixed24 {
        value
    }

    #[inline(always)]
    fn level(cell: Fixed24) -> Fixed24 {
        cell
    }

    #[inline(always)]
    fn to_level(value: Fixed24) -> Fixed24 {
        value
    }

    elementary::functions!();

    /// Rounded to nearest from the exact sum of squares.
    #[inline]
    fn norm(a: Fixed24, b: Fixed24, c: Fixed24, d: Fixed24) -> Fixed24 {
        // Four squares below 2^62 each.
        let sum = (square(a).wrapping_add(square(b))).wrapping_add(square(c).wrapping_add(square(d)));
        Fixed24::saturated(u64::from(roots::nearest64(sum)))
    }

    /// The length is that of the exact vector, however short; each component is within 2^-24.
    #[inline]
    fn unit(x: Fixed24, y: Fixed24, least: Fixed24) -> Option<(Fixed24, Fixed24)> {
        if square(x).wrapping_add(square(y)) <= square(least.positive()) {
            return None;
        }
        // Both components grow until the larger fills 31 bits.
        let shift = (x.size() | y.size()).leading_zeros().saturating_sub(1);
        let grown = |v: Fixed24| v.size() << shift;
        let (gx, gy) = (u64::from(grown(x)), u64::from(grown(y)));
        let length = u64::from(roots::nearest64(gx.wrapping_mul(gx).wrapping_add(gy.wrapping_mul(gy)))).max(1);
        let share = |grown: u64, of: Fixed24| {
            let size = Fixed24::saturated(((grown << 24).wrapping_add(length >> 1)) / length);
            if of < Fixed24::ZERO { -size } else { size }
        };
        Some((share(gx, x), share(gy, y)))
    }

    #[inline(always)]
    fn change(old: &[Fixed24], new: &[Fixed24], limit: Fixed24) -> u64 {
        let limit = limit.size();
        let moved = |(v, w): (&Fixed24, &Fixed24)| {
            if v.size() <= limit { u64::from(w.to_bits().abs_diff(v.to_bits())) } else { 0 }
        };
        old.iter().zip(new).map(moved).fold(0, u64::wrapping_add)
    }
}

/// The square with 48 fraction bits, below 2^62.
#[inline(always)]
fn square(v: Fixed24) -> u64 {
    let size = u64::from(v.size());
    size.wrapping_mul(size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn norms_are_rounded_to_nearest_and_saturate() {
        let of = Fixed24::of;
        assert_eq!(Q24::norm(of(3.0), of(-4.0), of(0.0), of(0.0)), of(5.0));
        let far = of(-128.0);
        assert_eq!(Q24::norm(far, far, far, far).to_bits(), i32::MAX);
        for i in 0..200_000u32 {
            let at = |k: u32| (i.wrapping_mul(k) as i32) >> (8 + i % 20);
            let [a, b, c, d] = [0x9E37_79B1, 0x85EB_CA6B, 0xC2B2_AE35, 0x27D4_EB2F].map(at);
            let exact = libm::sqrt([a, b, c, d].map(|v| f64::from(v) * f64::from(v)).iter().sum());
            let [a, b, c, d] = [a, b, c, d].map(Fixed24::from_bits);
            assert!((f64::from(Q24::norm(a, b, c, d).to_bits()) - exact).abs() <= 0.500_001);
        }
    }

    #[test]
    fn directions_of_long_and_of_tiny_vectors() {
        let least = Fixed24::from_bits(1);
        assert_eq!(Q24::unit(Fixed24::ZERO, Fixed24::ZERO, Fixed24::ZERO), None);
        assert_eq!(Q24::unit(least, Fixed24::ZERO, least), None);
        for i in 0..200_000u32 {
            let at = |k: u32| (i.wrapping_mul(k) as i32) >> (i % 30);
            let (x, y) = (at(0x9E37_79B1), at(0x85EB_CA6B));
            let length = libm::sqrt(f64::from(x) * f64::from(x) + f64::from(y) * f64::from(y));
            let Some((nx, ny)) = Q24::unit(Fixed24::from_bits(x), Fixed24::from_bits(y), least) else {
                assert!(length <= 1.0);
                continue;
            };
            for (found, exact) in [(nx, f64::from(x) / length), (ny, f64::from(y) / length)] {
                assert!((f64::from(found.to_bits()) - exact * 16_777_216.0).abs() <= 1.0, "({x}, {y})");
            }
        }
    }
}
