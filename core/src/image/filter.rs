//! Step 3: the filter, pass by pass over the image plane.

pub mod bilateral;
pub mod median;
pub mod median5;
pub mod starlet;
pub mod total_variation;
pub mod window;

use crate::arithmetic::{Arithmetic, Real};
use crate::config::{Config, Diffusivity, Filter};
use crate::plane::sweep::{Band, Cross, Halo, Kernel, advance, cross};
use crate::sky::otsu::Histogram;
use crate::sky::select::Select;
use bilateral::Bilateral;
use core::ops::Range;
use median::Median;
use median5::Median5;
use starlet::Starlet;
use total_variation::TotalVariation;

/// What a filter works in.
#[derive(Debug)]
pub struct Planes<'a, C> {
    /// The image, W x H.
    pub image: &'a mut [C],
    /// The front plane, W x H, in which no front lies yet: only for filters that say so
    /// ([`Filter::uses_front_plane`]).
    pub spare: &'a mut [C],
    /// At least three padded rows ([`crate::plane::sweep::ring_len`]).
    pub ring: &'a mut [C],
    /// Columns.
    pub width: usize,
}

/// The median of what a filter asks for in its first passes.
#[derive(Debug)]
pub struct Measured<'a> {
    /// The search, while it goes on.
    pub select: &'a Select,
    /// Its counts.
    pub counts: &'a mut Histogram,
    /// What was found.
    pub value: f32,
}

/// Whichever filter a configuration has in steps.
#[derive(Clone, Copy, Debug)]
pub enum AnyFilter<A: Arithmetic> {
    /// None of them.
    None,
    /// The heat equation.
    Heat(Heat<A>),
    /// Perona-Malik.
    PeronaMalik(PeronaMalik<A>),
    /// The median of 3 x 3.
    Median(Median),
    /// The median of 5 x 5.
    Median5(Median5),
    /// Near in place and brightness.
    Bilateral(Bilateral<A>),
    /// Total variation.
    TotalVariation(TotalVariation<A>),
    /// Significant details.
    Starlet(Starlet),
}

impl<A: Arithmetic> AnyFilter<A> {
    /// The filter of a configuration.
    #[inline(always)]
    pub fn new(config: &Config) -> Self {
        match config.filter {
            Filter::None | Filter::Gauss | Filter::Adaptive => AnyFilter::None,
            Filter::Heat => AnyFilter::Heat(Heat::new(config)),
            Filter::PeronaMalik { diffusivity, mu } => {
                AnyFilter::PeronaMalik(PeronaMalik::new(config, diffusivity, mu))
            }
            Filter::Median => AnyFilter::Median(Median),
            Filter::Median5 => AnyFilter::Median5(Median5),
            Filter::Bilateral { contrast } => AnyFilter::Bilateral(Bilateral::new(contrast)),
            Filter::TotalVariation { weight } => AnyFilter::TotalVariation(TotalVariation::new(weight)),
            Filter::Starlet { significance } => AnyFilter::Starlet(Starlet::new(significance)),
        }
    }

    /// Does some rows of a pass of so many steps; those of one pass in order.
    #[inline(always)]
    pub fn rows(
        &mut self,
        planes: &mut Planes<'_, A::Cell>,
        pass: (u32, u16),
        measured: Measured<'_>,
        rows: Range<usize>,
    ) {
        match self {
            AnyFilter::None => {}
            AnyFilter::Heat(filter) => planes.sweep::<A>(filter, rows),
            AnyFilter::PeronaMalik(filter) => planes.sweep::<A>(filter, rows),
            AnyFilter::Median(filter) => planes.sweep::<A>(filter, rows),
            AnyFilter::Median5(filter) => window::rows::<A>(filter, planes, rows),
            AnyFilter::Bilateral(filter) => window::rows::<A>(filter, planes, rows),
            AnyFilter::TotalVariation(filter) => filter.rows(planes, pass, rows),
            AnyFilter::Starlet(filter) => filter.rows::<A>(planes, pass, measured, rows),
        }
    }
}

impl<C> Planes<'_, C> {
    /// Some rows of a pass with a kernel of three rows.
    #[inline(always)]
    fn sweep<A: Arithmetic<Cell = C>>(&mut self, kernel: &mut impl Kernel<A, 3>, rows: Range<usize>) {
        let Planes { image, ring, width, .. } = self;
        let mut band = Band { plane: image, aux: &[], ring, width: *width, halo: Halo::NONE };
        advance::<A, _, 3>(kernel, &mut band, rows);
    }
}

/// One step of the heat equation (`schemacal`): `I + lambda (sum of 4 - 4 I)`.
#[derive(Clone, Copy, Debug)]
pub struct Heat<A: Arithmetic> {
    lambda: A::Real,
}

impl<A: Arithmetic> Heat<A> {
    /// `lambda = dt / dx^2`, at most 1/4.
    pub fn new(config: &Config) -> Self {
        Heat { lambda: A::Real::of(config.filter_dt / (config.dx * config.dx)) }
    }
}

impl<A: Arithmetic> Kernel<A, 3> for Heat<A> {
    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; 3], _aux: &[A::Cell], new: &mut [A::Cell]) {
        let filter = *self;
        let Cross { centre, left, right, below, above } = cross(old);
        for (((((new, &i), &l), &r), &b), &a) in new.iter_mut().zip(centre).zip(left).zip(right).zip(below).zip(above) {
            let i = A::pixel(i);
            let (l, r, b, a) = (A::pixel(l) - i, A::pixel(r) - i, A::pixel(b) - i, A::pixel(a) - i);
            *new = A::to_pixel(i + filter.lambda * ((l + r) + (b + a)));
        }
    }
}

/// One step of Perona-Malik (`eq:PM`) in the form of its authors (doi:10.1109/34.56205):
/// `I + lambda sum f(|d| / dx) d` over the differences d to the four neighbours.
#[derive(Clone, Copy, Debug)]
pub struct PeronaMalik<A: Arithmetic> {
    lambda: A::Real,
    /// `1 / (dx mu)`: differences become gradients in units of mu.
    sharpness: A::Real,
    diffusivity: Diffusivity,
}

impl<A: Arithmetic> PeronaMalik<A> {
    /// `mu` in image units per `dx`.
    pub fn new(config: &Config, diffusivity: Diffusivity, mu: f32) -> Self {
        PeronaMalik {
            lambda: A::Real::of(config.filter_dt / (config.dx * config.dx)),
            sharpness: A::Real::of(1.0 / (config.dx * mu)),
            diffusivity,
        }
    }

    /// `f(|d| / dx) d`.
    #[inline(always)]
    fn flow(&self, d: A::Real) -> A::Real {
        let s = d * self.sharpness;
        match self.diffusivity {
            Diffusivity::F1 => d.ratio(A::Real::ONE + s * s),
            Diffusivity::F2 => A::exp_neg(s * s) * d,
        }
    }
}

impl<A: Arithmetic> Kernel<A, 3> for PeronaMalik<A> {
    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; 3], _aux: &[A::Cell], new: &mut [A::Cell]) {
        let filter = *self;
        let Cross { centre, left, right, below, above } = cross(old);
        for (((((new, &i), &l), &r), &b), &a) in new.iter_mut().zip(centre).zip(left).zip(right).zip(below).zip(above) {
            let i = A::pixel(i);
            let (l, r) = (filter.flow(A::pixel(l) - i), filter.flow(A::pixel(r) - i));
            let (b, a) = (filter.flow(A::pixel(b) - i), filter.flow(A::pixel(a) - i));
            *new = A::to_pixel(i + filter.lambda * ((l + r) + (b + a)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    /// A pixel of 0.5, after one pass of a kernel, whose neighbours are lower by 0.4, 0.2 and 0.1 and higher by 0.2.
    fn filtered(mut kernel: impl Kernel<F32, 3>) -> f32 {
        let [below, row, above] = [[9.0, 0.4, 9.0], [0.1, 0.5, 0.3], [9.0, 0.7, 9.0]];
        let mut new = [0.5];
        kernel.row(&[&below, &row, &above], &[], &mut new);
        new[0]
    }

    #[test]
    fn filters_move_a_pixel_as_their_equations_say() {
        // lambda = dt / dx^2 = 0.2, and differences count in fifths.
        let config = Config { filter_dt: 2e-3, dx: 0.1, ..Config::PAPER_F160 };
        let perona_malik = |diffusivity| filtered(PeronaMalik::<F32>::new(&config, diffusivity, 2.0));
        let expected = [
            (filtered(Heat::<F32>::new(&config)), 0.5 - 0.2 * 0.5),
            // 0.4 / 5 + 0.2 / 2 + 0.1 / 1.25 - 0.2 / 2.
            (perona_malik(Diffusivity::F1), 0.5 - 0.2 * 0.16),
            // 0.4 exp(-4) + 0.2 exp(-1) + 0.1 exp(-1/4) - 0.2 exp(-1).
            (perona_malik(Diffusivity::F2), 0.5 - 0.2 * 0.085_206_3),
        ];
        for (found, expected) in expected {
            assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
        }
    }
}
