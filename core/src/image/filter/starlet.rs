//! The starlet: the isotropic undecimated wavelet transform of J.-L. Starck, J. Fadili and F.
//! Murtagh (doi:10.1109/TIP.2006.887733), of which only what is significant is kept.
//!
//! Scale j is the image smoothed by the cubic B-spline `(1, 4, 6, 4, 1) / 16` along rows and
//! columns, with `2^j - 1` holes between its values; its details are the scale before it minus
//! itself. Of the details `w` within `t`, so many standard deviations of their noise, nothing is
//! left, of others `w - t^2 / w`: the garrote of H.-Y. Gao (doi:10.1080/10618600.1998.10474677),
//! which bends where a hard threshold jumps. The noise is that of the first details: 1.4826 times
//! the median of their sizes.

use super::{Measured, Planes};
use crate::arithmetic::{Arithmetic, Real};
use crate::config::Filter;
use crate::plane::lattice::{self, Five, five_columns};
use crate::plane::rows::{row_of, row_of_mut};
use crate::sky::select;
use core::ops::Range;

/// Noise of the details of each scale, in units of that of the first, for noise without
/// correlation: the lengths of the differences of two of its smoothing kernels
/// (`the_noise_of_each_scale`).
const NOISE: [f32; 7] = [1.0, 0.225_263_45, 0.095_989_96, 0.046_270_34, 0.022_928_885, 0.011_438_933, 0.005_716_286];
/// A standard deviation of normal noise in medians of its size.
const OF_MEDIAN: f32 = 1.482_602_2;
/// Passes before the first scale, which measure the noise.
const MEASURING: u32 = select::PASSES;

/// A transform into as many scales as the filter has steps.
#[derive(Clone, Copy, Debug)]
pub struct Starlet {
    significance: f32,
}

/// What a pass does.
enum Pass {
    Measure,
    Scale(u32),
    Gather,
}

/// The noise, each scale, and the sum of what is kept; no scale without a noise.
const _: () = {
    let starlet = Filter::Starlet { significance: 0.0 };
    assert!(starlet.passes(1) == MEASURING + 2 && starlet.most_steps() as usize == NOISE.len());
};

impl Starlet {
    /// Details beyond `significance` standard deviations of their noise are kept.
    pub fn new(significance: f32) -> Self {
        Starlet { significance }
    }

    fn pass(pass: u32, scales: u16) -> Pass {
        match pass.checked_sub(MEASURING) {
            None => Pass::Measure,
            Some(scale) if scale < u32::from(scales) => Pass::Scale(scale),
            Some(_) => Pass::Gather,
        }
    }

    /// Whether a pass looks for the median size of the first details.
    pub const fn measures(pass: u32) -> bool {
        pass < MEASURING
    }

    /// Does some rows of a pass. The image plane goes from scale to scale; the spare one holds the
    /// image without the details that are not significant.
    #[inline(always)]
    pub fn rows<A: Arithmetic>(
        &self,
        planes: &mut Planes<'_, A::Cell>,
        (pass, scales): (u32, u16),
        measured: Measured<'_>,
        rows: Range<usize>,
    ) {
        let Planes { image, spare, ring, width } = planes;
        let width = *width;
        match Starlet::pass(pass, scales) {
            Pass::Measure => lattice::sweep(image, ring, width, 1, rows, |five| {
                smooth_along_columns::<A>(five.far_before, [five.before, five.centre, five.after, five.far_after]);
                let sizes = five.centre.iter().enumerate().map(|(x, &old)| {
                    let smooth = smooth_along_row::<A>(five.far_before, x, 1);
                    (A::pixel(old) - smooth).magnitude().to_f32()
                });
                measured.select.observe(measured.counts, sizes);
            }),
            Pass::Scale(scale) => {
                let limit = A::Real::of(self.limit(scale, measured.value));
                lattice::sweep(image, ring, width, 1 << scale, rows, |five| {
                    let kept = row_of_mut(spare, width, five.y);
                    if scale == 0 {
                        kept.iter_mut().zip(five.centre).for_each(|(kept, old)| *kept = *old);
                    }
                    scale_row::<A>(five, kept, 1 << scale, limit);
                });
            }
            Pass::Gather => {
                for y in rows {
                    let kept = row_of(spare, width, y);
                    row_of_mut(image, width, y).iter_mut().zip(kept).for_each(|(image, kept)| *image = *kept);
                }
            }
        }
    }

    /// The size up to which nothing is left of details, where the median size of the first is
    /// `median`.
    fn limit(&self, scale: u32, median: f32) -> f32 {
        let noise = NOISE.get(scale as usize).copied().unwrap_or(0.0);
        self.significance * (OF_MEDIAN * median) * noise
    }
}

/// The B-spline over four rows and `row`, which becomes the result.
#[inline(always)]
fn smooth_along_columns<A: Arithmetic>(row: &mut [A::Cell], [b, c, d, e]: [&[A::Cell]; 4]) {
    for ((((row, &b), &c), &d), &e) in row.iter_mut().zip(b).zip(c).zip(d).zip(e) {
        *row = A::to_pixel(spline::<A>([*row, b, c, d, e]));
    }
}

/// The B-spline along a row, in column `x`.
#[inline(always)]
fn smooth_along_row<A: Arithmetic>(row: &[A::Cell], x: usize, spacing: usize) -> A::Real {
    five_columns(row, x, spacing).map_or(A::Real::ZERO, spline::<A>)
}

/// `(1, 4, 6, 4, 1) / 16`.
#[inline(always)]
fn spline<A: Arithmetic>(cells: [A::Cell; 5]) -> A::Real {
    let [a, b, c, d, e] = cells.map(A::pixel);
    (a + e) * A::Real::of(0.0625) + ((b + d) * A::Real::of(0.25) + c * A::Real::of(0.375))
}

/// One row of the next scale, and what its details take away of the row that is kept.
#[inline(always)]
fn scale_row<A: Arithmetic>(five: Five<'_, A::Cell>, kept: &mut [A::Cell], spacing: usize, limit: A::Real) {
    let Five { far_before, before, centre, after, far_after, new, .. } = five;
    smooth_along_columns::<A>(far_before, [before, centre, after, far_after]);
    for (x, ((new, &old), kept)) in new.iter_mut().zip(centre).zip(kept).enumerate() {
        let smooth = smooth_along_row::<A>(far_before, x, spacing);
        let noise = insignificant::<A>(A::pixel(old) - smooth, limit);
        let value = A::pixel(*kept) - noise;
        *kept = A::to_pixel(value.positive().least(A::Real::ONE));
        *new = A::to_pixel(smooth);
    }
}

/// What is taken away of details: all up to `limit`, `limit^2 / details` beyond.
#[inline(always)]
fn insignificant<A: Arithmetic>(details: A::Real, limit: A::Real) -> A::Real {
    let size = details.magnitude();
    if size > limit {
        let taken = limit * limit.ratio(size);
        if details < A::Real::ZERO { -taken } else { taken }
    } else {
        details
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    extern crate std;
    use std::vec::Vec;

    #[test]
    fn the_spline_weighs_five_values() {
        assert_eq!(spline::<F32>([16.0, 8.0, 4.0, 2.0, 1.0]), 17.0 / 16.0 + 40.0 / 16.0 + 24.0 / 16.0);
    }

    /// The outer product of a kernel with itself is that of the plane: its sums are products of
    /// sums.
    #[test]
    fn the_noise_of_each_scale() {
        let mut kernel = std::vec![1.0f64];
        let mut first = None;
        for (scale, expected) in NOISE.into_iter().enumerate() {
            let mut next = std::vec![0.0; kernel.len() + (4 << scale)];
            for (tap, weight) in [1.0, 4.0, 6.0, 4.0, 1.0].into_iter().enumerate() {
                kernel.iter().enumerate().for_each(|(at, old)| next[at + (tap << scale)] += old * weight / 16.0);
            }
            let padded: Vec<f64> = (0..next.len())
                .map(|at| at.checked_sub(2 << scale))
                .map(|at| at.and_then(|at| kernel.get(at)).copied().unwrap_or(0.0))
                .collect();
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>().powi(2);
            let square = product(&padded, &padded) - 2.0 * product(&padded, &next) + product(&next, &next);
            let noise = square.sqrt() / *first.get_or_insert(square.sqrt());
            assert!((noise - f64::from(expected)).abs() < 1e-7, "scale {scale}: {noise}");
            kernel = next;
        }
    }

    #[test]
    fn the_garrote() {
        let taken = |details: f32| insignificant::<F32>(details, 0.2);
        assert_eq!([0.1, -0.1, 0.2].map(taken), [0.1, -0.1, 0.2]);
        assert_eq!([0.4, -0.4].map(taken), [0.1, -0.1]);
        assert_eq!(insignificant::<F32>(0.0, 0.0), 0.0);
    }
}
