//! The noise-aware segmentation: sky, noise, smoothing, the tree of level sets, deblending and
//! the cut on significance, with one setting for every kind of sky.
//!
//! All of it works on signal-to-noise, pixel values above the sky in units of a pixel's noise.
//! A pixel belongs to a source where the smoothed image is above [`Detection::outline`]; smoothing
//! is stronger where nothing significant is lost by it (Lepski's choice of scale).
//! The run is one call, deterministic, single precision, with at most a fixed number of passes
//! over the planes and one sort of the pixels in use.

use crate::deblend::{compete, reopen, straighten};
use crate::error::Error;
use crate::sky::{Mesh, Sky, mesh_cells};
use crate::smooth::{Weights, noise};
use crate::spike::cleaned;
use crate::tree::{Field, NONE, Region, grow, neighbours, root};

/// What the noise-aware segmentation asks of a source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// The outline: this many times the noise of a pixel.
    pub outline: f32,
    /// Light of a branch above the saddle that makes it a source, in noise units.
    pub branch: f32,
    /// The same as a part of the brighter neighbour's light.
    pub contrast: f32,
    /// Peak in the matched image, in its noise.
    pub significance: f32,
    /// Sum over the source, in noise units.
    pub light: f32,
    /// Pixels.
    pub min_area: u32,
    /// Light that the mirrored host does not explain, in noise of the smoothed image.
    pub excess: f32,
    /// Pixels of it.
    pub reopened_area: u32,
}

impl Detection {
    /// The default for every kind of sky.
    pub const DEFAULT: Detection = Detection {
        outline: 1.0,
        branch: 8.0,
        contrast: 0.0005,
        significance: 4.8,
        light: 20.0,
        min_area: 6,
        excess: 6.0,
        reopened_area: 4,
    };

    /// Whether the fainter of two regions that meet at `saddle` is a source of its own: enough
    /// pixels and light above the saddle, and around its peak more than twice the mirrored light
    /// of the brighter.
    pub fn stands_apart(&self, field: Field<'_>, bright: &Region, faint: &Region, saddle: f32) -> bool {
        let light = (faint.sum - f64::from(faint.area) * f64::from(saddle)) as f32;
        let significant = faint.area >= 3
            && light > self.branch
            && light > self.contrast * bright.sum as f32
            && faint.value - saddle > 0.5;
        if !significant {
            return false;
        }
        let centre = field.centre(bright.peak as usize);
        let peak = faint.peak as usize;
        let own = |&at: &usize| field.at(at) > 2.0 * field.mirrored(centre, at).unwrap_or(0.0);
        neighbours(peak, field.width, field.height()).chain([peak]).filter(own).count() >= 3
    }
}

/// The caller's memory: eight planes of 32 bits, the mesh and the table of regions.
#[derive(Debug)]
pub struct Workspace<'m> {
    /// W x H: signal-to-noise, in the end.
    pub signal: &'m mut [f32],
    /// W x H: lightly smoothed, then the matched image.
    pub fine: &'m mut [f32],
    /// W x H: smoothed by need.
    pub smooth: &'m mut [f32],
    /// W x H: 1 near sources, 0 on sky.
    pub masked: &'m mut [f32],
    /// W x H: scratch.
    pub scratch: &'m mut [f32],
    /// W x H: the tree; scratch.
    pub parents: &'m mut [u32],
    /// W x H: pixels by brightness; queue.
    pub order: &'m mut [u32],
    /// W x H: the labels.
    pub labels: &'m mut [u32],
    /// [`mesh_cells`] of the frame.
    pub mesh: &'m mut [Sky],
    /// As many as there may be peaks: [`regions`].
    pub regions: &'m mut [Region],
}

/// Regions that a frame can need.
pub const fn regions(width: usize, height: usize) -> usize {
    width * height / 3 + 1
}

/// What a run found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Number of sources; labels run from 1 to this, in raster order of first pixels.
    pub sources: u32,
    /// Pixels of sources.
    pub mask_pixels: u32,
    /// Whether the table of regions was too short.
    pub limit_reached: bool,
}

/// Times the sky is measured anew without the sources.
const ROUNDS: u32 = 2;
/// Scales of the smoothing for the tree, of the mask's growth and of the matched image, pixels.
const SCALES: [f32; 3] = [0.8, 2.0, 1.7];
/// Smoothing goes on where the change is below this, in its noise.
const LEPSKI: f32 = 2.5;

/// Segments `pixels` (row-major, not finite = undefined) into `work.labels`.
///
/// # Errors
/// [`Error::Length`] for memory that is too short, [`Error::NothingDefined`], or
/// [`Error::Constant`] where there is no noise.
pub fn detect(pixels: &[f32], width: usize, setting: &Detection, work: &mut Workspace<'_>) -> Result<Found, Error> {
    let count = pixels.len();
    check(count, width, work)?;
    let height = count / width;
    work.masked.fill(0.0);
    let mut fine_noise = 1.0;
    for round in 0..=ROUNDS {
        measure_signal(pixels, width, height, work)?;
        fine_noise = smooth(width, work);
        if round < ROUNDS {
            mask_sources(width, setting.outline, work);
        }
    }
    let limit_reached = separate(pixels, width, fine_noise, setting, work);
    let (sources, mask_pixels) = keep_significant(width, setting, work);
    Ok(Found { sources, mask_pixels, limit_reached })
}

fn check(count: usize, width: usize, work: &mut Workspace<'_>) -> Result<(), Error> {
    if width < 8 || count / width < 8 || !count.is_multiple_of(width) {
        let height = count.checked_div(width).unwrap_or(0);
        return Err(Error::Size { width, height, least: 8, most_pixels: 1 << 30 });
    }
    let needed = mesh_cells(width, count / width);
    if work.mesh.len() < needed {
        return Err(Error::Length { name: "the mesh", given: work.mesh.len(), needed });
    }
    let floats = [&work.signal, &work.fine, &work.smooth, &work.masked, &work.scratch].map(|plane| plane.len());
    let words = [&work.parents, &work.order, &work.labels].map(|plane| plane.len());
    match floats.into_iter().chain(words).find(|&given| given != count) {
        Some(given) => Err(Error::Length { name: "a plane", given, needed: count }),
        None => Ok(()),
    }
}

/// Signal-to-noise of every pixel, spikes replaced; undefined pixels have none.
fn measure_signal(pixels: &[f32], width: usize, height: usize, work: &mut Workspace<'_>) -> Result<(), Error> {
    if !pixels.iter().any(|pixel| pixel.is_finite()) {
        return Err(Error::NothingDefined { pixels: pixels.len() });
    }
    let mesh = Mesh::measure(pixels, work.masked, (width, height), work.mesh, work.scratch);
    let mut noise_seen = false;
    for (at, (out, &pixel)) in work.scratch.iter_mut().zip(pixels).enumerate() {
        let sky = mesh.at(at % width, at / width);
        let usable = pixel.is_finite() && sky.noise > 0.0;
        noise_seen |= usable;
        *out = if usable { (pixel - sky.level) / sky.noise } else { 0.0 };
    }
    if !noise_seen {
        return Err(Error::Constant { value: pixels.iter().copied().find(|pixel| pixel.is_finite()).unwrap_or(0.0) });
    }
    let row = |y: Option<usize>| y.and_then(|y| work.scratch.get(y * width..(y + 1) * width)).unwrap_or(&[]);
    for (y, out) in work.signal.chunks_exact_mut(width).enumerate() {
        let rows = [row(y.checked_sub(1)), row(Some(y)), row(Some(y + 1))];
        for (x, out) in out.iter_mut().enumerate() {
            *out = cleaned(rows, x);
        }
    }
    Ok(())
}

/// Fills the fine and the smooth plane; gives the noise of the fine one.
fn smooth(width: usize, work: &mut Workspace<'_>) -> f32 {
    let [fine, _, _] = SCALES;
    Weights::gauss(fine).apply(work.signal, work.scratch, work.fine, width);
    let fine_noise = noise(work.fine.iter().copied(), work.masked, work.scratch);
    Weights::SPLINE.apply(work.fine, work.scratch, work.smooth, width);
    let detail = work.fine.iter().zip(work.smooth.iter()).map(|(fine, smooth)| fine - smooth);
    let least = LEPSKI * noise(detail, work.masked, work.scratch);
    for (smooth, &fine) in work.smooth.iter_mut().zip(work.fine.iter()) {
        let change = if fine > *smooth { fine - *smooth } else { *smooth - fine };
        if change >= least {
            *smooth = fine;
        }
    }
    fine_noise
}

/// Masks the sources and what is within about three pixels of them.
fn mask_sources(width: usize, outline: f32, work: &mut Workspace<'_>) {
    for (fine, &smooth) in work.fine.iter_mut().zip(work.smooth.iter()) {
        *fine = if smooth > outline { 1.0 } else { 0.0 };
    }
    let [_, growth, _] = SCALES;
    Weights::gauss(growth).apply(work.fine, work.scratch, work.masked, width);
    for cell in work.masked.iter_mut() {
        *cell = if *cell > 0.08 { 1.0 } else { 0.0 };
    }
}

/// The tree, and the sources of its regions; says whether the table of regions was too short.
fn separate(pixels: &[f32], width: usize, noise: f32, setting: &Detection, work: &mut Workspace<'_>) -> bool {
    let field = Field { values: work.fine, width };
    let mut used = 0;
    for (at, (&smooth, pixel)) in (0u32..).zip(work.smooth.iter().zip(pixels)) {
        if let (true, true, Some(place)) = (smooth > setting.outline, pixel.is_finite(), work.order.get_mut(used)) {
            *place = at;
            used += 1;
        }
    }
    let order = work.order.get_mut(..used).unwrap_or(&mut []);
    order.sort_unstable_by(|&a, &b| field.at(b as usize).total_cmp(&field.at(a as usize)).then(a.cmp(&b)));
    work.parents.fill(NONE);
    let mut count = grow(field, order, work.parents, work.labels, work.regions, setting);
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
    for at in 0..pixels.len() {
        let root = work.parents.get(at).copied().unwrap_or(NONE);
        let id = work.labels.get(root as usize).copied().unwrap_or(NONE);
        if let Some(place) = work.order.get_mut(at) {
            let large = work.regions.get(id as usize).is_some_and(|region| region.area >= 3);
            *place = if root != NONE && large { id + 1 } else { 0 };
        }
    }
    work.labels.iter_mut().zip(work.order.iter()).for_each(|(label, id)| *label = *id);
    for _ in 0..2 {
        count = reopen(field, noise, work.labels, work.order, work.regions, count, setting);
    }
    compete(field, work.labels, work.regions, 4);
    straighten(work.labels, work.order, width, 2);
    count >= work.regions.len()
}

/// Drops what is not significant and numbers the rest in raster order; sources and their pixels.
fn keep_significant(width: usize, setting: &Detection, work: &mut Workspace<'_>) -> (u32, u32) {
    let [_, _, matched] = SCALES;
    Weights::gauss(matched).apply(work.signal, work.scratch, work.fine, width);
    let least = setting.significance * noise(work.fine.iter().copied(), work.masked, work.scratch);
    for region in work.regions.iter_mut() {
        (region.area, region.sum, region.value, region.label) = (0, 0.0, 0.0, 0);
    }
    for ((&label, &matched), &signal) in work.labels.iter().zip(work.fine.iter()).zip(work.signal.iter()) {
        if let Some(region) = work.regions.get_mut((label as usize).wrapping_sub(1)) {
            region.area += 1;
            region.sum += f64::from(signal);
            if matched > region.value {
                region.value = matched;
            }
        }
    }
    let (mut sources, mut mask_pixels) = (0, 0);
    for label in work.labels.iter_mut() {
        let Some(region) = work.regions.get_mut((*label as usize).wrapping_sub(1)) else { continue };
        let kept = region.area >= setting.min_area && region.value >= least && region.sum >= f64::from(setting.light);
        if kept && region.label == 0 {
            sources += 1;
            region.label = sources;
        }
        *label = region.label;
        mask_pixels += u32::from(*label != 0);
    }
    (sources, mask_pixels)
}
