//! The bilateral filter of C. Tomasi and R. Manduchi (doi:10.1109/ICCV.1998.710815): a mean over
//! neighbours that are near in place and near in brightness, so that noise is averaged and steps
//! higher than it are kept.

use super::window::Window;
use crate::arithmetic::{Arithmetic, Real};
use core::f32::consts::FRAC_1_SQRT_2;

/// Weights of places by a Gaussian of one pixel, `exp(-d^2 / 2)`: those of a row and column away.
const NEAR: [f32; 3] = [1.0, 0.606_530_66, 0.135_335_28];

/// Each pixel moves by the mean of its differences d to the 5 x 5 pixels around it, weighted by the
/// place and by `exp(-d^2 / (2 contrast^2))`.
#[derive(Clone, Copy, Debug)]
pub struct Bilateral<A: Arithmetic> {
    /// `1 / (sqrt 2 contrast)`.
    sharpness: A::Real,
    near: [A::Real; 3],
}

impl<A: Arithmetic> Bilateral<A> {
    /// `contrast` is the difference, in image units (0 to 1), from which pixels count less: a few
    /// times the noise.
    pub fn new(contrast: f32) -> Self {
        Bilateral { sharpness: A::Real::of(FRAC_1_SQRT_2 / contrast), near: NEAR.map(A::Real::of) }
    }
}

impl<A: Arithmetic> Window<A> for Bilateral<A> {
    #[inline(always)]
    fn pixel(&self, around: [[A::Real; 5]; 5]) -> A::Real {
        let [_, _, [_, _, centre, _, _], _, _] = around;
        let [zero, one, two] = self.near;
        let along = [two, one, zero, one, two];
        let (mut weights, mut sum) = (A::Real::ZERO, A::Real::ZERO);
        for (row, across) in around.into_iter().zip(along) {
            for (value, along) in row.into_iter().zip(along) {
                let d = value - centre;
                let s = d * self.sharpness;
                let weight = (across * along) * A::exp_neg(s * s);
                weights = weights + weight;
                sum = sum + weight * d;
            }
        }
        centre + sum.ratio(weights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::{F32, Q24};

    fn filtered<A: Arithmetic>(contrast: f32, around: [[f32; 5]; 5]) -> f32 {
        let around = around.map(|row| row.map(A::Real::of));
        Window::<A>::pixel(&Bilateral::<A>::new(contrast), around).to_f32()
    }

    /// A step much higher than the contrast stays; of one much lower only the mean by places is
    /// left.
    #[test]
    fn steps_are_kept_and_ripples_are_not() {
        let mut around = [[0.2; 5]; 5];
        around.iter_mut().for_each(|row| row[3..].fill(0.8));
        assert!((filtered::<F32>(0.05, around) - 0.2).abs() < 1e-6);
        assert!((filtered::<Q24>(0.05, around) - 0.2).abs() < 1e-6);
        let beside = (0.606_530_66 + 0.135_335_28) / (1.0 + 2.0 * (0.606_530_66 + 0.135_335_28));
        assert!((filtered::<F32>(1e3, around) - (0.2 + 0.6 * beside)).abs() < 1e-6);
    }
}
