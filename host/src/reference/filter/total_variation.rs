//! Total variation (L. I. Rudin, S. Osher, E. Fatemi 1992, DOI 10.1016/0167-2789(92)90242-F) by the
//! projection of A. Chambolle 2004 (DOI 10.1023/B:JMIV.0000011325.36760.1e), in his notation: tau =
//! 1/4, lambda the weight.

use super::super::Plane;
use super::Filtering;

const TAU: f64 = 0.25;

/// A pass: one step of p, or after the last of them the result `f - lambda div p`. The image stays
/// f until then.
pub(super) fn pass(lambda: f64, steps: u32, pass: u32, now: &Filtering) -> Filtering {
    let f = &now.image;
    let (width, height) = (f.width(), f.height());
    let zero = f.map(|_| 0.0);
    let (x, y) = match &now.kept[..] {
        [x, y] if pass > 0 => (x, y),
        _ => (&zero, &zero),
    };
    if pass >= steps {
        let u = Plane::from_fn(width, height, |i, j| (f.at(i, j) - lambda * divergence(x, y, i, j)).clamp(0.0, 1.0));
        return Filtering { image: u, kept: now.kept.clone() };
    }
    let force = Plane::from_fn(width, height, |i, j| divergence(x, y, i, j) - f.at(i, j) / lambda);
    // Beyond the last column and row the nearest answers, so that the forward difference is 0.
    let gradient = |i: isize, j: isize| {
        let own = force.at(i, j);
        (force.at(i + 1, j) - own, force.at(i, j + 1) - own)
    };
    let step = |p: &Plane, part: fn((f64, f64)) -> f64| {
        Plane::from_fn(width, height, |i, j| {
            let d = gradient(i, j);
            (p.at(i, j) + TAU * part(d)) / (1.0 + TAU * d.0.hypot(d.1))
        })
    };
    Filtering { image: f.clone(), kept: vec![step(x, |d| d.0), step(y, |d| d.1)] }
}

/// Backward differences, 0 outside.
fn divergence(x: &Plane, y: &Plane, i: isize, j: isize) -> f64 {
    let left = if i > 0 { x.at(i - 1, j) } else { 0.0 };
    let below = if j > 0 { y.at(i, j - 1) } else { 0.0 };
    (x.at(i, j) - left) + (y.at(i, j) - below)
}
