//! Step 4: the edge detector, the speed of the front: 1 in flat places, 0 on edges.

use crate::arithmetic::{Arithmetic, Bits, Exponent, Real};
use crate::config::{Config, Edge};
use crate::plane::sweep::{Cross, Kernel, cross};

/// `2 dx |grad I|` by central differences: undivided, so that it stays in [0, 2 sqrt 2].
#[inline(always)]
fn steepness<A: Arithmetic>(l: A::Cell, r: A::Cell, b: A::Cell, a: A::Cell) -> A::Real {
    A::norm(A::pixel(r) - A::pixel(l), A::pixel(a) - A::pixel(b), A::Real::ZERO, A::Real::ZERO)
}

/// Finds the least and the greatest steepness of the image; changes nothing. No steepness is below
/// zero, so that their bits compare as they do: whole numbers, whose extremes vector units find.
#[derive(Clone, Copy, Debug)]
pub struct GradientRange<A: Arithmetic> {
    /// The least `2 dx |grad I|` so far.
    pub least: A::Real,
    /// The greatest `2 dx |grad I|` so far.
    pub greatest: A::Real,
}

impl<A: Arithmetic> GradientRange<A> {
    /// Before the first pixel; 4 is above every steepness.
    pub fn none() -> Self {
        GradientRange { least: A::Real::of(4.0), greatest: A::Real::ZERO }
    }
}

impl<A: Arithmetic> Kernel<A, 3> for GradientRange<A> {
    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; 3], _aux: &[A::Cell], _new: &mut [A::Cell]) {
        let Cross { left, right, below, above, .. } = cross(old);
        let (mut least, mut greatest) = (self.least.bits(), self.greatest.bits());
        for (((&l, &r), &b), &a) in left.iter().zip(right).zip(below).zip(above) {
            let s = steepness::<A>(l, r, b, a).bits();
            least = least.min(s);
            greatest = greatest.max(s);
        }
        self.least = A::Real::from_bits(least);
        self.greatest = A::Real::from_bits(greatest);
    }
}

/// Turns the filtered image into the edge detector.
#[derive(Clone, Copy, Debug)]
pub enum EdgeDetector<A: Arithmetic> {
    /// `1 / (1 + z^p)`.
    G1 {
        /// `1 / (2 dx)`: steepness becomes `z = |grad I|`.
        scale: A::Real,
        /// p.
        p: Exponent,
    },
    /// `max(g2 - c2, 0) / (1 - c2)`; c2 = 0 is g2 itself.
    G2Mod {
        /// The least steepness.
        least: A::Real,
        /// The greatest minus the least.
        span: A::Real,
        /// c2.
        c2: A::Real,
        /// 1 - c2.
        rest: A::Real,
    },
}

impl<A: Arithmetic> EdgeDetector<A> {
    /// The detector of a configuration, for an image with these gradients.
    pub fn new(config: &Config, range: &GradientRange<A>) -> Self {
        let c2 = match config.edge {
            Edge::G1 { p } => {
                return EdgeDetector::G1 { scale: A::Real::of(0.5 / config.dx), p: Exponent::of(p) };
            }
            Edge::G2 => A::Real::ZERO,
            Edge::G2Mod { c2 } => A::Real::of(c2),
        };
        EdgeDetector::G2Mod { least: range.least, span: range.greatest - range.least, c2, rest: A::Real::ONE - c2 }
    }

    /// One row: `speed` of every steepness.
    #[inline(always)]
    fn fill(old: &[&[A::Cell]; 3], new: &mut [A::Cell], speed: impl Fn(A::Real) -> A::Real) {
        let Cross { left, right, below, above, .. } = cross(old);
        for ((((new, &l), &r), &b), &a) in new.iter_mut().zip(left).zip(right).zip(below).zip(above) {
            *new = A::to_pixel(speed(steepness::<A>(l, r, b, a)));
        }
    }
}

/// `1 / (1 + z^p)` without overflow: above 1 the power of `1/z` is taken. Large p make it a step,
/// exactly 1 below z = 1 and exactly 0 above.
#[inline(always)]
fn g1<A: Arithmetic>(z: A::Real, p: Exponent) -> A::Real {
    let one = A::Real::ONE;
    if z < one {
        return one.ratio(one + A::pow(z, p));
    }
    let power = A::pow(one.ratio(z), p);
    if one + power > one { power.ratio(one + power) } else { A::Real::ZERO }
}

impl<A: Arithmetic> Kernel<A, 3> for EdgeDetector<A> {
    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; 3], _aux: &[A::Cell], new: &mut [A::Cell]) {
        // Outside the loop: what has no branches becomes vectors.
        match *self {
            EdgeDetector::G1 { scale, p } => Self::fill(old, new, |s| g1::<A>(s * scale, p)),
            EdgeDetector::G2Mod { least, span, c2, rest } => Self::fill(old, new, |s| {
                let g2 = A::Real::ONE - (s - least).ratio(span);
                (g2 - c2).positive().ratio(rest)
            }),
        }
    }
}
