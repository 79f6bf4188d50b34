//! Active contours without edges of Chan and Vese (doi:10.1109/83.902291): the contour settles
//! where the image falls into two regions of least variance, not where its gradient is steep.
//!
//! The energy, in pixels, for a front v in [-1, 1] with the regularised step H(v) = (1 + v) / 2:
//!
//! `mu/dx * sum of |grad v|  +  sum of lambda1 (I - c1)^2 (1 + v) + lambda2 (I - c2)^2 (1 - v)`
//!
//! where c1 and c2 are the means of the image I weighted by 1 + v and 1 - v. The authors leave H
//! open; this one has a delta that is constant in the band |v| < 1 and nothing beyond, so every
//! pixel takes part, contours appear inside regions too, and the front is bounded. For fixed means
//! the energy is convex (doi:10.1137/040615286), and where it is least v is -1 or 1 almost
//! everywhere.
//!
//! The length |grad v| is that of [`Length`].
//!
//! A step is the authors' semi-implicit one with the weight of the centre doubled, because rows
//! are updated from old values only: `v + dt (F + mu/dx sum w (v_k - v)) / (1 + 2 dt mu/dx sum w)`,
//! cut at -1 and 1, with `F = lambda2 (I - c2)^2 - lambda1 (I - c1)^2`. It minimises a quadratic
//! that touches the energy and lies above it (h is concave in s^2, and the weighted Laplacian is at
//! most twice its diagonal), so the energy never rises, whatever dt; nor does it with new means.

use super::length::{Length, Nearby};
use super::{Evolve, Step, corners};
use crate::arithmetic::Arithmetic;
use crate::config::{Config, Scheme};
use crate::front::bands::Pull;
use crate::plane::sweep::{Band, Kernel, advance_active, cross};
use crate::plane::tiles::Tiles;
use core::ops::Range;

/// The scheme of Chan and Vese.
#[derive(Clone, Copy, Debug)]
pub struct ChanVese<A: Arithmetic> {
    length: Length<A>,
    pull: Pull<A>,
}

/// The kernel of one step, with the means it works with.
#[derive(Clone, Copy)]
struct Sweep<A: Arithmetic> {
    scheme: ChanVese<A>,
    c1: A::Real,
    c2: A::Real,
    step: Step<A>,
}

impl<A: Arithmetic> Kernel<A, 3> for Sweep<A> {
    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; 3], image: &[A::Cell], new: &mut [A::Cell]) {
        let Sweep { scheme, c1, c2, .. } = *self;
        let cross = cross(old);
        for ((((new, &v), sides), corners), &pixel) in
            new.iter_mut().zip(cross.centre).zip(cross.sides()).zip(corners(old)).zip(image)
        {
            let near = Nearby { centre: A::level(v), sides: sides.map(A::level), corners: corners.map(A::level) };
            let pixel = A::pixel(pixel);
            *new = A::to_level(scheme.length.step(&near, scheme.pull.of(pixel - c1, pixel - c2)));
        }
    }

    #[inline(always)]
    fn settle(&mut self, old: &[A::Cell], image: &[A::Cell], new: &mut [A::Cell]) {
        self.step.change.observe(old, new);
        self.step.change.regions.observe::<A>(old, new, image);
    }
}

/// The kernel of one step under a force that the other plane holds.
#[derive(Clone, Copy)]
struct Following<A: Arithmetic> {
    length: Length<A>,
    step: Step<A>,
}

impl<A: Arithmetic> Kernel<A, 3> for Following<A> {
    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; 3], force: &[A::Cell], new: &mut [A::Cell]) {
        let cross = cross(old);
        for ((((new, &v), sides), corners), &force) in
            new.iter_mut().zip(cross.centre).zip(cross.sides()).zip(corners(old)).zip(force)
        {
            let near = Nearby { centre: A::level(v), sides: sides.map(A::level), corners: corners.map(A::level) };
            *new = A::to_level(self.length.step(&near, A::level(force)));
        }
    }

    #[inline(always)]
    fn settle(&mut self, old: &[A::Cell], _: &[A::Cell], new: &mut [A::Cell]) {
        self.step.change.observe(old, new);
    }
}

impl<A: Arithmetic> Evolve<A> for ChanVese<A> {
    const FOLLOWS: bool = true;

    fn new(config: &Config, _unit: f32) -> Result<Self, Scheme> {
        match config.scheme {
            Scheme::ChanVese => Ok(ChanVese { length: Length::new(config), pull: Pull::new(config, 1) }),
            other => Err(other),
        }
    }

    fn window(&self) -> usize {
        3
    }

    fn advance(&self, band: &mut Band<'_, A::Cell>, tiles: &mut Tiles<'_>, rows: Range<usize>, step: &mut Step<A>) {
        let [c2, c1, ..] = step.means.values::<A>();
        let mut sweep = Sweep { scheme: *self, c1, c2, step: *step };
        advance_active::<A, _, 3>(&mut sweep, band, tiles, rows);
        *step = sweep.step;
    }

    fn follow(&self, band: &mut Band<'_, A::Cell>, tiles: &mut Tiles<'_>, rows: Range<usize>, step: &mut Step<A>) {
        let mut following = Following { length: self.length, step: *step };
        advance_active::<A, _, 3>(&mut following, band, tiles, rows);
        *step = following.step;
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{Plane, middle, plane, swept, unchanged};
    use super::*;
    use crate::arithmetic::F32;
    use crate::config::ChanVese as Weights;

    const CONFIG: Config = Config {
        dt: 0.5,
        dx: 0.1,
        scheme: Scheme::ChanVese,
        chan_vese: Weights { mu: 0.02, lambda1: 2.0, lambda2: 3.0 },
        ..Config::PAPER_F160
    };

    fn front() -> Plane {
        plane(|x, y| 0.04 * x - 0.02 * y + 0.01 * x * y - 0.3)
    }

    /// The step of the middle under a force.
    fn stepped(force: f32) -> f32 {
        let [[bl, b, br], [l, centre, r], [al, a, ar]] = middle(&front());
        Length::<F32>::new(&CONFIG).step(&Nearby { centre, sides: [l, r, b, a], corners: [bl, br, al, ar] }, force)
    }

    #[test]
    fn the_nearer_mean_pulls_a_pixel_to_its_side() {
        let (old, image) = (front(), plane(|x, y| 0.1 + 0.05 * x + 0.01 * y));
        let (new, change) = swept::<ChanVese<F32>>(&CONFIG, [0.2, 0.7, 0.0, 0.0], (&old, &image), ChanVese::advance);
        // The image is 0.4 there: 3 * 0.2^2 - 2 * 0.3^2.
        let (found, expected) = (middle(&new)[1][1], stepped(0.5 * (0.12 - 0.18)));
        assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
        let mut expected = unchanged(&CONFIG);
        expected.observe(&old, &new);
        expected.regions.observe::<F32>(&old, &new, &image);
        assert_eq!(change, expected);
        assert_ne!(change.regions, unchanged(&CONFIG).regions);
    }

    #[test]
    fn a_front_follows_the_force_beside_it() {
        let (old, force) = (front(), plane(|x, y| 0.02 * x - 0.01 * y));
        let (new, change) = swept::<ChanVese<F32>>(&CONFIG, [0.0; 4], (&old, &force), ChanVese::follow);
        let (found, expected) = (middle(&new)[1][1], stepped(0.05));
        assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
        let mut expected = unchanged(&CONFIG);
        expected.observe(&old, &new);
        assert_eq!(change, expected);
    }
}
