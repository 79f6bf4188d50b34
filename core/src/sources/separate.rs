//! Outlined pixels become regions: connected components, or parts of the tree of level sets.

use crate::arithmetic::Level;
use crate::config::{Config, Connectivity, Deblending};
use crate::plane::crew::Crew;
use crate::plane::field::Field;
use crate::plane::grid::Grid;
use crate::plane::part::Whole;
use crate::plane::rows::next_with;
use crate::plane::smooth::Weights;
use crate::plane::sort;
use crate::sources::centre::{centre_on_light, shape};
use crate::sources::deblend::{Reopening, compete, reopen, straighten};
use crate::sources::pieces::{connect, relabel};
use crate::sources::tree::{Count, Noise, Region, grow, region_at, root_of};
use crate::sources::typical::Typical;

/// Scale of the sharpening before the tree, pixels.
const SHARPNESS: f32 = 1.5;
/// A region of fewer pixels is no source.
const LEAST_AREA: u32 = 3;
/// Sweeps in which sources compete for the pixels at their borders.
const SWEEPS: u32 = 2;
/// Times that they do so: each leaves their shapes better known.
const COMPETITIONS: u32 = 2;
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
    /// Room for rows.
    pub rows: &'m mut [L],
    /// The tree; scratch.
    pub parents: &'m mut [u32],
    /// Pixels by brightness; scratch.
    pub order: &'m mut [u32],
    /// The bits of the front, above 0 inside the outlines, then the labels: 1 + the index of a region.
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
    crew: &impl Crew,
) -> Count {
    Weights::gauss(SHARPNESS).sharpen(work.fine, work.rows, grid, config.deblending.sharpening, crew);
    let field = Field { values: work.fine, grid };
    mark_inside::<L>(has_signal, work.labels);
    let used = by_brightness(field, work.labels, work.order, work.parents, crew);
    let order = work.order.get(..used).unwrap_or(&[]);
    let count = grow(field, order, work.parents, work.labels, work.regions, (config, photon));
    for region in work.regions.iter_mut().take(count.regions) {
        region.centre = field.centre(region.peak as usize);
    }
    for (rank, &at) in (0..).zip(order) {
        let root = root_of(work.parents, rank);
        let index = region_at(work.parents, root);
        let large = work.regions.get(index).is_some_and(|region| region.area >= LEAST_AREA);
        set(work.labels, at, if large { index as u32 + 1 } else { 0 });
    }
    count
}

/// A pixel inside the outlines; the rest is the first pixel of its run in its row, and of that pixel what its run is
/// known by.
const INSIDE: u32 = 1 << 31;

#[inline]
fn set(plane: &mut [u32], at: u32, to: u32) {
    if let Some(cell) = plane.get_mut(at as usize) {
        *cell = to;
    }
}

/// Makes marks of the pixels inside the front that have a signal, and 0 of the others.
fn mark_inside<L: Level>(has_signal: impl Fn(usize) -> bool, front: &mut [u32]) {
    /// Pixels that are looked at together.
    const PIECE: usize = 32;
    let is_inside = |bits: u32| L::from_bits(bits) > L::ZERO;
    for (first, front) in (0..).step_by(PIECE).zip(front.chunks_mut(PIECE)) {
        if front.iter().fold(false, |any, &bits| any | is_inside(bits)) {
            for (at, label) in (first..).zip(front) {
                *label = if is_inside(*label) && has_signal(at) { INSIDE } else { 0 };
            }
        } else {
            front.fill(0);
        }
    }
}

/// Lists the marked pixels, component by component so that what is looked at together lies together, each from the
/// brightest down, of equal pixels the first in the frame first, and marks each by 1 + its place in the list. Gives
/// their number; `spare` is as long as the list.
fn by_brightness<L: Level>(
    field: Field<'_, L>,
    labels: &mut [u32],
    order: &mut [u32],
    spare: &mut [u32],
    crew: &impl Crew,
) -> usize {
    let (components, listed) = by_component(field.grid, labels, order, spare);
    // Where a component ends the next one begins, and the last one ends with the list.
    let (ends, spare) = spare.split_at_mut_checked(components.saturating_sub(1)).unwrap_or_default();
    let order = order.get_mut(..listed).unwrap_or(&mut []);
    crew.each(groups(order, spare, ends, crew.hands()), |group| group.sort(field));
    for (rank, &at) in (1..).zip(order.iter()) {
        set(labels, at, rank);
    }
    listed
}

/// Components that are sorted by one hand.
struct Group<'a> {
    /// Where they begin in the list of all.
    first: usize,
    /// Their pixels.
    pixels: &'a mut [u32],
    /// Room for as many.
    spare: &'a mut [u32],
    /// Where in the list of all each of them ends, without the last.
    ends: &'a [u32],
}

impl Group<'_> {
    /// Sorts each component from its brightest pixel down, of equal pixels the first in the frame first.
    fn sort<L: Level>(self, field: Field<'_, L>) {
        /// Fewer are sorted by insertion.
        const FEW: usize = 32;
        let Group { first, mut pixels, spare, ends } = self;
        let (key, mut start) = (|at: u32| !field.at(at as usize).key(), first);
        for end in ends.iter().map(|&end| end as usize).chain([first + pixels.len()]) {
            let (component, rest) = pixels.split_at_mut_checked(end - start).unwrap_or_default();
            if component.len() < FEW {
                sort::few(component, |a, b| key(a) < key(b));
            } else {
                sort::by_key(component, spare, key);
            }
            (pixels, start) = (rest, end);
        }
    }
}

/// The components of a list in as many groups as there are hands, if there are enough.
fn groups<'a>(
    mut order: &'a mut [u32],
    mut spare: &'a mut [u32],
    mut ends: &'a [u32],
    hands: usize,
) -> impl Iterator<Item = Group<'a>> + Send {
    let (listed, hands) = (order.len(), hands.max(1));
    let (share, more, mut first) = (listed.div_ceil(hands), spare.len().saturating_sub(listed) / hands, 0);
    core::iter::from_fn(move || {
        if order.is_empty() {
            return None;
        }
        let inner = ends.partition_point(|&end| (end as usize) < first + share);
        let end = ends.get(inner).map_or(listed, |&end| end as usize);
        let (pixels, rest) = core::mem::take(&mut order).split_at_mut_checked(end - first)?;
        let (own, room) = core::mem::take(&mut spare).split_at_mut_checked(pixels.len() + more)?;
        let group = Group { first, pixels, spare: own, ends: ends.get(..inner).unwrap_or(&[]) };
        (order, spare, first) = (rest, room, end);
        ends = ends.get(inner + 1..).unwrap_or(&[]);
        Some(group)
    })
}

/// Lists the marked pixels by the components that they form, also by corners: these by their first pixels, the pixels
/// of each as they lie in the frame. Gives the number of components and of pixels; `ends` has where in the list each
/// component ends. Cost: three looks at each pixel, and two at those above.
fn by_component(grid: Grid, labels: &mut [u32], order: &mut [u32], ends: &mut [u32]) -> (usize, usize) {
    let mut next = 0;
    while let Some((first, end)) = run(grid, labels, next) {
        labels.get_mut(first..end).unwrap_or(&mut []).fill(INSIDE | first as u32);
        join_above(grid, labels, (first, end));
        next = end;
    }
    // A run is known by itself or by one before it, which has its component's number by now.
    let (mut components, mut next) = (0, 0);
    while let Some((first, end)) = run(grid, labels, next) {
        let mut number = known_by(labels, first);
        if number == first as u32 {
            number = components;
            set(ends, number, 0);
            components += 1;
        } else {
            number = known_by(labels, number as usize);
        }
        set(labels, first as u32, INSIDE | number);
        if let Some(pixels) = ends.get_mut(number as usize) {
            *pixels += (end - first) as u32;
        }
        next = end;
    }
    let mut listed = 0;
    for end in ends.iter_mut().take(components as usize) {
        (*end, listed) = (listed, listed + *end);
    }
    let mut next = 0;
    while let Some((first, end)) = run(grid, labels, next) {
        if let Some(free) = ends.get_mut(known_by(labels, first) as usize) {
            let places = order.get_mut(*free as usize..).unwrap_or(&mut []);
            places.iter_mut().zip(first as u32..end as u32).for_each(|(place, at)| *place = at);
            *free += (end - first) as u32;
        }
        next = end;
    }
    (components as usize, listed as usize)
}

/// The first marked pixel from `from` on, and the end of those that follow it in its row.
fn run(grid: Grid, labels: &[u32], from: usize) -> Option<(usize, usize)> {
    let first = next_with(labels, from, INSIDE)?;
    let row = labels.get(first..first + (grid.width.get() - first % grid.width))?;
    let length = row.iter().position(|label| label & INSIDE == 0).unwrap_or(row.len());
    Some((first, first + length))
}

/// The pixel, or the component, that a marked pixel is known by.
#[inline]
fn known_by(labels: &[u32], at: usize) -> u32 {
    labels.get(at).map_or(0, |label| label & !INSIDE)
}

/// The first pixel of the first run that the run of a pixel is known to touch; what leads there is halved on the way.
fn first_run(labels: &mut [u32], pixel: u32) -> u32 {
    let mut at = known_by(labels, pixel as usize);
    loop {
        let near = known_by(labels, at as usize);
        let far = known_by(labels, near as usize);
        // Of two runs the later one is known by the earlier.
        if near >= at || far >= near {
            return near;
        }
        set(labels, at, INSIDE | far);
        at = far;
    }
}

/// Lets a run and those in the row above that it touches be known by the first of them.
fn join_above(grid: Grid, labels: &mut [u32], (first, end): (usize, usize)) {
    let width = grid.width.get();
    let (left, row_end) = (first - first % width, first - first % width + width);
    let Some(above) = (first - usize::from(first > left)).checked_sub(width) else { return };
    let (mut own, mut is_followed) = (first as u32, false);
    for at in above..(end + usize::from(end < row_end)).saturating_sub(width) {
        let is_inside = labels.get(at).is_some_and(|label| label & INSIDE != 0);
        if is_inside && !is_followed {
            let other = first_run(labels, at as u32);
            set(labels, own.max(other), INSIDE | own.min(other));
            own = own.min(other);
        }
        is_followed = is_inside;
    }
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
    crew: &impl Crew,
) -> Count {
    let (field, light) = (Field { values: work.fine, grid }, Field { values: work.smooth, grid });
    let regions = work.regions.get_mut(..count.regions).unwrap_or(&mut []);
    centre_on_light([field, light], work.labels, regions, noise, crew);
    let regions = work.regions.get(..count.regions).unwrap_or(&[]);
    let typical = Typical::of(whole, field, noise.least, regions, (work.parents, work.order));
    if whole.is_some_and(Whole::is_waiting) {
        return count;
    }
    let Config { deblending, connectivity, .. } = *config;
    let Deblending { excess, reopened_area, .. } = deblending;
    let reopening = Reopening { field, typical, noise, excess, least_area: reopened_area, connectivity };
    for _ in 0..REOPENINGS {
        count = reopen(&reopening, work.labels, work.order, work.regions, count, crew);
    }
    for _ in 0..COMPETITIONS {
        shape(field, work.labels, work.regions.get_mut(..count.regions).unwrap_or(&mut []), crew);
        compete(field, work.labels, work.regions, SWEEPS, crew);
    }
    straighten(work.labels, work.order, grid, STRAIGHTENINGS, crew);
    connect(grid, work.labels, work.order, work.regions.get_mut(..count.regions).unwrap_or(&mut []));
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
    mark_inside::<L>(has_signal, work.labels);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::crew::Alone;
    use core::num::NonZero;

    extern crate std;
    use std::vec::Vec;

    const SIDE: usize = 160;

    /// So many hands, one after another.
    struct Hands(usize);

    impl Crew for Hands {
        fn hands(&self) -> usize {
            self.0
        }

        fn each<T: Send>(&self, items: impl Iterator<Item = T> + Send, work: impl Fn(T) + Sync) {
            items.for_each(work);
        }
    }

    /// A field of stars as thick as that of a globular cluster, with gaps between its components.
    fn crowd() -> Vec<f32> {
        let mut light = std::vec![0.0; SIDE * SIDE];
        let mut state = 1u32;
        let mut draw = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        for _ in 0..420 {
            let (x, y, peak) = (draw() * SIDE as f32, draw() * SIDE as f32, 3.0 * 200f32.powf(draw()));
            for (at, value) in light.iter_mut().enumerate() {
                let (dx, dy) = ((at % SIDE) as f32 - x, (at / SIDE) as f32 - y);
                *value += peak * (-(dx * dx + dy * dy) / (2.0 * 1.4 * 1.4)).exp();
            }
        }
        light
    }

    /// Regions of at least three pixels by their peaks.
    fn grown(light: &[f32], order: &[u32]) -> Vec<(u32, u32)> {
        let field = Field { values: light, grid: Grid { width: NonZero::new(SIDE).expect("not 0"), height: SIDE } };
        let (mut parents, mut ranks) = (std::vec![0; order.len()], std::vec![0; light.len()]);
        (1..).zip(order).for_each(|(rank, &at)| ranks[at as usize] = rank);
        let mut regions = std::vec![Region::<f32>::BLANK; light.len() / 3];
        let count = grow(field, order, &mut parents, &ranks, &mut regions, (&Config::NOISE_AWARE, 0.0));
        let large = regions[..count.regions].iter().filter(|region| region.area >= LEAST_AREA);
        let mut large: Vec<(u32, u32)> = large.map(|region| (region.peak, region.area)).collect();
        large.sort_unstable();
        large
    }

    /// Components as they are found pixel by pixel.
    #[test]
    fn runs_that_touch_are_one_component() {
        let (mut state, width) = (1u32, 37);
        for percent in [3, 20, 40, 55, 70, 100] {
            let grid = Grid { width: NonZero::new(width).expect("not 0"), height: 29 };
            let mut draw = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if (state >> 8) % 100 < percent { INSIDE } else { 0 }
            };
            let mut labels: Vec<u32> = (0..grid.cells()).map(|_| draw()).collect();
            let (mut left, mut queue) = (labels.clone(), std::vec![0; labels.len()]);
            let [mut order, mut ends] = [(); 2].map(|()| std::vec![0; labels.len()]);
            let (components, listed) = by_component(grid, &mut labels, &mut order, &mut ends);
            let (mut found, mut expected) = (0, Vec::new());
            while let Some(first) = left.iter().position(|&label| label == INSIDE) {
                let count = relabel((grid, Connectivity::Eight), first, 0, &mut left, &mut queue);
                queue[..count].sort_unstable();
                expected.extend_from_slice(&queue[..count]);
                assert_eq!(ends[found] as usize, expected.len(), "{percent} %: component {found}");
                found += 1;
            }
            assert_eq!((components, &order[..listed]), (found, &expected[..]), "{percent} %");
        }
    }

    #[test]
    fn the_order_of_components_changes_nothing() {
        let light = crowd();
        let grid = Grid { width: NonZero::new(SIDE).expect("not 0"), height: SIDE };
        for threshold in [1.0, 4.0, 8.0, 16.0] {
            let outline =
                |threshold: f32| light.iter().map(|value| (value - threshold).to_bits()).collect::<Vec<u32>>();
            let mut labels = outline(threshold);
            let [mut order, mut spare] = [(); 2].map(|()| std::vec![0; light.len()]);
            mark_inside::<f32>(|_| true, &mut labels);
            let field = Field { values: &light, grid };
            let used = by_brightness(field, &mut labels, &mut order, &mut spare, &Alone);
            let by_component = &order[..used];
            let mut over_all: Vec<u32> = by_component.to_vec();
            over_all.sort_by_key(|&at| (!light[at as usize].key(), at));
            assert_ne!(over_all, by_component, "there are several components");
            let regions = grown(&light, by_component);
            assert!(regions.len() > 100, "{} regions above {threshold}", regions.len());
            assert_eq!(regions, grown(&light, &over_all), "above {threshold}");
            for hands in [2, 3, 50] {
                let (mut labels, mut shared) = (outline(threshold), std::vec![0; light.len()]);
                mark_inside::<f32>(|_| true, &mut labels);
                by_brightness(field, &mut labels, &mut shared, &mut spare, &Hands(hands));
                assert_eq!(&shared[..used], by_component, "{hands} hands above {threshold}");
            }
        }
    }
}
