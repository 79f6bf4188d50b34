//! Outlined pixels become regions: connected components, or parts of the tree of level sets.

use crate::arithmetic::Level;
use crate::config::{Config, Connectivity, Deblending};
use crate::plane::field::Field;
use crate::plane::grid::Grid;
use crate::plane::part::Whole;
use crate::plane::smooth::Weights;
use crate::plane::sort;
use crate::sources::centre::centre_on_light;
use crate::sources::deblend::{Reopening, compete, reopen, straighten};
use crate::sources::pieces::{connect, relabel};
use crate::sources::tree::{Count, NONE, Noise, Region, grow, root};
use crate::sources::typical::Typical;

/// Scale of the sharpening before the tree, pixels.
const SHARPNESS: f32 = 1.5;
/// A region of fewer pixels is no source.
const LEAST_AREA: u32 = 3;
/// Sweeps in which sources compete for the pixels at their borders.
const SWEEPS: u32 = 2;
/// Times that pixels beyond their host's light are looked for.
const REOPENINGS: u32 = 2;
/// Steps by which borders between sources are straightened.
const STRAIGHTENINGS: u32 = 2;

/// The planes of these steps, W x H each, and the table of regions.
#[derive(Debug)]
pub struct Planes<'m, L: Level> {
    /// Lightly smoothed signal-to-noise; sharpened, once the tree has grown.
    pub fine: &'m mut [L],
    /// Signal-to-noise smoothed by need.
    pub smooth: &'m [L],
    /// Above 0 inside the outlines.
    pub front: &'m [L],
    /// Scratch.
    pub scratch: &'m mut [L],
    /// The tree; scratch.
    pub parents: &'m mut [u32],
    /// Pixels by brightness; scratch.
    pub order: &'m mut [u32],
    /// The labels: 1 + the index of a region.
    pub labels: &'m mut [u32],
    /// The regions.
    pub regions: &'m mut [Region<L>],
}

/// Lets the tree of level sets grow over the pixels inside the outlines that have a signal, and gives
/// each the label of its region.
pub fn tree<L: Level>(
    grid: Grid,
    has_signal: impl Fn(usize) -> bool,
    config: &Config,
    photon: f32,
    work: &mut Planes<'_, L>,
) -> Count {
    Weights::gauss(SHARPNESS).sharpen(work.fine, work.scratch, grid, config.deblending.sharpening);
    let field = Field { values: work.fine, grid };
    let mut used = 0;
    for (at, &front) in (0u32..).zip(work.front.iter()) {
        let inside = front > L::ZERO && has_signal(at as usize);
        if let (true, Some(place)) = (inside, work.order.get_mut(used)) {
            *place = at;
            used += 1;
        }
    }
    let order = work.order.get_mut(..used).unwrap_or(&mut []);
    // Brightest first; of equal ones the first in the frame.
    sort::by_key(order, work.parents, |at| !field.at(at as usize).key());
    work.parents.fill(NONE);
    let count = grow(field, order, work.parents, work.labels, work.regions, (config, photon));
    for region in work.regions.iter_mut().take(count.regions) {
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
            let large = work.regions.get(id as usize).is_some_and(|region| region.area >= LEAST_AREA);
            *place = if root != NONE && large { id + 1 } else { 0 };
        }
    }
    work.labels.iter_mut().zip(work.order.iter()).for_each(|(label, id)| *label = *id);
    count
}

/// Gives regions their centres, makes light that no host explains regions of their own, lets
/// neighbours compete for the pixels between them, and leaves each label one connected piece. Ends where other
/// parts of the image have yet to answer.
pub fn deblend<L: Level>(
    whole: Option<&dyn Whole>,
    grid: Grid,
    config: &Config,
    noise: Noise<L>,
    mut count: Count,
    work: &mut Planes<'_, L>,
) -> Count {
    let (field, light) = (Field { values: work.fine, grid }, Field { values: work.smooth, grid });
    centre_on_light([field, light], work.labels, work.regions, noise);
    let regions = work.regions.get(..count.regions).unwrap_or(&[]);
    let typical = Typical::of(whole, field, noise.least, regions, (work.parents, work.order));
    if whole.is_some_and(Whole::is_waiting) {
        return count;
    }
    let Config { deblending, connectivity, .. } = *config;
    let Deblending { excess, reopened_area, .. } = deblending;
    let reopening = Reopening { field, typical, noise, excess, least_area: reopened_area, connectivity };
    for _ in 0..REOPENINGS {
        count = reopen(&reopening, work.labels, work.order, work.regions, count);
    }
    compete(field, work.labels, work.regions, SWEEPS);
    straighten(work.labels, work.order, grid, STRAIGHTENINGS);
    connect(grid, work.labels, work.order, work.regions);
    count
}

/// Makes the connected components of the pixels inside the outlines that have a signal regions, in
/// raster order of their first pixels.
pub fn components<L: Level>(
    grid: Grid,
    has_signal: impl Fn(usize) -> bool,
    connectivity: Connectivity,
    work: &mut Planes<'_, L>,
) -> Count {
    /// A pixel inside that has no label yet.
    const INSIDE: u32 = u32::MAX;
    for (at, (label, &front)) in work.labels.iter_mut().zip(work.front).enumerate() {
        *label = if front > L::ZERO && has_signal(at) { INSIDE } else { 0 };
    }
    let mut count = Count::default();
    for first in 0..work.labels.len() {
        if work.labels.get(first) != Some(&INSIDE) {
            continue;
        }
        let label = match work.regions.get_mut(count.regions) {
            Some(region) => {
                *region = Region { peak: first as u32, ..Region::BLANK };
                count.regions += 1;
                count.regions as u32
            }
            None => {
                count.left_out += 1;
                0
            }
        };
        relabel((grid, connectivity), first, label, work.labels, work.order);
    }
    count
}
