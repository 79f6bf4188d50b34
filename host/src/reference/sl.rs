//! `SLg`: the semi-Lagrangian scheme of u_t + g |grad u| = 0.

use super::{Parameters, Plane};
use std::f64::consts::TAU;

/// One time step.
pub(super) fn step(p: &Parameters, g: &Plane, v: &Plane) -> Plane {
    let directions = directions(p.directions);
    Plane::from_fn(v.width(), v.height(), |i, j| lowest(p, &directions, g.at(i, j), v, i, j))
}

/// The unit vectors (cos, sin)(2 pi k / count).
pub(super) fn directions(count: u32) -> Vec<(f64, f64)> {
    let angle = |k: u32| TAU * f64::from(k) / f64::from(count);
    (0..count).map(|k| (angle(k).cos(), angle(k).sin())).collect()
}

/// The minimum of the bilinear interpolant at x - dt g a, over the centre and the directions a.
pub(super) fn lowest(p: &Parameters, directions: &[(f64, f64)], g: f64, v: &Plane, i: isize, j: isize) -> f64 {
    let reach = p.dt * g / p.dx;
    let mut lowest = v.at(i, j);
    for (x, y) in directions {
        lowest = v.interpolate(i as f64 - reach * x, j as f64 - reach * y).min(lowest);
    }
    lowest
}
