//! The number types a pipeline can run in, as type parameters.
//!
//! An [`Arithmetic`] says three things: the [`Real`] that kernels compute in, the
//! [`Cell`](Arithmetic::Cell) that planes and scratch rows are made of, and how the two convert.
//! Narrow formats keep narrow cells and compute in a wider `Real`.

#[deny(clippy::arithmetic_side_effects)]
pub(crate) mod codec;
pub mod digest;
mod elementary;
mod exponent;
mod fixed32;
mod float;
mod level;
pub mod machine;
mod q11;
mod q24;
mod roots;
pub mod sum;
pub mod vectors;

pub use exponent::Exponent;
pub use fixed32::{Fixed, Fixed14, Fixed24};
pub use float::{F32, LARGEST_CHANGE};
pub use level::Level;
pub use q11::{Narrow, Q11};
pub use q24::Q24;

use crate::arithmetic::machine::{Machine, Plain, Task};
use crate::arithmetic::vectors::Vectors;
use core::fmt::Debug;
use core::ops::{Add, Mul, Neg, Sub};

pub(crate) mod sealed {
    /// Only this crate can promise the same bits for an arithmetic.
    pub trait Sealed {}
}

/// What has a bit pattern: for digests, snapshots and the caller's memory.
pub trait Bits: Copy {
    /// The bit pattern, zero-extended.
    fn bits(self) -> u32;
    /// What has this bit pattern, or the nearest harmless one (never a NaN).
    fn from_bits(bits: u32) -> Self;
}

/// A number that kernels compute in. Never NaN, never a silent wrap.
pub trait Real:
    Bits
    + Debug
    + Send
    + Sync
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// Nothing.
    const ZERO: Self;
    /// One.
    const ONE: Self;

    /// The nearest representable number, saturated to the range.
    fn of(x: f32) -> Self;

    /// The nearest `f32`.
    fn to_f32(self) -> f32;

    /// `self / divisor`, saturated to the range; 0 where the divisor is not above 0.
    fn ratio(self, divisor: Self) -> Self;

    /// Integer part and fraction of `self >= 0`, the integer part at most `limit`.
    fn split(self, limit: usize) -> (usize, Self);

    /// The larger of `self` and 0.
    #[inline(always)]
    fn positive(self) -> Self {
        if self > Self::ZERO { self } else { Self::ZERO }
    }

    /// The smaller of `self` and 0.
    #[inline(always)]
    fn negative(self) -> Self {
        if self < Self::ZERO { self } else { Self::ZERO }
    }

    /// The smaller of the two; `self` where they are equal.
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    /// The larger of the two; `self` where they are equal.
    #[inline(always)]
    fn greatest(self, other: Self) -> Self {
        if other > self { other } else { self }
    }

    /// The absolute value.
    #[inline(always)]
    fn magnitude(self) -> Self {
        if self < Self::ZERO { -self } else { self }
    }
}

/// One element of a plane: an image value, a front value or, at the end, a label.
pub trait Cell: Bits + Debug + Default + PartialEq + Send + Sync + 'static {
    /// The largest label a cell can hold.
    const MAX_LABEL: u32;
    /// Bytes of one cell.
    const BYTES: usize;
    /// All bits 0: static memory full of it takes no room in a program's image.
    const BLANK: Self;

    /// A cell that holds a label, saturated to [`Self::MAX_LABEL`].
    fn from_label(label: u32) -> Self;
    /// The label in the cell.
    fn label(self) -> u32;
}

/// A number system for the whole pipeline.
pub trait Arithmetic: sealed::Sealed + Copy + Default + Debug + Send + Sync + 'static {
    /// The name on the command line and in golden files.
    const NAME: &'static str;
    /// A number that tells snapshots of different arithmetics apart.
    const CODE: u8;
    /// How many units of [`Self::change`] make 1 of the front's unit.
    const CHANGE_UNITS: f32;
    /// Whether the front must be held in pixels and saturated to a band of this half-width.
    const NEEDS_BAND: Option<f32>;
    /// Coefficients and front values must be smaller than this.
    const LIMIT: f32;
    /// The least weight of the curvature, `nu dt / dx^2`, that cells of the front can resolve.
    const LEAST_CURVATURE: f32;

    /// What kernels compute in.
    type Real: Real;
    /// What planes and scratch rows are made of.
    type Cell: Cell;
    /// Vector units for rows of tiles, or [`NoVectors`](crate::arithmetic::vectors::NoVectors).
    type Vectors: Vectors<Cell = Self::Cell, Real = Self::Real>;

    /// The vector units, where the processor has them.
    #[inline(always)]
    fn vectors() -> Option<Self::Vectors> {
        None
    }

    /// Image value or edge detector, in [0, 1], from its cell.
    fn pixel(cell: Self::Cell) -> Self::Real;
    /// Cell of an image value or edge detector in [0, 1].
    fn to_pixel(value: Self::Real) -> Self::Cell;
    /// Front value from its cell.
    fn level(cell: Self::Cell) -> Self::Real;
    /// Cell of a front value.
    fn to_level(value: Self::Real) -> Self::Cell;

    /// The square root of `x >= 0`.
    fn sqrt(x: Self::Real) -> Self::Real;
    /// `sqrt((a^2 + b^2) + (c^2 + d^2))`: the length of the upwind gradient.
    fn norm(a: Self::Real, b: Self::Real, c: Self::Real, d: Self::Real) -> Self::Real;
    /// The length of the upwind gradient, undivided (`nabla^+`), where the four neighbours lie
    /// lower by `drops`; those that lie higher are of no account.
    #[inline(always)]
    fn descent(drops: [Self::Real; 4]) -> Self::Real {
        // Written out, here and below: a compiler that saves code leaves `map` a loop.
        let [l, r, b, a] = drops;
        Self::norm(l.positive(), r.positive(), b.positive(), a.positive())
    }

    /// One pixel of the first-order scheme: `v - courant g` times [`Self::descent`] towards the
    /// neighbours `around`.
    #[inline(always)]
    fn retreat(v: Self::Cell, around: [Self::Cell; 4], courant: Self::Real, g: Self::Cell) -> Self::Cell {
        let v = Self::level(v);
        let [l, r, b, a] = around;
        let drops = [v - Self::level(l), v - Self::level(r), v - Self::level(b), v - Self::level(a)];
        let gradient = Self::descent(drops);
        Self::to_level(v - (courant * Self::pixel(g)) * gradient)
    }

    /// The unit vector along `(x, y)`, or `None` where its length is at most `least`, or 0.
    fn unit(x: Self::Real, y: Self::Real, least: Self::Real) -> Option<(Self::Real, Self::Real)>;
    /// `x^p` for x in [0, 1].
    fn pow(x: Self::Real, p: Exponent) -> Self::Real;
    /// `log2(1 + x)` for x in [0, 1].
    fn log2_1p(x: Self::Real) -> Self::Real;
    /// `exp(-x)` for x >= 0.
    fn exp_neg(x: Self::Real) -> Self::Real;

    /// What [`Self::on_grid`] needs to know about a band of `band` pixels.
    fn anchor(band: f32) -> Self::Real {
        Self::Real::of(band)
    }
    /// A front value rounded to a grid, so that motions that matter to no pixel end. Fixed-point
    /// values are on one.
    #[inline(always)]
    fn on_grid(value: Self::Real, anchor: Self::Real) -> Self::Real {
        let _ = anchor;
        value
    }

    /// The square root of `x >= 0` in `f32`, correctly rounded, as fast as the machine has it.
    #[inline(always)]
    fn root(x: f32) -> f32 {
        Plain::sqrt(x)
    }

    /// Sum of `|new - old|` over the cells with `|old| <= limit`, in [`Self::CHANGE_UNITS`].
    /// Independent of vector width; sums of rows add exactly, in any order.
    fn change(old: &[Self::Cell], new: &[Self::Cell], limit: Self::Real) -> u64;

    /// Runs a row loop on the machine's wide units, where the arithmetic has a use for them.
    #[inline(always)]
    fn wide<T: Task>(row: T) -> T::Output {
        row.run()
    }
}
