//! What a processor offers beyond plain code: a square root and wider vectors.
//!
//! Neither can change a bit. IEEE 754 rounds the square root correctly, so every conforming
//! implementation returns the same value, and the row loops are written so that their result does
//! not depend on how many pixels are worked on at once.

use crate::arithmetic::vectors::{NoVectors, Vectors};

/// Whether the processor has vector units, which want loops of constant length.
pub(crate) const VECTORS: bool = cfg!(any(target_arch = "x86_64", target_arch = "aarch64"));

/// A row loop, as a thing that can be handed to a [`Machine`]. A closure would do, but nothing can
/// oblige the compiler to inline a closure, and only inlined code gets the wider vectors.
pub trait Task {
    /// What the loop returns.
    type Output;

    /// Runs the loop; implementations are `#[inline(always)]`.
    fn run(self) -> Self::Output;
}

/// A processor, as the row loops see it.
pub trait Machine: Copy + Default + core::fmt::Debug + Send + Sync + 'static {
    /// Its vector units for single precision, or [`NoVectors`].
    type Vectors: Vectors<Cell = f32, Real = f32>;

    /// The vector units, where this very processor has them.
    #[inline(always)]
    fn vectors() -> Option<Self::Vectors> {
        None
    }

    /// The square root of `x >= 0`, correctly rounded (IEEE 754, ties to even).
    fn sqrt(x: f32) -> f32;

    /// Runs a row loop, on wider vector units where the processor has them.
    #[inline(always)]
    fn wide<T: Task>(row: T) -> T::Output {
        row.run()
    }
}

/// Any processor: the square root of `libm`, no vectors asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Plain;

impl Machine for Plain {
    type Vectors = NoVectors<f32, f32>;

    #[inline]
    fn sqrt(x: f32) -> f32 {
        libm::sqrtf(x)
    }
}
