//! The front (`default.md`, 4).

use super::super::Around;
use super::Plane;

/// u is kept within minus and plus this.
pub const BAND: f64 = 0.3;
/// The time of a step.
pub const STEP: f64 = 0.2;
/// No direction is taken where both central differences are below this.
pub const FLAT: f64 = 5e-4;

/// The front before it moves.
pub fn start(smooth: &Plane, threshold: f64) -> Plane {
    smooth.map(|v| (v - threshold).clamp(-BAND, BAND))
}

/// The front after a step.
pub fn step(u: &Plane, fine: &Plane, threshold: f64, nu: f64, flat: f64) -> Plane {
    Plane::from_fn(u.width(), u.height(), |i, j| {
        let (near, force) = (u.around(i, j), force(fine.at(i, j), threshold));
        (near.c + STEP * (force * steepness(&near, force) + nu * bend(&near, flat))).clamp(-BAND, BAND)
    })
}

/// F.
pub fn force(light: f64, threshold: f64) -> f64 {
    (light - threshold).clamp(-2.0, 2.0)
}

/// The upwind length of the gradient.
pub fn steepness(v: &Around, force: f64) -> f64 {
    let sign = if force > 0.0 { 1.0 } else { -1.0 };
    let axis = |before: f64, after: f64| (sign * (before - v.c)).max(sign * (after - v.c)).max(0.0);
    axis(v.w, v.e).hypot(axis(v.s, v.n))
}

/// `kappa |grad u|`.
fn bend(v: &Around, flat: f64) -> f64 {
    let (x, y) = ((v.e - v.w) / 2.0, (v.n - v.s) / 2.0);
    let (xx, yy) = (v.e - 2.0 * v.c + v.w, v.n - 2.0 * v.c + v.s);
    if x.abs() < flat && y.abs() < flat {
        return (xx + yy) / 4.0;
    }
    let xy = (v.ne + v.sw - v.nw - v.se) / 4.0;
    (xx * y * y - 2.0 * xy * x * y + yy * x * x) / (x * x + y * y)
}
