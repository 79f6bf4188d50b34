//! The equations of one step: sky, light and the two shifts of the centre, weighted by the noise.

use crate::arithmetic::Real;

/// What a pixel is as a sum of: a level sky, the star, and the star's change with its column and row.
#[derive(Clone, Copy, Debug)]
pub struct Basis<R> {
    /// The sky, the same for every pixel.
    pub sky: R,
    /// The star.
    pub star: R,
    /// Its change with the column of the centre.
    pub column: R,
    /// Its change with the row of the centre.
    pub row: R,
}

/// Weighted sums of products: the information matrix (symmetric) and the right-hand side.
#[derive(Clone, Copy, Debug)]
pub struct Equations<R> {
    matrix: Symmetric<R>,
    side: Basis<R>,
}

/// The ten sums of a symmetric matrix.
#[derive(Clone, Copy, Debug)]
struct Symmetric<R> {
    sky: Basis<R>,
    star: [R; 3],
    column: [R; 2],
    row: R,
}

/// What the equations say.
#[derive(Clone, Copy, Debug)]
pub struct Solution<R> {
    /// Sky in units of its basis.
    pub sky: R,
    /// Amplitude of the star.
    pub star: R,
    /// Shift times amplitude along columns and rows.
    pub shift: (R, R),
    /// Information on the amplitude, the sky being unknown.
    pub of_star: R,
    /// Information on the two shifts (xx, xy, yy), sky and amplitude being unknown.
    pub of_shift: (R, R, R),
}

impl<R: Real> Equations<R> {
    /// Knows of the sky alone that it is `level` in units of its basis, with this information.
    pub fn with_sky(information: R, level: R) -> Self {
        let zero = Basis { sky: R::ZERO, star: R::ZERO, column: R::ZERO, row: R::ZERO };
        let sky = Basis { sky: information, ..zero };
        Equations {
            matrix: Symmetric { sky, star: [R::ZERO; 3], column: [R::ZERO; 2], row: R::ZERO },
            side: Basis { sky: information * level, ..zero },
        }
    }

    /// Adds a pixel with its weight.
    #[inline(always)]
    pub fn add(&mut self, basis: Basis<R>, weight: R, value: R) {
        let Basis { sky, star, column, row } = basis;
        let [of_sky, of_star, of_column, of_row] = [weight * sky, weight * star, weight * column, weight * row];
        let m = &mut self.matrix;
        m.sky.sky = m.sky.sky + of_sky * sky;
        m.sky.star = m.sky.star + of_sky * star;
        m.sky.column = m.sky.column + of_sky * column;
        m.sky.row = m.sky.row + of_sky * row;
        let [star_star, star_column, star_row] = m.star;
        m.star = [star_star + of_star * star, star_column + of_star * column, star_row + of_star * row];
        let [column_column, column_row] = m.column;
        m.column = [column_column + of_column * column, column_row + of_column * row];
        m.row = m.row + of_row * row;
        self.side.sky = self.side.sky + of_sky * value;
        self.side.star = self.side.star + of_star * value;
        self.side.column = self.side.column + of_column * value;
        self.side.row = self.side.row + of_row * value;
    }

    /// Eliminates in the order sky, star, column, row; none where a pivot is not above 0.
    pub fn solve(&self) -> Option<Solution<R>> {
        let Equations { matrix: Symmetric { sky: k, star, column, row }, side } = *self;
        let above = |pivot: R| if pivot > R::ZERO { Some(pivot) } else { None };
        let pivot = above(k.sky)?;
        let [fs, fc, fr] = [k.star, k.column, k.row].map(|v| v.ratio(pivot));
        let [ss, sc, sr] = star;
        let [ss, sc, sr] = [ss - fs * k.star, sc - fs * k.column, sr - fs * k.row];
        let [cc, cr] = column;
        let [cc, cr, rr] = [cc - fc * k.column, cr - fc * k.row, row - fr * k.row];
        let [ts, tc, tr] = [side.star - fs * side.sky, side.column - fc * side.sky, side.row - fr * side.sky];

        let of_star = above(ss)?;
        let [gc, gr] = [sc, sr].map(|v| v.ratio(of_star));
        let [cc, cr, rr] = [cc - gc * sc, cr - gc * sr, rr - gr * sr];
        let [tc, tr] = [tc - gc * ts, tr - gr * ts];

        let pivot_column = above(cc)?;
        let h = cr.ratio(pivot_column);
        let last = above(rr - h * cr)?;
        let y = (tr - h * tc).ratio(last);
        let x = (tc - cr * y).ratio(pivot_column);
        let amplitude = (ts - sc * x - sr * y).ratio(of_star);
        let level = (side.sky - k.star * amplitude - k.column * x - k.row * y).ratio(pivot);
        Some(Solution { sky: level, star: amplitude, shift: (x, y), of_star, of_shift: (cc, cr, rr) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pixels with their weights, and what they are made of.
    const PIXELS: [(f32, Basis<f32>); 6] = {
        const fn pixel(weight: f32, star: f32, column: f32, row: f32) -> (f32, Basis<f32>) {
            (weight, Basis { sky: 0.5, star, column, row })
        }
        [
            pixel(1.0, 1.0, 0.25, -0.125),
            pixel(0.5, 0.5, 0.5, 0.25),
            pixel(0.75, 0.5, -0.5, 0.125),
            pixel(1.0, 0.25, 0.125, 0.5),
            pixel(0.25, 0.75, 0.375, -0.5),
            pixel(1.0, 0.0, 0.0, 0.25),
        ]
    };

    fn equations(value: impl Fn(&Basis<f32>) -> f32) -> Equations<f32> {
        let mut equations = Equations::with_sky(0.5, 2.0);
        PIXELS.iter().for_each(|(weight, basis)| equations.add(*basis, *weight, value(basis)));
        equations
    }

    #[test]
    fn what_pixels_are_made_of_is_found() {
        let value = |b: &Basis<f32>| 2.0 * b.sky + 3.0 * b.star + 0.5 * b.column - 0.25 * b.row;
        // The pixels together do not tie columns to rows; one more does.
        let tie = Basis { sky: 0.5, star: 0.25, column: 0.5, row: 0.375 };
        let mut tied = equations(value);
        tied.add(tie, 1.0, value(&tie));
        for equations in [equations(value), tied] {
            let found = equations.solve().expect("a solution");
            for (found, made) in [(found.sky, 2.0), (found.star, 3.0), (found.shift.0, 0.5), (found.shift.1, -0.25)] {
                assert!((found - made).abs() < 1e-5, "{found}, not {made}");
            }
        }
    }

    /// The change of the least sum of squares, `shift^2 information`, as a quantity is held away from its best value.
    #[test]
    fn information_is_how_sharp_the_least_is() {
        let found = equations(|_| 0.0).solve().expect("a solution");
        let (xx, xy, yy) = found.of_shift;
        for (found, expected) in [(found.of_star, 0.861_177_9), (xx, 0.369_984_3), (xy, 0.006_389_6), (yy, 0.301_710_8)]
        {
            assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
        }
    }

    #[test]
    fn what_no_pixel_tells_has_no_solution() {
        let solved = |basis: [Basis<f32>; 3]| {
            let mut equations = Equations::with_sky(1.0, 0.0);
            basis.into_iter().for_each(|basis| equations.add(basis, 1.0, 1.0));
            equations.solve().is_some()
        };
        let zero = Basis { sky: 0.0, star: 0.0, column: 0.0, row: 0.0 };
        let [star, column, row] =
            [Basis { star: 1.0, ..zero }, Basis { column: 1.0, ..zero }, Basis { row: 1.0, ..zero }];
        assert!(solved([star, column, row]));
        assert!(!solved([star, column, zero]) && !solved([star, zero, row]) && !solved([zero, column, row]));
        assert!(Equations::with_sky(0.0f32, 0.0).solve().is_none());
    }
}
