//! Multiphase active contours of Vese and Chan (doi:10.1023/A:1020874308076): two fronts part the
//! image into four phases of least variance.
//!
//! The energy, in pixels, for fronts v and w in [-1, 1] with the H of [`super::ChanVese`], of which
//! this is twice the authors':
//!
//! `mu/dx * sum of |grad v| + |grad w|  +  1/2 sum of (I - c)^2 (1 +- v) (1 +- w)`
//!
//! over the four combinations of signs, c the mean of the image I with that weight. For a fixed w
//! and fixed means it is the energy of one front, of which the step of [`super::ChanVese`] raises
//! none; so v is moved first, and then w beside the new v. Only what lies at the same pixel ties
//! them together, so that one sweep moves both.
//!
//! Where a pixel starts is told by its value: in the phase with the mean nearest to it, of the four
//! classes of least variance of a histogram ([`crate::sky::classes`]).
//!
//! Both fronts lie in the front plane ([`crate::front::pair`]): their values are rounded to 2^-14,
//! and a step below half of that is none.

use super::length::{Length, Nearby};
use super::{Evolve, Step, corners};
use crate::arithmetic::{Arithmetic, Real};
use crate::config::{Config, Scheme};
use crate::front::pair;
use crate::plane::sweep::{Band, Kernel, advance_active, cross};
use crate::plane::tiles::Tiles;
use core::ops::Range;

/// The scheme of Vese and Chan with four phases.
#[derive(Clone, Copy, Debug)]
pub struct Multiphase<A: Arithmetic> {
    length: Length<A>,
    /// `dt / 2`.
    force: A::Real,
}

/// The kernel of one step, with the means it works with.
#[derive(Clone, Copy)]
struct Sweep<A: Arithmetic> {
    scheme: Multiphase<A>,
    means: [A::Real; 4],
    step: Step<A>,
}

impl<A: Arithmetic> Multiphase<A> {
    /// A front value after a step, beside a value of the other front: what a pixel differs from the
    /// means by, squared, outside and inside of its front where it is inside of the other, and where
    /// it is outside.
    #[inline(always)]
    fn step(&self, near: &Nearby<A::Real>, other: A::Real, [inside, outside]: [[A::Real; 2]; 2]) -> A::Real {
        let pull = |[without, within]: [A::Real; 2]| without - within;
        let force = (A::Real::ONE + other) * pull(inside) + (A::Real::ONE - other) * pull(outside);
        self.length.step(near, self.force * force)
    }
}

impl<A: Arithmetic> Kernel<A, 3> for Sweep<A> {
    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; 3], image: &[A::Cell], new: &mut [A::Cell]) {
        let Sweep { scheme, means, .. } = *self;
        let cross = cross(old);
        for ((((new, &cell), sides), corners), &pixel) in
            new.iter_mut().zip(cross.centre).zip(cross.sides()).zip(corners(old)).zip(image)
        {
            let (centre, sides, corners) = (pair::values(cell), sides.map(pair::values), corners.map(pair::values));
            let [v, w] = centre;
            let pixel = A::pixel(pixel);
            // In the order of the phases: outside both, in the first alone, in both, in the second alone.
            let [neither, first, both, second] = means.map(|mean| (pixel - mean) * (pixel - mean));
            let near = Nearby { centre: v, sides: sides.map(|[v, _]| v), corners: corners.map(|[v, _]| v) };
            let moved = scheme.step(&near, w, [[second, both], [neither, first]]);
            // As its cell will have it.
            let [v, _] = pair::values(pair::cell::<A::Real, A::Cell>([moved, A::Real::ZERO]));
            let near = Nearby { centre: w, sides: sides.map(|[_, w]| w), corners: corners.map(|[_, w]| w) };
            let moved = scheme.step(&near, v, [[first, both], [neither, second]]);
            *new = pair::cell([v, moved]);
        }
    }

    #[inline(always)]
    fn settle(&mut self, old: &[A::Cell], image: &[A::Cell], new: &mut [A::Cell]) {
        self.step.change.observe_pairs(old, new);
        self.step.change.regions.observe_pairs::<A>(old, new, image);
    }
}

impl<A: Arithmetic> Evolve<A> for Multiphase<A> {
    fn new(config: &Config, _unit: f32) -> Result<Self, Scheme> {
        match config.scheme {
            Scheme::Multiphase => Ok(Multiphase { length: Length::new(config), force: A::Real::of(config.dt * 0.5) }),
            other => Err(other),
        }
    }

    fn window(&self) -> usize {
        3
    }

    fn advance(&self, band: &mut Band<'_, A::Cell>, tiles: &mut Tiles<'_>, rows: Range<usize>, step: &mut Step<A>) {
        let mut sweep = Sweep { scheme: *self, means: step.means.values::<A>(), step: *step };
        advance_active::<A, _, 3>(&mut sweep, band, tiles, rows);
        *step = sweep.step;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    #[test]
    fn a_front_is_pulled_by_the_phases_that_its_other_front_leaves() {
        let length = Length::new(&Config::PAPER_F160);
        let scheme = Multiphase::<F32> { length, force: 0.1 };
        let alone = Nearby { centre: 0.2, sides: [0.2; 4], corners: [0.2; 4] };
        let moved = |other| scheme.step(&alone, other, [[0.8, 0.2], [0.3, 0.6]]) - 0.2;
        let of_force = 2.0 * (length.step(&alone, 0.5) - 0.2);
        // Inside of the other it is 0.6, outside -0.3, and 1 + w and 1 - w are their weights.
        for (other, force) in [(1.0, 1.2), (-1.0, -0.6), (0.5, 1.5 * 0.6 - 0.5 * 0.3)] {
            assert!((moved(other) - 0.1 * force * of_force).abs() < 1e-6, "{other}: {}", moved(other));
        }
    }

    /// Both fronts of a pixel whose four squared differences from the means are told by hand.
    #[test]
    fn each_front_moves_beside_the_other() {
        use super::super::tests::{middle, plane, swept, unchanged};
        let chan_vese = crate::config::ChanVese { mu: 0.02, ..Config::PAPER_F160.chan_vese };
        let config = Config { dt: 0.5, dx: 0.1, chan_vese, ..Config::PAPER_F160.with_scheme(Scheme::Multiphase) };
        let fronts = |x: f32, y: f32| [0.03 * x - 0.02 * y + 0.25, 0.01 * x + 0.04 * y - 0.75];
        let old = plane(|x, y| pair::cell(fronts(x, y)));
        let image = plane(|x, y| 0.06 * x + 0.02 * y);
        let means = [0.1, 0.2, 0.8, 0.6];
        let (new, change) = swept::<Multiphase<F32>>(&config, means, (&old, &image), Multiphase::advance);
        let around = middle(&old).map(|row| row.map(pair::values::<f32>));
        let near = |of: usize| {
            let [[bl, b, br], [l, centre, r], [al, a, ar]] = around.map(|row| row.map(|values| values[of]));
            Nearby { centre, sides: [l, r, b, a], corners: [bl, br, al, ar] }
        };
        let length = Length::<F32>::new(&config);
        // The image is 0.4: outside both 0.09, in the first alone 0.04, in both 0.16, in the second alone 0.04.
        let v = length.step(&near(0), 0.25 * ((1.0 - 0.5) * (0.04 - 0.16) + (1.0 + 0.5) * (0.09 - 0.04)));
        let w = length.step(&near(1), 0.25 * ((1.0 + v) * (0.04 - 0.16) + (1.0 - v) * (0.09 - 0.04)));
        let found = pair::values::<f32>(middle(&new)[1][1]);
        assert!((found[0] - v).abs() < 4e-5 && (found[1] - w).abs() < 6e-5, "{found:?}, not {v} and {w}");
        let mut expected = unchanged(&config);
        expected.observe_pairs(&old, &new);
        expected.regions.observe_pairs::<F32>(&old, &new, &image);
        assert_eq!(change, expected);
        assert_ne!((change.sum, change.regions), (0, unchanged(&config).regions));
    }
}
