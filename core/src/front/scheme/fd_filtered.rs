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
