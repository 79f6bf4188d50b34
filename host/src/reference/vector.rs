//! Several bands of one field by one front (T. F. Chan, B. Y. Sandberg, L. A. Vese 2000, DOI 10.1006/jvci.1999.0442).
//!
//! Steps 1 to 3 are taken in each band by itself. Where the front starts near the objects, these are what any band has
//! above its own level.

use super::{Evolution, Parameters, Plane, Prepared, ReferenceError, evolve_in, framed, near, otsu, sources};

/// What came of several bands.
#[derive(Clone, Debug)]
pub struct Vector {
    /// What the front sees of each band.
    pub bands: Vec<Plane>,
    /// The representation function at the start.
    pub u0: Plane,
    /// The front until it stopped.
    pub evolution: Evolution,
    /// {u > 0} without the pixels that the first band does not define.
    pub mask: Vec<bool>,
    /// Sources as of one image.
    pub labels: Vec<u32>,
}

/// The front that starts around what is above its own level in any band.
pub fn near_any(p: &Parameters, bands: &[Plane], levels: &[f64], margin: f64) -> Plane {
    let (width, height) = bands.first().map_or((0, 0), |first| (first.width(), first.height()));
    let above = |i, j| bands.iter().zip(levels).any(|(band, &level)| band.at(i, j) > level);
    let objects = Plane::from_fn(width, height, |i, j| if above(i, j) { 1.0 } else { 0.0 });
    near(p, &objects, 0.5, margin)
}

/// Moves one front in bands of `width` x `height` pixels each.
///
/// # Errors
/// Those of [`super::run`], for any of the bands.
pub fn run_in(p: &Parameters, bands: &[Vec<f64>], width: usize, height: usize) -> Result<Vector, ReferenceError> {
    p.check()?;
    let prepared: Result<Vec<Prepared>, _> = bands.iter().map(|band| Prepared::of(p, band, width, height)).collect();
    let prepared = prepared?;
    let bands: Vec<Plane> = prepared.iter().map(|band| band.last(p.order).clone()).collect();
    let u0 = match p.start_margin {
        None => framed(p, width, height),
        Some(margin) => {
            let level = |at: usize| prepared[at].tau.unwrap_or_else(|| otsu(bands[at].values().iter().copied()));
            let levels: Vec<f64> = (0..bands.len()).map(level).collect();
            near_any(p, &bands, &levels, margin)
        }
    };
    let evolution = evolve_in(p, &bands, &u0);
    let defined = prepared.first().map_or(&[][..], |first| &first.defined);
    let mask: Vec<bool> = evolution.u.values().iter().zip(defined).map(|(&v, &seen)| seen && v > 0.0).collect();
    let (labels, _) = sources(p, &mask, width);
    Ok(Vector { bands, u0, evolution, mask, labels })
}
