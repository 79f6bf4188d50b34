//! Step 3: the filters.

use super::Plane;

/// Filter of step 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// The image as it is.
    None,
    /// `schemacal`.
    Heat {
        /// Iterations.
        steps: u32,
        /// Time step.
        dt: f64,
    },
    /// `eq:PM`.
    PeronaMalik {
        /// f1 or f2.
        f: Diffusivity,
        /// Gradient threshold, in grey levels per unit of length.
        mu: f64,
        /// Iterations.
        steps: u32,
        /// Time step.
        dt: f64,
    },
    /// The median of 3 x 3 pixels.
    Median {
        /// Iterations.
        steps: u32,
    },
}

/// Diffusion coefficient of Perona and Malik.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Diffusivity {
    /// 1 / (1 + (z/mu)^2).
    F1,
    /// exp(-(z/mu)^2).
    F2,
}

/// What a filter may be told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSettings {
    /// Iterations.
    pub steps: u32,
    /// Time step.
    pub dt: f64,
    /// f1 or f2, and its gradient threshold.
    pub diffusion: (Diffusivity, f64),
}

impl Filter {
    /// The filter of a name on the command line; [`Filter::None`] for those that are no filter of the paper's steps.
    pub fn named(name: &str, FilterSettings { steps, dt, diffusion: (f, mu) }: FilterSettings) -> Filter {
        match name {
            "heat" => Filter::Heat { steps, dt },
            "pm" => Filter::PeronaMalik { f, mu, steps, dt },
            "median" => Filter::Median { steps },
            _ => Filter::None,
        }
    }

    /// Its iterations.
    pub fn steps(self) -> u32 {
        match self {
            Filter::None => 0,
            Filter::Heat { steps, .. } | Filter::PeronaMalik { steps, .. } | Filter::Median { steps } => steps,
        }
    }
}

/// The filtered image.
pub(super) fn filter(filter: Filter, dx: f64, image: &Plane) -> Plane {
    (0..filter.steps()).fold(image.clone(), |image, _| filter_step(filter, dx, &image))
}

/// One step of the filter.
pub fn filter_step(filter: Filter, dx: f64, image: &Plane) -> Plane {
    match filter {
        Filter::None => image.clone(),
        Filter::Heat { dt, .. } => heat(image, dt, dx),
        Filter::PeronaMalik { f, mu, dt, .. } => perona_malik(image, f, mu, dt, dx),
        Filter::Median { .. } => median(image),
    }
}

/// The median of each pixel and its eight neighbours.
fn median(old: &Plane) -> Plane {
    Plane::from_fn(old.width(), old.height(), |i, j| {
        let old = old.around(i, j);
        let mut nine = [old.nw, old.n, old.ne, old.w, old.c, old.e, old.sw, old.s, old.se];
        nine.sort_by(f64::total_cmp);
        nine[4]
    })
}

/// One step of `schemacal`.
fn heat(old: &Plane, dt: f64, dx: f64) -> Plane {
    Plane::from_fn(old.width(), old.height(), |i, j| {
        let old = old.around(i, j);
        old.c + dt * (old.e + old.n - 4.0 * old.c + old.w + old.s) / (dx * dx)
    })
}

/// One step of `eq:PM` in the four-neighbour form of P. Perona and J. Malik 1990 (DOI 10.1109/34.56205). Each
/// difference to a neighbour, divided by dx, is the gradient that mu is compared with (erratum 6).
fn perona_malik(old: &Plane, f: Diffusivity, mu: f64, dt: f64, dx: f64) -> Plane {
    Plane::from_fn(old.width(), old.height(), |i, j| {
        let old = old.around(i, j);
        let mut flow = 0.0;
        for neighbour in [old.e, old.n, old.w, old.s] {
            let slope = (neighbour - old.c) / dx;
            flow += coefficient(f, slope.abs(), mu) * slope;
        }
        old.c + dt * flow / dx
    })
}

/// f1 or f2 of a gradient.
fn coefficient(f: Diffusivity, gradient: f64, mu: f64) -> f64 {
    let ratio = gradient / mu;
    match f {
        Diffusivity::F1 => 1.0 / (1.0 + ratio * ratio),
        Diffusivity::F2 => (-ratio * ratio).exp(),
    }
}
