//! A front that starts from a map: a former segmentation, a drawing, or a level set.

use skyfront_core::arithmetic::{Arithmetic, F32, Real};
use skyfront_core::config::{Config, Motion};
use skyfront_core::front::profile::Profile;
use skyfront_core::front::start::{mark_row, spread_row};

/// Where the front starts.
#[derive(Clone, Debug, PartialEq)]
pub enum StartMap {
    /// Values of u in the front's unit, as front.fits holds them: positive where the front has yet to go.
    Level(Vec<f32>),
    /// So many pixels outside the marked ones, whose distance the plane holds.
    Outside {
        /// Pixels from each pixel to the nearest marked one.
        distance: Vec<f32>,
        /// Pixels between a marked one and the front.
        margin: f32,
    },
}

impl StartMap {
    /// Pixels between a map and the front that starts there, if nothing is said.
    pub const MARGIN: f32 = 4.0;

    /// The start that a map of rows of `width` means: a level set where values are negative, else
    /// `margin` pixels outside those that are not 0. Undefined pixels count as outside.
    pub fn of(values: &[f32], width: usize, margin: f32) -> StartMap {
        if values.iter().any(|&value| value < 0.0) {
            let finite = values.iter().copied().filter(|value| value.is_finite());
            let least = finite.fold(0.0, |least, value| if value < least { value } else { least });
            let level = |&value: &f32| if value.is_finite() { value } else { least };
            return StartMap::Level(values.iter().map(level).collect());
        }
        let marks: Vec<f32> = values.iter().map(|&value| if value > 0.0 { 1.0 } else { 0.0 }).collect();
        let mut distance = vec![0.0; values.len()];
        // A front that grows needs to know how far its seeds are, one that shrinks only that they are.
        let farthest = (width + values.len() / width) as f32;
        for (row, marks) in distance.chunks_exact_mut(width).zip(marks.chunks_exact(width)) {
            mark_row::<F32>(marks, 0.5, farthest, row);
        }
        spread(distance.chunks_exact_mut(width));
        spread(distance.chunks_exact_mut(width).rev());
        StartMap::Outside { distance, margin }
    }

    /// Writes the start into the plane of a front.
    pub fn fill<A: Arithmetic>(&self, config: &Config, (width, height): (usize, usize), plane: &mut [A::Cell]) {
        let set = |cell: &mut A::Cell, value: f32| *cell = A::to_level(A::Real::of(value));
        match self {
            StartMap::Level(values) => plane.iter_mut().zip(values).for_each(|(cell, &value)| set(cell, value)),
            StartMap::Outside { distance, margin } => {
                let front = Profile::new(config, width, height);
                let mut levels = vec![0.0; width];
                for (row, distance) in plane.chunks_exact_mut(width).zip(distance.chunks_exact(width)) {
                    levels.copy_from_slice(distance);
                    match config.motion {
                        Motion::Inward => front.outside_row::<F32>(*margin, &mut levels),
                        Motion::Outward => front.around_row(*margin, &mut levels),
                    }
                    row.iter_mut().zip(&levels).for_each(|(cell, &value)| set(cell, value));
                }
            }
        }
    }
}

/// Lets distances spread over the rows, each from the one before.
fn spread<'a>(rows: impl Iterator<Item = &'a mut [f32]>) {
    let mut before: &[f32] = &[];
    for row in rows {
        spread_row::<F32>(before, row);
        before = row;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drawing_starts_a_margin_outside() {
        let mut map = vec![0.0; 81];
        map[40] = 7.0;
        let StartMap::Outside { distance, margin } = StartMap::of(&map, 9, 2.0) else { panic!("a drawing") };
        assert_eq!((distance[40], distance[42], distance[38], distance[22], margin), (0.0, 2.0, 2.0, 2.0, 2.0));
        assert!((distance[50] - 2f32.sqrt()).abs() < 1e-6);
        let config = Config { band: Some(8.0), ..Config::PAPER_F160 };
        let mut plane = vec![9.0; 81];
        StartMap::of(&map, 9, 2.0).fill::<F32>(&config, (9, 9), &mut plane);
        assert_eq!((plane[40], plane[41], plane[42], plane[43]), (2.0, 1.0, 0.0, -1.0));
    }

    #[test]
    fn signs_make_it_a_level_set() {
        let start = StartMap::of(&[1.5, -0.5, f32::NAN], 3, 2.0);
        assert_eq!(start, StartMap::Level(vec![1.5, -0.5, -0.5]));
    }
}
