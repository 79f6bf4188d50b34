//! Total variation: the image of least variation near the given one (L. I. Rudin, S. Osher, E.
//! Fatemi, doi:10.1016/0167-2789(92)90242-F), by the projection of A. Chambolle
//! (doi:10.1023/B:JMIV.0000011325.36760.1e).
//!
//! The result is `f - weight div p`, where the field p of vectors no longer than 1 comes from 0 by
//! `p + tau d` over `1 + tau |d|`, d the gradient of `div p - f / weight`, as often as the filter
//! has steps. f stays in the image plane; p lies in the front plane, two numbers of 15 bits per
//! cell. A step of p below half of these is none: the result may keep slopes of `weight / 8192` per
//! pixel where the model's is flat.

use super::Planes;
use crate::arithmetic::{Arithmetic, Bits, Real};
use crate::plane::rows::{row_of, row_of_mut};
use core::ops::Range;

/// Chambolle's step; he proves 1/8, and finds that 1/4 does best.
const TAU: f32 = 0.25;
/// Steps of a component of p from 0 to 1.
const UNIT: f32 = 16_384.0;
const COMPONENT: u32 = 15;

/// The filter of a weight.
#[derive(Clone, Copy, Debug)]
pub struct TotalVariation<A: Arithmetic> {
    weight: A::Real,
    /// `1 / weight`.
    fidelity: A::Real,
}

/// The components of p in a cell, along a row and across rows.
pub fn components<R: Real>(cell: impl Bits) -> [R; 2] {
    let bits = cell.bits();
    [bits >> COMPONENT, bits].map(|bits| {
        let steps = (bits & ((1 << COMPONENT) - 1)) as f32;
        R::of((steps - UNIT) * (1.0 / UNIT))
    })
}

/// A cell of two components, each to the nearest of its steps; no pattern of an infinity or NaN.
fn cell<R: Real, C: Bits>(components: [R; 2]) -> C {
    let [x, y] = components.map(|value| {
        let steps = (value.to_f32() * UNIT + (UNIT + 0.5)) as u32;
        steps.clamp(1, (1 << COMPONENT) - 1)
    });
    C::from_bits(x << COMPONENT | y)
}

impl<A: Arithmetic> TotalVariation<A> {
    /// `weight` in image units (0 to 1): a plateau of r pixels comes down by `2 weight / r`.
    pub fn new(weight: f32) -> Self {
        TotalVariation { weight: A::Real::of(weight), fidelity: A::Real::of(1.0 / weight) }
    }

    /// Does some rows of a pass.
    #[inline(always)]
    pub fn rows(&self, planes: &mut Planes<'_, A::Cell>, (pass, steps): (u32, u16), rows: Range<usize>) {
        let Planes { image, spare, ring, width } = planes;
        let (width, height) = (*width, image.len() / (*width).max(1));
        if pass >= u32::from(steps) {
            for y in rows {
                let image = row_of_mut(image, width, y);
                each_divergence::<A>(spare, width, y, image, |image, divergence| {
                    let value = A::pixel(*image) - self.weight * divergence;
                    *image = A::to_pixel(value.positive().least(A::Real::ONE));
                });
            }
            return;
        }
        let (one, rest) = ring.split_at_mut_checked(width).unwrap_or((&mut [], &mut []));
        let two = rest.get_mut(..width).unwrap_or(&mut []);
        for y in rows {
            let (own, next) = if y % 2 == 0 { (&mut *one, &mut *two) } else { (&mut *two, &mut *one) };
            if y == 0 {
                self.force_row(image, spare, width, 0, pass, own);
            }
            let after = y.saturating_add(1);
            if after < height {
                self.force_row(image, spare, width, after, pass, next);
            }
            let across = if after < height { &*next } else { &*own };
            step_row::<A>(pass, own, across, row_of_mut(spare, width, y));
        }
    }

    /// `div p - f / weight` of row `y`, whose gradient moves p.
    fn force_row(
        &self,
        image: &[A::Cell],
        field: &[A::Cell],
        width: usize,
        y: usize,
        pass: u32,
        force: &mut [A::Cell],
    ) {
        let image = row_of(image, width, y);
        if pass == 0 {
            // p is 0, whatever the plane holds.
            for (force, &f) in force.iter_mut().zip(image) {
                *force = A::to_level(-(A::pixel(f) * self.fidelity));
            }
            return;
        }
        let mut pixels = image.iter();
        each_divergence::<A>(field, width, y, force, |force, divergence| {
            let f = pixels.next().map_or(A::Real::ZERO, |&f| A::pixel(f));
            *force = A::to_level(divergence - f * self.fidelity);
        });
    }
}

/// Gives `each` the cells of `row`, row `y` of some plane, with the divergence of the field there.
#[inline(always)]
fn each_divergence<A: Arithmetic>(
    field: &[A::Cell],
    width: usize,
    y: usize,
    row: &mut [A::Cell],
    mut each: impl FnMut(&mut A::Cell, A::Real),
) {
    let (own, below) = (row_of(field, width, y), y.checked_sub(1).map_or(&[][..], |y| row_of(field, width, y)));
    let mut left = A::Real::ZERO;
    let below = below.iter().map(Some).chain(core::iter::repeat(None));
    for ((cell, &own), below) in row.iter_mut().zip(own).zip(below) {
        let [x, y] = components::<A::Real>(own);
        let [_, y_below] = below.map_or([A::Real::ZERO; 2], |&cell| components(cell));
        each(cell, (x - left) + (y - y_below));
        left = x;
    }
}

/// One row of the next p. Beyond the last column and row the force is repeated: no gradient leads
/// there.
#[inline(always)]
fn step_row<A: Arithmetic>(pass: u32, force: &[A::Cell], across: &[A::Cell], field: &mut [A::Cell]) {
    let tau = A::Real::of(TAU);
    let along = force.iter().skip(1).chain(force.last());
    for (((field, &own), &along), &across) in field.iter_mut().zip(force).zip(along).zip(across) {
        let own = A::level(own);
        let (dx, dy) = (A::level(along) - own, A::level(across) - own);
        let [x, y] = if pass == 0 { [A::Real::ZERO; 2] } else { components(*field) };
        let divisor = A::Real::ONE + tau * A::norm(dx, dy, A::Real::ZERO, A::Real::ZERO);
        *field = cell([(x + tau * dx).ratio(divisor), (y + tau * dy).ratio(divisor)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::{F32, Fixed24, Q24};

    extern crate std;
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn a_cell_holds_two_components() {
        for x in [-1.0, -0.5, 0.0, 0.25, 0.999] {
            for y in [-0.75, 0.125, 0.6, 0.999] {
                let near = |[a, b]: [f32; 2]| (a - x).abs() <= 0.5 / UNIT + 1e-7 && (b - y).abs() <= 0.5 / UNIT + 1e-7;
                let packed: f32 = cell([x, y]);
                assert!(packed.is_finite() && (x == -1.0 || near(components(packed))), "{x} {y}");
                let packed: Fixed24 = cell([Fixed24::of(x), Fixed24::of(y)]);
                assert!(x == -1.0 || near(components(packed)), "{x} {y}");
            }
        }
    }

    fn filtered<A: Arithmetic>(weight: f32, steps: u16, image: &[f32], width: usize) -> Vec<f32> {
        let mut cells: Vec<A::Cell> = image.iter().map(|&value| A::to_pixel(A::Real::of(value))).collect();
        let mut spare = vec![A::Cell::from_bits(0x1234_5678); image.len()];
        let mut ring = vec![A::Cell::from_bits(0); 3 * width];
        let filter = TotalVariation::<A>::new(weight);
        // The last pass is that to the result.
        for pass in 0..=u32::from(steps) {
            for y in 0..image.len() / width {
                let mut planes = Planes { image: &mut cells, spare: &mut spare, ring: &mut ring, width };
                filter.rows(&mut planes, (pass, steps), y..y + 1);
            }
        }
        cells.into_iter().map(|cell| A::pixel(cell).to_f32()).collect()
    }

    /// A strip of columns on either side of a step comes nearer to the other by the weight over its
    /// width: the known solution in one dimension.
    #[test]
    fn a_step_comes_down_by_the_weight_over_its_width() {
        let image: Vec<f32> = (0..16 * 5).map(|at| if at % 16 < 8 { 0.2 } else { 0.7 }).collect();
        for found in [filtered::<F32>(0.16, 900, &image, 16), filtered::<Q24>(0.16, 900, &image, 16)] {
            for (at, value) in found.into_iter().enumerate() {
                let expected = if at % 16 < 8 { 0.2 + 0.02 } else { 0.7 - 0.02 };
                // A slope of weight / 8192 over eight pixels, on both sides.
                assert!((value - expected).abs() < 3.2e-4, "pixel {at}: {value}");
            }
        }
    }
}
