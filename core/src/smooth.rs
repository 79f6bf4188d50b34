//! Smoothing of a whole plane by a separable kernel, mirrored at the borders, and the noise
//! that is left in it.

use crate::sky::median;

/// The most weights of a kernel on one side of its centre.
pub const RADIUS: usize = 12;

/// A symmetric kernel: the weight of the centre, then outwards; sums to 1 over both sides.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    weights: [f32; RADIUS + 1],
    radius: usize,
}

impl Weights {
    /// The cubic spline of the a trous transform (Starck and Murtagh 2006, Astronomical Image and
    /// Data Analysis): 1, 4, 6, 4, 1 over 16.
    pub const SPLINE: Weights = Weights {
        weights: [6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        radius: 2,
    };

    /// A Gaussian of standard deviation `scale` in pixels, at most 3.4, cut at 3.5 of them.
    pub fn gauss(scale: f32) -> Weights {
        let radius = (libm::ceilf(3.5 * scale) as usize).clamp(1, RADIUS);
        let mut weights = [0.0; RADIUS + 1];
        let mut total = 0.0;
        for (index, weight) in weights.iter_mut().enumerate().take(radius + 1) {
            let distance = index as f32 / scale;
            *weight = libm::expf(-0.5 * distance * distance);
            total += if index == 0 { *weight } else { 2.0 * *weight };
        }
        weights.iter_mut().for_each(|weight| *weight /= total);
        Weights { weights, radius }
    }

    fn value(&self, at: usize, length: usize, sample: impl Fn(usize) -> f32) -> f32 {
        let mut sum = sample(at) * self.weights.first().copied().unwrap_or(1.0);
        for (distance, &weight) in self.weights.iter().enumerate().take(self.radius + 1).skip(1) {
            let below = if at >= distance { at - distance } else { distance - at - 1 };
            let above = if at + distance < length { at + distance } else { 2 * length - 1 - at - distance };
            sum += weight * (sample(below.min(length - 1)) + sample(above.min(length - 1)));
        }
        sum
    }

    /// Smooths `from` into `to`, both W x H; `between` holds the plane smoothed along its rows.
    /// Cost: `4 radius` additions a pixel.
    pub fn apply(&self, from: &[f32], between: &mut [f32], to: &mut [f32], width: usize) {
        for (row, out) in from.chunks_exact(width).zip(between.chunks_exact_mut(width)) {
            for (x, out) in out.iter_mut().enumerate() {
                *out = self.value(x, width, |x| row.get(x).copied().unwrap_or(0.0));
            }
        }
        let height = from.len() / width;
        for (y, out) in to.chunks_exact_mut(width).enumerate() {
            for (x, out) in out.iter_mut().enumerate() {
                *out = self.value(y, height, |y| between.get(y * width + x).copied().unwrap_or(0.0));
            }
        }
    }
}

/// Standard deviation of a plane's noise where `masked` is not above 0, from the lower half of
/// its values: sources are positive. `values` is as long as the plane.
pub fn noise(plane: impl Iterator<Item = f32>, masked: &[f32], values: &mut [f32]) -> f32 {
    let mut count = 0;
    for (value, _) in plane.zip(masked).filter(|(_, mask)| **mask <= 0.0) {
        if let Some(out) = values.get_mut(count) {
            *out = value;
            count += 1;
        }
    }
    if count < 16 {
        return 1.0;
    }
    let values = values.get_mut(..count).unwrap_or(&mut []);
    let centre = median(values);
    let (lower, _, _) = values.select_nth_unstable_by(count / 2, f32::total_cmp);
    lower.iter_mut().for_each(|value| *value = centre - *value);
    1.4826 * median(lower)
}
