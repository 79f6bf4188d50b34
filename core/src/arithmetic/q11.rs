//! 16-bit fixed point: narrow planes, 4 bytes per pixel, and kernels in I8F24.
//!
//! The image and the edge detector are U1F15 (range [0, 2), step 2^-15); the front is I5F11 in
//! pixels (range [-16, 16), step 2^-11), saturated by its band to at most 8 pixels.

use super::fixed32::Fixed24;
use super::{Arithmetic, Bits, Cell, Exponent, Real, elementary, roots, sealed::Sealed};
use crate::arithmetic::vectors::NoVectors;
use fixed::types::{I5F11, U1F15};

/// Fixed point in 16-bit planes; the front needs a band.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Q11;

/// 16 bits: U1F15 in the image plane, I5F11 in the front plane, at the end a label.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Narrow(u16);

impl Bits for Narrow {
    #[inline]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }

    #[inline]
    fn from_bits(bits: u32) -> Self {
        Narrow(bits as u16)
    }
}

impl Cell for Narrow {
    const MAX_LABEL: u32 = 0xFFFF;
    const BYTES: usize = 2;
    const BLANK: Self = Narrow(0);

    #[inline]
    fn from_label(label: u32) -> Self {
        Narrow(label.min(Self::MAX_LABEL) as u16)
    }

    #[inline]
    fn label(self) -> u32 {
        u32::from(self.0)
    }
}

/// Cells whose changes surely add up in 32 bits.
const PIECE: usize = 256;
/// Fraction bits of the speed in a step of the first-order scheme.
const SPEED_BITS: u32 = 17;
/// Fraction bits that a pixel and a level lack of a [`Fixed24`].
const PIXEL_SHIFT: u32 = 24 - U1F15::FRAC_NBITS;
const LEVEL_SHIFT: u32 = 24 - I5F11::FRAC_NBITS;

impl Narrow {
    #[inline(always)]
    fn level_bits(self) -> i16 {
        I5F11::from_bits(self.0 as i16).to_bits()
    }
}

impl Sealed for Q11 {}

impl Arithmetic for Q11 {
    const NAME: &'static str = "q11";
    const CODE: u8 = 3;
    const CHANGE_UNITS: f32 = 2048.0;
    const NEEDS_BAND: Option<f32> = Some(8.0);
    const LIMIT: f32 = 128.0;
    /// The move of a contour with a radius of 16 pixels, `LEAST_CURVATURE / 16`, is half a step of
    /// a level and so just seen; with a smaller weight all but the sharpest corners stay.
    const LEAST_CURVATURE: f32 = 1.0 / 256.0;

    type Real = Fixed24;
    type Cell = Narrow;
    type Vectors = NoVectors<Narrow, Fixed24>;

    #[inline(always)]
    fn pixel(cell: Narrow) -> Fixed24 {
        Fixed24::from_bits(i32::from(cell.0) << PIXEL_SHIFT)
    }

    #[inline(always)]
    fn to_pixel(value: Fixed24) -> Narrow {
        let rounded = value.to_bits().saturating_add(1 << (PIXEL_SHIFT - 1)) >> PIXEL_SHIFT;
        Narrow(rounded.clamp(0, i32::from(u16::MAX)) as u16)
    }

    #[inline(always)]
    fn level(cell: Narrow) -> Fixed24 {
        Fixed24::from_bits(i32::from(cell.level_bits()) << LEVEL_SHIFT)
    }

    #[inline(always)]
    fn to_level(value: Fixed24) -> Narrow {
        let rounded = value.to_bits().saturating_add(1 << (LEVEL_SHIFT - 1)) >> LEVEL_SHIFT;
        Narrow(rounded.clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16 as u16)
    }

    elementary::functions!();

    /// Within 2^-15 of the exact length below 2, where image gradients and smooth fronts lie;
    /// within 2^-11 of it up to 32, the longest that a band of 8 pixels allows; saturated beyond.
    /// The squares have 32 bits, so that a processor without wide products can afford them.
    #[inline(always)]
    fn norm(a: Fixed24, b: Fixed24, c: Fixed24, d: Fixed24) -> Fixed24 {
        let sizes = [a.size(), b.size(), c.size(), d.size()];
        let largest = sizes.iter().fold(0, |all, size| all | size);
        let shift = if largest >> 24 == 0 {
            PIXEL_SHIFT
        } else if largest >> 25 == 0 {
            PIXEL_SHIFT + 1
        } else {
            LEVEL_SHIFT
        };
        let [a, b, c, d] = sizes.map(|size| {
            let size = (size >> shift).min(0xFFFF);
            size.wrapping_mul(size)
        });
        let sum = (a.saturating_add(b)).saturating_add(c.saturating_add(d));
        Fixed24::from_bits((roots::nearest32(sum) << shift) as i32)
    }

    /// In whole steps of a level, with products of 32 bits and a root of 16 significant bits: a move
    /// is within 0.7 steps of the exact one up to gradients of 4, within 2 steps up to 32.
    #[inline(always)]
    fn retreat(v: Narrow, around: [Narrow; 4], courant: Fixed24, g: Narrow) -> Narrow {
        let level = i32::from(v.level_bits());
        let square = |cell: Narrow| {
            let drop = level.wrapping_sub(i32::from(cell.level_bits()));
            // A band leaves no drop of more than 16 pixels; so the sum has 32 bits.
            let drop = drop.max(0) as u32;
            drop.wrapping_mul(drop)
        };
        let [l, r, b, a] = around;
        let square = (square(l).wrapping_add(square(r))).wrapping_add(square(b).wrapping_add(square(a)));
        if square == 0 {
            return v;
        }
        // With 17 fraction bits: the speed is at most 1/2.
        let courant = courant.size().wrapping_add(1 << (23 - SPEED_BITS)) >> (24 - SPEED_BITS);
        let speed = courant.wrapping_mul(u32::from(g.0)).wrapping_add(1 << 14) >> U1F15::FRAC_NBITS;
        let (root, excess) = roots::scaled32(square);
        let twice = speed.wrapping_mul(root) >> (SPEED_BITS - 1).wrapping_add(excess);
        let change = twice.wrapping_add(1) >> 1;
        Narrow(level.wrapping_sub(change as i32).max(i32::from(i16::MIN)) as i16 as u16)
    }

    /// Each component is within 2^-13.
    #[inline]
    fn unit(x: Fixed24, y: Fixed24, least: Fixed24) -> Option<(Fixed24, Fixed24)> {
        // Both components fill 31 bits, then keep the upper 15.
        let (sx, sy) = (x.size(), y.size());
        let shift = (sx | sy).leading_zeros().saturating_sub(1);
        let (sx, sy) = (sx << shift >> 16, sy << shift >> 16);
        let length = roots::nearest32(sx.wrapping_mul(sx).wrapping_add(sy.wrapping_mul(sy)));
        if length << 16 >> shift <= least.size() {
            return None;
        }
        let share = |size: u32, of: Fixed24| {
            let size = Fixed24::from_bits(((((size << 16) + (length >> 1)) / length.max(1)).min(1 << 16) << 8) as i32);
            if of < Fixed24::ZERO { -size } else { size }
        };
        Some((share(sx, x), share(sy, y)))
    }

    #[inline(always)]
    fn change(old: &[Narrow], new: &[Narrow], limit: Fixed24) -> u64 {
        let limit = limit.size() >> LEVEL_SHIFT;
        let moved = |(v, w): (&Narrow, &Narrow)| {
            let (v, w) = (i32::from(v.level_bits()), i32::from(w.level_bits()));
            if v.unsigned_abs() <= limit { w.abs_diff(v) } else { 0 }
        };
        let pieces = old.chunks(PIECE).zip(new.chunks(PIECE));
        let sums = pieces.map(|(old, new)| old.iter().zip(new).map(moved).fold(0, u32::wrapping_add));
        sums.map(u64::from).fold(0, u64::wrapping_add)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_round_to_nearest_and_saturate() {
        let pixel = |x: f32| Q11::pixel(Q11::to_pixel(Fixed24::of(x))).to_f32();
        let level = |x: f32| Q11::level(Q11::to_level(Fixed24::of(x))).to_f32();
        assert_eq!([pixel(-0.5), pixel(0.0), pixel(1.0), pixel(3.0)], [0.0, 0.0, 1.0, 65535.0 / 32768.0]);
        assert_eq!([level(-20.0), level(-8.0), level(8.0), level(20.0)], [-16.0, -8.0, 8.0, 32767.0 / 2048.0]);
        for i in -32768..32768i32 {
            let x = i as f32 / 4096.0 + 1e-5;
            assert!((level(x) - x).abs() <= 0.5 / 2048.0);
            assert!((pixel(x.abs() / 8.0) - x.abs() / 8.0).abs() <= 0.5 / 32768.0);
        }
    }

    #[test]
    fn norms_keep_their_bounds() {
        let of = Fixed24::of;
        assert_eq!(Q11::norm(of(3.0), of(-4.0), of(0.0), of(0.0)), of(5.0));
        assert_eq!(Q11::norm(of(16.0), of(-16.0), of(16.0), of(-16.0)).to_f32(), 32.0);
        assert_eq!(Q11::norm(of(-128.0), of(0.0), of(0.0), of(0.0)).to_f32(), 65535.0 / 2048.0);
        for i in 0..400_000u32 {
            // Multiples of a level's step, as differences of the front are.
            let at = |k: u32| ((i.wrapping_mul(k) as i32) >> (3 + i % 16)) >> LEVEL_SHIFT << LEVEL_SHIFT;
            let parts = [0x9E37_79B1, 0x85EB_CA6B, 0xC2B2_AE35, 0x27D4_EB2F].map(at);
            let exact = libm::sqrt(parts.map(|v| f64::from(v) * f64::from(v)).iter().sum()) / 16_777_216.0;
            let [a, b, c, d] = parts.map(Fixed24::from_bits);
            let error = f64::from(Q11::norm(a, b, c, d).to_f32()) - exact.min(32.0);
            assert!(error.abs() <= if exact < 2.0 { 1.0 / 32768.0 } else { 1.0 / 2048.0 }, "{parts:?}: {error}");
        }
    }

    #[test]
    fn moves_keep_their_bound() {
        for i in 0..400_000u32 {
            // Levels of at most 8 pixels from zero, at every distance from each other.
            let at = |k: u32| (i.wrapping_mul(k) as i32 >> 16 >> (1 + i % 15)) as i16;
            let [v, l, r, b, a] = [0x9E37_79B1, 0x85EB_CA6B, 0xC2B2_AE35, 0x27D4_EB2F, 0x1656_67B1].map(at);
            let (g, courant) = (i.wrapping_mul(0x9E37_79B1) >> 17, [0.5, 0.25, 0.1, 0.013][i as usize % 4]);
            let cell = |level: i16| Narrow(level as u16);
            let moved = Q11::retreat(cell(v), [l, r, b, a].map(cell), Fixed24::of(courant), Narrow(g as u16));
            let drops = [l, r, b, a].map(|side| f64::from((i32::from(v) - i32::from(side)).max(0)));
            let gradient = libm::sqrt(drops.iter().map(|drop| drop * drop).sum());
            let exact = f64::from(v) - f64::from(courant) * f64::from(g) / 32768.0 * gradient;
            let error = (f64::from(moved.level_bits()) - exact).abs();
            assert!(error <= if gradient <= 8192.0 { 0.7 } else { 2.0 }, "{v} {l} {r} {b} {a}, g {g}: {error}");
        }
    }

    #[test]
    fn directions_keep_their_bound() {
        let least = Fixed24::from_bits(1);
        assert_eq!(Q11::unit(Fixed24::ZERO, Fixed24::ZERO, Fixed24::ZERO), None);
        for i in 1..200_000u32 {
            let at = |k: u32| (i.wrapping_mul(k) as i32) >> (i % 28);
            let (x, y) = (at(0x9E37_79B1), at(0x85EB_CA6B));
            let length = libm::sqrt(f64::from(x) * f64::from(x) + f64::from(y) * f64::from(y));
            let Some((nx, ny)) = Q11::unit(Fixed24::from_bits(x), Fixed24::from_bits(y), least) else {
                assert!(length <= 1.5);
                continue;
            };
            for (found, exact) in [(nx, f64::from(x) / length), (ny, f64::from(y) / length)] {
                assert!((f64::from(found.to_f32()) - exact).abs() <= 1.0 / 8192.0, "({x}, {y})");
            }
        }
    }
}
