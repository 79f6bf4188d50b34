//! `DFgk`: finite differences of u_t + g |grad u| = nu g k |grad u|, k the curvature of the level lines.

use super::plane::Around;
use super::{CurvatureForm, Parameters, Plane, fd};

/// One time step.
pub(super) fn step(p: &Parameters, g: &Plane, v: &Plane) -> Plane {
    let threshold = p.degenerate_c * p.dx.powf(p.degenerate_s);
    Plane::from_fn(v.width(), v.height(), |i, j| {
        let v = v.around(i, j);
        let (x, y) = central(&v, p.dx);
        let turn = if (x * x + y * y).sqrt() <= threshold { average(p, &v) } else { p.nu * p.dt * lambda(&v, p.dx) };
        v.c - p.dt * g.at(i, j) * fd::upwind(&v, p.dx) + g.at(i, j) * turn
    })
}

/// D^c: the gradient by central differences.
pub(super) fn central(v: &Around, dx: f64) -> (f64, f64) {
    ((v.e - v.w) / (2.0 * dx), (v.n - v.s) / (2.0 * dx))
}

/// Where the gradient is degenerate: nu/4 times the sum of the four neighbours, less v each (erratum 3).
pub(super) fn average(p: &Parameters, v: &Around) -> f64 {
    let sum = v.e + v.n + v.w + v.s;
    match p.curvature_form {
        CurvatureForm::Consistent => p.nu / 4.0 * (sum - 4.0 * v.c),
        CurvatureForm::Printed => p.nu / 4.0 * sum,
    }
}

/// Lambda = k |grad u|, with the denominator |D^c|^2 (erratum 2).
fn lambda(v: &Around, dx: f64) -> f64 {
    let (x, y) = central(v, dx);
    let xx = (v.e - 2.0 * v.c + v.w) / (dx * dx);
    let yy = (v.n - 2.0 * v.c + v.s) / (dx * dx);
    let xy = (v.ne - v.nw - v.se + v.sw) / (4.0 * dx * dx);
    (xx * y * y - 2.0 * x * y * xy + yy * x * x) / (x * x + y * y)
}
