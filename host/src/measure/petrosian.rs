//! The radius at which a source's light has thinned out to a given part of what it is within (Petrosian
//! 1976, doi:10.1086/182301), as the SDSS takes it (Blanton et al. 2001, doi:10.1086/320405): it depends
//! on no outline and little on the distance of a galaxy.

use super::aperture::{Sum, largest};
use super::{Aperture, Flux, Scene, Shape};
use skyfront_core::sources::catalog::Source;
use skyfront_core::sources::flags;
use std::f64::consts::PI;

/// The annulus is as much wider and narrower than the radius.
const ANNULUS: f64 = 1.25;
/// Radii are tried so many in each factor of [`ANNULUS`].
const STEPS: usize = 5;
/// The least radius that is tried, pixels.
const LEAST: f64 = 0.5;
/// Mean light of the annulus, in units of the mean within the radius.
const RATIO: f64 = 0.2;
/// The flux is that within so many radii.
const REACH: f64 = 2.0;

/// A Petrosian radius and the flux that it tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Petrosian {
    /// Semi-major axis, pixels; NaN where there is none.
    pub radius: f64,
    /// Flux within twice the radius.
    pub flux: Flux,
    /// Flags that it earns.
    pub(super) flags: u32,
}

/// The light in one of the ellipses.
#[derive(Clone, Copy)]
struct Within {
    radius: f64,
    area: f64,
    value: f64,
}

impl Petrosian {
    /// None.
    pub const NONE: Petrosian = Petrosian { radius: f64::NAN, flux: Flux::NONE, flags: 0 };

    /// That of a source, in ellipses with its axes. Cost: the pixels of a dozen ellipses of that size, none
    /// larger than an aperture of the source may be.
    pub fn of(scene: &Scene<'_>, shape: &Shape, source: &Source) -> Petrosian {
        let (a, b) = shape.wide_axes();
        let times = |radius: f64| Aperture::ellipse((shape.x, shape.y), (radius, radius * b / a), shape.theta);
        let most = (largest(source.area) * a / (PI * b)).sqrt();
        let within = |radius: f64| {
            let (mut area, mut value) = (0.0, 0.0);
            times(radius).lights(scene, source.label, |_, light, share| {
                area += share;
                value += share * light.value;
            });
            Within { radius, area, value }
        };
        let step = ANNULUS.powf(1.0 / STEPS as f64);
        let radii = std::iter::successors(Some(LEAST), |radius| Some(radius * step)).take_while(|&r| r <= most);
        let Some(radius) = crossing(radii.map(within)) else { return Petrosian::NONE };
        let mut sum = Sum::default();
        let found = times((REACH * radius).min(most)).lights(scene, source.label, |_, light, share| {
            sum.add(light, share);
        });
        let cut = if REACH * radius > most { flags::APERTURE } else { 0 };
        Petrosian { radius, flux: sum.flux(scene), flags: found | cut }
    }
}

/// The first radius at which the annulus falls to the ratio, between two that are tried on a straight
/// line.
fn crossing(within: impl Iterator<Item = Within>) -> Option<f64> {
    let (mut last, mut ellipses) = (None::<(f64, f64)>, Vec::new());
    for one in within {
        ellipses.push(one);
        let Some([inner, .., outer]) = ellipses.last_chunk::<{ 2 * STEPS + 1 }>() else { continue };
        let middle = ellipses[ellipses.len() - 1 - STEPS];
        let mean = middle.value / middle.area;
        let ratio = (outer.value - inner.value) / (outer.area - inner.area) / mean;
        // Darkness has no ratio.
        if !(mean > 0.0 && ratio.is_finite()) {
            last = None;
            continue;
        }
        if let Some((radius, before)) = last.filter(|&(_, before)| before >= RATIO && ratio < RATIO) {
            return Some(radius + (middle.radius - radius) * (before - RATIO) / (before - ratio));
        }
        last = Some((middle.radius, ratio));
    }
    None
}
