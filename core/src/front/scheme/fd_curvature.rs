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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    const CONFIG: Config = Config { dt: 0.025, dx: 0.1, nu: 0.2, scheme: Scheme::FdCurvature, ..Config::PAPER_F160 };

    fn moved(config: Config, speed: f32, [below, row, above]: [[f32; 3]; 3]) -> f32 {
        let mut scheme = <FdCurvature<F32> as Evolve<F32>>::new(&config, 1.0).expect("its scheme");
        let mut new = [0.0];
        scheme.row(&[&below, &row, &above], &[speed], &mut new);
        new[0]
    }

    #[test]
    fn a_value_falls_by_its_gradient_and_bends_by_its_curvature() {
        // D = (0.3, 0.4), v_xx = 0.2, v_yy = -0.2, v_xy = 0.1: 0.2 * 0.64 - 2 * 0.48 * 0.1 - 0.2 * 0.36 = -0.04, half of
        // it for nu dt / dx^2, and sqrt(0.2^2 + 0.5^2) downwind.
        let around = [[0.1, -0.5, 0.3], [-0.2, 0.0, 0.4], [0.2, 0.3, 0.8]].map(|row| row.map(|v| 0.2 + v));
        let expected = 0.2 - 0.25 * 0.5 * 0.538_516_5 - 0.5 * 0.5 * 0.04;
        assert!((moved(CONFIG, 0.5, around) - expected).abs() < 1e-6);
        assert!((moved(Config { nu: 0.0, ..CONFIG }, 1.0, around) - 0.2 + 0.25 * 0.538_516_5).abs() < 1e-6);
    }

    #[test]
    fn where_it_is_flat_the_four_neighbours_count() {
        let around = [[7.0, 0.8, 7.0], [0.9, 1.0, 0.9], [7.0, 0.8, 7.0]];
        // sqrt(2 * 0.1^2 + 2 * 0.2^2) downwind, and nu / 4 times -0.6, or as printed times 3.4.
        let fallen = 1.0 - 0.25 * 0.5 * 0.316_227_8;
        let printed = Config { curvature_form: CurvatureForm::Printed, ..CONFIG };
        for (config, bent) in [(CONFIG, -0.6), (printed, 3.4)] {
            let (found, expected) = (moved(config, 0.5, around), fallen + 0.5 * 0.05 * bent);
            assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
        }
    }

    #[test]
    fn a_plane_falls_by_its_slope() {
        super::super::tests::assert_that_a_plane_falls::<FdCurvature<F32>>(Scheme::FdCurvature);
    }
}
