//! What keeps a banded front narrow, however far it travels.
//!
//! A first-order scheme smears the front's profile, by about `0.4 sqrt(steps)` pixels, and its
//! tails never quite end: more and more pixels change, by less and less. With a band every new
//! value is settled: values above half the band and below half the floor grow away from zero by a
//! small factor, both ends are saturated, and in floating point values are rounded to a grid. The
//! sign of no value changes, and next to the front values are only rounded.
//!
//! With gains that fall with the square of the widths, growth and smearing (diffusion with
//! `D <= 1/8` pixel^2 a step) balance in a profile of slope about 1, and the growth of the two
//! sides (width^2 times gain) is equal, so that the profile travels at the speed of the front.

use crate::arithmetic::vectors::COLUMNS;
use crate::arithmetic::vectors::Vectors;
use crate::arithmetic::{Arithmetic, Real};

/// How far below zero a banded front goes, in pixels: as deep as the paper's `u0` at the border.
pub const FLOOR: f32 = 1.5;

/// The constants of the rule, or none without a band.
#[derive(Clone, Copy, Debug)]
pub struct Settle<A: Arithmetic> {
    sides: Option<(Side<A>, Side<A>)>,
    anchor: A::Real,
}

/// One side of the front.
#[derive(Clone, Copy, Debug)]
struct Side<A: Arithmetic> {
    limit: A::Real,
    half: A::Real,
    gain: A::Real,
}

impl<A: Arithmetic> Side<A> {
    fn new(limit: f32) -> Self {
        Side { limit: A::Real::of(limit), half: A::Real::of(limit * 0.5), gain: A::Real::of(0.5 / (limit * limit)) }
    }
}

impl<A: Arithmetic> Settle<A> {
    /// The rule for a front that rises to `band` pixels. None for arithmetics whose cells are
    /// narrow themselves: they saturate at the band and end tails by their own step, and settling
    /// below zero would only make the stopping rule fire early.
    pub fn new(band: Option<f32>) -> Self {
        let band_to_settle = band.filter(|_| A::NEEDS_BAND.is_none());
        let sides = band_to_settle.map(|band| (Side::new(band), Side::new(FLOOR)));
        Settle { sides, anchor: A::anchor(band.unwrap_or(1.0)) }
    }

    /// Settles a piece of a row.
    #[inline(always)]
    pub fn row(&self, row: &mut [A::Cell]) {
        let Settle { sides, anchor } = *self;
        let Some((above, below)) = sides else { return };
        for cell in row {
            let v = A::level(*cell);
            // A difference: operands of a sum would be swapped at will, in every other lane.
            let growth = above.gain * (v - above.half).positive() - below.gain * (-below.half - v).positive();
            let value = (v + growth).least(above.limit).greatest(-below.limit);
            *cell = A::to_level(A::on_grid(value, anchor));
        }
    }

    /// [`Self::row`] on vector units.
    #[inline(always)]
    pub fn on_vectors(&self, vectors: A::Vectors, tiles: &mut [[A::Cell; COLUMNS]]) {
        let Settle { sides, anchor } = *self;
        let Some((above, below)) = sides else { return };
        for tile in tiles {
            let v = vectors.load(tile);
            let over = vectors.positive(vectors.minus(v, vectors.splat(above.half)));
            let under = vectors.positive(vectors.minus(vectors.splat(-below.half), v));
            let over = vectors.times(vectors.splat(above.gain), over);
            let under = vectors.times(vectors.splat(below.gain), under);
            let value = vectors.plus(v, vectors.minus(over, under));
            let value = vectors.least(value, vectors.splat(above.limit));
            let value = vectors.greatest(value, vectors.splat(-below.limit));
            vectors.store(vectors.minus(vectors.plus(value, vectors.splat(anchor)), vectors.splat(anchor)), tile);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    #[test]
    fn signs_stay_and_tails_end() {
        let settle = Settle::<F32>::new(Some(8.0));
        let mut row = [-9.0, -1.4, -0.75, -1e-3, 0.0, 1e-9, 2.5, 4.0, 6.0, 7.99];
        settle.row(&mut row);
        let grid = 1.0 / 16384.0;
        assert_eq!(row, [-1.5, -1.5, -0.75, -16.0 * grid, 0.0, 0.0, 2.5, 4.0, 6.015_625, 8.0]);
        let mut paper = [1e-30];
        Settle::<F32>::new(None).row(&mut paper);
        assert_eq!(paper, [1e-30]);
    }
}
