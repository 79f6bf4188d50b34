//! Finite differences with curvature: `v - dt g |grad v| (1 - nu k)` (`DFgk`).

use super::{Evolve, Step, corners, flat_limit, tracked};
use crate::arithmetic::{Arithmetic, Real};
use crate::config::{Config, CurvatureForm, Scheme};
use crate::plane::sweep::{Band, Kernel, cross};
use crate::plane::tiles::Tiles;
use core::ops::Range;

/// The scheme `DFgk`, with Lambda over `|D^c|^2` and, in the consistent form, `- 4 v` in the flat
/// case (spec section 2, items 2 and 3).
#[derive(Clone, Copy, Debug)]
pub struct FdCurvature<A: Arithmetic> {
    courant: A::Real,
    /// `nu dt / dx^2`, the weight of Lambda.
    bend: A::Real,
    /// `nu / 4`, the weight of the average in the flat case.
    mean: A::Real,
    flat: A::Real,
    form: CurvatureForm,
}

/// The eight neighbours of a pixel: left, right, below, above, and the corners.
struct Around<R> {
    l: R,
    r: R,
    b: R,
    a: R,
    corners: [R; 4],
}

impl<A: Arithmetic> FdCurvature<A> {
    /// The curvature's share of the step, before the factor g.
    #[inline(always)]
    fn curvature(&self, v: A::Real, n: &Around<A::Real>) -> A::Real {
        let half = A::Real::of(0.5);
        let sum = (n.l + n.r) + (n.b + n.a);
        match A::unit((n.r - n.l) * half, (n.a - n.b) * half, self.flat) {
            None => {
                let average = match self.form {
                    CurvatureForm::Consistent => ((n.l - v) + (n.r - v)) + ((n.b - v) + (n.a - v)),
                    CurvatureForm::Printed => sum,
                };
                self.mean * average
            }
            Some((nx, ny)) => {
                let [bl, br, al, ar] = n.corners;
                let (xx, yy) = ((n.l - v) + (n.r - v), (n.b - v) + (n.a - v));
                let xy = ((ar + bl) - (al + br)) * A::Real::of(0.25);
                let mixed = (nx * ny) * xy;
                self.bend * ((xx * (ny * ny) + yy * (nx * nx)) - (mixed + mixed))
            }
        }
    }
}

impl<A: Arithmetic> Kernel<A, 3> for FdCurvature<A> {
    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; 3], speed: &[A::Cell], new: &mut [A::Cell]) {
        let scheme = *self;
        let cross = cross(old);
        for ((((new, &v), [l, r, b, a]), corners), &g) in
            new.iter_mut().zip(cross.centre).zip(cross.sides()).zip(corners(old)).zip(speed)
        {
            let v = A::level(v);
            let n = Around {
                l: A::level(l),
                r: A::level(r),
                b: A::level(b),
                a: A::level(a),
                corners: corners.map(A::level),
            };
            let gradient = A::descent([v - n.l, v - n.r, v - n.b, v - n.a]);
            let g = A::pixel(g);
            *new = A::to_level(v - (scheme.courant * g) * gradient + g * scheme.curvature(v, &n));
        }
    }
}

impl<A: Arithmetic> Evolve<A> for FdCurvature<A> {
    fn new(config: &Config, unit: f32) -> Result<Self, Scheme> {
        match config.scheme {
            Scheme::FdCurvature => Ok(FdCurvature {
                courant: A::Real::of(config.dt / config.dx),
                bend: A::Real::of(config.nu * config.dt / (config.dx * config.dx)),
                mean: A::Real::of(config.nu * 0.25),
                flat: flat_limit::<A>(config, unit),
                form: config.curvature_form,
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
