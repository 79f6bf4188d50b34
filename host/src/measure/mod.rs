//! What an astronomer wants to know of a source, measured on the original pixels in f64.
//!
//! Fluxes are sums above the background. Their errors are `sqrt(sum sigma^2 + flux / gain)` over
//! the same pixels, sigma being the noise of the background; the second term is left out where no
//! gain is known. Positions count from 0 here.

mod aperture;
mod growth;
mod level;
mod overlap;
mod scene;
mod shape;

pub use aperture::Aperture;
pub use level::{Level, clipped_scatter, estimate};
pub use scene::Scene;
pub use shape::{Shape, Values};

use crate::sky::Sky;
use growth::Growth;
use skyfront_core::catalog::Source;
use skyfront_core::flags;

/// Kron's first moment is taken within this many times the ellipse of the second moments.
const KRON_REACH: f64 = 6.0;
/// The Kron aperture in units of that moment, and its least size in units of the ellipse
/// (SExtractor's `PHOT_AUTOPARAMS`).
const KRON: (f64, f64) = (2.5, 3.5);
/// Halvings of the interval in which the half-light radius lies.
const HALVINGS: usize = 24;

/// What is known beside the image and the labels; what is absent is estimated or left out.
#[derive(Clone, Debug, Default)]
pub struct Extras<'a> {
    /// Background; by default the median of the pixels outside all sources.
    pub background: Option<Level<'a>>,
    /// Standard deviation of the background's noise, not finite where a pixel is not to be used;
    /// by default estimated from the pixels outside all sources.
    pub noise: Option<Level<'a>>,
    /// Electrons in a unit of the image.
    pub gain: Option<f64>,
    /// Pixel value from which pixels are saturated.
    pub saturation: Option<f64>,
    /// Magnitude of a flux of 1.
    pub zero_point: Option<f64>,
    /// Radii of circular apertures, pixels.
    pub apertures: Vec<f64>,
    /// Flags that every source has.
    pub flags: u32,
}

/// A flux with its error, in units of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flux {
    /// Above the background.
    pub value: f64,
    /// One standard deviation.
    pub error: f64,
}

impl Flux {
    /// Magnitude and its error for a zero point; NaN where there is no flux.
    pub fn magnitude(&self, zero_point: f64) -> (f64, f64) {
        if self.value > 0.0 {
            (zero_point - 2.5 * libm::log10(self.value), 2.5 / std::f64::consts::LN_10 * self.error / self.value)
        } else {
            (f64::NAN, f64::NAN)
        }
    }
}

/// A source with all that was measured.
#[derive(Clone, Debug)]
pub struct Measured {
    /// What the core summed up.
    pub source: Source,
    /// Centroid, moments and ellipse, above the background.
    pub shape: Shape,
    /// The pixel values as they are.
    pub values: Values,
    /// Flux of the segment.
    pub flux: Flux,
    /// Mean background under the source.
    pub background: f64,
    /// Mean noise under the source.
    pub noise: f64,
    /// Mean value above the background along the outline.
    pub threshold: f64,
    /// Semi-major axis of the Kron aperture, pixels.
    pub kron_radius: f64,
    /// Flux in the Kron aperture.
    pub kron: Flux,
    /// Radius of the circle around the centroid with half of the Kron flux; NaN where none has.
    pub half_light: f64,
    /// Flux in each circular aperture.
    pub apertures: Vec<Flux>,
    /// Right ascension and declination, degrees.
    pub position: Option<(f64, f64)>,
    /// Major axis from north through east, degrees.
    pub position_angle: Option<f64>,
    /// Bits of [`skyfront_core::flags`].
    pub flags: u32,
}

/// Measures all sources; labels are those of `scene`, 1 for the first source.
pub fn measure(scene: &Scene<'_>, sources: &[Source], extras: &Extras<'_>, sky: Option<&Sky>) -> Vec<Measured> {
    let sums = shape::sums(scene, sources);
    sources.iter().zip(&sums).map(|(source, sums)| one(scene, source, sums, extras, sky)).collect()
}

fn one(scene: &Scene<'_>, source: &Source, sums: &shape::Sums, extras: &Extras<'_>, sky: Option<&Sky>) -> Measured {
    let shape = sums.shape(source);
    let label = source.label;
    let (background, noise, threshold) = sums.levels();
    let mut flags = sums.flags() | extras.flags;
    let mut flux_in = |aperture: Aperture| {
        let (flux, found) = aperture.flux(scene, label);
        flags |= found;
        flux
    };
    let ellipse = kron_aperture(scene, &shape, label);
    let kron = flux_in(ellipse);
    let apertures =
        extras.apertures.iter().map(|&radius| flux_in(Aperture::circle(shape.x, shape.y, radius))).collect();
    Measured {
        source: *source,
        shape,
        values: sums.values(source),
        flux: sums.flux(scene),
        background,
        noise,
        threshold,
        kron_radius: ellipse.a,
        kron,
        half_light: half_light(scene, &shape, label, ellipse.a, kron.value),
        apertures,
        position: sky.and_then(|sky| sky.position(shape.x, shape.y)),
        position_angle: sky.and_then(|sky| sky.position_angle(shape.x, shape.y, shape.theta)),
        flags: flags & !shape::OUTLINE,
    }
}

/// The ellipse of the second moments, enlarged to hold nearly all light.
fn kron_aperture(scene: &Scene<'_>, shape: &Shape, label: u32) -> Aperture {
    let (a, b) = shape.wide_axes();
    let times = |factor: f64| Aperture::ellipse((shape.x, shape.y), (factor * a, factor * b), shape.theta);
    let moment = times(KRON_REACH).first_moment(scene, label).unwrap_or(0.0) * KRON_REACH;
    times((KRON.0 * moment).max(KRON.1))
}

/// The radius of the circle with half of a flux, at most `reach`.
fn half_light(scene: &Scene<'_>, shape: &Shape, label: u32, reach: f64, total: f64) -> f64 {
    if total.is_nan() || total <= 0.0 {
        return f64::NAN;
    }
    let growth = Growth::new(scene, label, (shape.x, shape.y), reach);
    if growth.within(reach) < 0.5 * total {
        return f64::NAN;
    }
    let (mut low, mut high) = (0.0, reach);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if growth.within(middle) < 0.5 * total { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The flags that a whole run earns.
pub fn run_flags(outcome: &skyfront_core::outcome::Outcome) -> u32 {
    let limit = outcome.reason == skyfront_core::outcome::StopReason::TimeLimit;
    let full = outcome.unlabelled > 0 || outcome.catalogued < outcome.sources;
    (if limit { flags::LIMIT } else { 0 }) | (if full { flags::NO_ROOM } else { 0 })
}
