//! The noise-aware segmentation: sky, noise, smoothing, the tree of level sets, deblending and
//! the cut on significance, with one setting for every kind of sky.
//!
//! All of it works on signal-to-noise, pixel values above the sky in units of a pixel's noise.
//! A pixel belongs to a source where the smoothed image is above [`Detection::outline`]; smoothing
//! is stronger where nothing significant is lost by it (Lepski's choice of scale).
//! The run is one call, deterministic, with at most a fixed number of passes over the planes and
//! one sort of the pixels in use. The sky is measured in the image's own single precision; from
//! signal-to-noise on, all there is for every pixel is in the [`Level`] of the caller's choice, and
//! single precision has no more to do than what there is once a frame or region: the cut, the
//! photon noise, the centres of wide regions.

use crate::arithmetic::{Fixed14, Level, Real};
use crate::config::detection::Detection;
use crate::error::Error;
use crate::front::outline::Front;
use crate::plane::field::Field;
use crate::plane::grid::Grid;
use crate::plane::smooth::Weights;
use crate::plane::sort::{self, Keys};
use crate::sky::photon;
use crate::sky::signal::{self, View};
use crate::sky::tail::Tail;
use crate::sky::{LEAST_PIXELS, Sky, Survey, Values, mesh_cells};
use crate::sources::centre::centre_on_light;
use crate::sources::deblend::{compete, reopen, straighten};
use crate::sources::pieces::connect;
use crate::sources::significance::height;
use crate::sources::tree::{NONE, Region, grow, root};
use crate::sources::typical::Typical;

/// The caller's memory: nine planes of 32 bits, the mesh and the table of regions.
#[derive(Debug)]
pub struct Workspace<'m, L: Level> {
    /// W x H: signal-to-noise, in the end.
    pub signal: &'m mut [L],
    /// W x H: lightly smoothed, then the matched image.
    pub fine: &'m mut [L],
    /// W x H: smoothed by need.
    pub smooth: &'m mut [L],
    /// W x H: the front, above 0 inside the outlines.
    pub front: &'m mut [L],
    /// W x H: 1 near sources, 0 on sky.
    pub masked: &'m mut [L],
    /// W x H: scratch.
    pub scratch: &'m mut [L],
    /// W x H: the tree; scratch.
    pub parents: &'m mut [u32],
    /// W x H: pixels by brightness; queue.
    pub order: &'m mut [u32],
    /// W x H: the labels.
    pub labels: &'m mut [u32],
    /// [`mesh_cells`] of the frame: background and noise, in the end (see [`Mesh::over`](crate::sky::Mesh::over)).
    pub mesh: &'m mut [Sky],
    /// As many as there may be peaks: [`regions`].
    pub regions: &'m mut [Region<L>],
}

/// Regions that a frame can need.
pub const fn regions(width: usize, height: usize) -> usize {
    width * height / 3 + 1
}

const _: () = assert!(size_of::<Region<f32>>() == size_of::<Region<Fixed14>>());

/// Bytes of a [`Workspace`]: nine planes (signal, fine, smooth, front, masked, scratch, parents, order,
/// labels), the mesh and the regions.
pub const fn bytes(width: usize, height: usize) -> usize {
    9 * 4 * width * height
        + mesh_cells(width, height) * size_of::<Sky>()
        + regions(width, height) * size_of::<Region<f32>>()
}

/// What is known of the sky beforehand; what is not is measured on the image.
#[derive(Clone, Copy, Debug, Default)]
pub struct Known<'a> {
    /// W x H: the background, in units of the image. Where it is not finite, the pixel is undefined.
    pub background: Option<&'a [f32]>,
    /// W x H: the standard deviation of each pixel. Where it is not finite or not above 0, the
    /// pixel is undefined.
    pub noise: Option<&'a [f32]>,
    /// Whether `noise` says only which pixels are noisier than others, as weight maps do: it is
    /// then multiplied by one factor, so that it agrees with the noise that is measured.
    pub relative: bool,
}

impl Known<'_> {
    pub(crate) fn value(map: Option<&[f32]>, at: usize) -> Option<f32> {
        map.and_then(|map| map.get(at).copied())
    }

    /// Whether the maps leave the pixel defined.
    pub(crate) fn allows(&self, at: usize) -> bool {
        Self::value(self.background, at).is_none_or(f32::is_finite)
            && Self::value(self.noise, at).is_none_or(|noise| noise.is_finite() && noise > 0.0)
    }
}

/// What a run found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Number of sources; labels run from 1 to this, in raster order of first pixels.
    pub sources: u32,
    /// Pixels of sources.
    pub mask_pixels: u32,
    /// Peaks for which the table of regions had no room: their pixels are in no source.
    pub unlabelled: u32,
    /// The cut on the peak in the matched image, in its noise.
    pub significance: f32,
    /// The photon noise of the image (see [`crate::sky::photon`]).
    pub photon: f32,
    /// How the values of the frame came about.
    pub values: Values,
    /// How much of the sky could be measured, in the last round.
    pub survey: Survey,
}

/// Times the sky is measured anew without the sources.
const ROUNDS: u32 = 2;
/// Scales of the smoothing for the tree, of the mask's growth, of the sharpening, of the matched
/// image and of what is taken from it, pixels.
pub(crate) const SCALES: [f32; 5] = [0.8, 2.0, 1.5, 1.7, 2.5];
/// How much the matched image is sharpened: what lies on the halo of a bright source must stand
/// above that, and what is narrow is brighter than smoothing lets it be.
const MATCHED_SHARPENING: f32 = 0.6;
/// A source is masked when a pixel of it stands this high above the noise: noise peaks are not,
/// for without them the sky would be biased low.
const MASKED_PEAK: f32 = 3.5;
/// Rounds of the cut on significance, which depends on the number of sources it leaves.
const CUTS: u32 = 4;

/// Segments `pixels` (row-major, not finite = undefined) into `work.labels`.
///
/// # Errors
/// [`Error::Parameter`] of the setting, [`Error::Size`], [`Error::Length`] for memory or maps of
/// another size, [`Error::Arithmetic`] for a side longer than [`Level::LONGEST`],
/// [`Error::NothingDefined`], or [`Error::NoSky`] and [`Error::NoNoise`] where the frame tells nothing
/// of its sky or of its noise.
pub fn detect<L: Level>(
    pixels: &[f32],
    width: usize,
    known: &Known<'_>,
    setting: &Detection,
    work: &mut Workspace<'_, L>,
) -> Result<Found, Error> {
    let count = pixels.len();
    setting.validate()?;
    let grid = check(count, width, known, work)?;
    let view = View::of(pixels, grid, known, Keys(work.parents, work.order));
    if view.values.defined == 0 {
        return Err(Error::NothingDefined { pixels: count });
    }
    work.masked.fill(L::ZERO);
    signal::mask_undefined(&view, work.masked);
    work.mesh.fill(Sky::UNKNOWN);
    let mut fine = Tail { noise: L::ONE, skewness: 0.0 };
    let mut survey = Survey::default();
    for round in 0..=ROUNDS {
        survey = signal::measure(&view, work).ok_or_else(|| no_noise(&view, work))?;
        fine = signal::smooth(&view, work);
        if round < ROUNDS {
            signal::mask_sources(&view, L::of(setting.outline), fine.height(MASKED_PEAK), work);
        }
    }
    let field = Field { values: work.signal, grid };
    let photon = photon::slope(field, work.fine, work.masked, Keys(work.parents, work.order));
    let front = Front {
        threshold: L::of(setting.outline),
        curvature: L::Weight::of(setting.curvature),
        steps: setting.front_steps,
    };
    work.front.iter_mut().zip(work.smooth.iter()).for_each(|(front, &smooth)| *front = smooth);
    front.outline(work.fine, work.front, work.scratch, grid);
    let unlabelled = separate(&view, (fine.noise, photon), setting, work);
    drop_undefined(&view, work.labels);
    let (significance, least) = cut(&view, setting, work);
    let (sources, mask_pixels) = keep(setting, least, work);
    Ok(Found { sources, mask_pixels, unlabelled, significance, photon, values: view.values, survey })
}

/// Why there is nothing to divide the signal by.
fn no_noise<L: Level>(view: &View<'_>, work: &Workspace<'_, L>) -> Error {
    let Values { defined, commonest, .. } = view.values;
    if work.mesh.first().is_none_or(|sky| sky.level.is_nan()) {
        return Error::NoSky { defined, needed: LEAST_PIXELS };
    }
    let equal = (0..).zip(view.pixels).filter(|&(at, &pixel)| pixel == commonest && view.is_defined(at)).count();
    Error::NoNoise { value: commonest, equal: equal as u32, defined }
}

/// An undefined pixel between two of a source carries its light across, but is in no source.
fn drop_undefined(view: &View<'_>, labels: &mut [u32]) {
    for (_, label) in labels.iter_mut().enumerate().filter(|(at, _)| !view.is_defined(*at)) {
        *label = 0;
    }
}

fn check<L: Level>(count: usize, width: usize, known: &Known<'_>, work: &mut Workspace<'_, L>) -> Result<Grid, Error> {
    let whole = |grid: &Grid| grid.height > 0 && grid.cells() == count && count <= 1 << 30;
    let Some(grid) = Grid::of(count, width).filter(whole) else {
        let height = count.checked_div(width).unwrap_or(0);
        return Err(Error::Size { width, height, least: 1, most_columns: 1 << 30, most_pixels: 1 << 30 });
    };
    if width > L::LONGEST || grid.height > L::LONGEST {
        let reason = "the places of its pixels have 16 bits: no side may be longer than 65536 pixels";
        return Err(Error::Arithmetic { name: L::NAME, reason });
    }
    let needed = mesh_cells(width, grid.height);
    if work.mesh.len() < needed {
        return Err(Error::Length { name: "the mesh", given: work.mesh.len(), needed });
    }
    let floats =
        [&work.signal, &work.fine, &work.smooth, &work.front, &work.masked, &work.scratch].map(|plane| plane.len());
    let words = [&work.parents, &work.order, &work.labels].map(|plane| plane.len());
    let maps = [known.background, known.noise].into_iter().flatten().map(<[f32]>::len);
    match floats.into_iter().chain(words).chain(maps).find(|&given| given != count) {
        Some(given) => Err(Error::Length { name: "a plane or map", given, needed: count }),
        None => Ok(grid),
    }
}

/// The tree, and the sources of its regions; gives the number of peaks without a region.
fn separate<L: Level>(
    view: &View<'_>,
    (noise, photon): (L, f32),
    setting: &Detection,
    work: &mut Workspace<'_, L>,
) -> u32 {
    let [_, _, sharpness, ..] = SCALES;
    let grid = view.grid;
    Weights::gauss(sharpness).sharpen(work.fine, work.scratch, grid, setting.sharpening);
    let field = Field { values: work.fine, grid };
    let mut used = 0;
    for (at, &front) in (0u32..).zip(work.front.iter()) {
        let inside = front > L::ZERO && view.has_signal(at as usize);
        if let (true, Some(place)) = (inside, work.order.get_mut(used)) {
            *place = at;
            used += 1;
        }
    }
    let order = work.order.get_mut(..used).unwrap_or(&mut []);
    // Brightest first; of equal ones the first in the frame.
    sort::by_key(order, work.parents, |at| !field.at(at as usize).key());
    work.parents.fill(NONE);
    let (mut count, mut left_out) = grow(field, order, work.parents, work.labels, work.regions, (setting, photon));
    for region in work.regions.iter_mut().take(count) {
        region.centre = field.centre(region.peak as usize);
    }
    // The identity of a root is read through the order plane before the labels are written.
    for at in order.iter() {
        let root = root(work.parents, *at);
        if let Some(cell) = work.parents.get_mut(*at as usize) {
            *cell = root;
        }
    }
    for at in 0..grid.cells() {
        let root = work.parents.get(at).copied().unwrap_or(NONE);
        let id = work.labels.get(root as usize).copied().unwrap_or(NONE);
        if let Some(place) = work.order.get_mut(at) {
            let large = work.regions.get(id as usize).is_some_and(|region| region.area >= 3);
            *place = if root != NONE && large { id + 1 } else { 0 };
        }
    }
    work.labels.iter_mut().zip(work.order.iter()).for_each(|(label, id)| *label = *id);
    let light = Field { values: work.smooth, grid };
    centre_on_light([field, light], work.labels, work.regions, (noise, photon));
    let regions = work.regions.get(..count).unwrap_or(&[]);
    let typical = Typical::of(field, noise, regions, (work.parents, work.order));
    for _ in 0..2 {
        let (now, more) =
            reopen((field, typical), (noise, photon), work.labels, work.order, work.regions, count, setting);
        (count, left_out) = (now, left_out + more);
    }
    compete(field, work.labels, work.regions, 2);
    straighten(work.labels, work.order, grid, 2);
    connect(grid, work.labels, work.order, work.regions);
    left_out
}

/// The cut on the peak in the matched image: in units of its noise, and of the signal.
fn cut<L: Level>(view: &View<'_>, setting: &Detection, work: &mut Workspace<'_, L>) -> (f32, L) {
    let ([.., scale, wide], grid, piled) = (SCALES, view.grid, view.values.piled);
    Weights::gauss(scale).apply(work.signal, work.scratch, work.fine, grid);
    Weights::gauss(wide).sharpen(work.fine, work.scratch, grid, MATCHED_SHARPENING);
    let matched = |at: usize| work.fine.get(at).copied().unwrap_or(L::ZERO);
    let tail = Tail::measure(matched, work.masked, piled, Keys(work.parents, work.order));
    let matched_noise = tail.noise.to_f32();
    let step = |at: usize| matched(at + 1) - matched(at);
    let slope = Tail::measure(step, work.masked, piled, Keys(work.parents, work.order)).noise.to_f32();
    let roughness = if matched_noise > 0.0 { slope / matched_noise } else { 0.0 };
    let elements = work.signal.len() as f32 * roughness * roughness;
    sum_up(work);
    let floor = setting.peak * setting.outline;
    let (mut allowed, mut result) = (setting.false_sources, (0.0, L::of(floor)));
    for _ in 0..CUTS {
        let significance = tail.raised(height(elements, allowed));
        let least = significance * matched_noise;
        let least = L::of(if least > floor { least } else { floor });
        result = (significance, least);
        let kept = work.regions.iter().filter(|region| is_source(region, setting, least)).count();
        let share = setting.false_share * kept as f32;
        allowed = if share > allowed { share } else { allowed };
    }
    result
}

/// Area, light and matched peak of every region, from its pixels.
fn sum_up<L: Level>(work: &mut Workspace<'_, L>) {
    for region in work.regions.iter_mut() {
        (region.area, region.sum, region.value, region.label) = (0, L::NOTHING, L::ZERO, 0);
    }
    for ((&label, &matched), &signal) in work.labels.iter().zip(work.fine.iter()).zip(work.signal.iter()) {
        if let Some(region) = work.regions.get_mut((label as usize).wrapping_sub(1)) {
            region.area += 1;
            region.sum = region.sum + signal.times(1);
            if matched > region.value {
                region.value = matched;
            }
        }
    }
}

fn is_source<L: Level>(region: &Region<L>, setting: &Detection, least: L) -> bool {
    let light = L::share(L::ONE.times(1), setting.light);
    let least_area = if region.divided == 0 { setting.min_area } else { setting.part_area() };
    region.area >= least_area && region.value >= least && region.sum >= light
}

/// Drops what is no source and numbers the rest in raster order; sources and their pixels.
fn keep<L: Level>(setting: &Detection, least: L, work: &mut Workspace<'_, L>) -> (u32, u32) {
    let (mut sources, mut mask_pixels) = (0, 0);
    for label in work.labels.iter_mut() {
        let Some(region) = work.regions.get_mut((*label as usize).wrapping_sub(1)) else { continue };
        if region.label == 0 && is_source(region, setting, least) {
            sources += 1;
            region.label = sources;
        }
        *label = region.label;
        mask_pixels += u32::from(*label != 0);
    }
    (sources, mask_pixels)
}
