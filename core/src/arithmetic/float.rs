//! IEEE 754 single precision, the same bits on every processor.
//!
//! Only additions, subtractions, multiplications, divisions, comparisons and correctly rounded
//! square roots; `libm`, pinned and without processor features, for the rest. No fused
//! multiply-add, no `f32::min`, no operation that can make a NaN from finite numbers.

use super::{Arithmetic, Bits, Cell, Exponent, Real, sealed::Sealed};
use crate::arithmetic::machine::{Machine, Plain, Task};
use core::marker::PhantomData;

/// Single precision on a machine `M`; `M` changes the speed, never the bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct F32<M: Machine = Plain>(PhantomData<M>);

impl Bits for f32 {
    #[inline]
    fn bits(self) -> u32 {
        self.to_bits()
    }

    #[inline]
    fn from_bits(bits: u32) -> f32 {
        let value = f32::from_bits(bits);
        if value.is_finite() { value } else { 0.0 }
    }
}

impl Real for f32 {
    const ZERO: f32 = 0.0;
    const ONE: f32 = 1.0;

    #[inline(always)]
    fn of(x: f32) -> f32 {
        x
    }

    #[inline(always)]
    fn to_f32(self) -> f32 {
        self
    }

    /// Without a branch: rows of quotients are left to vector units.
    #[inline(always)]
    fn ratio(self, divisor: f32) -> f32 {
        let divides = divisor > 0.0;
        let quotient = self / if divides { divisor } else { 1.0 };
        f32::from_bits(quotient.to_bits() & u32::from(divides).wrapping_neg())
    }

    #[inline(always)]
    fn split(self, limit: usize) -> (usize, f32) {
        // No side has 2^32 pixels, and 32 bits are converted at once.
        let whole = (self as u32 as usize).min(limit);
        (whole, self - whole as u32 as f32)
    }
}

impl Cell for f32 {
    /// Every integer up to here has its own `f32`.
    const MAX_LABEL: u32 = 1 << 24;
    const BYTES: usize = 4;
    const BLANK: f32 = 0.0;

    #[inline]
    fn from_label(label: u32) -> f32 {
        label.min(Self::MAX_LABEL) as f32
    }

    #[inline]
    fn label(self) -> u32 {
        self as u32
    }
}

/// Cells that are looked at together: their changes surely add up in 32 bits.
const PIECE: usize = 32;
/// The largest change of a cell that is told from larger ones: the last step before 1/2.
pub const LARGEST_CHANGE: f32 = 0.499_999_97;

impl<M: Machine> Sealed for F32<M> {}

impl<M: Machine> Arithmetic for F32<M> {
    const NAME: &'static str = "f32";
    const CODE: u8 = 1;
    const CHANGE_UNITS: f32 = 16_777_216.0;
    const NEEDS_BAND: Option<f32> = None;
    const LIMIT: f32 = f32::INFINITY;
    const LEAST_CURVATURE: f32 = 0.0;

    type Real = f32;
    type Cell = f32;
    type Vectors = M::Vectors;

    #[inline(always)]
    fn vectors() -> Option<M::Vectors> {
        M::vectors()
    }

    #[inline(always)]
    fn pixel(cell: f32) -> f32 {
        cell
    }

    #[inline(always)]
    fn to_pixel(value: f32) -> f32 {
        value
    }

    #[inline(always)]
    fn level(cell: f32) -> f32 {
        cell
    }

    #[inline(always)]
    fn to_level(value: f32) -> f32 {
        value
    }

    #[inline(always)]
    fn sqrt(x: f32) -> f32 {
        M::sqrt(x)
    }

    #[inline(always)]
    fn root(x: f32) -> f32 {
        M::sqrt(x)
    }

    #[inline(always)]
    fn norm(a: f32, b: f32, c: f32, d: f32) -> f32 {
        M::sqrt((a * a + b * b) + (c * c + d * d))
    }

    #[inline(always)]
    fn unit(x: f32, y: f32, least: f32) -> Option<(f32, f32)> {
        let square = x * x + y * y;
        if square > least * least && square > f32::MIN_POSITIVE {
            let length = M::sqrt(square);
            Some((x / length, y / length))
        } else {
            None
        }
    }

    #[inline]
    fn pow(x: f32, p: Exponent) -> f32 {
        match p {
            Exponent::Squarings(n) => (0..n).fold(x, |x, _| x * x),
            Exponent::Roots(n) => (0..n).fold(x, |x, _| M::sqrt(x)),
            Exponent::Any(p) => libm::powf(x, p),
        }
    }

    #[inline]
    fn log2_1p(x: f32) -> f32 {
        libm::log1pf(x) / core::f32::consts::LN_2
    }

    #[inline]
    fn exp_neg(x: f32) -> f32 {
        libm::expf(-x)
    }

    /// 1.5 * 2^23 grid steps, of 2^-14 pixels or, beyond a band of 256, of twice as much as often
    /// as needed: a sum with it has its last bit at one grid step.
    fn anchor(band: f32) -> f32 {
        let (mut anchor, mut widest) = (768.0, 256.0);
        while widest < band && widest < 1e9 {
            anchor *= 2.0;
            widest *= 2.0;
        }
        anchor
    }

    #[inline(always)]
    fn on_grid(value: f32, anchor: f32) -> f32 {
        (value + anchor) - anchor
    }

    /// Each change is rounded to a multiple of 2^-24 and counts 1/2 at most: whole numbers, which
    /// add up to the same sum in any order and on units of any width.
    #[inline(always)]
    fn change(old: &[f32], new: &[f32], limit: f32) -> u64 {
        const HALF: f32 = 0.5;
        let pieces = old.chunks(PIECE).zip(new.chunks(PIECE));
        pieces.fold(0, |sum, (old, new)| {
            if old.iter().fold(true, |far, v| far & (v.abs() > limit)) {
                return sum;
            }
            let units = old.iter().zip(new).fold(0u32, |sum, (&v, &w)| {
                let change = (w - v).abs();
                let change = if change < LARGEST_CHANGE { change } else { LARGEST_CHANGE };
                // From 1/2 to 1 the bit patterns of f32 count in steps of 2^-24.
                let units = (HALF + change).to_bits().wrapping_sub(HALF.to_bits());
                sum.wrapping_add(if v.abs() <= limit { units } else { 0 })
            });
            sum + u64::from(units)
        })
    }

    #[inline(always)]
    fn wide<T: Task>(row: T) -> T::Output {
        M::wide(row)
    }
}
