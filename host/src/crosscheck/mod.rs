//! The core beside the reference: every arithmetic, stage by stage.

mod compare;
mod report;
mod settings;

pub use compare::{Comparison, Difference, compare};
pub use report::{json, table};
pub use settings::parameters;

use crate::machine::Native;
use crate::pipeline::{Drive, Segmentation, segment_in};
use crate::reference::{ReferenceError, run};
use skyfront_core::arithmetic::{Arithmetic, F32};
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::front::Front;
use thiserror::Error as ThisError;

/// What may differ, at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Of the normalised, rescaled and filtered image.
    pub image: f64,
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
    /// What f32 is held to. Image values are in \[0, 1\] and pass some ten roundings of 6e-8; r1 with alpha = 1/4 and
    /// r3 lift them steeply next to 0 and tau. The detector multiplies differences by 5 / (1 - c2) / (M - m) or, for
    /// g1, by p/4. |du| <= 5e-4 is what the project promises.
    pub const F32: Tolerances =
        Tolerances { image: 1e-5, edge: 1e-3, front: 5e-4, steps: 0, pixels: 0, centroid: 1e-3 };
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
                "g" => t.edge,
                "u" => t.front,
                _ => t.image,
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

/// Runs one configuration in every arithmetic and in the reference. `tolerances` replaces those of each arithmetic.
///
/// # Errors
/// What the core or the reference finds wrong with the configuration or the image.
pub fn crosscheck(
    config: &Config,
    pixels: &[f32],
    width: usize,
    height: usize,
    tolerances: impl Fn(&'static str, Tolerances) -> Tolerances,
) -> Result<Vec<Check>, CheckError> {
    let wide: Vec<f64> = pixels.iter().map(|&v| v.into()).collect();
    let reference = run(&parameters(config), &wide, width, height)?;
    let unit = f64::from(Front::new(config, width, height).unit);
    let check = |arithmetic, core: Segmentation, most| Check {
        arithmetic,
        comparison: compare(pixels, &core, &reference, unit),
        tolerances: tolerances(arithmetic, most),
    };
    let float = kept::<F32<Native>>(config, pixels, width, height)?;
    Ok(vec![check(F32::<Native>::NAME, float, Tolerances::F32)])
}

/// The core's run with its stages.
fn kept<A: Arithmetic>(config: &Config, pixels: &[f32], width: usize, height: usize) -> Result<Segmentation, Error> {
    segment_in::<A>(config, pixels, width, height, &mut Drive { keep_stages: true, ..Drive::default() })
}
