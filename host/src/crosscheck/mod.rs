//! The core beside the reference: every arithmetic, step by step.
//!
//! Each step is held beside the reference's from the core's own input ([`walk`]): a fault shows where it is made, and
//! what a step may differ by follows from its own arithmetic, whatever came before and however often a front steps.
//! The whole runs are compared beside that: there a pixel near u = 0 goes where roundings lead it.

mod borders;
mod combine;
mod compare;
mod notes;
mod report;
mod rounding;
mod settings;
mod signal;
mod walk;

pub use combine::combination;
pub use compare::{Comparison, PlaneDifference, compare, compare_bands, compare_signal};
pub use notes::Difference;
pub use report::{json, table};
pub use settings::{parameters, settings};
pub use signal::{centroids, walk_signal, whole_run};
pub use walk::{walk, walk_bands};

use crate::arithmetics::{self, Task, adapted};
use crate::extraction;
use crate::input::{Combine, Input};
use crate::pipeline::{Drive, segment_in};
use crate::reference::{ReferenceError, Stages, run, run_in};
use rounding::bit;
use skyfront_core::arithmetic::{Arithmetic, F32, Fixed14, Level};
use skyfront_core::config::{Config, Edge, Scheme, Start};
use skyfront_core::error::Error;
use skyfront_core::front::bands;
use skyfront_core::front::profile::Profile;
use thiserror::Error as ThisError;

/// How far a number of the core may lie beyond what [`walk`] explains, at most: the roundings of a step's result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Of the normalised image, and of its two levels in units of their distance.
    pub normalised: f64,
    /// Of the rescaled image, and of each step of the filter.
    pub rescaled: f64,
    /// Of the edge detector.
    pub edge: f64,
    /// Of each step of the front, in its own unit: the paper's u, or pixels in a band.
    pub front: f64,
    /// Of centroids, in pixels.
    pub centroid: f64,
    /// Steps that the whole run may take more or fewer than the reference's; not asked by itself.
    pub steps: Option<u32>,
    /// Pixels that the masks of the whole runs may differ in; not asked by itself.
    pub pixels: Option<usize>,
}

impl Tolerances {
    /// Those of an arithmetic, by name, in a configuration.
    ///
    /// A step adds, multiplies and divides numbers up to 1 a few times, each rounded to 2^-24: 2^-21 are eight such
    /// roundings. A front in a band of B pixels has numbers up to B; the edge detector of `g2mod` is divided by 1 - c2
    /// at the end. Cells of 16 bits round the image to 2^-16, and a front to half of 2^-11, or 0.7 of it by the bound of
    /// `q11`'s first-order step.
    pub fn of(arithmetic: &str, config: &Config) -> Tolerances {
        let band = f64::from(config.band.unwrap_or(1.0)).max(1.0);
        let amplified = match config.edge {
            Edge::G2Mod { c2 } => 1.0 / (1.0 - f64::from(c2)),
            Edge::G1 { .. } | Edge::G2 => 1.0,
        };
        let (image, front) = match arithmetic {
            "q11" => (bit(16), 0.75 * bit(11)),
            _ => (0.0, bit(21) * band),
        };
        Tolerances {
            normalised: bit(21) + image,
            rescaled: bit(21) + image,
            edge: bit(21) * (1.0 + amplified) + image,
            front,
            centroid: 1e-3,
            steps: None,
            pixels: None,
        }
    }

    /// That of a step.
    fn of_step(&self, step: &str) -> f64 {
        match step {
            "levels" | "normalised" => self.normalised,
            "rescaled" | "filtered" => self.rescaled,
            "gradient" | "g" => self.edge,
            "u0" | "u" => self.front,
            "centroids" => self.centroid,
            // A number of the configuration or of a histogram, in f32.
            "tau" | "change" => bit(20),
            // Whole numbers, and times whose roundings are counted where they are compared.
            _ => 0.0,
        }
    }
}

/// An arithmetic beside the reference.
#[derive(Clone, Debug)]
pub struct Check {
    /// Name of the arithmetic.
    pub arithmetic: &'static str,
    /// Each step beside the reference's from the same input, in the order of the run.
    pub steps: Vec<Difference>,
    /// The whole run beside the whole run of the reference, in which roundings add up.
    pub comparison: Comparison,
    /// The tolerances.
    pub tolerances: Tolerances,
}

impl Check {
    /// The steps beyond their tolerance; empty where the check passes.
    pub fn failures(&self) -> Vec<&'static str> {
        let (c, t) = (&self.comparison, &self.tolerances);
        let beyond = |d: &&Difference| d.beyond.is_nan() || d.beyond > t.of_step(d.step);
        let mut failures: Vec<_> = self.steps.iter().filter(beyond).map(|d| d.step).collect();
        let whole = [
            ("steps", t.steps.is_some_and(|most| c.steps.0.abs_diff(c.steps.1) > most)),
            ("mask", t.pixels.is_some_and(|most| c.mask_pixels > most)),
        ];
        failures.extend(whole.iter().filter(|(_, failed)| *failed).map(|(name, _)| *name));
        failures
    }
}

/// Why a check could not be made.
#[derive(Clone, Debug, PartialEq, ThisError)]
pub enum CheckError {
    /// The core refused.
    #[error("{0}")]
    Core(Error),
    /// The reference has nothing to say about the configuration.
    #[error("{0}")]
    NoReference(&'static str),
    /// The reference refused.
    #[error("the reference: {0}")]
    Reference(#[from] ReferenceError),
}

impl From<Error> for CheckError {
    fn from(error: Error) -> Self {
        CheckError::Core(error)
    }
}

/// Why the reference has nothing to say about a configuration, if it has not.
pub fn unheard_of(config: &Config) -> Option<&'static str> {
    let given = config.start == Start::Given;
    given.then_some("the reference has no word on a front that starts from a map: leave --start out")
}

/// Runs one configuration in every arithmetic that serves it, and in the reference. `tolerances` may replace those of
/// an arithmetic.
///
/// # Errors
/// What the core or the reference finds wrong with the configuration or the image.
pub fn crosscheck(
    config: &Config,
    pixels: &[f32],
    width: usize,
    height: usize,
    tolerances: impl Fn(Tolerances) -> Tolerances,
) -> Result<Vec<Check>, CheckError> {
    let further = Vec::new();
    CheckTask { config, pixels, further, size: (width, height), tolerances, reference: None }.checks()
}

/// The same of images that are searched together ([`Input::find_with`]), as `how` says: their combination, and the run
/// over it, or one front in all of them.
///
/// # Errors
/// Those of [`crosscheck`], and of [`bands::serve`] where one front is to go by several images.
pub fn crosscheck_together(
    config: &Config,
    input: &Input,
    how: Combine,
    tolerances: impl Fn(Tolerances) -> Tolerances,
) -> Result<Vec<Check>, CheckError> {
    let (image, further) = (&input.detected.image, input.with.iter().map(Vec::as_slice).collect::<Vec<_>>());
    if !further.is_empty() {
        bands::serve::<F32>(config, further.len() + 1)?;
    }
    let size = (image.width, image.height);
    let task = CheckTask { config, pixels: &image.pixels, further, size, tolerances, reference: None };
    let mut checks = task.checks()?;
    let images: Vec<&[f32]> = input.bands.iter().map(|band| band.image.pixels.as_slice()).collect();
    if let Some(combined) = combination(&images, how, &image.pixels, image.width) {
        checks.iter_mut().for_each(|check| check.steps.insert(0, combined));
    }
    Ok(checks)
}

/// A check in one arithmetic after the other, with the reference run of the last one: most share it.
struct CheckTask<'a, F> {
    config: &'a Config,
    pixels: &'a [f32],
    /// Further bands for the same front.
    further: Vec<&'a [f32]>,
    size: (usize, usize),
    tolerances: F,
    reference: Option<(Config, Stages)>,
}

impl<F: Fn(Tolerances) -> Tolerances> Task for CheckTask<'_, F> {
    type Output = Result<Option<Check>, CheckError>;

    fn run<A: Arithmetic>(&mut self) -> Self::Output {
        let check = match (self.config.sky.is_known(), A::NAME) {
            (false, _) if !self.further.is_empty() => self.on_bands::<A>(),
            (false, _) => self.on_pixels::<A>(),
            (true, <f32 as Level>::NAME) => self.on_signal::<A, f32>(),
            (true, <Fixed14 as Level>::NAME) => self.on_signal::<A, Fixed14>(),
            (true, _) => return Ok(None),
        };
        match check {
            Err(CheckError::Core(Error::Arithmetic { .. })) => Ok(None),
            check => check.map(Some),
        }
    }
}

impl<F: Fn(Tolerances) -> Tolerances> CheckTask<'_, F> {
    /// The checks in every arithmetic that serves.
    fn checks(mut self) -> Result<Vec<Check>, CheckError> {
        if let Some(what) = unheard_of(self.config) {
            return Err(CheckError::NoReference(what));
        }
        let checks: Result<Vec<_>, _> = arithmetics::each(&mut self).into_iter().collect();
        Ok(checks?.into_iter().flatten().collect())
    }

    /// The paper's steps.
    fn on_pixels<A: Arithmetic>(&mut self) -> Result<Check, CheckError> {
        let (width, height) = self.size;
        let config = adapted::<A>(self.config);
        let mut drive = Drive { keep_stages: true, ..Drive::default() };
        let core = segment_in::<A>(&config, self.pixels, width, height, &mut drive)?;
        let stages = match self.reference.take() {
            Some((same, stages)) if same == config => stages,
            _ => {
                let wide: Vec<f64> = self.pixels.iter().map(|&v| v.into()).collect();
                run(&parameters(&config), &wide, width, height)?
            }
        };
        let steps = walk::<A>(&config, &parameters(&config), self.pixels, self.size, &mut |_, _| {})?;
        let unit = f64::from(Profile::new(&config, width, height).unit);
        let comparison = compare(self.pixels, &core, &stages, unit);
        self.reference = Some((config, stages));
        Ok(self.check::<A>(&config, steps, comparison))
    }

    /// The front of the paper's two regions in several bands.
    fn on_bands<A: Arithmetic>(&mut self) -> Result<Check, CheckError> {
        let (width, height) = self.size;
        let config = adapted::<A>(self.config);
        let bands: Vec<&[f32]> = std::iter::once(self.pixels).chain(self.further.iter().copied()).collect();
        let mut drive = Drive { bands: &self.further, ..Drive::default() };
        let core = segment_in::<A>(&config, self.pixels, width, height, &mut drive)?;
        let steps = walk_bands::<A>(&config, &parameters(&config), &bands, self.size)?;
        let wide: Vec<Vec<f64>> = bands.iter().map(|band| band.iter().map(|&v| v.into()).collect()).collect();
        let whole = run_in(&parameters(&config), &wide, width, height)?;
        let unit = f64::from(Profile::new(&config, width, height).unit);
        let comparison = compare_bands(self.pixels, &core, &whole, unit);
        Ok(self.check::<A>(&config, steps, comparison))
    }

    /// A run on signal-to-noise.
    fn on_signal<A: Arithmetic, L: Level>(&mut self) -> Result<Check, CheckError> {
        let (width, height) = self.size;
        let config = adapted::<A>(self.config);
        let core = extraction::segment::<A, L>(&config, self.pixels, width, &mut Drive::default())?;
        let mut steps = walk_signal::<A, L>(&config, &settings(&config), self.pixels, self.size)?;
        steps.push(centroids(self.pixels, &core));
        let unit = match config.scheme {
            Scheme::Region => 1.0,
            _ => Profile::new(&config, width, height).unit.into(),
        };
        let comparison = compare_signal(self.pixels, &core, &whole_run(&config, self.pixels, width)?, unit);
        Ok(self.check::<A>(&config, steps, comparison))
    }

    fn check<A: Arithmetic>(&self, config: &Config, steps: Vec<Difference>, comparison: Comparison) -> Check {
        let tolerances = (self.tolerances)(Tolerances::of(A::NAME, config));
        Check { arithmetic: A::NAME, steps, comparison, tolerances }
    }
}
