//! The filtered scheme of Falcone, Paolucci and Tozza (arXiv:1812.03026) for u_t + g |grad u| = 0: the monotone step of
//! `DFg`, and that of Lax and Wendroff where the two are near each other.

use super::fd_curvature::central;
use super::plane::Around;
use super::{Parameters, Plane, fd};

/// One time step.
pub(super) fn step(p: &Parameters, g: &Plane, v: &Plane) -> Plane {
    let share = (2.5 * p.dx).min(0.25);
    Plane::from_fn(v.width(), v.height(), |i, j| {
        let (v, g) = (v.around(i, j), g.around(i, j));
        let slope = fd::upwind(&v, p.dx);
        let monotone = v.c - p.dt * g.c * slope;
        let tolerance = share * g.c * slope * p.dt;
        match second_order(p, &g, &v) {
            Some(fine) if tolerance > 0.0 => monotone + tolerance * filter((fine - monotone) / tolerance),
            _ => monotone,
        }
    })
}

/// Taylor's expansion to dt^2: u_t = -g |Du| and u_tt = g n.D(g |Du|) with the unit normal n, by central differences.
/// `None` where the gradient vanishes.
fn second_order(p: &Parameters, g: &Around, v: &Around) -> Option<f64> {
    let (ux, uy) = central(v, p.dx);
    let (gx, gy) = central(g, p.dx);
    let slope = ux.hypot(uy);
    if slope <= 0.0 {
        return None;
    }
    let uxx = (v.e - 2.0 * v.c + v.w) / (p.dx * p.dx);
    let uyy = (v.n - 2.0 * v.c + v.s) / (p.dx * p.dx);
    let uxy = (v.ne - v.nw - v.se + v.sw) / (4.0 * p.dx * p.dx);
    // D|Du| = (D^2 u) n.
    let slope_x = (uxx * ux + uxy * uy) / slope;
    let slope_y = (uxy * ux + uyy * uy) / slope;
    let along = ((gx * slope + g.c * slope_x) * ux + (gy * slope + g.c * slope_y) * uy) / slope;
    Some(v.c - p.dt * g.c * slope + p.dt * p.dt / 2.0 * g.c * along)
}

/// The filter of Froese and Oberman (arXiv:1204.5798): x near 0, 0 far from it, continuous.
fn filter(x: f64) -> f64 {
    if x.abs() <= 1.0 { x } else { x.signum() * (2.0 - x.abs()).max(0.0) }
}
