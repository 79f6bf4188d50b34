//! Finite differences of second order where the front is smooth: a filtered scheme for `DFg`.
//!
//! After M. Falcone, G. Paolucci and S. Tozza, "A high-order scheme for image segmentation via a
//! modified level-set method" (arXiv:1812.03026), and O. Bokanowski, M. Falcone and S. Sahu
//! (arXiv:1501.01518), where convergence to the viscosity solution is proved:
//!
//! `v(n+1) = M + eps dt F((A - M) / (eps dt))`, `eps = min(5/2 dx, 1/4) g |nabla+ v|`
//!
//! M is the upwind step of [`super::Fd`], which is monotone, and A the one of Lax and Wendroff: the
//! Taylor series of v in time to `dt^2`, in which the equation turns times into places,
//!
//! `v - dt g |D v| + dt^2/2 g (g n.D^2v n + Dg.Dv)`, `n = Dv / |Dv|`,
//!
//! all derivatives by central differences. Both are steps by `dt g` times a slope, and so the filter
//! compares slopes. F(x) is x up to |x| = 1, falls to 0 at |x| = 2 and stays there (B. D. Froese,
//! A. M. Oberman, arXiv:1204.5798): rounding cannot switch it, as it could the one that jumps.
//!
//! The slope taken is between 3/4 and 5/4 of the upwind one, which is at most twice the greatest
//! drop to a neighbour. With `dt <= 2/5 dx` a new value therefore lies between the old one and the
//! least of its four neighbours: the front never moves back, no value arises that was not there,
//! and what rests in `DFg` rests here. A is stable up to `dt = dx/2` (for n along a diagonal; von
//! Neumann).

use super::{Evolve, Step, corners, tracked};
use crate::arithmetic::{Arithmetic, Real};
use crate::config::{Config, Scheme};
use crate::plane::beside::rows_beside;
use crate::plane::sweep::{Band, Kernel, cross};
use crate::plane::tiles::Tiles;
use core::ops::Range;

/// How the filter's room, as a share of the upwind slope, grows with dx: fronts with a radius of
/// curvature above 1/5 of the paper's unit of length are smooth.
const ROOM: f32 = 2.5;
/// Its largest share: with 1/2 kinks are smoothed already.
const LARGEST: f32 = 0.25;

/// The filtered scheme.
#[derive(Clone, Copy, Debug)]
pub struct FdFiltered<A: Arithmetic> {
    /// `dt / dx`: how many pixels the front moves in a step where g = 1.
    courant: A::Real,
    /// The share of the upwind slope by which the other may differ from it.
    room: A::Real,
}

impl<A: Arithmetic> FdFiltered<A> {
    /// `fine` where it is near `upwind`, `upwind` where it is far from it.
    #[inline(always)]
    fn filtered(&self, upwind: A::Real, fine: A::Real) -> A::Real {
        let (room, beyond) = (self.room * upwind, fine - upwind);
        let size = beyond.magnitude();
        let size = size.least((room + room - size).positive());
        if beyond < A::Real::ZERO { upwind - size } else { upwind + size }
    }
}

impl<A: Arithmetic> Kernel<A, 3> for FdFiltered<A> {
    const AROUND: bool = true;

    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; 3], speed: &[A::Cell], new: &mut [A::Cell]) {
        let scheme = *self;
        let (half, quarter) = (A::Real::of(0.5), A::Real::of(0.25));
        let v = cross(old);
        let g = cross(&rows_beside(speed));
        for (((((new, &v), [l, r, b, a]), [bl, br, al, ar]), &g), [gl, gr, gb, ga]) in
            new.iter_mut().zip(v.centre).zip(v.sides()).zip(corners(old)).zip(g.centre).zip(g.sides())
        {
            let [v, l, r, b, a] = [v, l, r, b, a].map(A::level);
            let [bl, br, al, ar] = [bl, br, al, ar].map(A::level);
            let [g, gl, gr, gb, ga] = [g, gl, gr, gb, ga].map(A::pixel);
            let upwind = A::descent([v - l, v - r, v - b, v - a]);
            let (x, y) = ((r - l) * half, (a - b) * half);
            let slope = if let Some((nx, ny)) = A::unit(x, y, A::Real::ZERO) {
                let (xx, yy) = ((l - v) + (r - v), (b - v) + (a - v));
                let mixed = (nx * ny) * (((ar + bl) - (al + br)) * quarter);
                let bend = (xx * (nx * nx) + yy * (ny * ny)) + (mixed + mixed);
                let turn = x * ((gr - gl) * half) + y * ((ga - gb) * half);
                let fine = (x * nx + y * ny) - (scheme.courant * half) * (g * bend + turn);
                scheme.filtered(upwind, fine)
            } else {
                upwind
            };
            *new = A::to_level(v - (scheme.courant * g) * slope);
        }
    }
}

impl<A: Arithmetic> Evolve<A> for FdFiltered<A> {
    fn new(config: &Config, _unit: f32) -> Result<Self, Scheme> {
        match config.scheme {
            Scheme::FdFiltered => Ok(FdFiltered {
                courant: A::Real::of(config.dt / config.dx),
                room: A::Real::of(ROOM * config.dx).least(A::Real::of(LARGEST)),
            }),
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
    use crate::arithmetic::vectors::COLUMNS;

    fn scheme(dt: f32, dx: f32) -> FdFiltered<F32> {
        let config = Config { dt, dx, ..Config::PAPER_F160.with_scheme(Scheme::FdFiltered) };
        <FdFiltered<F32> as Evolve<F32>>::new(&config, 1.0).expect("its scheme")
    }

    #[test]
    fn what_is_far_from_the_upwind_slope_is_filtered_out() {
        // The room is a quarter of the upwind slope; beyond it the difference falls to nothing at twice of it.
        let filtered = |fine: f32| scheme(0.02, 0.1).filtered(2.0, fine);
        for (fine, expected) in [(2.3, 2.3), (1.6, 1.6), (2.7, 2.3), (1.3, 1.7), (3.5, 2.0), (0.5, 2.0), (2.0, 2.0)] {
            assert!((filtered(fine) - expected).abs() < 1e-6, "{fine}: {}", filtered(fine));
        }
        // In finer pixels there is less: 2.5 dx.
        assert!((scheme(0.01, 0.05).filtered(2.0, 2.3) - 2.2).abs() < 1e-6);
    }

    #[test]
    fn a_value_falls_by_the_slope_of_second_order() {
        // D = (0.3, 0.4), v_xx = 0.2, v_yy = -0.2, v_xy = 0.1; g = 0.5 with Dg = (0.1, -0.15).
        let [below, row, above] = [[0.3, -0.3, 0.5], [0.0, 0.2, 0.6], [0.4, 0.5, 1.0]];
        // Rows beside a tile are as long as the tile and a cell on either side.
        let mut speed = [0.0; 3 * (COLUMNS + 2)];
        for (cells, row) in speed.chunks_exact_mut(COLUMNS + 2).zip([[0.0, 0.7, 0.0], [0.4, 0.5, 0.6], [0.0, 0.4, 0.0]])
        {
            cells[..3].copy_from_slice(&row);
        }
        let mut new = [0.0];
        scheme(0.04, 0.1).row(&[&below, &row, &above], &speed, &mut new);
        // n.D^2v n = 0.2 * 0.36 - 0.2 * 0.64 + 2 * 0.48 * 0.1 = 0.04, and Dg.Dv = -0.03.
        let slope = 0.5 - 0.2 * (0.5 * 0.04 - 0.03);
        assert!((new[0] - 0.2 + 0.4 * 0.5 * slope).abs() < 1e-6, "{new:?}");
        // On a top there is no direction: upwind.
        scheme(0.04, 0.1).row(&[&[0.0, -0.3, 0.0], &[-0.4, 0.0, -0.4], &[0.0, -0.3, 0.0]], &speed, &mut new);
        assert!((new[0] + 0.4 * 0.5 * 0.5 * core::f32::consts::SQRT_2).abs() < 1e-6, "{new:?}");
    }

    #[test]
    fn a_plane_falls_by_its_slope() {
        super::super::tests::assert_that_a_plane_falls::<FdFiltered<F32>>(Scheme::FdFiltered);
    }
}
