//! Semi-Lagrangian, first order: the least value within reach of the front (`SLg`).
//!
//! The minimum over the closed ball is taken over its centre and 16 (or 64) directions on its
//! rim, evenly spread from the axis. The set is symmetric under mirroring and transposition, and
//! so is every formula, so that a mirrored image gives a mirrored front, exactly.

use super::{Evolve, Step, corners, tracked};
use crate::arithmetic::{Arithmetic, Real};
use crate::config::{Config, Scheme};
use crate::plane::sweep::{Band, Kernel, cross};
use crate::plane::tiles::Tiles;
use core::ops::Range;

/// Directions strictly inside a quadrant, 64 to the circle: (cos, sin) of k pi / 32.
const QUADRANT: [(f32, f32); 15] = [
    (0.995_184_7, 0.098_017_14),
    (0.980_785_3, 0.195_090_32),
    (0.956_940_35, 0.290_284_67),
    (0.923_879_5, 0.382_683_43),
    (0.881_921_3, 0.471_396_74),
    (0.831_469_6, 0.555_570_2),
    (0.773_010_43, 0.634_393_3),
    (core::f32::consts::FRAC_1_SQRT_2, core::f32::consts::FRAC_1_SQRT_2),
    (0.634_393_3, 0.773_010_43),
    (0.555_570_2, 0.831_469_6),
    (0.471_396_74, 0.881_921_3),
    (0.382_683_43, 0.923_879_5),
    (0.290_284_67, 0.956_940_35),
    (0.195_090_32, 0.980_785_3),
    (0.098_017_14, 0.995_184_7),
];

/// The scheme `SLg` with `4 (M + 1)` directions. The foot stays in the 3 x 3 neighbourhood while
/// `dt g / dx <= 1`.
#[derive(Clone, Copy, Debug)]
pub struct Sl<A: Arithmetic, const M: usize = 3> {
    /// `dt / dx`: how many pixels away the foot lies where g = 1.
    pub(super) reach: A::Real,
    directions: [(A::Real, A::Real); M],
}

impl<A: Arithmetic, const M: usize> Sl<A, M> {
    pub(super) fn with_reach(reach: f32) -> Self {
        let step = 16 / (M + 1);
        let mut inside = QUADRANT.iter().skip(step.saturating_sub(1)).step_by(step.max(1));
        let directions = core::array::from_fn(|_| {
            let &(cos, sin) = inside.next().unwrap_or(&(1.0, 0.0));
            (A::Real::of(cos), A::Real::of(sin))
        });
        Sl { reach: A::Real::of(reach), directions }
    }

    /// The least interpolated value at distance 0 or `rho` pixels.
    ///
    /// `sides` are the differences of left, right, below, above to the centre; `corners` those of
    /// the corners below left, below right, above left, above right.
    #[inline(always)]
    pub(super) fn least_within(&self, v: A::Real, rho: A::Real, sides: [A::Real; 4], corners: [A::Real; 4]) -> A::Real {
        let [l, r, b, a] = sides;
        let [bl, br, al, ar] = corners;
        let mut least = A::Real::ZERO.least(rho * l.least(r)).least(rho * b.least(a));
        for (h, w, d) in [(l, b, bl), (r, b, br), (l, a, al), (r, a, ar)] {
            // Bilinear: the twist is what the corner adds to the two sides.
            let twist = d - (h + w);
            for &(cos, sin) in &self.directions {
                let (x, y) = (rho * cos, rho * sin);
                least = least.least((x * h + y * w) + (x * y) * twist);
            }
        }
        v + least
    }
}

impl<A: Arithmetic, const M: usize> Kernel<A, 3> for Sl<A, M> {
    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; 3], speed: &[A::Cell], new: &mut [A::Cell]) {
        let scheme = *self;
        let cross = cross(old);
        for ((((new, &v), [l, r, b, a]), [bl, br, al, ar]), &g) in
            new.iter_mut().zip(cross.centre).zip(cross.sides()).zip(corners(old)).zip(speed)
        {
            let v = A::level(v);
            let from_v = |cell: A::Cell| A::level(cell) - v;
            let sides = [from_v(l), from_v(r), from_v(b), from_v(a)];
            let corners = [from_v(bl), from_v(br), from_v(al), from_v(ar)];
            *new = A::to_level(scheme.least_within(v, scheme.reach * A::pixel(g), sides, corners));
        }
    }
}

impl<A: Arithmetic, const M: usize> Evolve<A> for Sl<A, M> {
    fn new(config: &Config, _unit: f32) -> Result<Self, Scheme> {
        match config.scheme {
            Scheme::Sl if usize::from(config.directions) == 4 * (M + 1) => Ok(Sl::with_reach(config.dt / config.dx)),
            other => Err(other),
        }
    }

    fn window(&self) -> usize {
        3
    }

    fn advance(&self, band: &mut Band<'_, A::Cell>, tiles: &mut Tiles<'_>, rows: Range<usize>, step: &mut Step<A>) {
        tracked::<A, _, 3>(*self, band, tiles, rows, step);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    /// The least value within 0.4 pixels of a pixel with value 2, in a plane that rises along a direction.
    fn least<const M: usize>([x, y]: [f32; 2]) -> f32 {
        let sides = [-x, x, -y, y];
        Sl::<F32, M>::with_reach(0.8).least_within(2.0, 0.4, sides, [-x - y, x - y, y - x, x + y])
    }

    #[test]
    fn planes_fall_by_their_slope_along_every_direction() {
        for (k, &(cos, sin)) in (1..).zip(&QUADRANT) {
            let angle = k as f32 * core::f32::consts::PI / 32.0;
            assert!((libm::cosf(angle) - cos).abs() < 1e-6 && (libm::sinf(angle) - sin).abs() < 1e-6, "{k}");
            for (x, y) in [(cos, sin), (-cos, sin), (cos, -sin), (-cos, -sin)] {
                assert!((least::<15>([x, y]) - 1.6).abs() < 1e-6, "{k}");
                // Of 16 directions only every fourth is one of these.
                assert_eq!((least::<3>([x, y]) - 1.6).abs() < 1e-6, k % 4 == 0, "{k}");
            }
        }
        for axis in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
            assert!((least::<3>(axis) - 1.6).abs() < 1e-6, "{axis:?}");
        }
        assert_eq!(least::<3>([0.0, 0.0]), 2.0);
        // On a crest, half as steep to the left and below as it rises beyond: along the diagonal between these two.
        let found = Sl::<F32, 3>::with_reach(0.8).least_within(2.0, 0.4, [-0.5, 1.0, -0.5, 1.0], [-1.0, 0.5, 0.5, 2.0]);
        assert!((found - (2.0 - 0.4 * core::f32::consts::FRAC_1_SQRT_2)).abs() < 1e-6, "{found}");
    }

    #[test]
    fn corners_count_by_the_product_of_the_distances() {
        for corner in 0..4 {
            let corners = core::array::from_fn(|at| if at == corner { -1.0 } else { 0.0 });
            let least = Sl::<F32, 3>::with_reach(0.8).least_within(2.0, 0.4, [0.0; 4], corners);
            assert!((least - (2.0 - 0.5 * 0.4 * 0.4)).abs() < 1e-6, "{corner}: {least}");
        }
    }

    #[test]
    fn the_front_reaches_as_far_as_its_speed_takes_it() {
        let config = Config { dt: 0.05, dx: 0.1, ..Config::PAPER_F160.with_scheme(Scheme::Sl) };
        let mut scheme = <Sl<F32> as Evolve<F32>>::new(&config, 1.0).expect("its scheme");
        let mut new = [0.0];
        let row = [1.0, 2.0, 3.0];
        scheme.row(&[&row, &row, &row], &[0.6], &mut new);
        assert!((new[0] - (2.0 - 0.5 * 0.6)).abs() < 1e-6, "{new:?}");
    }

    #[test]
    fn a_plane_falls_by_its_slope() {
        super::super::tests::assert_that_a_plane_falls::<Sl<F32>>(Scheme::Sl);
    }
}
