//! Smoothing, the noise of what is smooth, and the mask of sources (`default.md`, 2 and 3).

use super::{Facts, Judge, Plane, median, neighbours, sample};

/// The weights of a Gaussian from its centre outwards.
fn gauss(scale: f64) -> Vec<f64> {
    let reach = (3.5 * scale).ceil() as i32;
    let weight = |n: i32| (-0.5 * (f64::from(n) / scale).powi(2)).exp();
    let all: f64 = (-reach..=reach).map(weight).sum();
    (0..=reach).map(|n| weight(n) / all).collect()
}

/// A place on an axis, mirrored at its ends.
fn mirrored(at: isize, length: usize) -> isize {
    let length = length as isize;
    let inside = if at < 0 { -1 - at } else { at.min(2 * length - 1 - at) };
    inside.clamp(0, length - 1)
}

fn convolved(plane: &Plane, weights: &[f64]) -> Plane {
    let (width, height) = (plane.width(), plane.height());
    let reach = weights.len() as isize - 1;
    let sum = |at: &dyn Fn(isize) -> f64| (-reach..=reach).map(|n| weights[n.unsigned_abs()] * at(n)).sum();
    let rows = Plane::from_fn(width, height, |i, j| sum(&|n| plane.at(mirrored(i + n, width), j)));
    Plane::from_fn(width, height, |i, j| sum(&|n| rows.at(i, mirrored(j + n, height))))
}

/// A plane smoothed by a Gaussian.
pub fn smoothed(plane: &Plane, scale: f64) -> Plane {
    convolved(plane, &gauss(scale))
}

/// A plane and a part of what a Gaussian takes from it.
pub fn sharpened(plane: &Plane, scale: f64, part: f64) -> Plane {
    let smooth = smoothed(plane, scale);
    Plane::from_fn(plane.width(), plane.height(), |i, j| plane.at(i, j) + part * (plane.at(i, j) - smooth.at(i, j)))
}

/// The fine image smoothed by the spline, and the least difference of the two that is kept.
pub fn spline(fine: &Plane, masked: &[bool], facts: &Facts) -> (Plane, f64) {
    let spline = convolved(fine, &[6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0]);
    let detail: Vec<f64> = fine.values().iter().zip(spline.values()).map(|(fine, smooth)| fine - smooth).collect();
    let least = 1.7 * Tail::of(&detail, masked, facts).noise;
    (spline, least)
}

/// Smoothed beyond the fine image where nothing significant is lost.
pub fn by_need(fine: &Plane, masked: &[bool], facts: &Facts) -> Plane {
    let (spline, least) = spline(fine, masked, facts);
    Plane::from_fn(fine.width(), fine.height(), |i, j| {
        let (fine, smooth) = (fine.at(i, j), spline.at(i, j));
        if (fine - smooth).abs() < least { smooth } else { fine }
    })
}

/// The noise of a smoothed plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tail {
    /// Its standard deviation.
    pub noise: f64,
    /// Its skewness.
    pub skewness: f64,
}

impl Tail {
    /// Of values where they are not masked.
    pub fn of(values: &[f64], masked: &[bool], facts: &Facts) -> Tail {
        let mut sky: Vec<f64> = sample(values.len()).filter(|&at| !masked[at]).map(|at| values[at]).collect();
        sky.sort_by(f64::total_cmp);
        let (n, half) = (sky.len(), sky.len() / 2);
        if n < 16 {
            return Tail { noise: 1.0, skewness: 0.0 };
        }
        let middle = median(&sky);
        let (lower, upper) = (middle - sky[half - 1 - half / 2], sky[n - half + half / 2] - middle);
        if !facts.cut_off && !facts.coarse {
            return Tail { noise: 1.4826 * lower, skewness: 0.0 };
        }
        let mut noise = 1.4826 * if facts.cut_off { lower.max(0.5 * (lower + upper)) } else { lower };
        if facts.coarse {
            let far = [(1000, 3.090232), (10_000, 3.719016), (30_000, 3.987879)];
            let far = far.map(|(parts, height)| (middle - sky[n / parts]) / height);
            noise = far.into_iter().fold(noise.max(clipped(&sky)), f64::max);
        }
        let all = values.iter().zip(masked).filter(|(_, masked)| !**masked).map(|(value, _)| *value);
        Tail { noise, skewness: skewness(&all.filter(|value| value.abs() <= 6.0 * noise).collect::<Vec<_>>()) }
    }

    /// So many noise units, raised for a long tail.
    pub fn raised(&self, z: f64) -> f64 {
        z + self.skewness * (z * z - 1.0) / 6.0
    }
}

/// The standard deviation of values within five of the mean, which is 1 at first.
fn clipped(values: &[f64]) -> f64 {
    let (mut mean, mut noise, mut kept) = (0.0, 1.0, 0);
    for _ in 0..10 {
        let near: Vec<f64> = values.iter().copied().filter(|v| (v - mean).abs() <= 5.0 * noise).collect();
        let mean_of = |f: &dyn Fn(f64) -> f64| near.iter().map(|&v| f(v)).sum::<f64>() / near.len().max(1) as f64;
        mean = mean_of(&|v| v);
        noise = mean_of(&|v| (v - mean).powi(2)).sqrt();
        if near.len() == kept {
            break;
        }
        kept = near.len();
    }
    noise
}

fn skewness(values: &[f64]) -> f64 {
    let mean_of = |f: &dyn Fn(f64) -> f64| values.iter().map(|&v| f(v)).sum::<f64>() / values.len().max(1) as f64;
    let mean = mean_of(&|v| v);
    let (variance, third) = (mean_of(&|v| (v - mean).powi(2)), mean_of(&|v| (v - mean).powi(3)));
    let skewness = if variance > 0.0 { third / variance.powf(1.5) } else { 0.0 };
    if skewness < 0.15 { 0.0 } else { skewness.min(2.5) }
}

/// The marks of sources, smoothed: above [`MASKED`] the sky is not looked at.
pub fn marks(fine: &Plane, smooth: &Plane, threshold: f64, peak: f64, judge: &Judge) -> Plane {
    let (width, height) = (fine.width(), fine.height());
    let above: Vec<bool> = smooth.values().iter().map(|&v| judge.exceeds(v, threshold)).collect();
    let mut marked: Vec<bool> =
        fine.values().iter().zip(&above).map(|(&v, &above)| above && judge.exceeds(v, peak)).collect();
    let forwards = || 0..width * height;
    for at in forwards().chain(forwards().rev()).chain(forwards()) {
        marked[at] |= above[at] && neighbours(at, width, height, 8).into_iter().any(|near| marked[near]);
    }
    let ones = Plane::from_fn(width, height, |i, j| f64::from(u8::from(marked[j as usize * width + i as usize])));
    smoothed(&ones, 2.0)
}

/// What smoothed marks are above where the sky is not looked at.
pub const MASKED: f64 = 0.2;
