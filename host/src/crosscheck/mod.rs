//! The core beside the reference: every arithmetic, stage by stage.

mod compare;
mod report;
mod settings;

pub use compare::{Comparison, Difference, compare};
pub use report::{json, table};
pub use settings::parameters;

use crate::arithmetics::{self, Task, adapted};
use crate::pipeline::{Drive, segment_in};
use crate::reference::{ReferenceError, Stages, run};
use skyfront_core::arithmetic::Arithmetic;
use skyfront_core::config::{Config, Rescale, Tau};
use skyfront_core::error::Error;
use skyfront_core::front::Front;
use thiserror::Error as ThisError;

/// What may differ, at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Of the normalised image.
    pub normalised: f64,
    /// Of the rescaled and the filtered image.
    pub rescaled: f64,
    /// Of the edge detector.
    pub edge: f64,
    /// Of the front, in units of the paper's u.
    pub front: f64,
    /// Number of steps.
    pub steps: u32,
    /// Pixels of the mask, and pixels with another label.
    pub pixels: usize,
    /// Centroids, in pixels.
    pub centroid: f64,
}

impl Tolerances {
    /// The tolerances of an arithmetic, by name, for an image of so many pixels.
    ///
    /// Normalised values are in \[0, 1\] and rounded a few times: to 6e-8 in f32 and q24, to 2^-14 in q11. r1 with
    /// alpha = 1/4 lifts a rounding next to 0, and r3 with beta = 8 one next to tau, to its fourth or eighth root; the
    /// edge detector multiplies differences by 5 / (1 - c2) / (M - m) or, for g1, by p/4. |du| <= 5e-4 in f32, 3
    /// pixels in q24 and 0.2 % of the pixels in q11 are what the project promises: and a source of two pixels that
    /// loses one has its centroid moved by half a pixel.
    pub fn of(arithmetic: &str, pixels: usize) -> Tolerances {
        let exact = Tolerances {
            normalised: 1e-6,
            rescaled: 1e-4,
            edge: 1e-3,
            front: 5e-4,
            steps: 0,
            pixels: 0,
            centroid: 1e-3,
        };
        match arithmetic {
            "q24" => {
                Tolerances { rescaled: 0.12, edge: 0.02, front: 5e-3, steps: 3, pixels: 3, centroid: 0.5, ..exact }
            }
            "q11" => Tolerances {
                normalised: 6.2e-5,
                rescaled: 0.3,
                edge: 0.2,
                front: 0.05,
                steps: 25,
                pixels: pixels / 500,
                centroid: 0.5,
            },
            _ => exact,
        }
    }

    /// The same with more room where r3 takes its threshold from the noise or from a rule that puts it into the flank
    /// of the sky: thousands of pixels lie next to tau there, where r3 turns a rounding of 1e-7 into 1e-3.
    fn for_config(self, config: &Config) -> Tolerances {
        match config.rescale {
            Rescale::R3 { tau: Tau::Kapur | Tau::Rosin | Tau::Noise { .. }, .. } => {
                Tolerances { rescaled: self.rescaled * 20.0, edge: self.edge * 20.0, front: self.front * 4.0, ..self }
            }
            _ => self,
        }
    }
}

/// A comparison with its arithmetic and what it was allowed.
#[derive(Clone, Debug)]
pub struct Check {
    /// Name of the arithmetic.
    pub arithmetic: &'static str,
    /// The differences.
    pub comparison: Comparison,
    /// The tolerances.
    pub tolerances: Tolerances,
}

impl Check {
    /// The quantities beyond their tolerance; empty where the check passes.
    pub fn failures(&self) -> Vec<&'static str> {
        let (c, t) = (&self.comparison, &self.tolerances);
        let stages = c.stages.iter().filter(|d| {
            let most = match d.stage {
                "normalised" => t.normalised,
                "g" => t.edge,
                "u" => t.front,
                _ => t.rescaled,
            };
            beyond(d.max, most)
        });
        let mut failures: Vec<_> = stages.map(|d| d.stage).collect();
        let counted = [
            ("steps", c.steps.0.abs_diff(c.steps.1) > t.steps),
            ("mask", c.mask_pixels > t.pixels),
            ("labels", c.label_pixels > t.pixels),
            ("centroids", beyond(c.centroid_shift, t.centroid)),
        ];
        failures.extend(counted.iter().filter(|(_, failed)| *failed).map(|(name, _)| *name));
        failures
    }
}

/// Whether a difference is more than it may be; one that is not a number always is.
fn beyond(difference: f64, most: f64) -> bool {
    difference.is_nan() || difference > most
}

/// Why a check could not be made.
#[derive(Clone, Debug, PartialEq, ThisError)]
pub enum CheckError {
    /// The core refused.
    #[error("{0}")]
    Core(Error),
    /// The reference refused.
    #[error("the reference: {0}")]
    Reference(#[from] ReferenceError),
}

impl From<Error> for CheckError {
    fn from(error: Error) -> Self {
        CheckError::Core(error)
    }
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
    let mut task = CheckTask { config, pixels, size: (width, height), tolerances, reference: None };
    let checks: Result<Vec<_>, _> = arithmetics::each(&mut task).into_iter().collect();
    Ok(checks?.into_iter().flatten().collect())
}

/// A check in one arithmetic after the other, with the reference run of the last one: most share it.
struct CheckTask<'a, F> {
    config: &'a Config,
    pixels: &'a [f32],
    size: (usize, usize),
    tolerances: F,
    reference: Option<(Config, Stages)>,
}

impl<F: Fn(Tolerances) -> Tolerances> Task for CheckTask<'_, F> {
    type Output = Result<Option<Check>, CheckError>;

    fn run<A: Arithmetic>(&mut self) -> Self::Output {
        let (width, height) = self.size;
        let config = adapted::<A>(self.config);
        let mut drive = Drive { keep_stages: true, ..Drive::default() };
        let core = match segment_in::<A>(&config, self.pixels, width, height, &mut drive) {
            Err(Error::Arithmetic { .. }) => return Ok(None),
            core => core?,
        };
        if self.reference.as_ref().is_none_or(|(same, _)| *same != config) {
            let wide: Vec<f64> = self.pixels.iter().map(|&v| v.into()).collect();
            self.reference = Some((config, run(&parameters(&config), &wide, width, height)?));
        }
        let unit = f64::from(Front::new(&config, width, height).unit);
        let reference = self.reference.as_ref().map(|(_, stages)| stages);
        Ok(reference.map(|stages| Check {
            arithmetic: A::NAME,
            comparison: compare(self.pixels, &core, stages, unit),
            tolerances: (self.tolerances)(Tolerances::of(A::NAME, self.pixels.len()).for_config(&config)),
        }))
    }
}
