//! A start near the objects: the front begins at a margin outside the tau-level set of the
//! filtered image, and travels only the last pixels.
//!
//! Three passes over the rows of the front plane: pixels above the level have distance 0; the
//! chamfer distance (steps of 1 and sqrt 2 pixels, doi:10.1016/S0734-189X(86)80047-0) spreads from
//! below, and from above. Distances end a little beyond the margin.

use crate::arithmetic::{Arithmetic, Real};
use crate::front::settle::FLOOR;

/// Distances beyond this, in pixels, are not told apart.
fn farthest(margin: f32) -> f32 {
    margin + 2.0 * FLOOR
}

/// Distance 0 where the image is above `level`, far elsewhere.
pub fn mark_row<A: Arithmetic>(image: &[A::Cell], level: f32, margin: f32, distance: &mut [A::Cell]) {
    let (level, zero) = (A::Real::of(level), A::to_level(A::Real::ZERO));
    let far = A::to_level(A::Real::of(farthest(margin)));
    for (distance, &cell) in distance.iter_mut().zip(image) {
        *distance = if A::pixel(cell) > level { zero } else { far };
    }
}

/// Distance 0, too, where another band is above its own level.
pub fn mark_also<A: Arithmetic>(image: &[A::Cell], level: f32, distance: &mut [A::Cell]) {
    let level = A::Real::of(level);
    let above = distance.iter_mut().zip(image).filter(|(_, cell)| A::pixel(**cell) > level);
    above.for_each(|(distance, _)| *distance = A::to_level(A::Real::ZERO));
}

/// Lets distances spread into a row from the row before it (empty for the first) and along it,
/// in both directions.
pub fn spread_row<A: Arithmetic>(before: &[A::Cell], row: &mut [A::Cell]) {
    let (side, corner) = (A::Real::ONE, A::Real::of(core::f32::consts::SQRT_2));
    let neighbours =
        |x: usize| before.get(x.saturating_sub(1)..).unwrap_or(&[]).iter().take(if x == 0 { 2 } else { 3 });
    for (x, cell) in row.iter_mut().enumerate() {
        let mut least = A::level(*cell);
        for (near, &other) in (if x == 0 { 1usize } else { 0 }..).zip(neighbours(x)) {
            least = least.least(A::level(other) + if near == 1 { side } else { corner });
        }
        *cell = A::to_level(least);
    }
    along::<A>(row.iter_mut());
    along::<A>(row.iter_mut().rev());
}

/// Distances spread along a row in one direction.
fn along<'a, A: Arithmetic>(row: impl Iterator<Item = &'a mut A::Cell>)
where
    A::Cell: 'a,
{
    let mut last: Option<A::Real> = None;
    for cell in row {
        let value = A::level(*cell);
        let value = last.map_or(value, |last| value.least(last + A::Real::ONE));
        *cell = A::to_level(value);
        last = Some(value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    #[test]
    fn distances_from_a_pixel() {
        let mut image = [0.0f32; 35];
        image[2 * 7 + 3] = 0.6;
        let mut distance = [0.0f32; 35];
        for (image, row) in image.chunks(7).zip(distance.chunks_mut(7)) {
            mark_row::<F32>(image, 0.5, 3.0, row);
        }
        for order in [[0, 1, 2, 3, 4], [4, 3, 2, 1, 0]] {
            let mut before: ([f32; 7], usize) = ([0.0; 7], 0);
            for y in order {
                let row = &mut distance[y * 7..(y + 1) * 7];
                spread_row::<F32>(&before.0[..before.1], row);
                before.0.copy_from_slice(row);
                before.1 = 7;
            }
        }
        let root = core::f32::consts::SQRT_2;
        let expected = [
            [root * 2.0 + 1.0, root * 2.0, root + 1.0, 2.0, root + 1.0, root * 2.0, root * 2.0 + 1.0],
            [root + 2.0, root + 1.0, root, 1.0, root, root + 1.0, root + 2.0],
            [3.0, 2.0, 1.0, 0.0, 1.0, 2.0, 3.0],
        ];
        for (found, expected) in distance.chunks(7).zip(expected) {
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-6, "{distance:?}");
            }
        }
    }

    #[test]
    fn distances_end_beyond_what_a_front_keeps() {
        let mut distance = [0.0f32; 3];
        mark_row::<F32>(&[0.0, 0.6, 0.5], 0.5, 3.0, &mut distance);
        assert_eq!(distance[1], 0.0);
        assert!(distance[0] == distance[2] && distance[0] > 3.0 + FLOOR, "{distance:?}");
    }
}
