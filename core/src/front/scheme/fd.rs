//! Finite differences, first order: `v - dt g |grad v|`, upwind (`DFg`).

use super::{Evolve, Step, tracked};
use crate::arithmetic::vectors::COLUMNS;
use crate::arithmetic::vectors::Vectors;
use crate::arithmetic::{Arithmetic, Real};
use crate::config::{Config, Scheme};
use crate::plane::sweep::{Band, Kernel, RowOf, Tile, cross};
use crate::plane::tiles::Tiles;
use core::ops::Range;

/// The scheme `DFg`. Monotone while `dt g / dx <= 1/2`.
#[derive(Clone, Copy, Debug)]
pub struct Fd<A: Arithmetic> {
    /// `dt / dx`: how many pixels the front moves in a step where g = 1.
    courant: A::Real,
}

impl<A: Arithmetic> Kernel<A, 3> for Fd<A> {
    const CORNERS: bool = false;
    const ON_VECTORS: bool = true;

    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; 3], speed: &[A::Cell], new: &mut [A::Cell]) {
        // A copy: behind the reference it could change with every pixel written.
        let Fd { courant } = *self;
        let cross = cross(old);
        for (((new, &v), around), &g) in new.iter_mut().zip(cross.centre).zip(cross.sides()).zip(speed) {
            *new = A::retreat(v, around, courant, g);
        }
    }

    /// [`Arithmetic::retreat`] on vector units.
    #[inline(always)]
    fn on_vectors(&self, vectors: A::Vectors, tile: &Tile<'_, A::Cell>) -> RowOf<A> {
        let v = vectors.load(tile.centre);
        let [l, r, b, a] = tile.sides;
        let (row, column) = (squares::<A>(vectors, v, l, r), squares::<A>(vectors, v, b, a));
        let squares = vectors.plus(row, column);
        let reach = vectors.times(vectors.splat(self.courant), vectors.load(tile.beside));
        vectors.minus(v, vectors.times(reach, vectors.root(squares)))
    }
}

/// The sum of the squared drops towards two neighbours.
#[inline(always)]
fn squares<A: Arithmetic>(
    vectors: A::Vectors,
    v: RowOf<A>,
    one: &[A::Cell; COLUMNS],
    other: &[A::Cell; COLUMNS],
) -> RowOf<A> {
    let one = vectors.positive(vectors.minus(v, vectors.load(one)));
    let other = vectors.positive(vectors.minus(v, vectors.load(other)));
    vectors.plus(vectors.times(one, one), vectors.times(other, other))
}

impl<A: Arithmetic> Evolve<A> for Fd<A> {
    fn new(config: &Config, _unit: f32) -> Result<Self, Scheme> {
        match config.scheme {
            Scheme::Fd => Ok(Fd { courant: A::Real::of(config.dt / config.dx) }),
            other => Err(other),
        }
    }

    fn window(&self) -> usize {
        3
    }

    fn advance(&self, band: &mut Band<'_, A::Cell>, tiles: &mut Tiles<'_>, rows: Range<usize>, step: &mut Step<A>) {
        tracked::<A, _, 3>(*self, band, tiles, rows, step);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    #[test]
    fn a_value_falls_by_its_upwind_gradient() {
        let config = Config { dt: 0.025, dx: 0.1, ..Config::PAPER_F160 };
        let mut scheme = <Fd<F32> as Evolve<F32>>::new(&config, 1.0).expect("its scheme");
        // Lower by 0.6 on the left and by 0.8 above; what is higher does not count.
        let [below, row, above] = [[0.0, 1.3, 0.0], [0.4, 1.0, 5.0], [0.0, 0.2, 0.0]];
        let mut new = [1.0];
        scheme.row(&[&below, &row, &above], &[0.5], &mut new);
        assert!((new[0] - (1.0 - 0.25 * 0.5)).abs() < 1e-6, "{new:?}");
        // In a well nothing moves.
        scheme.row(&[&below, &[4.0, -1.0, 5.0], &above], &[0.5], &mut new);
        assert_eq!(new, [-1.0]);
    }

    #[test]
    fn a_plane_falls_by_its_slope() {
        super::super::tests::assert_that_a_plane_falls::<Fd<F32>>(Scheme::Fd);
    }
}
