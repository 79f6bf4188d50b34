//! Two fronts in the plane of one: a cell of 32 bits holds two values in [-1, 1].
//!
//! A value is a whole number of steps of 2^-14, its sign in the highest of 16 bits: so no cell is an
//! infinity or NaN.

use crate::arithmetic::{Arithmetic, Bits, Real};

/// Steps of a value from 0 to 1.
pub const UNIT: i32 = 16_384;
const SIGN: u32 = 1 << 15;

/// The phases that two fronts part an image into, so that those next to each other differ in one
/// front only: whether they lie inside the first and inside the second. Of one front alone the first
/// phase is what lies outside, the second what lies inside.
pub const PHASES: [[bool; 2]; 4] = [[false, false], [true, false], [true, true], [false, true]];

/// The two values of a cell, in steps; those that are none of [`cell`] are held at the ends.
#[inline(always)]
pub fn steps(cell: impl Bits) -> [i32; 2] {
    let bits = cell.bits();
    [bits >> 16, bits].map(|half| {
        let size = ((half & (SIGN - 1)) as i32).min(UNIT);
        if half & SIGN == 0 { size } else { -size }
    })
}

/// The two values of a cell.
#[inline(always)]
pub fn values<R: Real>(cell: impl Bits) -> [R; 2] {
    steps(cell).map(|steps| R::of(steps as f32 * (1.0 / UNIT as f32)))
}

/// The step nearest to a value in [-1, 1].
#[inline(always)]
fn nearest<R: Real>(value: R) -> u32 {
    let size = (value.magnitude().to_f32() * UNIT as f32 + 0.5) as u32;
    if value < R::ZERO && size > 0 { SIGN | size } else { size }
}

/// A cell of two values in [-1, 1], each to the nearest of its steps.
#[inline(always)]
pub fn cell<R: Real, C: Bits>(values: [R; 2]) -> C {
    let [first, second] = values.map(nearest);
    C::from_bits(first << 16 | second)
}

/// What two fronts change in a step: the sum over both in steps, and the pixels in which one of
/// them crosses 0.
#[inline(always)]
pub fn change<C: Bits>(old: &[C], new: &[C]) -> (u64, u32) {
    old.iter().zip(new).fold((0, 0), |(sum, crossings), (&old, &new)| {
        let ([v, w], [v_new, w_new]) = (steps(old), steps(new));
        let moved = v.abs_diff(v_new).wrapping_add(w.abs_diff(w_new));
        let crossed = (v > 0) != (v_new > 0) || (w > 0) != (w_new > 0);
        (u64::from(moved).wrapping_add(sum), u32::from(crossed).wrapping_add(crossings))
    })
}

/// Puts each pixel of a row into the phase with the mean nearest to it, the first of several; means in the order of
/// [`PHASES`].
pub fn start_row<A: Arithmetic>(means: [A::Real; 4], image: &[A::Cell], row: &mut [A::Cell]) {
    for (start, &pixel) in row.iter_mut().zip(image) {
        let pixel = A::pixel(pixel);
        let [mut nearest, _, _, _] = PHASES;
        let mut least: Option<A::Real> = None;
        for (phase, mean) in PHASES.into_iter().zip(means) {
            let distance = (pixel - mean).magnitude();
            if least.is_none_or(|least| distance < least) {
                (least, nearest) = (Some(distance), phase);
            }
        }
        *start = cell(nearest.map(|inside| if inside { A::Real::ONE } else { -A::Real::ONE }));
    }
}

/// Puts each pixel of a row wholly into the phase that the signs of its fronts tell.
pub fn decide_row<A: Arithmetic>(row: &mut [A::Cell]) {
    let side = |steps: i32| if steps > 0 { A::Real::ONE } else { -A::Real::ONE };
    row.iter_mut().for_each(|pair| *pair = cell(steps(*pair).map(side)));
}

/// Turns the two fronts of a row into the ranks of their phases, as front values: -1 for the darkest, what is outside,
/// and above it from 1 on.
pub fn rank_row<A: Arithmetic>(ranks: [u8; 4], row: &mut [A::Cell]) {
    for cell in row {
        let inside = steps(*cell).map(|steps| steps > 0);
        let rank = PHASES.iter().zip(ranks).find(|(phase, _)| **phase == inside).map_or(0, |(_, rank)| rank);
        *cell = A::to_level(if rank == 0 { -A::Real::ONE } else { A::Real::of(f32::from(rank)) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::{F32, Fixed24};

    #[test]
    fn a_cell_holds_both_values_to_the_nearest_step() {
        for v in (-UNIT..=UNIT).step_by(61) {
            for w in [-UNIT, -1, 0, 1, 77, UNIT] {
                let values = [v, w].map(|steps| (steps as f32 + 0.4) / UNIT as f32).map(|v| v.min(1.0));
                let (float, fixed) = (cell::<f32, f32>(values), cell::<_, Fixed24>(values.map(Fixed24::of)));
                assert_eq!((steps(float), steps(fixed)), ([v, w], [v, w]));
                assert!(float.is_finite() && float.bits() == fixed.bits());
                assert_eq!(super::values::<f32>(float), [v, w].map(|steps| steps as f32 / UNIT as f32));
            }
        }
    }

    #[test]
    fn no_bits_are_beyond_the_ends() {
        for bits in [u32::MAX, 0x8000_8000, 0x7FFF_7FFF, 0x4001_C001] {
            assert!(steps(Fixed24::from_bits(bits as i32)).iter().all(|steps| steps.abs() <= UNIT), "{bits:x}");
        }
    }

    #[test]
    fn a_pixel_starts_in_the_nearest_phase_and_ends_as_its_rank() {
        let means = [0.1, 0.3, 0.5, 0.9];
        let (image, mut row) = ([0.0f32, 0.25, 0.69, 0.71], [0.0; 4]);
        start_row::<F32>(means, &image, &mut row);
        assert_eq!(row.map(|cell| steps(cell).map(|steps| steps > 0)), PHASES);
        row = row.map(|pair| cell(super::values::<f32>(pair).map(|value| value * 0.01)));
        decide_row::<F32>(&mut row);
        assert_eq!(
            row.map(super::values::<f32>),
            PHASES.map(|phase| phase.map(|inside| if inside { 1.0 } else { -1.0 }))
        );
        rank_row::<F32>([2, 0, 3, 1], &mut row);
        assert_eq!(row, [2.0, -1.0, 3.0, 1.0]);
    }

    #[test]
    fn a_change_is_that_of_both_fronts() {
        let one = |v: f32, w: f32| cell::<f32, f32>([v, w]);
        let (old, new) = ([one(0.5, -0.25), one(0.0, 1.0)], [one(0.25, 0.25), one(0.0, 1.0)]);
        assert_eq!(change(&old, &new), (UNIT as u64 * 3 / 4, 1));
    }
}
