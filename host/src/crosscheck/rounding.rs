//! What an arithmetic may round: the source of every tolerance.
//!
//! Each step of the core is held beside the reference's from the very same input, so that nothing adds up. What is left
//! has two parts. Inside a step a number may be off by [`Rounding::inside`]: the reference takes the step with its input
//! moved as far up and down, and the core must lie between the two, or beyond them by no more than the roundings of its
//! result, which [`Tolerances`](super::Tolerances) state.

use skyfront_core::arithmetic::{Arithmetic, Real};

/// How far a number inside a step may be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rounding {
    /// A cell of the image.
    pub cell: f64,
    /// An image value, before a power or a root of it is taken.
    pub value: f64,
    /// The length of a gradient, in image units per two pixels: a share of it, and a part that is always there.
    pub gradient: (f64, f64),
    /// Half a difference of two front values, of which the direction of a normal is taken, in the front's unit.
    pub direction: f64,
    /// The share of the least gradient that the direction of the front is taken of.
    pub flat: f64,
    /// Half a step of the grid that a banded front is rounded to, in pixels.
    pub grid: f64,
    /// A front value, in the front's unit, of the front before its first step.
    pub start: f64,
    /// A share of a pixel's change, in the sum that the stopping rule looks at, in the front's unit.
    pub change: f64,
}

/// 2^-n.
pub(super) const fn bit(n: u32) -> f64 {
    1.0 / (1u64 << n) as f64
}

impl Rounding {
    /// Of f32, whose subtractions of neighbours are exact; of numbers with 24 fraction bits; and of such with cells of 15
    /// bits for the image and 11 for the front, and gradients of 15.
    pub fn of<A: Arithmetic>(band: Option<f64>) -> Rounding {
        let change = 0.5 / f64::from(A::CHANGE_UNITS);
        match A::NAME {
            "q24" => Rounding {
                cell: bit(25),
                value: bit(24),
                gradient: (0.0, bit(23)),
                direction: bit(24),
                flat: bit(12),
                grid: 0.0,
                start: bit(23),
                change,
            },
            "q11" => Rounding {
                cell: bit(16),
                value: bit(24),
                gradient: (0.0, bit(15)),
                direction: 0.0,
                flat: bit(8),
                grid: 0.0,
                start: bit(12) + bit(23),
                change,
            },
            _ => Rounding {
                cell: bit(25),
                value: 0.0,
                gradient: (bit(22), 0.0),
                direction: 0.0,
                flat: bit(16),
                // An anchor is 768 times 2^14 steps.
                grid: band.map_or(0.0, |band| f64::from(A::anchor(band as f32).to_f32()) / 768.0 * bit(15)),
                start: bit(22) * band.unwrap_or(1.0).max(1.0),
                change,
            },
        }
    }

    /// How far the length of a gradient may be off.
    pub fn of_gradient(&self, length: f64) -> f64 {
        self.gradient.0 * length + self.gradient.1
    }
}
