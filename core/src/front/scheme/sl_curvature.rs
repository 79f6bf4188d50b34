//! Semi-Lagrangian with curvature: `SLg` plus an average along the contour (`SLgk`).

use super::{Evolve, Sl, Step, flat_limit, tracked};
use crate::arithmetic::{Arithmetic, Real};
use crate::config::{Config, CurvatureForm, Scheme};
use crate::plane::sweep::{Band, Kernel};
use crate::plane::tiles::Tiles;
use core::ops::Range;

/// Rows and columns that the look along the contour can reach.
const RADIUS: usize = 5;
/// Rows of the window.
const WINDOW: usize = 2 * RADIUS + 1;

/// The scheme `SLgk`; in the consistent form the averages are taken minus v (spec section 2,
/// item 3). Along the contour it looks `sqrt(2 dt) / dx` pixels far, at most 5.
#[derive(Clone, Copy, Debug)]
pub struct SlCurvature<A: Arithmetic, const M: usize = 3> {
    sl: Sl<A, M>,
    /// `sqrt(2 dt) / dx`.
    look: A::Real,
    /// `nu / 2`, the weight of the two looks.
    pair: A::Real,
    /// `nu / 4`, the weight of the four neighbours in the flat case.
    mean: A::Real,
    flat: A::Real,
    form: CurvatureForm,
}

/// The window around column `x` of a row: values at whole offsets, relative to the centre.
struct View<'a, A: Arithmetic> {
    old: &'a [&'a [A::Cell]; WINDOW],
    x: usize,
    v: A::Real,
}

impl<A: Arithmetic> View<'_, A> {
    /// The value `dx` columns and `dy` rows away, minus the centre; 0 beyond the window.
    #[inline(always)]
    fn at(&self, dx: isize, dy: isize) -> A::Real {
        let row = self.old.get((RADIUS as isize + dy) as usize);
        let cell = row.and_then(|row| row.get((self.x + RADIUS).wrapping_add_signed(dx)));
        cell.map_or(A::Real::ZERO, |&cell| A::level(cell) - self.v)
    }

    /// The bilinear interpolant at the offset `(x, y)`, minus the centre. Both offsets are split
    /// away from the centre, so that mirrored offsets give mirrored cells.
    #[inline(always)]
    fn interpolate(&self, x: A::Real, y: A::Real) -> A::Real {
        let (sx, sy) = (sign(x), sign(y));
        let (ix, fx) = x.magnitude().split(RADIUS);
        let (iy, fy) = y.magnitude().split(RADIUS);
        let (x0, y0) = (sx * ix as isize, sy * iy as isize);
        let (x1, y1) = (sx * (ix + 1).min(RADIUS) as isize, sy * (iy + 1).min(RADIUS) as isize);
        let centre = self.at(x0, y0);
        let (h, w, d) = (self.at(x1, y0) - centre, self.at(x0, y1) - centre, self.at(x1, y1) - centre);
        centre + ((fx * h + fy * w) + (fx * fy) * (d - (h + w)))
    }
}

#[inline(always)]
fn sign<R: Real>(x: R) -> isize {
    if x < R::ZERO { -1 } else { 1 }
}

impl<A: Arithmetic, const M: usize> SlCurvature<A, M> {
    /// The curvature's share of the step, before the factor g.
    #[inline(always)]
    fn curvature(&self, view: &View<'_, A>, sides: [A::Real; 4]) -> A::Real {
        let [l, r, b, a] = sides;
        let half = A::Real::of(0.5);
        let (weight, sum, count) = match A::unit((r - l) * half, (a - b) * half, self.flat) {
            None => (self.mean, (l + r) + (b + a), 4),
            Some((nx, ny)) => {
                let (x, y) = (self.look * ny, -(self.look * nx));
                (self.pair, view.interpolate(x, y) + view.interpolate(-x, -y), 2)
            }
        };
        let average = weight * sum;
        match self.form {
            CurvatureForm::Consistent => average,
            CurvatureForm::Printed => (0..count).fold(average, |sum, _| sum + weight * view.v),
        }
    }
}

impl<A: Arithmetic, const M: usize> Kernel<A, WINDOW> for SlCurvature<A, M> {
    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; WINDOW], speed: &[A::Cell], new: &mut [A::Cell]) {
        let scheme = *self;
        for ((x, new), &g) in new.iter_mut().enumerate().zip(speed) {
            let view = View::<A> { old, x, v: A::level(*new) };
            let sides = [view.at(-1, 0), view.at(1, 0), view.at(0, -1), view.at(0, 1)];
            let corners = [view.at(-1, -1), view.at(1, -1), view.at(-1, 1), view.at(1, 1)];
            let g = A::pixel(g);
            let moved = scheme.sl.least_within(view.v, scheme.sl.reach * g, sides, corners);
            *new = A::to_level(moved + g * scheme.curvature(&view, sides));
        }
    }
}

impl<A: Arithmetic, const M: usize> Evolve<A> for SlCurvature<A, M> {
    fn new(config: &Config, unit: f32) -> Result<Self, Scheme> {
        match config.scheme {
            Scheme::SlCurvature if usize::from(config.directions) == 4 * (M + 1) => Ok(SlCurvature {
                sl: Sl::with_reach(config.dt / config.dx),
                look: A::Real::of(libm::sqrtf(2.0 * config.dt) / config.dx),
                pair: A::Real::of(config.nu * 0.5),
                mean: A::Real::of(config.nu * 0.25),
                flat: flat_limit::<A>(config, unit),
                form: config.curvature_form,
            }),
            other => Err(other),
        }
    }

    fn window(&self) -> usize {
        WINDOW
    }

    fn advance(&self, band: &mut Band<'_, A::Cell>, tiles: &mut Tiles<'_>, rows: Range<usize>, step: &mut Step<A>) {
        tracked::<A, _, WINDOW>(*self, band, tiles, rows, step);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    /// The new value of the middle of a plane of values, where dt/dx is 0.5 and it looks `look` pixels far.
    fn moved(form: CurvatureForm, look: f32, speed: f32, value: impl Fn(f32, f32) -> f32) -> f32 {
        let rows: [[f32; WINDOW]; WINDOW] = core::array::from_fn(|y| {
            core::array::from_fn(|x| value(x as f32 - RADIUS as f32, y as f32 - RADIUS as f32))
        });
        let (pair, mean) = (0.1, 0.05);
        let sl = Sl::<F32, 3>::with_reach(0.5);
        let mut scheme = SlCurvature { sl, look, pair, mean, flat: 1e-3, form };
        let mut new = [value(0.0, 0.0)];
        scheme.row(&core::array::from_fn(|y| &rows[y][..]), &[speed], &mut new);
        new[0]
    }

    #[test]
    fn it_looks_along_the_contour_to_both_sides() {
        use CurvatureForm::{Consistent, Printed};
        // Rises along (3, 4) / 5, so that it looks at (2, -1.5) and at (-2, 1.5), between two rows.
        let plane = |x: f32, y: f32| 1.0 + 0.06 * x + 0.08 * y;
        let bent = |x: f32, y: f32| plane(x, y) + 0.01 * x * x + 0.03 * y * y - 0.02 * x * y;
        // 0.01 * 4 + 0.03 * (1 + 4) / 2 + 0.02 * 3 on either side.
        let looks = 2.0 * (0.04 + 0.075 + 0.06);
        assert!((moved(Consistent, 2.5, 0.0, bent) - 1.0).abs() < 1e-6, "nothing moves without speed");
        let added = |form, value: &dyn Fn(f32, f32) -> f32| {
            // What it has without a look is the semi-Lagrangian step.
            moved(form, 2.5, 0.5, value) - moved(Consistent, 0.0, 0.5, value)
        };
        assert!(added(Consistent, &plane).abs() < 1e-6);
        assert!((added(Consistent, &bent) - 0.5 * 0.1 * looks).abs() < 1e-6);
        assert!((added(Printed, &bent) - 0.5 * 0.1 * (looks + 2.0)).abs() < 1e-6);
    }

    #[test]
    fn between_pixels_it_is_bilinear() {
        let value = |x: f32, y: f32| 0.1 * x + 0.03 * y + 0.02 * x * x - 0.013 * y * y + 0.017 * x * y + 0.5;
        let rows: [[f32; WINDOW]; WINDOW] = core::array::from_fn(|y| {
            core::array::from_fn(|x| value(x as f32 - RADIUS as f32, y as f32 - RADIUS as f32))
        });
        let view = View::<F32> { old: &core::array::from_fn(|y| &rows[y][..]), x: 0, v: 0.5 };
        for (x, y) in [(1.4, -1.05), (-1.4, 1.05), (0.3, 0.6), (-2.7, -4.3), (4.6, 3.0), (0.0, 5.0), (-5.0, 0.0)] {
            let (left, below) = (libm::floorf(x), libm::floorf(y));
            let along = |y: f32| value(left, y) + (x - left) * (value(left + 1.0, y) - value(left, y));
            let expected = along(below) + (y - below) * (along(below + 1.0) - along(below)) - 0.5;
            assert!((view.interpolate(x, y) - expected).abs() < 1e-5, "{x}, {y}: {expected}");
        }
    }

    #[test]
    fn the_front_comes_from_every_corner() {
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let corner = |at_x: f32, at_y: f32| if (at_x, at_y) == (x, y) { 1.0 } else { 2.0 };
            let found = moved(CurvatureForm::Consistent, 0.0, 0.8, corner);
            assert!((found - (2.0 - 0.5 * 0.4 * 0.4)).abs() < 1e-6, "{x}, {y}: {found}");
        }
    }

    #[test]
    fn where_it_is_flat_the_four_neighbours_count() {
        let bowl = |x: f32, y: f32| 2.0 + 0.1 * x * x + 0.3 * y * y;
        // The sum over the neighbours is 0.8, and with the pixel's own value, as printed, four of it more.
        assert!((moved(CurvatureForm::Consistent, 2.5, 0.5, bowl) - (2.0 + 0.5 * 0.05 * 0.8)).abs() < 1e-6);
        assert!((moved(CurvatureForm::Printed, 2.5, 0.5, bowl) - (2.0 + 0.5 * 0.05 * 8.8)).abs() < 1e-6);
    }

    #[test]
    fn the_constants_are_those_of_a_configuration() {
        let config = Config { dt: 0.02, dx: 0.1, nu: 0.3, ..Config::PAPER_F160.with_scheme(Scheme::SlCurvature) };
        let scheme = <SlCurvature<F32> as Evolve<F32>>::new(&config, 1.0).expect("its scheme");
        for (found, expected) in [(scheme.look, 2.0), (scheme.pair, 0.15), (scheme.mean, 0.075), (scheme.sl.reach, 0.2)]
        {
            assert!((found - expected).abs() < 1e-6, "{scheme:?}");
        }
    }

    #[test]
    fn a_plane_falls_by_its_slope() {
        super::super::tests::assert_that_a_plane_falls::<SlCurvature<F32>>(Scheme::SlCurvature);
    }
}
