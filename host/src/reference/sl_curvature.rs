//! `SLgk`: the semi-Lagrangian scheme of u_t + g |grad u| = nu g k |grad u|.

use super::fd_curvature::{average, central};
use super::sl::{directions, lowest};
use super::{CurvatureForm, Parameters, Plane};
use std::f64::consts::SQRT_2;

/// One time step.
pub(super) fn step(p: &Parameters, g: &Plane, v: &Plane) -> Plane {
    let directions = directions(p.directions);
    let threshold = p.degenerate_c * p.dx.powf(p.degenerate_s);
    Plane::from_fn(v.width(), v.height(), |i, j| {
        let front = lowest(p, &directions, g.at(i, j), v, i, j);
        let near = v.around(i, j);
        let (x, y) = central(&near, p.dx);
        let length = (x * x + y * y).sqrt();
        let turn = if length <= threshold {
            average(p, &near)
        } else {
            along(p, v, i, j, (SQRT_2 * y / length, -SQRT_2 * x / length))
        };
        front + g.at(i, j) * turn
    })
}

/// nu times the mean of the interpolant at the two ends x +- sigma sqrt(dt) of the tangent, less v (erratum 3).
fn along(p: &Parameters, v: &Plane, i: isize, j: isize, sigma: (f64, f64)) -> f64 {
    let reach = p.dt.sqrt() / p.dx;
    let (x, y) = (sigma.0 * reach, sigma.1 * reach);
    let ahead = v.interpolate(i as f64 + x, j as f64 + y);
    let behind = v.interpolate(i as f64 - x, j as f64 - y);
    match p.curvature_form {
        CurvatureForm::Consistent => p.nu * ((ahead + behind) / 2.0 - v.at(i, j)),
        CurvatureForm::Printed => p.nu / 2.0 * (ahead + behind),
    }
}
