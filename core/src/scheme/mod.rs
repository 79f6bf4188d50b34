//! Step 5: the schemes that move the front, a family of files of one shape.
//!
//! Each scheme is a row kernel on the front plane with the edge detector as the other row. All use
//! undivided differences: lengths are pixels, and dx enters only through a few coefficients.

mod any;
mod fd;
mod fd_curvature;
mod sl;
mod sl_curvature;

pub use any::AnyScheme;
pub use fd::Fd;
pub use fd_curvature::FdCurvature;
pub use sl::Sl;
pub use sl_curvature::SlCurvature;

use crate::arithmetic::{Arithmetic, Real};
use crate::config::{Config, Scheme};
use crate::stop::Change;
use crate::sweep::{Halo, Kernel, advance};
use core::ops::Range;

/// A scheme for the evolution, chosen at compile time (one scheme in the program) or at run time
/// ([`AnyScheme`]).
pub trait Evolve<A: Arithmetic>: Sized {
    /// Builds the scheme of a validated configuration, or says that it is another one.
    ///
    /// # Errors
    /// The name of the scheme that this type cannot serve.
    fn new(config: &Config, unit: f32) -> Result<Self, Scheme>;

    /// Rows of the window: 2R + 1.
    fn window(&self) -> usize;

    /// Moves the front in `rows` of a band by one step and adds what changed to `change`.
    #[allow(clippy::too_many_arguments, reason = "the planes, the scratch and the rows of one sweep")]
    fn advance(
        &self,
        front: &mut [A::Cell],
        speed: &[A::Cell],
        ring: &mut [A::Cell],
        width: usize,
        rows: Range<usize>,
        halo: Halo<'_, A::Cell>,
        change: &mut Change<A>,
    );
}

/// A scheme's kernel together with the record of what it changed.
struct Tracked<'a, A: Arithmetic, K> {
    kernel: K,
    change: &'a mut Change<A>,
}

impl<A: Arithmetic, K: Kernel<A, N>, const N: usize> Kernel<A, N> for Tracked<'_, A, K> {
    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; N], speed: &[A::Cell], new: &mut [A::Cell]) {
        self.kernel.row(old, speed, new);
        let before = old.get(N / 2).and_then(|row| row.get(N / 2..)).unwrap_or(&[]);
        self.change.observe(before.get(..new.len()).unwrap_or(&[]), new);
    }
}

/// One tracked sweep of a kernel: what every scheme's `advance` does.
#[allow(clippy::too_many_arguments, reason = "the planes, the scratch and the rows of one sweep")]
fn tracked<A: Arithmetic, K: Kernel<A, N>, const N: usize>(
    kernel: K,
    front: &mut [A::Cell],
    speed: &[A::Cell],
    ring: &mut [A::Cell],
    width: usize,
    rows: Range<usize>,
    halo: Halo<'_, A::Cell>,
    change: &mut Change<A>,
) {
    advance::<A, _, N>(&mut Tracked { kernel, change }, front, speed, ring, width, rows, halo);
}

/// The length of an undivided central difference below which the front counts as flat:
/// `|D^c| <= degenerate dx`, as `|(r - l) / 2|` in units of the front plane.
fn flat_limit<A: Arithmetic>(config: &Config, unit: f32) -> A::Real {
    A::Real::of(config.degenerate * config.dx * config.dx * unit)
}
