//! The Rescaling Segmentation Algorithm in f64, written straight from the paper: the yardstick of `skyfront crosscheck`.
//!
//! Source: S. Tozza, M. Falcone, "On the segmentation of astronomical images via level-set methods". Equation labels
//! in `code` are the LaTeX labels of the paper. Every stage is a whole plane that stays available, differences are
//! divided by dx, nothing is folded, fused or reused: the code is meant to be held beside the page. It shares no
//! numerical code with `skyfront-core`, so that agreement of the two means something. What the default adds to the paper
//! is in [`noise_aware`], written from its description in `host/doc/default.md`.
//!
//! Where the print cannot be taken literally the correction is numbered, and the comments refer to the numbers:
//!
//! 1. u0 is centred on the grid of any W x H (the print gives 300 x 300 with the centre half a pixel off).
//! 2. The curvature term is divided by |D^c|^2 (printed: the first power).
//! 3. The averages of `DFgk` and `SLgk` have `- v` ([`CurvatureForm::Consistent`]; the print is [`CurvatureForm::Printed`]).
//! 4. The threshold C dx^s, not given in the paper, has C = 0.1 and s = 1.
//! 5. r(x) > x is asked on (0, 1) only: the ends are fixed points.
//! 6. mu of Perona-Malik is a gradient, in grey levels per unit of length (not per pixel).
//! 7. g1 must not overflow: IEEE infinity gives exactly 0.
//! 8. [`Stop::Rate`] is the rule per unit time; [`Stop::Paper`] is `critarr`.
//! 9. Every explicit step is held to its CFL bound.

mod arrival;
pub mod chan_vese;
mod edge;
mod error;
mod fd;
mod fd_curvature;
mod fd_filtered;
mod filter;
mod front;
mod initial;
pub mod multiphase;
pub mod noise_aware;
mod normalize;
mod otsu;
mod parameters;
mod plane;
mod rescale;
mod segments;
mod settle;
mod sl;
mod sl_curvature;
mod threshold;
mod vector;

pub use arrival::{arrivals, soonest};
pub use edge::{detector, gradient, gradient_range};
pub use error::ReferenceError;
pub use filter::{Diffusivity, Filter, FilterSettings, Filtering, filter_pass, scale_noise};
pub use front::{Ended, Evolution, at_rest, change, evolve, evolve_in, step};
pub use initial::{framed, half_side, initial, near, saturated};
pub use normalize::{normalize, range};
pub use otsu::otsu;
pub use parameters::{Connectivity, CurvatureForm, Edge, Normalize, Order, Parameters, Rescale, Scheme, Stop, Tau};
pub use plane::{Around, Plane};
pub use rescale::{r1, r2, r3, rescale, threshold};
pub use segments::{centroids, is_beyond_reach, label, sources};
pub use settle::settle;
pub use threshold::{kapur, noise, rosin};
pub use vector::{Vector, near_any, run_in};

/// Everything the algorithm computed on its way, row-major with row 0 first.
#[derive(Clone, Debug)]
pub struct Stages {
    /// The two grey levels of the original image that became 0 and 1.
    pub range: (f64, f64),
    /// Which pixels of the original image were finite.
    pub defined: Vec<bool>,
    /// `risc01`, in \[0, 1\]; undefined pixels hold the lower median.
    pub normalised: Plane,
    /// The threshold of r3; `None` for the other rescalings.
    pub tau: Option<f64>,
    /// After r1, r2 or r3: of the normalised image, or of the filtered one when the filter comes first.
    pub rescaled: Plane,
    /// After the filter: of the rescaled image, or of the normalised one when the filter comes first.
    pub filtered: Plane,
    /// m and M: the range of |grad I|, in grey levels per unit of length.
    pub gradient: (f64, f64),
    /// The edge detector, in \[0, 1\].
    pub g: Plane,
    /// The representation function at the start.
    pub u0: Plane,
    /// The representation function when the front stopped.
    pub u: Plane,
    /// {u > 0} without the undefined pixels.
    pub mask: Vec<bool>,
    /// Sources 1, 2, ... in raster order of their first pixel; 0 is the background.
    pub labels: Vec<u32>,
    /// Number of sources.
    pub sources: u32,
    /// Time steps taken.
    pub steps: u32,
    /// Time at the end, `steps` times dt.
    pub t: f64,
    /// What ended the evolution.
    pub ended: Ended,
    /// After each step, dx^2 times the sum over |v^n| <= eps_F of |v^(n+1) - v^n|.
    pub changes: Vec<f64>,
}

/// Runs the whole algorithm on `width` x `height` pixels, row-major; pixels that are not finite are undefined.
///
/// # Errors
/// A parameter out of its bounds, a length that is not width times height, or an image without two different levels.
pub fn run(parameters: &Parameters, pixels: &[f64], width: usize, height: usize) -> Result<Stages, ReferenceError> {
    run_from(parameters, pixels, framed(parameters, width, height))
}

/// [`run`] with the caller's own representation function, whose size is that of the image.
///
/// # Errors
/// Those of [`run`].
pub fn run_from(parameters: &Parameters, pixels: &[f64], u0: Plane) -> Result<Stages, ReferenceError> {
    parameters.check()?;
    let (p, width) = (parameters, u0.width());
    let prepared = Prepared::of(p, pixels, width, u0.height())?;
    let last = prepared.last(p.order);
    let slope = gradient(last, p.dx);
    let (m, big_m) = gradient_range(&slope);
    let g = match p.scheme {
        Scheme::ChanVese | Scheme::Multiphase => last.clone(),
        _ => detector(p.edge, &slope, m, big_m),
    };
    let u0 = match p.start_margin {
        None => u0,
        Some(margin) => {
            let level = prepared.tau.unwrap_or_else(|| otsu(last.values().iter().copied()));
            near(p, last, level, margin)
        }
    };
    let Prepared { range, defined, normalised, tau, rescaled, filtered } = prepared;
    let Evolution { u, steps, t, ended, changes } = evolve(p, &g, &u0);
    let mask: Vec<bool> = u.values().iter().zip(&defined).map(|(&v, &seen)| seen && v > 0.0).collect();
    let (labels, sources) = sources(p, &mask, width);
    Ok(Stages {
        range,
        defined,
        normalised,
        tau,
        rescaled,
        filtered,
        gradient: (m, big_m),
        g,
        u0,
        u,
        mask,
        labels,
        sources,
        steps,
        t,
        ended,
        changes,
    })
}

/// An image filtered by itself: normalised, filtered, and in its own units again.
///
/// # Errors
/// Those of [`run`].
pub fn filtered(parameters: &Parameters, image: &Plane) -> Result<Plane, ReferenceError> {
    parameters.check()?;
    let Prepared { range, filtered, .. } = Prepared::of(parameters, image.values(), image.width(), image.height())?;
    Ok(denormalized(range, &filtered))
}

/// The image that becomes `normalised` by `range`, clipped to that.
pub fn denormalized((low, high): (f64, f64), normalised: &Plane) -> Plane {
    normalised.map(|v| low + (high - low) * v)
}

/// Steps 1 to 3 of an image.
struct Prepared {
    range: (f64, f64),
    defined: Vec<bool>,
    normalised: Plane,
    tau: Option<f64>,
    rescaled: Plane,
    filtered: Plane,
}

impl Prepared {
    fn of(p: &Parameters, pixels: &[f64], width: usize, height: usize) -> Result<Prepared, ReferenceError> {
        if width < initial::LEAST_SIDE || height < initial::LEAST_SIDE || pixels.len() != width * height {
            return Err(ReferenceError::Size { pixels: pixels.len(), width, height });
        }
        let defined: Vec<bool> = pixels.iter().map(|v| v.is_finite()).collect();
        let range = range(p.normalize, pixels)?;
        let normalised = normalize(range, pixels, width, height);
        let threshold = |image: &Plane| threshold(p.rescale, p.tau, image, &defined);
        let (tau, rescaled, filtered);
        match p.order {
            Order::RescaleFirst => {
                tau = threshold(&normalised);
                rescaled = rescale(p.rescale, tau, &normalised);
                filtered = filter::filter(p.filter, p.dx, &rescaled);
            }
            Order::FilterFirst => {
                filtered = filter::filter(p.filter, p.dx, &normalised);
                tau = threshold(&filtered);
                rescaled = rescale(p.rescale, tau, &filtered);
            }
        }
        Ok(Prepared { range, defined, normalised, tau, rescaled, filtered })
    }

    /// What the front sees.
    fn last(&self, order: Order) -> &Plane {
        match order {
            Order::RescaleFirst => &self.filtered,
            Order::FilterFirst => &self.rescaled,
        }
    }
}
