//! Step 5: the schemes that move the front, a family of files of one shape.
//!
//! Each scheme is a row kernel on the front plane with the edge detector as the other row. All use
//! undivided differences: lengths are pixels, and dx enters only through a few coefficients.

mod any;
mod chan_vese;
mod fd;
mod fd_curvature;
mod fd_filtered;
mod length;
mod marching;
mod multiphase;
mod preset;
mod sl;
mod sl_curvature;
mod still;

pub use any::AnyScheme;
pub use chan_vese::ChanVese;
pub use fd::Fd;
pub use fd_curvature::FdCurvature;
pub use fd_filtered::FdFiltered;
pub use marching::Marching;
pub use multiphase::Multiphase;
pub(crate) use preset::Chosen;
pub use preset::{Fixed, Preset};
pub use sl::Sl;
pub use sl_curvature::SlCurvature;
pub use still::Still;

use crate::arithmetic::vectors::COLUMNS;
use crate::arithmetic::{Arithmetic, Real};
use crate::config::{Config, Scheme};
use crate::front::region::Means;
use crate::front::settle::Settle;
use crate::front::stop::Change;
use crate::plane::sweep::{Band, Kernel, RowOf, Tile, advance_active, shifted};
use crate::plane::tiles::Tiles;
use core::ops::Range;

/// A scheme for the evolution, chosen at compile time (one scheme in the program) or at run time
/// ([`AnyScheme`]).
pub trait Evolve<A: Arithmetic>: Sized {
    /// The one configuration that a program with this type can run, or `None` for all of the
    /// scheme's: see [`Preset`].
    const ONLY: Option<Config> = None;

    /// Whether the front may be found by arrival times in place of steps.
    const MARCHES: bool = false;

    /// Whether several bands may move the front: [`Self::follow`] is there.
    const FOLLOWS: bool = false;

    /// Builds the scheme of a validated configuration, or says that it is another one.
    ///
    /// # Errors
    /// The name of the scheme that this type cannot serve.
    fn new(config: &Config, unit: f32) -> Result<Self, Scheme>;

    /// Rows of the window: 2R + 1.
    fn window(&self) -> usize;

    /// Moves the front in the active tiles of `rows` by one step; notes which tiles change, and
    /// adds what changes to the step's record.
    fn advance(&self, band: &mut Band<'_, A::Cell>, tiles: &mut Tiles<'_>, rows: Range<usize>, step: &mut Step<A>);

    /// The same where the other plane holds the force itself ([`crate::front::bands`]).
    fn follow(&self, band: &mut Band<'_, A::Cell>, tiles: &mut Tiles<'_>, rows: Range<usize>, step: &mut Step<A>) {
        let _ = (band, tiles, rows, step);
    }
}

/// A step of the front: how new values are settled, and the record of what changed.
#[derive(Clone, Copy, Debug)]
pub struct Step<A: Arithmetic> {
    /// Applied to every new value.
    pub settle: Settle<A>,
    /// What changed so far in this step.
    pub change: Change<A>,
    /// The means of the regions of Chan and Vese, as they were before this step.
    pub means: Means,
}

/// A scheme's kernel as a part of a step.
#[derive(Clone, Copy)]
struct Tracked<A: Arithmetic, K> {
    kernel: K,
    step: Step<A>,
}

impl<A: Arithmetic, K: Kernel<A, N>, const N: usize> Kernel<A, N> for Tracked<A, K> {
    const CORNERS: bool = K::CORNERS;
    const AROUND: bool = K::AROUND;
    const ON_VECTORS: bool = K::ON_VECTORS;

    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; N], speed: &[A::Cell], new: &mut [A::Cell]) {
        self.kernel.row(old, speed, new);
    }

    #[inline(always)]
    fn settle(&mut self, old: &[A::Cell], _: &[A::Cell], new: &mut [A::Cell]) {
        self.step.settle.row(new);
        self.step.change.observe(old, new);
    }

    #[inline(always)]
    fn on_vectors(&self, vectors: A::Vectors, tile: &Tile<'_, A::Cell>) -> RowOf<A> {
        self.kernel.on_vectors(vectors, tile)
    }

    #[inline(always)]
    fn settle_on_vectors(&self, vectors: A::Vectors, new: &mut [[A::Cell; COLUMNS]]) {
        self.step.settle.on_vectors(vectors, new);
    }

    #[inline(always)]
    fn observe_on_vectors(&mut self, vectors: A::Vectors, old: RowOf<A>, new: RowOf<A>) {
        self.step.change.observe_on_vectors(vectors, old, new);
    }
}

/// One sweep of a kernel over the active tiles: what every scheme's `advance` does.
fn tracked<A: Arithmetic, K: Kernel<A, N> + Copy, const N: usize>(
    kernel: K,
    band: &mut Band<'_, A::Cell>,
    tiles: &mut Tiles<'_>,
    rows: Range<usize>,
    step: &mut Step<A>,
) {
    let mut tracked = Tracked { kernel, step: *step };
    advance_active::<A, _, N>(&mut tracked, band, tiles, rows);
    *step = tracked.step;
}

/// The length of an undivided central difference below which the front counts as flat:
/// `|D^c| <= degenerate dx^degenerate_power`, as `|(r - l) / 2|` in units of the front plane.
fn flat_limit<A: Arithmetic>(config: &Config, unit: f32) -> A::Real {
    let slope = (0..config.degenerate_power).fold(config.degenerate, |slope, _| slope * config.dx);
    A::Real::of(slope * config.dx * unit)
}

/// The corners of each pixel in a window of three padded rows: below left and right, above left
/// and right.
#[inline(always)]
fn corners<'a, C: Copy>(old: &[&'a [C]; 3]) -> impl Iterator<Item = [C; 4]> + use<'a, C> {
    let [below, _, above] = *old;
    let rows = below.iter().zip(shifted(below, 2)).zip(above).zip(shifted(above, 2));
    rows.map(|(((&bl, &br), &al), &ar)| [bl, br, al, ar])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;
    use crate::front::stop::StopRule;
    use crate::plane::sweep::{Halo, ring_len};
    use crate::plane::tiles::{flags_len, rows_of_tile};

    /// Rows and columns of a frame, and what the widest window keeps of it.
    const SIDE: usize = 12;
    const RING: usize = ring_len(SIDE, 11);

    /// A plane of a frame.
    pub type Plane = [f32; SIDE * SIDE];

    /// A plane by column and row.
    pub fn plane(value: impl Fn(f32, f32) -> f32) -> Plane {
        core::array::from_fn(|at| value((at % SIDE) as f32, (at / SIDE) as f32))
    }

    /// A plane's value at (5, 5), with those around.
    pub fn middle(plane: &Plane) -> [[f32; 3]; 3] {
        core::array::from_fn(|y| core::array::from_fn(|x| plane[(4 + y) * SIDE + 4 + x]))
    }

    /// What a sweep does to a front beside another plane, and what it notes of that.
    pub fn swept<S: Evolve<F32>>(
        config: &Config,
        means: [f32; 4],
        (old, aux): (&Plane, &Plane),
        sweep: impl Fn(&S, &mut Band<'_, f32>, &mut Tiles<'_>, Range<usize>, &mut Step<F32>),
    ) -> (Plane, Change<F32>) {
        let scheme = S::new(config, 1.0).expect("its scheme");
        let (mut new, mut ring, mut flags) = (*old, [0.0; RING], [0; flags_len(SIDE, SIDE)]);
        let ring = &mut ring[..ring_len(SIDE, scheme.window())];
        let mut tiles = Tiles::new(&mut flags, SIDE, rows_of_tile(SIDE));
        tiles.wake();
        let mut step = Step { settle: Settle::new(None), change: unchanged(config), means: Means::of(means) };
        let mut band = Band { plane: &mut new, aux, ring, width: SIDE, halo: Halo::NONE };
        sweep(&scheme, &mut band, &mut tiles, 0..SIDE, &mut step);
        (new, step.change)
    }

    pub fn unchanged(config: &Config) -> Change<F32> {
        Change::none(&StopRule::new(config, 1.0))
    }

    /// Without curvature every scheme lowers a front that rises by 0.3 per pixel by `dt/dx g 0.3`.
    pub fn assert_that_a_plane_falls<S: Evolve<F32>>(scheme: Scheme) {
        let config = Config { dt: 0.02, dx: 0.1, nu: 0.2, ..Config::PAPER_F160.with_scheme(scheme) };
        let old = plane(|x, _| 0.3 * x - 1.5);
        let (new, change) = swept::<S>(&config, [0.0; 4], (&old, &[0.5; SIDE * SIDE]), S::advance);
        let [_, [left, centre, right], _] = middle(&new);
        for (found, before) in [(left, -0.3), (centre, 0.0), (right, 0.3)] {
            assert!((found - (before - 0.2 * 0.5 * 0.3)).abs() < 1e-6, "{scheme:?}: {before} became {found}");
        }
        let mut expected = unchanged(&config);
        expected.observe(&old, &new);
        assert_eq!((change, change.sum > 0), (expected, true), "{scheme:?}");
        let other = if scheme == Scheme::Fd { Scheme::Sl } else { Scheme::Fd };
        assert_eq!(S::new(&Config::PAPER_F160.with_scheme(other), 1.0).err(), Some(other));
    }

    #[test]
    fn what_is_flat_is_told_in_pixels_and_units_of_the_plane() {
        for (degenerate_power, slope) in [(0, 3.0), (1, 0.6), (2, 0.12)] {
            let config = Config { degenerate: 3.0, degenerate_power, dx: 0.2, ..Config::PAPER_F160 };
            let found = flat_limit::<F32>(&config, 10.0);
            assert!((found - slope * 0.2 * 10.0).abs() < 1e-6, "{degenerate_power}: {found}");
        }
    }
}
