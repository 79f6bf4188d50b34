//! What keeps a banded front narrow (ours): both sides are drawn out towards their ends.

use super::Plane;

/// How far below zero a banded front goes, in pixels.
const FLOOR: f64 = 1.5;

/// The front after a step, values in pixels: above half the band and below half the floor they grow away from zero by
/// 0.5 / limit^2 of what they are beyond it, and end at the band and the floor.
pub fn settle(front: &Plane, band: f64) -> Plane {
    let growth = |beyond: f64, limit: f64| 0.5 / (limit * limit) * (beyond - limit / 2.0).max(0.0);
    front.map(|v| (v + growth(v, band) - growth(-v, FLOOR)).clamp(-FLOOR, band))
}
