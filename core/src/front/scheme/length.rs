//! The length of the contours of Chan and Vese's models, and what it pulls a front by.
//!
//! The length is a sum over squares of four pixels of `h(s)`, s^2 the mean of the squared
//! differences along opposite sides, added for both axes; `h(s) = s` above the limit `degenerate`
//! and a parabola below: there the curvature is the average of the four neighbours minus v, as in
//! the consistent form of the other schemes. A square at the border, whose outer half repeats the
//! inner one, counts half. No direction is preferred.

use crate::arithmetic::{Arithmetic, Real};
use crate::config::Config;

/// The weight of the length in a step.
#[derive(Clone, Copy, Debug)]
pub struct Length<A: Arithmetic> {
    /// `dt mu / dx`.
    weight: A::Real,
    /// Differences below this are flat, in pixels per pixel.
    flat: A::Real,
}

/// A front value with its neighbours.
#[derive(Clone, Copy)]
pub struct Nearby<R> {
    /// The value itself.
    pub centre: R,
    /// Left, right, below, above.
    pub sides: [R; 4],
    /// Below left and right, above left and right.
    pub corners: [R; 4],
}

impl<A: Arithmetic> Length<A> {
    /// The length's weight in a configuration.
    pub fn new(config: &Config) -> Self {
        Length {
            weight: A::Real::of(config.dt * config.chan_vese.mu / config.dx),
            flat: A::Real::of(config.degenerate),
        }
    }

    /// Half the weight of a square with these differences along its four sides.
    #[inline(always)]
    fn square(&self, sides: [A::Real; 4]) -> A::Real {
        let [a, b, c, d] = sides;
        let steep = A::norm(a, b, c, d) * A::Real::of(core::f32::consts::FRAC_1_SQRT_2);
        A::Real::of(0.5).ratio(steep.greatest(self.flat))
    }

    /// The semi-implicit step of a value under a force: `v + (force + weight sum w (v_k - v)) / (1 +
    /// 2 weight sum w)`, cut at -1 and 1.
    #[inline(always)]
    pub fn step(&self, near: &Nearby<A::Real>, force: A::Real) -> A::Real {
        let v = near.centre;
        let [l, r, b, a] = near.sides.map(|side| side - v);
        let [bl, br, al, ar] = near.corners.map(|corner| corner - v);
        let square = |x: A::Real, y: A::Real, corner: A::Real| self.square([x, corner - y, y, corner - x]);
        let (wbl, wbr, wal, war) = (square(l, b, bl), square(r, b, br), square(l, a, al), square(r, a, ar));
        let [wl, wr, wb, wa] = [wbl + wal, wbr + war, wbl + wbr, wal + war];
        let bend = (wl * l + wr * r) + (wb * b + wa * a);
        let weights = (wl + wr) + (wb + wa);
        let divisor = A::Real::ONE + (self.weight + self.weight) * weights;
        let moved = v + (force + self.weight * bend).ratio(divisor);
        moved.least(A::Real::ONE).greatest(-A::Real::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    /// Differences to the four sides and the four corners.
    fn near(centre: f32, sides: [f32; 4], corners: [f32; 4]) -> Nearby<f32> {
        Nearby { centre, sides: sides.map(|side| side + centre), corners: corners.map(|corner| corner + centre) }
    }

    #[test]
    fn the_weights_are_those_of_a_configuration() {
        let chan_vese = crate::config::ChanVese { mu: 0.02, ..Config::PAPER_F160.chan_vese };
        let length = Length::<F32>::new(&Config { dt: 0.5, dx: 0.1, chan_vese, degenerate: 0.3, ..Config::PAPER_F160 });
        assert!((length.weight - 0.1).abs() < 1e-7 && length.flat == 0.3, "{length:?}");
    }

    #[test]
    fn where_it_is_flat_the_four_neighbours_count() {
        let length = Length::<F32> { weight: 0.5, flat: 2.0 };
        // Each weighs 1/2: (0.2 + 0.5 * 0.5 * 0.4) / (1 + 2 * 0.5 * 2).
        let moved = length.step(&near(0.1, [0.3, -0.1, 0.4, -0.2], [0.0; 4]), 0.2);
        assert!((moved - (0.1 + 0.3 / 3.0)).abs() < 1e-6, "{moved}");
    }

    #[test]
    fn where_it_is_steep_each_square_counts_by_its_slope() {
        let length = Length::<F32> { weight: 0.1, flat: 1e-3 };
        // The squares' slopes: 0.5, 0.5, 0.3 and sqrt(0.27), where the two differences along x are 0.3 and 0.6.
        let moved = length.step(&near(0.2, [0.3, -0.3, 0.4, 0.0], [0.7, 0.1, 0.3, 0.3]), 0.05);
        let [one, other] = [0.5 / 0.3, 0.5 / 0.519_615_2];
        let (bend, weights) = (0.3 * (1.0 + one) - 0.3 * (1.0 + other) + 0.4 * 2.0, 2.0 * (2.0 + one + other));
        let expected = 0.2 + (0.05 + 0.1 * bend) / (1.0 + 0.2 * weights);
        assert!((moved - expected).abs() < 1e-6, "{moved}, not {expected}");
    }

    #[test]
    fn fronts_stay_between_their_ends() {
        let length = Length::<F32> { weight: 0.0, flat: 1.0 };
        let moved = |force| length.step(&near(0.5, [0.0; 4], [0.0; 4]), force);
        assert_eq!([0.25, 3.0, -3.0].map(moved), [0.75, 1.0, -1.0]);
    }
}
