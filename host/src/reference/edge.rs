//! Step 4: the edge detector, a decreasing function of |grad I|.

use super::{Edge, Plane};

/// |grad I| by central differences with replicated edge pixels.
pub fn gradient(image: &Plane, dx: f64) -> Plane {
    Plane::from_fn(image.width(), image.height(), |i, j| {
        let image = image.around(i, j);
        let x = (image.e - image.w) / (2.0 * dx);
        let y = (image.n - image.s) / (2.0 * dx);
        (x * x + y * y).sqrt()
    })
}

/// m and M: the smallest and the largest |grad I|.
pub fn gradient_range(slope: &Plane) -> (f64, f64) {
    let values = slope.values().iter();
    values.fold((f64::INFINITY, 0.0), |(m, big_m), &z| (m.min(z), big_m.max(z)))
}

/// g of every |grad I|. A plane of equal gradients has no edge: g2 is 1 there.
pub fn detector(edge: Edge, slope: &Plane, m: f64, big_m: f64) -> Plane {
    let g2 = |z: f64| {
        if big_m > m { 1.0 - (z - m) / (big_m - m) } else { 1.0 }
    };
    slope.map(|z| match edge {
        // `g1`. z^p overflows to infinity for z > 1 and large p, and 1/infinity is exactly 0 (erratum 7).
        Edge::G1 { p } => 1.0 / (1.0 + z.powf(p)),
        Edge::G2 => g2(z),
        Edge::G2Mod { c2 } => (g2(z) - c2).max(0.0) / (1.0 - c2),
    })
}
