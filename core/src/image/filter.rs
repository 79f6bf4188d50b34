//! Step 3: the filter, one explicit time step a sweep.

pub mod median;

use crate::arithmetic::{Arithmetic, Real};
use crate::config::{Config, Diffusivity, Filter};
use crate::plane::sweep::{Cross, Kernel, cross};
use median::Median;

/// One step of whichever filter a configuration has in steps.
#[derive(Clone, Copy, Debug)]
pub enum AnyFilter<A: Arithmetic> {
    /// None of them.
    None,
    /// The heat equation.
    Heat(Heat<A>),
    /// Perona-Malik.
    PeronaMalik(PeronaMalik<A>),
    /// The median.
    Median(Median),
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
        }
    }
}

impl<A: Arithmetic> Kernel<A, 3> for AnyFilter<A> {
    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; 3], aux: &[A::Cell], new: &mut [A::Cell]) {
        match self {
            AnyFilter::None => {}
            AnyFilter::Heat(filter) => filter.row(old, aux, new),
            AnyFilter::PeronaMalik(filter) => filter.row(old, aux, new),
            AnyFilter::Median(filter) => Kernel::<A, 3>::row(filter, old, aux, new),
        }
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
