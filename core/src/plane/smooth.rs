//! Smoothing of a whole plane by a separable kernel, mirrored at the borders.

use crate::arithmetic::{Level, Real};
use crate::plane::crew::Crew;
use crate::plane::grid::Grid;

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

    /// Smooths `from` into `to`, both W x H; `between` holds the plane smoothed along its rows.
    /// Each sum begins with the centre and goes outwards. Cost: `4 radius` additions a pixel.
    pub fn apply<L: Level>(&self, from: &[L], between: &mut [L], to: &mut [L], grid: Grid, crew: &impl Crew) {
        self.along_rows(from, between, grid, crew);
        self.along_columns(between, to, grid, crew, |rows, first, to| {
            to.fill(L::ZERO);
            self.add_along_columns(rows, first, to, grid, 1.0);
        });
    }

    /// Adds to a plane `strength` times what smoothing takes from it: an unsharp mask.
    pub fn sharpen<L: Level>(&self, plane: &mut [L], between: &mut [L], grid: Grid, strength: f32, crew: &impl Crew) {
        self.along_rows(plane, between, grid, crew);
        let gain = 1.0 + strength;
        self.along_columns(between, plane, grid, crew, |rows, first, plane| {
            plane.iter_mut().for_each(|value| *value = value.scaled(L::Weight::of(gain)));
            self.add_along_columns(rows, first, plane, grid, -strength);
        });
    }

    /// Smooths all rows, band by band.
    fn along_rows<L: Level>(&self, from: &[L], to: &mut [L], grid: Grid, crew: &impl Crew) {
        let band = (grid.width.get() * crew.rows(grid)).max(1);
        crew.each(from.chunks(band).zip(to.chunks_mut(band)), |(from, to)| self.rows(from, to, grid.width.get()));
    }

    /// Does `work` on every band of `to`, by the index of its first row; it reads all of `from`.
    fn along_columns<L: Level>(
        &self,
        from: &[L],
        to: &mut [L],
        grid: Grid,
        crew: &impl Crew,
        work: impl Fn(&[L], usize, &mut [L]) + Sync,
    ) {
        let rows = crew.rows(grid).max(1);
        let bands = (0..).step_by(rows).zip(to.chunks_mut((grid.width.get() * rows).max(1)));
        crew.each(bands, |(first, to)| work(from, first, to));
    }

    /// The weights beside the centre with their distances.
    fn sides(&self) -> impl Iterator<Item = (usize, f32)> {
        self.weights.into_iter().enumerate().take(self.radius + 1).skip(1)
    }

    fn rows<L: Level>(&self, from: &[L], to: &mut [L], width: usize) {
        let [centre, ..] = self.weights;
        let centre = L::Weight::of(centre);
        let width = width.max(1);
        for (row, out) in from.chunks_exact(width).zip(to.chunks_exact_mut(width)) {
            out.iter_mut().zip(row).for_each(|(out, value)| *out = value.scaled(centre));
            for (distance, weight) in self.sides() {
                let weight = L::Weight::of(weight);
                let inner = width.saturating_sub(2 * distance);
                if let (Some(left), Some(right)) = (row.get(..inner), row.get(width - inner..)) {
                    add(out.get_mut(distance..distance + inner).unwrap_or(&mut []), left, right, weight);
                }
                let left_end = if inner > 0 { distance } else { width };
                for x in (0..left_end).chain((left_end + inner).min(width)..width) {
                    let [below, above] = mirrored(x, distance, width).map(|at| row.get(at).copied().unwrap_or(L::ZERO));
                    if let Some(out) = out.get_mut(x) {
                        *out = *out + (below + above).scaled(weight);
                    }
                }
            }
        }
    }

    /// Adds `gain` times the smoothed columns of `from` to the rows from `first` on.
    fn add_along_columns<L: Level>(&self, from: &[L], first: usize, to: &mut [L], grid: Grid, gain: f32) {
        let ([centre, ..], width) = (self.weights, grid.width.get());
        let centre = L::Weight::of(gain * centre);
        let row = |y: usize| from.get(y * width..(y + 1) * width).unwrap_or(&[]);
        for (y, out) in (first..).zip(to.chunks_exact_mut(width)) {
            out.iter_mut().zip(row(y)).for_each(|(out, value)| *out = *out + value.scaled(centre));
            for (distance, weight) in self.sides() {
                let [below, above] = mirrored(y, distance, grid.height);
                add(out, row(below), row(above), L::Weight::of(gain * weight));
            }
        }
    }
}

fn add<L: Level>(out: &mut [L], left: &[L], right: &[L], weight: L::Weight) {
    for ((out, left), right) in out.iter_mut().zip(left).zip(right) {
        *out = *out + (*left + *right).scaled(weight);
    }
}

/// The two places at a distance from `at`, mirrored at the ends of the axis.
fn mirrored(at: usize, distance: usize, length: usize) -> [usize; 2] {
    let below = if at >= distance { at - distance } else { distance - at - 1 };
    let above = if at + distance < length { at + distance } else { (2 * length).saturating_sub(1 + at + distance) };
    [below.min(length.saturating_sub(1)), above]
}
