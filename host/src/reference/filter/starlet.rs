//! Starlet transform and its significant details: J.-L. Starck, J. Fadili and F. Murtagh 2007 (DOI
//! 10.1109/TIP.2006.887733), shrunk by the garrote of H.-Y. Gao 1998 (DOI
//! 10.1080/10618600.1998.10474677).

use super::super::Plane;
use super::Filtering;

/// The B3 spline.
const SPLINE: [f64; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];

/// A pass: one scale, or after the last of them the sum of what is kept. `first` is the image
/// before the filter, of whose finest details the noise is told.
pub(super) fn pass(significance: f64, scales: u32, pass: u32, first: &Plane, now: &Filtering) -> Filtering {
    let kept = now.kept.first().filter(|_| pass > 0).unwrap_or(&now.image);
    if pass >= scales {
        return Filtering { image: kept.clone(), kept: now.kept.clone() };
    }
    let next = smooth(&now.image, 1 << pass);
    let limit = significance * noise(first) * scale_noise(pass);
    let new = Plane::from_fn(next.width(), next.height(), |i, j| {
        let w = now.image.at(i, j) - next.at(i, j);
        let shrunk = if w.abs() <= limit { 0.0 } else { w - limit * limit / w };
        (kept.at(i, j) - (w - shrunk)).clamp(0.0, 1.0)
    });
    Filtering { image: next, kept: vec![new] }
}

/// c(j+1) of c(j), with holes between the values of the kernel.
fn smooth(image: &Plane, spacing: isize) -> Plane {
    let (width, height) = (image.width() as isize, image.height() as isize);
    let along_columns = Plane::from_fn(image.width(), image.height(), |i, j| {
        (-2..=2).zip(SPLINE).map(|(tap, h)| h * image.at(i, inside(j, tap, spacing, height))).sum()
    });
    Plane::from_fn(image.width(), image.height(), |i, j| {
        (-2..=2).zip(SPLINE).map(|(tap, h)| h * along_columns.at(inside(i, tap, spacing, width), j)).sum()
    })
}

/// The place so many spacings away from `at`; where that is outside, the last one before it is
/// repeated.
fn inside(at: isize, taps: isize, spacing: isize, length: isize) -> isize {
    let mut taps = taps;
    while !(0..length).contains(&(at + taps * spacing)) {
        taps -= taps.signum();
    }
    at + taps * spacing
}

/// The noise of the first details by the median of their sizes.
fn noise(image: &Plane) -> f64 {
    let next = smooth(image, 1);
    let mut sizes: Vec<f64> = image.values().iter().zip(next.values()).map(|(a, b)| (a - b).abs()).collect();
    sizes.sort_by(f64::total_cmp);
    1.482_602_218_505_602 * sizes[(sizes.len() - 1) / 2]
}

/// Noise of the details of a scale in units of that of the first, for independent noise: from the
/// kernels themselves.
pub fn scale_noise(scale: u32) -> f64 {
    let (mut kernel, mut first) = (vec![1.0], None);
    for j in 0.. {
        let mut next = vec![0.0; kernel.len() + (4 << j)];
        for (tap, h) in SPLINE.into_iter().enumerate() {
            for (at, old) in kernel.iter().enumerate() {
                next[at + (tap << j)] += h * old;
            }
        }
        let sum = |f: &dyn Fn(usize) -> f64| (0..next.len()).map(f).sum::<f64>();
        let old = |at: usize| at.checked_sub(2 << j).and_then(|at| kernel.get(at)).copied().unwrap_or(0.0);
        // Of outer products of a kernel with itself.
        let [aa, ab, bb] =
            [sum(&|at| old(at) * old(at)), sum(&|at| old(at) * next[at]), sum(&|at| next[at] * next[at])];
        let length = (aa * aa - 2.0 * ab * ab + bb * bb).sqrt();
        let one = *first.get_or_insert(length);
        if j == scale {
            return length / one;
        }
        kernel = next;
    }
    unreachable!("a scale is reached")
}
