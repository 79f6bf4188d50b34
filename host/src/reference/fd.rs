//! `DFg`: first-order finite differences of u_t + g |grad u| = 0.

use super::plane::Around;
use super::{Parameters, Plane};

/// One time step.
pub(super) fn step(p: &Parameters, g: &Plane, v: &Plane) -> Plane {
    Plane::from_fn(v.width(), v.height(), |i, j| {
        let v = v.around(i, j);
        v.c - p.dt * g.at(i, j) * upwind(&v, p.dx)
    })
}

/// The paper's nabla+, the upwind |grad u| of a front that moves outwards.
pub(super) fn upwind(v: &Around, dx: f64) -> f64 {
    let minus_x = (v.c - v.w) / dx;
    let plus_x = (v.e - v.c) / dx;
    let minus_y = (v.c - v.s) / dx;
    let plus_y = (v.n - v.c) / dx;
    let squares =
        minus_x.max(0.0).powi(2) + plus_x.min(0.0).powi(2) + minus_y.max(0.0).powi(2) + plus_y.min(0.0).powi(2);
    squares.sqrt()
}
