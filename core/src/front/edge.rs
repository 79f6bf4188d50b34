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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    /// Three pixels in a row, of which the middle one differs by 0.3 along the row and by 0.4 across it.
    const ROWS: [[f32; 5]; 3] = [[0.1, 0.1, 0.2, 0.4, 0.4], [0.1, 0.1, 0.3, 0.4, 0.4], [0.1, 0.1, 0.6, 0.4, 0.4]];

    fn speed(edge: Edge, dx: f32, range: GradientRange<F32>) -> f32 {
        let [below, row, above] = &ROWS;
        let mut new = [0.0; 3];
        let config = Config { edge, dx, ..Config::PAPER_F160 };
        EdgeDetector::<F32>::new(&config, &range).row(&[below, row, above], &[], &mut new);
        new[1]
    }

    #[test]
    fn gradients_are_ranged() {
        let mut range = GradientRange::<F32>::none();
        let [below, row, above] = &ROWS;
        range.row(&[below, row, above], &[], &mut []);
        assert!((range.least - 0.1).abs() < 1e-6 && (range.greatest - 0.5).abs() < 1e-6, "{range:?}");
    }

    #[test]
    fn detectors_are_the_papers() {
        let range = GradientRange { least: 0.2, greatest: 1.0 };
        // The gradient is 0.5 / (2 dx); of g2 it is 3/8 of the way from the least to the greatest.
        let cases = [
            (Edge::G1 { p: 2.0 }, 0.1, 1.0 / 7.25),
            (Edge::G1 { p: 2.0 }, 0.5, 0.8),
            (Edge::G1 { p: 3.0 }, 0.1, 1.0 / 16.625),
            (Edge::G1 { p: 4000.0 }, 0.1, 0.0),
            (Edge::G1 { p: 4000.0 }, 0.5, 1.0),
            (Edge::G2, 0.1, 0.625),
            (Edge::G2Mod { c2: 0.5 }, 0.1, 0.25),
            (Edge::G2Mod { c2: 0.8 }, 0.1, 0.0),
        ];
        for (edge, dx, expected) in cases {
            let found = speed(edge, dx, range);
            assert!((found - expected).abs() < 1e-6, "{edge:?}: {found}, not {expected}");
        }
        // 1e-8, of which 1 in a sum with it knows nothing.
        assert_eq!(speed(Edge::G1 { p: 20.0 }, 0.1, range), 0.0);
    }
}
