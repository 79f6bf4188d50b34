//! Step 5, its start: the front's u0, in the frame or near the objects.

use super::{Parameters, Plane, Scheme};

/// Smallest width and height: the zero level of u0 lies two pixels inside the border.
pub(super) const LEAST_SIDE: usize = 5;

/// u0: a pyramid over the grid whose zero level is the rectangle two pixels inside the frame's border (erratum 1).
pub fn initial(width: usize, height: usize, dx: f64) -> Plane {
    let centre = |n: usize| (n as f64 - 1.0) * dx / 2.0;
    let half = |n: usize| n as f64 * dx / 2.0 - 2.0 * dx;
    Plane::from_fn(width, height, |i, j| {
        let x = (i as f64 * dx - centre(width)).abs() / half(width);
        let y = (j as f64 * dx - centre(height)).abs() / half(height);
        1.0 - x.max(y)
    })
}

/// Half the shorter side of the rectangle that u0 is positive in: the pixels in one unit of u0.
pub fn half_side(plane: &Plane) -> f64 {
    plane.width().min(plane.height()) as f64 / 2.0 - 2.0
}

/// u0 saturated at `band` pixels from the front, counted along the shorter side of the frame.
pub fn saturated(u0: &Plane, band: f64) -> Plane {
    let half = half_side(u0);
    u0.map(|v| v.clamp(-band / half, band / half))
}

/// The band of a front: one pixel on each side for the regions of Chan and Vese.
fn band_of(p: &Parameters) -> Option<f64> {
    match p.scheme {
        Scheme::ChanVese => Some(1.0),
        // Times are in pixels, with a band or without.
        Scheme::FastMarching => p.band.or(Some(f64::INFINITY)),
        _ => p.band,
    }
}

/// The paper's u0; in a band (ours) the distance to its rectangle in pixels, along the nearer axis, from 1.5 pixels
/// outside to the band.
pub fn framed(p: &Parameters, width: usize, height: usize) -> Plane {
    let Some(band) = band_of(p) else { return initial(width, height, p.dx) };
    let depth = |at: isize, n: usize| (n as f64 - 1.0) / 2.0 - (at as f64 - (n as f64 - 1.0) / 2.0).abs() - 1.5;
    let distance = Plane::from_fn(width, height, |i, j| depth(i, width).min(depth(j, height)));
    let floor = if p.scheme == Scheme::ChanVese { 1.0 } else { 1.5 };
    distance.map(|d| d.clamp(-floor, band) / half_side(&distance))
}

/// u0 `margin` pixels outside the nodes above `level`, in the band of the parameters.
pub fn near(p: &Parameters, image: &Plane, level: f64, margin: f64) -> Plane {
    let near = outside(image, level, margin);
    match band_of(p) {
        Some(band) if p.scheme == Scheme::ChanVese => saturated(&near, band),
        Some(band) => near.map(|v| v.min(band / half_side(&near))),
        None => near,
    }
}

/// u0 near the objects: the distance from `margin` pixels outside the nodes above `level` in steps of 1 and sqrt 2
/// pixels, at least -1.5 pixels, in the unit of the paper's u0.
fn outside(image: &Plane, level: f64, margin: f64) -> Plane {
    let half = half_side(image);
    let mut distance = image.map(|v| if v > level { 0.0 } else { f64::INFINITY });
    for _ in 0..(margin + 2.0) as usize {
        distance = Plane::from_fn(image.width(), image.height(), |i, j| {
            let near = distance.around(i, j);
            let side = near.e.min(near.w).min(near.n).min(near.s) + 1.0;
            let corner = near.ne.min(near.nw).min(near.se).min(near.sw) + 2f64.sqrt();
            near.c.min(side).min(corner)
        });
    }
    distance.map(|d| (margin - d).max(-1.5) / half)
}
