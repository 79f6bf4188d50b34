//! Step 3: the filters.

mod starlet;
mod total_variation;

use super::Plane;
pub use starlet::scale_noise;

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
    /// The median of 5 x 5 pixels.
    Median5 {
        /// Iterations.
        steps: u32,
    },
    /// That of C. Tomasi and R. Manduchi over 5 x 5 pixels, with a Gaussian of one pixel.
    Bilateral {
        /// Standard deviation of the weights by brightness.
        contrast: f64,
        /// Iterations.
        steps: u32,
    },
    /// Rudin, Osher and Fatemi's model by Chambolle's projection.
    TotalVariation {
        /// lambda.
        weight: f64,
        /// Iterations.
        steps: u32,
    },
    /// Significant details of the starlet transform.
    Starlet {
        /// Of details, in standard deviations of their noise.
        significance: f64,
        /// Scales.
        scales: u32,
    },
}

/// What a filter works on: the image, and what its passes keep beside it.
#[derive(Clone, Debug)]
pub struct Filtering {
    /// The image as the passes so far left it.
    pub image: Plane,
    /// Of total variation the field's components along rows and columns, of the starlet what is kept of the image.
    pub kept: Vec<Plane>,
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
    /// What is given with its name.
    pub number: f64,
}

impl Filter {
    /// The filter of a name on the command line; [`Filter::None`] for those that are no filter of the paper's steps.
    pub fn named(name: &str, settings: FilterSettings) -> Filter {
        let FilterSettings { steps, dt, diffusion: (f, mu), number } = settings;
        match name {
            "heat" => Filter::Heat { steps, dt },
            "pm" => Filter::PeronaMalik { f, mu, steps, dt },
            "median" => Filter::Median { steps },
            "median5" => Filter::Median5 { steps },
            "bilateral" => Filter::Bilateral { contrast: number, steps },
            "tv" => Filter::TotalVariation { weight: number, steps },
            "starlet" => Filter::Starlet { significance: number, scales: steps },
            _ => Filter::None,
        }
    }

    /// Its passes over the image: one an iteration, and what follows from them.
    pub fn passes(self) -> u32 {
        match self {
            Filter::None => 0,
            Filter::Heat { steps, .. } | Filter::PeronaMalik { steps, .. } | Filter::Bilateral { steps, .. } => steps,
            Filter::Median { steps } | Filter::Median5 { steps } => steps,
            Filter::TotalVariation { steps: 0, .. } | Filter::Starlet { scales: 0, .. } => 0,
            Filter::TotalVariation { steps, .. } | Filter::Starlet { scales: steps, .. } => steps + 1,
        }
    }
}

/// The filtered image.
pub(super) fn filter(filter: Filter, dx: f64, image: &Plane) -> Plane {
    let start = Filtering { image: image.clone(), kept: Vec::new() };
    (0..filter.passes()).fold(start, |now, pass| filter_pass(filter, dx, pass, image, &now)).image
}

/// One pass of the filter, the first being 0; `first` is the image before it.
pub fn filter_pass(filter: Filter, dx: f64, pass: u32, first: &Plane, now: &Filtering) -> Filtering {
    let image = &now.image;
    let image = match filter {
        Filter::None => image.clone(),
        Filter::Heat { dt, .. } => heat(image, dt, dx),
        Filter::PeronaMalik { f, mu, dt, .. } => perona_malik(image, f, mu, dt, dx),
        Filter::Median { .. } => median(image, 1),
        Filter::Median5 { .. } => median(image, 2),
        Filter::Bilateral { contrast, .. } => bilateral(image, contrast),
        Filter::TotalVariation { weight, steps } => return total_variation::pass(weight, steps, pass, now),
        Filter::Starlet { significance, scales } => return starlet::pass(significance, scales, pass, first, now),
    };
    Filtering { image, kept: Vec::new() }
}

/// The values of the pixels up to `radius` rows and columns away, with their distances along rows and columns.
fn square(image: &Plane, radius: isize, i: isize, j: isize) -> impl Iterator<Item = (f64, [isize; 2])> {
    let rows = (-radius..=radius).flat_map(move |y| (-radius..=radius).map(move |x| [x, y]));
    rows.map(move |[x, y]| (image.at(i + x, j + y), [x, y]))
}

/// The median of each pixel and its neighbours.
fn median(old: &Plane, radius: isize) -> Plane {
    Plane::from_fn(old.width(), old.height(), |i, j| {
        let mut values: Vec<f64> = square(old, radius, i, j).map(|(value, _)| value).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    })
}

/// The mean of a pixel and its neighbours, weighted by Gaussians of place and of brightness (C. Tomasi, R. Manduchi
/// 1998, DOI 10.1109/ICCV.1998.710815).
fn bilateral(old: &Plane, contrast: f64) -> Plane {
    Plane::from_fn(old.width(), old.height(), |i, j| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (value, [x, y]) in square(old, 2, i, j) {
            let far = (x * x + y * y) as f64;
            let weight = (-far / 2.0 - ((value - old.at(i, j)) / contrast).powi(2) / 2.0).exp();
            sum += weight * value;
            weights += weight;
        }
        sum / weights
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
