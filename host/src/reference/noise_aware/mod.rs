//! The default in f64, written from `host/doc/default.md`: whole planes, whole sorts, sources as lists of pixels.
//!
//! Every step is a function of what the step before left, so that it can be held beside the core's step from the very
//! same input. It shares no numerical code with `skyfront-core`.

mod centre;
mod combine;
mod compete;
mod facts;
mod judge;
mod knots;
mod light;
mod outline;
mod photon;
mod reopen;
mod seen;
mod select;
mod signal;
mod sky;
mod smooth;
mod tree;

pub use centre::centre;
pub use combine::{Combination, combined};
pub use compete::{Contest, Moments, compete, connect, moments, straighten};
pub use facts::Facts;
pub use judge::{Judge, Slack, nearest};
pub use knots::joined;
pub use outline::{BAND, FLAT, STEP, force, start, steepness, step};
pub use photon::{grown, photon_noise};
pub use reopen::{Scene, Typical};
pub use seen::Roundings;
pub use select::{Cut, cut, matched, select};
pub use signal::{has_signal, signal, without_spikes};
pub use sky::{Mesh, Seen, Sky};
pub use smooth::{MASKED, Tail, by_need, marks, sharpened, smoothed, spline};
pub use tree::{Region, Regions, components, tree};

use super::{Connectivity, Plane, ReferenceError};

/// How signal-to-noise is smoothed before a front starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Smoothing {
    /// Not at all.
    None,
    /// The fine image.
    Fine,
    /// By need.
    ByNeed,
}

/// What is asked of sky and sources; `default.md` has the options' names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Pixels along a side of a cell of the sky.
    pub cell: usize,
    /// `--spike-height`.
    pub spike_height: f64,
    /// `--filter`.
    pub smoothing: Smoothing,
    /// `--threshold`.
    pub threshold: f64,
    /// `--outline-steps`.
    pub steps: u32,
    /// `--outline-curvature`.
    pub curvature: f64,
    /// Whether sources are parts of the tree; else they are connected components.
    pub by_tree: bool,
    /// `--deblend-light`.
    pub branch: f64,
    /// `--deblend-contrast`.
    pub contrast: f64,
    /// `--deblend-excess`.
    pub excess: f64,
    /// `--deblend-area`.
    pub reopened_area: usize,
    /// `--deblend-knots`.
    pub knots: usize,
    /// `--deblend-sharpening`.
    pub sharpening: f64,
    /// Which pixels touch.
    pub connectivity: Connectivity,
    /// Whether sources must be significant; else they need their area only.
    pub by_significance: bool,
    /// `--min-area`.
    pub min_area: usize,
    /// `--min-peak`.
    pub peak: f64,
    /// `--false-sources`.
    pub false_sources: f64,
    /// `--false-share`.
    pub false_share: f64,
    /// `--min-light`.
    pub light: f64,
}

/// What a run computed on its way.
#[derive(Clone, Debug)]
pub struct Found {
    /// What the detector did to the values.
    pub facts: Facts,
    /// Sky and noise.
    pub mesh: Mesh,
    /// Signal-to-noise without spikes.
    pub signal: Plane,
    /// Smoothed by need.
    pub smooth: Plane,
    /// Where the sky is not looked at.
    pub masked: Vec<bool>,
    /// The photon noise.
    pub photon: f64,
    /// The front.
    pub front: Moved,
    /// The cut on significance.
    pub cut: Cut,
    /// The sources.
    pub labels: Vec<u32>,
    /// Their number.
    pub sources: u32,
}

/// A front at its end.
#[derive(Clone, Debug)]
pub struct Moved {
    /// Above 0 inside.
    pub u: Plane,
    /// Its steps.
    pub steps: u32,
    /// Its time.
    pub t: f64,
}

/// The front of the default over the smoothed image, with the fine image for its force.
pub fn region_front(settings: &Settings, image: &Plane, fine: &Plane) -> Moved {
    let step = |u: Plane, _| step(&u, fine, settings.threshold, settings.curvature, FLAT);
    let u = (0..settings.steps).fold(start(image, settings.threshold), step);
    Moved { u, steps: settings.steps, t: f64::from(settings.steps) * STEP }
}

/// Runs a whole configuration with the front that `moved` makes of the smoothed image and the fine one.
///
/// # Errors
/// [`ReferenceError::NoSky`], or what `moved` finds wrong.
pub fn run(
    settings: &Settings,
    pixels: &[f64],
    width: usize,
    moved: impl Fn(&Plane, &Plane) -> Result<Moved, ReferenceError>,
) -> Result<Found, ReferenceError> {
    let (judge, size) = (&Judge::exact(), (width, pixels.len() / width));
    let facts = Facts::of(pixels, width);
    let defined: Vec<bool> = pixels.iter().map(|&pixel| facts.defines(pixel)).collect();
    let signals = has_signal(&defined, width);
    let mut masked: Vec<bool> = signals.iter().map(|signal| !signal).collect();
    let mut mesh = Mesh::unknown(size, settings.cell);
    for round in 0.. {
        mesh = mesh.measure(pixels, &seen(&defined, &masked), &facts, 0.0);
        if !mesh.cells.iter().any(|cell| cell.is_some_and(|sky| sky.noise > 0.0)) {
            break;
        }
        let signal =
            without_spikes(&signal(pixels, &defined, &mesh, width, f64::INFINITY), settings.spike_height, judge);
        let fine = smoothed(&signal, 0.8);
        let tail = Tail::of(fine.values(), &masked, &facts);
        let smooth = by_need(&fine, &masked, &facts);
        if round < 2 {
            let marks = marks(&fine, &smooth, settings.threshold, tail.raised(3.5) * tail.noise, judge);
            masked = marks.values().iter().zip(&signals).map(|(&mark, signal)| mark > MASKED || !signal).collect();
            continue;
        }
        let photon = photon_noise(&signal, &fine, &masked);
        let image = match settings.smoothing {
            Smoothing::None => &signal,
            Smoothing::Fine => &fine,
            Smoothing::ByNeed => &smooth,
        };
        let front = moved(image, &fine)?;
        let inside: Vec<bool> = front.u.values().iter().zip(&signals).map(|(&u, &signal)| u > 0.0 && signal).collect();
        let mut regions = if settings.by_tree {
            let image = sharpened(&fine, 1.5, settings.sharpening);
            let mut regions = tree(&image, &inside, photon, settings, judge);
            opened(&image, &smooth, &mut regions, (tail.noise, photon), settings, judge);
            (0..2).for_each(|_| compete(&image, &mut regions));
            settle(&image, &mut regions, settings, judge);
            regions
        } else {
            components(&inside, width, settings.connectivity)
        };
        drop_undefined(&mut regions.labels, &defined);
        let matched = matched(&signal);
        let cut = cut(&signal, &matched, &masked, &facts, &regions, settings, judge);
        let (labels, sources) = select(&signal, &matched, &regions, cut, settings, judge);
        return Ok(Found { facts, mesh, signal, smooth, masked, photon, front, cut, labels, sources });
    }
    Err(ReferenceError::NoSky)
}

/// What becomes of the regions of the tree before they compete.
pub fn opened(
    image: &Plane,
    smooth: &Plane,
    regions: &mut Regions,
    (noise, photon): (f64, f64),
    settings: &Settings,
    judge: &Judge,
) {
    centre(image, smooth, regions, (noise, photon), judge);
    let typical = Typical::of(image, regions, noise);
    let scene = Scene { image, typical: &typical, noise, photon, settings, judge };
    (0..2).for_each(|_| scene.reopen(regions));
}

/// What becomes of them once they have competed.
pub fn settle(image: &Plane, regions: &mut Regions, settings: &Settings, judge: &Judge) {
    (0..2).for_each(|_| regions.labels = straighten(&regions.labels, image.width()));
    regions.labels = joined(image, regions, settings.knots, judge);
    regions.labels = connect(regions, image.width());
}

/// Takes undefined pixels out of sources.
pub fn drop_undefined(labels: &mut [u32], defined: &[bool]) {
    labels.iter_mut().zip(defined).filter(|(_, defined)| !**defined).for_each(|(label, _)| *label = 0);
}

/// What each pixel is to the sky.
pub fn seen(defined: &[bool], masked: &[bool]) -> Vec<Seen> {
    let seen = |(&defined, &masked): (&bool, &bool)| match (defined, masked) {
        (false, _) => Seen::Nothing,
        (true, true) => Seen::Source,
        (true, false) => Seen::Sky,
    };
    defined.iter().zip(masked).map(seen).collect()
}

/// The places of a sample of a plane.
fn sample(pixels: usize) -> impl Iterator<Item = usize> {
    (0..pixels).step_by(pixels.div_ceil(65_536) | 1)
}

/// The median of sorted values, of which there is one.
fn median(sorted: &[f64]) -> f64 {
    sorted[sorted.len() / 2]
}

/// The first of the eight neighbours of a pixel in the order in which they are met, inside the frame.
fn neighbours(at: usize, width: usize, height: usize, first: usize) -> Vec<usize> {
    const AROUND: [(isize, isize); 8] = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];
    let (x, y) = ((at % width) as isize, (at / width) as isize);
    let near = AROUND[..first].iter().map(|(i, j)| (x + i, y + j));
    let inside = near.filter(|&(x, y)| (0..width as isize).contains(&x) && (0..height as isize).contains(&y));
    inside.map(|(x, y)| y as usize * width + x as usize).collect()
}

impl Connectivity {
    /// How many neighbours touch a pixel: those across edges come first.
    fn neighbours(self) -> usize {
        match self {
            Connectivity::Four => 4,
            Connectivity::Eight => 8,
        }
    }
}
