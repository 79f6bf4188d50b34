//! What an astronomer wants to know of a source, measured on the original pixels in f64.
//!
//! Fluxes are sums above the background. Their errors are `sqrt(sum sigma^2 + flux / gain)` over
//! the same pixels, sigma being the noise of the background; the second term is left out where no
//! gain is known. Positions count from 0 here.

mod aperture;
mod growth;
mod level;
mod local;
mod overlap;
mod petrosian;
mod scene;
mod shape;
mod window;

pub use aperture::Aperture;
pub use level::{Level, clipped_scatter, estimate};
pub use local::Local;
pub use petrosian::Petrosian;
pub use scene::{Neighbours, Scene};
pub use shape::{Ellipse, Shape, Values};
pub use window::Windowed;

use crate::sky::{Patch, Sky};
use crate::workers::in_order;
use aperture::{Sum, largest_kron};
use growth::Growth;
use skyfront_core::sources::catalog::Source;
use skyfront_core::sources::flags;
use skyfront_core::sources::measure::{Levels, Sums};
use std::f64::consts::PI;

/// Sources that a thread takes at a time.
const PIECE: usize = 32;
/// Kron's first moment is taken within this many times the ellipse of the second moments.
const KRON_REACH: f64 = 6.0;
/// The Kron aperture in units of that moment, and its least size in units of the ellipse
/// (SExtractor's `PHOT_AUTOPARAMS`).
const KRON: (f64, f64) = (2.5, 3.5);

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
    /// What apertures count where they meet other sources.
    pub neighbours: Neighbours,
    /// What is measured beyond the pixels of the sources.
    pub wanted: Wanted,
    /// Flags that every source has.
    pub flags: u32,
    /// Threads that measure; the result does not depend on them.
    pub threads: usize,
    /// The row of the image that the pixels begin with, where they are a strip of it: places are those in the image.
    pub first_row: usize,
}

/// What is measured beyond the pixels of the sources; what is not wanted costs nothing and is NaN.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// The Kron aperture and the half-light radius.
    pub kron: bool,
    /// The windowed centroid; needs the half-light radius.
    pub windowed: bool,
    /// The background beside the source.
    pub local: bool,
    /// The Petrosian radius.
    pub petrosian: bool,
}

impl Wanted {
    /// Nothing.
    pub const NOTHING: Wanted = Wanted { kron: false, windowed: false, local: false, petrosian: false };
}

impl Default for Wanted {
    fn default() -> Self {
        Wanted { kron: true, ..Wanted::NOTHING }
    }
}

/// A flux with its error, in units of the image.
///
/// ```
/// use skyfront::measure::Flux;
///
/// let (magnitude, error) = Flux { value: 100.0, error: 1.0 }.magnitude(25.0);
/// assert!((magnitude - 20.0).abs() < 1e-9 && (error - 0.0109).abs() < 1e-4);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flux {
    /// Above the background.
    pub value: f64,
    /// One standard deviation.
    pub error: f64,
}

impl Flux {
    /// No flux.
    pub const NONE: Flux = Flux { value: f64::NAN, error: f64::NAN };

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
///
/// ```
/// use skyfront::measure::{Extras, Scene, measure};
/// use skyfront::pipeline::{Drive, segment};
/// use skyfront::truth::simulated;
/// use skyfront_core::config::Config;
/// use skyfront_core::simulate::Kind;
///
/// let (image, _) = simulated(Kind::Bright, 5, 96, 96);
/// let run = segment(&Config::NOISE_AWARE, &image.pixels, 96, 96, &mut Drive::default())?;
/// let extras = Extras { apertures: vec![3.0], ..Extras::default() };
/// let scene = Scene::new(&image.pixels, &run.labels, 96, 96, &extras);
/// for source in measure(&scene, &run.sources, &extras, None) {
///     let (flux, circle) = (source.kron, source.apertures[0]);
///     println!("{:.2} {:.2}", source.shape.x, source.shape.y);
///     println!("{:.4} +- {:.4}, in 3 pixels {:.4}", flux.value, flux.error, circle.value);
/// }
/// # assert!(!run.sources.is_empty());
/// # Ok::<(), skyfront_core::error::Error>(())
/// ```
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
    /// Radius of the circle around the centroid with half of the Kron aperture's light; NaN where
    /// there is none.
    pub half_light: f64,
    /// Flux in each circular aperture.
    pub apertures: Vec<Flux>,
    /// The windowed centroid.
    pub windowed: Windowed,
    /// The background beside the source.
    pub local: Local,
    /// The Petrosian radius and flux.
    pub petrosian: Petrosian,
    /// Flux of the segment above the background beside the source, with the noise there.
    pub local_flux: Flux,
    /// Right ascension and declination, degrees.
    pub position: Option<(f64, f64)>,
    /// Longitude and latitude along the header's own axes, degrees.
    pub own_position: Option<(f64, f64)>,
    /// The sky around the centroid.
    pub patch: Option<Patch>,
    /// Right ascension and declination of the windowed centroid, degrees.
    pub windowed_position: Option<(f64, f64)>,
    /// Major axis from north through east, degrees.
    pub position_angle: Option<f64>,
    /// Bits of [`skyfront_core::sources::flags`].
    pub flags: u32,
    /// The same source in further images.
    pub bands: Vec<Measured>,
}

impl Measured {
    /// Moves all places by so many columns and rows: those of a part of an image become those of the image.
    pub fn shift(&mut self, (columns, rows): (usize, usize)) {
        let (x, y) = (columns as f64, rows as f64);
        let by =
            |(first, last): (u32, u32), (columns, rows): (usize, usize)| (first + columns as u32, last + rows as u32);
        self.source.columns = by(self.source.columns, (columns, columns));
        self.source.rows = by(self.source.rows, (rows, rows));
        self.values.peak_at = by(self.values.peak_at, (columns, rows));
        (self.shape.x, self.shape.y) = (self.shape.x + x, self.shape.y + y);
        (self.windowed.x, self.windowed.y) = (self.windowed.x + x, self.windowed.y + y);
    }
}

/// Measures all sources; labels are those of `scene`, 1 for the first source. Cost: one pass over
/// the image, and the pixels of every aperture.
pub fn measure(scene: &Scene<'_>, sources: &[Source], extras: &Extras<'_>, sky: Option<&Sky>) -> Vec<Measured> {
    let sums = shape::sums(scene, sources.len(), extras.threads);
    let task = Task { scene, extras, sky };
    in_order(sources.len(), PIECE, extras.threads, |index, growth: &mut Growth| {
        let sums = &sums[index];
        task.one(&sources[index], sums, Shape::of(sums), growth)
    })
}

/// Measures the circular apertures at places, columns and rows from 0, as if a source of the label
/// there had its centroid at each; all else is NaN.
pub fn measure_at(scene: &Scene<'_>, places: &[(f64, f64)], extras: &Extras<'_>, sky: Option<&Sky>) -> Vec<Measured> {
    let extras = &Extras { wanted: Wanted::NOTHING, ..extras.clone() };
    let task = Task { scene, extras, sky };
    in_order(places.len(), PIECE, extras.threads, |index, growth: &mut Growth| {
        let (x, y) = places[index];
        let source = Source::empty(scene.label_at(x, y));
        let measured = task.one(&source, &Sums::default(), Shape::at(x, y), growth);
        Measured { flux: Flux::NONE, flags: measured.flags & !flags::NO_FLUX, ..measured }
    })
}

/// What every source is measured with.
struct Task<'a> {
    scene: &'a Scene<'a>,
    extras: &'a Extras<'a>,
    sky: Option<&'a Sky>,
}

/// The Kron aperture's semi-major axis and flux, the half-light radius, and flags.
struct Kron {
    radius: f64,
    flux: Flux,
    half_light: f64,
    flags: u32,
}

impl Task<'_> {
    fn one(&self, source: &Source, sums: &Sums, shape: Shape, growth: &mut Growth) -> Measured {
        let Task { scene, extras, sky } = self;
        let label = source.label;
        let Levels { background, noise, threshold } = sums.levels();
        let flux = sums.flux(scene.gain());
        let wanted = extras.wanted;
        let kron = if wanted.kron || wanted.windowed { self.kron(&shape, source, growth) } else { Kron::NONE };
        let mut flags = sums.flags() | extras.flags | kron.flags;
        let mut flux_in = |radius: f64| {
            let (flux, found) = Aperture::circle(shape.x, shape.y, radius).flux(scene, label);
            flags |= found;
            flux
        };
        let apertures = extras.apertures.iter().map(|&radius| flux_in(radius)).collect();
        let windowed = if wanted.windowed {
            Windowed::of(scene, source, (shape.x, shape.y), kron.half_light)
        } else {
            Windowed::NONE
        };
        let petrosian = if wanted.petrosian { Petrosian::of(scene, &shape, source) } else { Petrosian::NONE };
        flags |= petrosian.flags;
        let local = if wanted.local { Local::of(scene, source) } else { Local::NONE };
        Measured {
            source: *source,
            shape,
            values: Values::of(sums, source),
            flux: Flux { value: flux.value, error: flux.error },
            background,
            noise,
            threshold,
            kron_radius: kron.radius,
            kron: kron.flux,
            half_light: kron.half_light,
            apertures,
            windowed,
            local,
            petrosian,
            local_flux: shape::flux_beside(sums, scene, &local),
            position: sky.and_then(|sky| sky.position(shape.x, shape.y)),
            own_position: sky.and_then(|sky| sky.own_position(shape.x, shape.y)),
            patch: sky.and_then(|sky| sky.patch(shape.x, shape.y)),
            windowed_position: sky.filter(|_| wanted.windowed).and_then(|sky| sky.position(windowed.x, windowed.y)),
            position_angle: sky.and_then(|sky| sky.position_angle(shape.x, shape.y, shape.theta)),
            flags,
            bands: Vec::new(),
        }
    }

    /// The Kron aperture, and the circle with half of its light.
    fn kron(&self, shape: &Shape, source: &Source, growth: &mut Growth) -> Kron {
        let (scene, label) = (self.scene, source.label);
        let (ellipse, whole) = kron_aperture(scene, shape, source);
        let mut sum = Sum::default();
        growth.clear();
        let found = ellipse.lights(scene, label, |spot, light, share| {
            sum.add(light, share);
            growth.add(spot.dx, spot.dy, share * light.value);
        });
        let flags = found | if whole { 0 } else { flags::APERTURE };
        let flux = sum.flux(scene);
        let half_light = if flux.value > 0.0 {
            growth.settle();
            growth.radius_of(0.5 * flux.value, |distances, each| ellipse.lights_between(scene, label, distances, each))
        } else {
            f64::NAN
        };
        Kron { radius: ellipse.a, flux, half_light, flags }
    }
}

impl Kron {
    const NONE: Kron = Kron { radius: f64::NAN, flux: Flux::NONE, half_light: f64::NAN, flags: 0 };
}

/// The ellipse of the second moments, enlarged to hold nearly all light, and whether it is as large as
/// it should be: none is larger than [`largest_kron`].
fn kron_aperture(scene: &Scene<'_>, shape: &Shape, source: &Source) -> (Aperture, bool) {
    let (a, b) = shape.wide_axes();
    let times = |factor: f64| Aperture::ellipse((shape.x, shape.y), (factor * a, factor * b), shape.theta);
    let most = (largest_kron(source.area) / (PI * a * b)).sqrt();
    let reach = KRON_REACH.min(most);
    let moment = times(reach).first_moment(scene, source.label).unwrap_or(0.0) * reach;
    let wanted = (KRON.0 * moment).max(KRON.1);
    (times(wanted.min(most)), wanted <= most && reach == KRON_REACH)
}

/// The flags that a whole run earns.
pub fn run_flags(outcome: &skyfront_core::run::outcome::Outcome) -> u32 {
    let limit = outcome.reason == skyfront_core::run::outcome::StopReason::TimeLimit;
    let full = outcome.unlabelled > 0 || outcome.catalogued < outcome.sources;
    (if limit { flags::LIMIT } else { 0 }) | (if full { flags::NO_ROOM } else { 0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Kron's ellipse around a thin ring of the radius 300 would have 300 times its pixels.
    #[test]
    fn the_kron_aperture_of_a_ring_is_cut_and_that_of_a_disc_is_not() {
        const SIDE: usize = 700;
        let measured = |least: f64| {
            let far = |at: usize| ((at % SIDE) as f64 - 350.0).hypot((at / SIDE) as f64 - 350.0);
            let labels: Vec<u32> = (0..SIDE * SIDE).map(|at| u32::from(far(at) < 303.0 && far(at) >= least)).collect();
            let pixels: Vec<f32> = labels.iter().map(|&label| 10.0 * label as f32).collect();
            let constant = |value| Some(Level::Constant(value));
            let extras = Extras { background: constant(0.0), noise: constant(1.0), ..Extras::default() };
            let mut source = Source::empty(1);
            for (at, _) in labels.iter().enumerate().filter(|(_, label)| **label > 0) {
                source.add((at % SIDE) as u32, (at / SIDE) as u32, pixels[at], 0.0);
            }
            let scene = Scene::new(&pixels, &labels, SIDE, SIDE, &extras);
            let row = measure(&scene, &[source], &extras, None).remove(0);
            (PI * row.kron_radius * row.kron_radius * row.shape.b / row.shape.a, largest_kron(source.area))
        };
        let ((ring, most), (disc, room)) = (measured(300.0), measured(0.0));
        assert!((ring / most - 1.0).abs() < 1e-3, "{ring} of {most}");
        assert!(disc < 0.5 * room, "{disc} of {room}");
    }

    const SIDE: usize = 121;
    const CENTRE: (f64, f64) = (60.3, 59.6);

    /// A Gaussian with these widths, the first along (4, 3), that is 1000 above a background of 7 with a noise of 1; its
    /// source ends where it falls to 1.
    fn gaussian((a, b): (f64, f64), gain: Option<f64>) -> Measured {
        let light = |at: usize| {
            let (x, y) = ((at % SIDE) as f64 - CENTRE.0, (at / SIDE) as f64 - CENTRE.1);
            let (along, across) = ((0.8 * x + 0.6 * y) / a, (0.8 * y - 0.6 * x) / b);
            1000.0 * libm::exp(-0.5 * (along * along + across * across))
        };
        let pixels: Vec<f32> = (0..SIDE * SIDE).map(|at| (7.0 + light(at)) as f32).collect();
        let labels: Vec<u32> = pixels.iter().map(|&pixel| u32::from(pixel > 8.0)).collect();
        let [background, noise] = [7.0, 1.0].map(|level| Some(Level::Constant(level)));
        let wanted = Wanted { kron: true, windowed: true, local: true, petrosian: true };
        let extras = Extras { background, noise, gain, wanted, ..Extras::default() };
        let mut source = Source::empty(1);
        for (at, _) in labels.iter().enumerate().filter(|(_, label)| **label > 0) {
            source.add((at % SIDE) as u32, (at / SIDE) as u32, pixels[at], 7.0);
        }
        measure(&Scene::new(&pixels, &labels, SIDE, SIDE, &extras), &[source], &extras, None).remove(0)
    }

    /// What integrals over the plane make of it.
    #[test]
    fn a_gaussian_has_the_sizes_and_the_light_of_its_integrals() {
        let found = gaussian((5.0, 3.0), Some(2.0));
        let close = |name: &str, found: f64, expected: f64, accuracy: f64| {
            assert!((found / expected - 1.0).abs() < accuracy, "{name}: {found}, not {expected}");
        };
        assert!((found.shape.x - CENTRE.0).abs() < 1e-3 && (found.shape.y - CENTRE.1).abs() < 1e-3);
        assert!((found.windowed.x - CENTRE.0).abs() < 1e-3 && (found.windowed.y - CENTRE.1).abs() < 1e-3);
        close("a", found.shape.a, 5.0, 5e-3);
        close("b", found.shape.b, 3.0, 5e-3);
        close("theta", found.shape.theta, 0.75f64.atan(), 1e-2);
        // 2.5 times a mean distance of sqrt(pi/2) is less than the least, in which 0.9978 of the light lies.
        close("Kron's radius", found.kron_radius, 3.5 * 5.0, 1e-2);
        let all = 2.0 * PI * 15.0 * 1000.0;
        close("Kron's flux", found.kron.value, 0.9978 * all, 1e-3);
        let area = PI * 12.25 * 15.0;
        close("its error", found.kron.error, (area + found.kron.value / 2.0).sqrt(), 1e-3);
        // Where exp(-0.32 u) - exp(-0.78125 u) is 0.2 * 0.9225 (1 - exp(-u/2)), u the square of the radius.
        close("Petrosian's radius", found.petrosian.radius, 2.285_95 * 5.0, 1e-2);
        close("Petrosian's flux", found.petrosian.flux.value, all, 1e-3);
        close("the background beside it", found.local.background, 7.0, 1e-3);
        assert_eq!(found.flags, 0);
    }

    #[test]
    fn a_window_sees_the_errors_of_its_pixels() {
        let found = gaussian((4.0, 4.0), None);
        // Half of 0.9978.
        assert!((found.half_light / (4.0 * 1.175_54) - 1.0).abs() < 5e-3, "{}", found.half_light);
        let (window, star) = (found.half_light * 2.0 / 2.35, 4.0);
        let light = 2.0 * PI * 1000.0 / (1.0 / (window * window) + 1.0 / (star * star));
        let error = 2.0 * PI * window.powi(4) / (light * light);
        let (xx, yy, xy) = found.windowed.errors;
        assert!((xx / error - 1.0).abs() < 5e-3 && (yy / error - 1.0).abs() < 5e-3, "{xx} {yy}, not {error}");
        assert!(xy.abs() < 0.01 * error);
    }

    #[test]
    fn places_in_a_part_become_those_in_the_image() {
        let measured = gaussian((4.0, 4.0), None);
        let mut moved = measured.clone();
        moved.shift((100, 2000));
        let places = |of: &Measured| [of.shape.x, of.shape.y, of.windowed.x, of.windowed.y];
        let there = [100.0, 2000.0, 100.0, 2000.0];
        for ((place, moved), by) in places(&measured).into_iter().zip(places(&moved)).zip(there) {
            assert_eq!(place + by, moved);
        }
        let ends = |(first, last): (u32, u32), by| (first + by, last + by);
        assert_eq!(moved.source.columns, ends(measured.source.columns, 100));
        assert_eq!(moved.source.rows, ends(measured.source.rows, 2000));
        let (x, y) = measured.values.peak_at;
        assert_eq!(moved.values.peak_at, (x + 100, y + 2000));
    }

    #[test]
    fn a_run_that_ended_early_or_had_no_room_flags_its_sources() {
        use skyfront_core::image::normalize::Extremes;
        use skyfront_core::run::outcome::{Outcome, StopReason};
        let whole = crate::nothing::without_front(Extremes::NONE);
        for (outcome, flags) in [
            (whole, 0),
            (Outcome { reason: StopReason::TimeLimit, ..whole }, flags::LIMIT),
            (Outcome { unlabelled: 1, ..whole }, flags::NO_ROOM),
            (Outcome { sources: 3, catalogued: 2, ..whole }, flags::NO_ROOM),
            (Outcome { sources: 3, catalogued: 3, ..whole }, 0),
        ] {
            assert_eq!(run_flags(&outcome), flags, "{outcome:?}");
        }
    }
}
