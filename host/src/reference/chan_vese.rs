//! Active contours without edges (T. F. Chan, L. A. Vese 2001, DOI 10.1109/83.902291), with H(v) = (1 + v) / 2 for v in
//! \[-1, 1\], v = u counted in pixels; and of vector-valued images (T. F. Chan, B. Y. Sandberg, L. A. Vese 2000, DOI
//! 10.1006/jvci.1999.0442), whose bands here have the same lambdas.

use super::initial::half_side;
use super::plane::Around;
use super::{Parameters, Plane};

/// One semi-implicit time step; `bands` are what the regions are told apart by, one image or several of one size.
pub fn step(p: &Parameters, bands: &[Plane], u: &Plane) -> Plane {
    let half = half_side(u);
    let v = u.map(|u| u * half);
    let means: Vec<(f64, f64)> = bands.iter().map(|band| means(band, &v)).collect();
    Plane::from_fn(v.width(), v.height(), |i, j| {
        let all = bands.iter().zip(&means).map(|(band, (c1, c2))| {
            let level = band.at(i, j);
            -p.lambda.0 * (level - c1).powi(2) + p.lambda.1 * (level - c2).powi(2)
        });
        pull(p, &v.around(i, j), all.sum::<f64>() / bands.len() as f64) / half
    })
}

/// What a force and the length of the contours make of v in a semi-implicit time step.
pub(super) fn pull(p: &Parameters, near: &Around, force: f64) -> f64 {
    let (flow, weights) = length(p, near);
    let mu = p.mu / p.dx;
    let next = near.c + p.dt * (force + mu * flow) / (1.0 + 2.0 * p.dt * mu * weights);
    next.clamp(-1.0, 1.0)
}

/// c1 and c2: the means of the image with the weights H and 1 - H; 1 and 0 for a region without pixels.
fn means(image: &Plane, v: &Plane) -> (f64, f64) {
    let mean = |weight: fn(f64) -> f64, none: f64| {
        let weights = v.values().iter().map(|&v| weight(v));
        let light = image.values().iter().zip(weights.clone()).map(|(level, weight)| level * weight).sum::<f64>();
        let all = weights.sum::<f64>();
        if all > 0.0 { light / all } else { none }
    };
    (mean(|v| 0.5 * (1.0 + v), 1.0), mean(|v| 0.5 * (1.0 - v), 0.0))
}

/// What the length of the contours pulls v by, and the sum of the weights of its neighbours in that. The gradient is
/// that of a square of four pixels: the root mean square of its two differences along each axis.
fn length(p: &Parameters, v: &Around) -> (f64, f64) {
    let (mut flow, mut weights) = (0.0, 0.0);
    for (x, y, corner) in [(v.w, v.s, v.sw), (v.e, v.s, v.se), (v.w, v.n, v.nw), (v.e, v.n, v.ne)] {
        let along_x = ((x - v.c).powi(2) + (corner - y).powi(2)) / 2.0;
        let along_y = ((y - v.c).powi(2) + (corner - x).powi(2)) / 2.0;
        let slope = (along_x + along_y).sqrt().max(p.degenerate_c);
        flow += (x - v.c + y - v.c) / (2.0 * slope);
        weights += 1.0 / slope;
    }
    (flow, weights)
}
