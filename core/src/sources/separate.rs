//! Outlined pixels become regions: connected components, or parts of the tree of level sets.

use crate::arithmetic::Level;
use crate::arithmetic::codec::Codec;
use crate::config::{Config, Connectivity, Deblending};
use crate::plane::crew::Crew;
use crate::plane::field::Field;
use crate::plane::grid::Grid;
use crate::plane::part::Whole;
use crate::plane::rows::{next_with, rows_of_mut};
use crate::plane::smooth::Weights;
use crate::plane::sort;
use crate::plane::walk::Walk;
use crate::sources::centre::{centre_on_light, shape};
use crate::sources::deblend::{Contest, Opening, Reopening, compete, reopen, straighten};
use crate::sources::knots;
use crate::sources::pieces::{Joining, connect, relabel};
use crate::sources::tree::{Count, Noise, Region, Share, grow, grow_by, region_at, root_of};
use crate::sources::typical::Typical;
use core::ops::Range;

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

/// How far the pixels inside the outlines are listed and the tree has grown, part by part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Growing {
    /// The regions.
    pub count: Count,
    /// Components, and the pixels that are listed.
    components: usize,
    listed: usize,
    /// The next component or pixel.
    next: usize,
    /// The label of the component at hand.
    label: u32,
}

impl Growing {
    /// Before the first pass.
    pub const NOTHING: Growing =
        Growing { count: Count { regions: 0, left_out: 0 }, components: 0, listed: 0, next: 0, label: 0 };

    /// The list of fields, out or in.
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        self.count.code(codec)?;
        for size in [&mut self.components, &mut self.listed, &mut self.next] {
            codec.size(size)?;
        }
        codec.word(&mut self.label)
    }
}

/// Lets the tree of level sets grow over the pixels inside the outlines that have a signal, and gives
/// each the label of its region.
pub(crate) fn tree<L: Level>(
    (walk, crew): (&mut Walk, &impl Crew),
    growing: &mut Growing,
    grid: Grid,
    has_signal: impl Fn(usize) -> bool,
    (config, photon): (&Config, f32),
    work: &mut Planes<'_, L>,
) -> Option<()> {
    let (width, sharpening) = (grid.width.get(), config.deblending.sharpening);
    walk.pass(grid.height, 2 * width, |rows| {
        Weights::gauss(SHARPNESS).sharpen_rows(rows, work.fine, work.rows, grid, sharpening, crew);
    })?;
    let field = Field { values: work.fine, grid };
    walk.pass(grid.height, width, |rows| mark_inside::<L>(has_signal, rows, width, work.labels))?;
    by_brightness((walk, crew), growing, field, work.labels, work.order, work.parents)?;
    let order = work.order.get(..growing.listed).unwrap_or(&[]);
    let mut share = Share { first: 0, order, parents: work.parents, regions: work.regions };
    let (count, setting) = (&mut growing.count, (config, photon));
    if walk.is_open() && crew.hands() > 1 {
        let components = growing.components;
        walk.once(order.len(), || grow_by(crew, count, field, &mut share, components, work.labels, setting))?;
    } else {
        walk.pass(order.len(), 2, |part| grow(count, field, &mut share, part, work.labels, setting))?;
    }
    walk.pass(growing.count.regions, 2, |part| {
        for region in work.regions.get_mut(part).unwrap_or(&mut []) {
            region.centre = field.centre(region.peak as usize);
        }
    })?;
    walk.pass(order.len(), 1, |part| {
        for (rank, &at) in (0..).zip(order).take(part.end).skip(part.start) {
            let root = root_of(work.parents, rank);
            let index = region_at(work.parents, root);
            let large = work.regions.get(index).is_some_and(|region| region.area >= LEAST_AREA);
            set(work.labels, at, if large { index as u32 + 1 } else { 0 });
        }
    })
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

/// Makes marks of the pixels of some rows that are inside the front and have a signal, and 0 of the others.
fn mark_inside<L: Level>(has_signal: impl Fn(usize) -> bool, rows: Range<usize>, width: usize, front: &mut [u32]) {
    /// Pixels that are looked at together.
    const PIECE: usize = 32;
    let is_inside = |bits: u32| L::from_bits(bits) > L::ZERO;
    let pieces = rows_of_mut(front, &rows, width).chunks_mut(PIECE);
    for (first, front) in (rows.start * width..).step_by(PIECE).zip(pieces) {
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
/// brightest down, of equal pixels the first in the frame first, and marks each by 1 + its place in the list. Counts
/// them; `spare` is as long as the plane.
fn by_brightness<L: Level>(
    (walk, crew): (&mut Walk, &impl Crew),
    growing: &mut Growing,
    field: Field<'_, L>,
    labels: &mut [u32],
    order: &mut [u32],
    spare: &mut [u32],
) -> Option<()> {
    by_component(walk, growing, field.grid, labels, order, spare)?;
    // Where a component ends the next one begins, and the last one ends with the list. Left of the first pixel of every
    // other component, or above it, is one of its own that is not inside: there is room for both.
    let (ends, spare) = spare.split_at_mut_checked(growing.components.saturating_sub(1)).unwrap_or_default();
    let order = order.get_mut(..growing.listed).unwrap_or(&mut []);
    if walk.is_open() {
        let groups = groups(order, spare, ends, crew.hands());
        walk.once(growing.listed, || crew.each(groups, |group| group.sort(field)))?;
    } else {
        sort_each(walk, growing, field, order, spare, ends)?;
    }
    walk.pass(growing.listed, 1, |part| {
        for (rank, &at) in (1..).zip(order.iter()).take(part.end).skip(part.start) {
            set(labels, at, rank);
        }
    })
}

/// Fewer pixels are sorted by insertion.
const FEW: usize = 32;

/// Sorts each component from its brightest pixel down, of equal pixels the first in the frame first.
fn sort_each<L: Level>(
    walk: &mut Walk,
    growing: &mut Growing,
    field: Field<'_, L>,
    order: &mut [u32],
    spare: &mut [u32],
    ends: &[u32],
) -> Option<()> {
    let key = |at: u32| !field.at(at as usize).key();
    let listed = order.len();
    let end_of = |component: usize| ends.get(component).map_or(listed, |&end| end as usize);
    walk.once(1, || growing.next = 0)?;
    let mark = walk.mark();
    while let Some(number) = walk.each(growing.components, &mut growing.next)? {
        let (start, end) = (number.checked_sub(1).map_or(0, end_of), end_of(number));
        let component = order.get_mut(start..end).unwrap_or(&mut []);
        if component.len() < FEW {
            walk.once(component.len(), || sort::few(component, |a, b| key(a) < key(b)))?;
        } else {
            sort::by_key_in(walk, component, spare, key)?;
        }
        growing.next = number + 1;
        walk.again(mark);
    }
    Some(())
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
    /// The same for these.
    fn sort<L: Level>(self, field: Field<'_, L>) {
        let Group { first, mut pixels, spare, ends } = self;
        let (key, mut start) = (|at: u32| !field.at(at as usize).key(), first);
        for end in ends.iter().map(|&end| end as usize).chain([first + pixels.len()]) {
            let (component, rest) = pixels.split_at_mut_checked(end.saturating_sub(start)).unwrap_or_default();
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
    // What is not needed is not touched.
    let more = (spare.len().saturating_sub(listed) / hands).min(sort::WIDE_ROOM);
    let (share, mut first) = (listed.div_ceil(hands), 0);
    core::iter::from_fn(move || {
        if order.is_empty() {
            return None;
        }
        let inner = ends.partition_point(|&end| (end as usize) < first + share);
        let end = ends.get(inner).map_or(listed, |&end| end as usize);
        let (pixels, rest) = core::mem::take(&mut order).split_at_mut_checked(end.saturating_sub(first))?;
        let (own, room) = core::mem::take(&mut spare).split_at_mut_checked(pixels.len() + more)?;
        let group = Group { first, pixels, spare: own, ends: ends.get(..inner).unwrap_or(&[]) };
        (order, spare, first) = (rest, room, end);
        ends = ends.get(inner + 1..).unwrap_or(&[]);
        Some(group)
    })
}

/// Lists the marked pixels by the components that they form, also by corners: these by their first pixels, the pixels
/// of each as they lie in the frame. Counts components and pixels; `ends` has where in the list each
/// component ends. Cost: three looks at each pixel, and two at those above.
fn by_component(
    walk: &mut Walk,
    growing: &mut Growing,
    grid: Grid,
    labels: &mut [u32],
    order: &mut [u32],
    ends: &mut [u32],
) -> Option<()> {
    let width = grid.width.get();
    walk.pass(grid.height, 2 * width, |rows| {
        each_run(grid, rows, labels, |labels, (first, end)| {
            labels.get_mut(first..end).unwrap_or(&mut []).fill(INSIDE | first as u32);
            join_above(grid, labels, (first, end));
        });
    })?;
    walk.pass(grid.height, width, |rows| {
        each_run(grid, rows, labels, |labels, run| number(run, &mut growing.components, labels, ends));
    })?;
    walk.pass(growing.components, 1, |part| {
        for end in ends.get_mut(part).unwrap_or(&mut []) {
            let pixels = *end as usize;
            (*end, growing.listed) = (growing.listed as u32, growing.listed.saturating_add(pixels));
        }
    })?;
    walk.pass(grid.height, width, |rows| {
        each_run(grid, rows, labels, |labels, (first, end)| {
            if let Some(free) = ends.get_mut(known_by(labels, first) as usize) {
                let places = order.get_mut(*free as usize..).unwrap_or(&mut []);
                places.iter_mut().zip(first as u32..end as u32).for_each(|(place, at)| *place = at);
                *free = free.wrapping_add((end - first) as u32);
            }
        });
    })
}

/// Goes through the runs of marked pixels in some rows: the first pixel of each, and its end.
fn each_run(grid: Grid, rows: Range<usize>, labels: &mut [u32], mut work: impl FnMut(&mut [u32], (usize, usize))) {
    let (mut next, last) = (rows.start * grid.width.get(), rows.end * grid.width.get());
    while let Some(first) = next_with(labels.get(..last).unwrap_or(&[]), next, INSIDE) {
        let row = labels.get(first..first + (grid.width.get() - first % grid.width)).unwrap_or(&[]);
        next = first + row.iter().position(|label| label & INSIDE == 0).unwrap_or(row.len()).max(1);
        work(labels, (first, next));
    }
}

/// Lets the first pixel of a run have the number of its component, and counts its pixels there. It is known by itself
/// or by one before it, which has the number by now.
fn number((first, end): (usize, usize), components: &mut usize, labels: &mut [u32], pixels: &mut [u32]) {
    let mut number = known_by(labels, first);
    if number == first as u32 {
        number = *components as u32;
        set(pixels, number, 0);
        *components = components.saturating_add(1);
    } else {
        number = known_by(labels, number as usize);
    }
    set(labels, first as u32, INSIDE | number);
    if let Some(pixels) = pixels.get_mut(number as usize) {
        *pixels = pixels.wrapping_add((end - first) as u32);
    }
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

/// How far blends are divided, part by part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dividing<L: Level> {
    /// Whether there is a typical source.
    is_typical: bool,
    pub opening: Opening<L>,
    contest: Contest,
    joining: Joining,
}

impl<L: Level> Dividing<L> {
    /// Before the first pass.
    pub const NOTHING: Dividing<L> =
        Dividing { is_typical: false, opening: Opening::NOTHING, contest: Contest::NOTHING, joining: Joining::NOTHING };

    /// The list of fields, out or in.
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        codec.flag(&mut self.is_typical)?;
        self.opening.code(codec)?;
        self.contest.code(codec)?;
        self.joining.code(codec)
    }
}

/// Gives regions their centres, makes light that no host explains regions of their own, lets
/// neighbours compete for the pixels between them, and leaves each label one connected piece. Ends where other
/// parts of the image have yet to answer. `dividing` has the count of the regions.
pub(crate) fn deblend<L: Level>(
    (walk, crew): (&mut Walk, &impl Crew),
    dividing: &mut Dividing<L>,
    whole: Option<&dyn Whole>,
    grid: Grid,
    config: &Config,
    noise: Noise<L>,
    work: &mut Planes<'_, L>,
) -> Option<()> {
    let Dividing { is_typical, opening, contest, joining } = dividing;
    let (field, light) = (Field { values: work.fine, grid }, Field { values: work.smooth, grid });
    let regions = work.regions.get_mut(..opening.count.regions).unwrap_or(&mut []);
    centre_on_light((walk, crew), [field, light], work.labels, regions, noise)?;
    Typical::find((walk, crew), is_typical, whole, field, noise.least, regions, (work.parents, work.order))?;
    if whole.is_some_and(Whole::is_waiting) {
        return Some(());
    }
    let typical = Typical::over(work.parents, *is_typical);
    let Config { deblending, connectivity, .. } = *config;
    let Deblending { excess, reopened_area, .. } = deblending;
    let reopening = Reopening { field, typical, noise, excess, least_area: reopened_area, connectivity };
    reopen((walk, crew), opening, &reopening, work.labels, work.order, (work.regions, REOPENINGS))?;
    let regions = work.regions.get_mut(..opening.count.regions).unwrap_or(&mut []);
    for _ in 0..COMPETITIONS {
        shape((walk, crew), field, work.labels, regions)?;
        compete((walk, crew), contest, field, work.labels, regions, SWEEPS)?;
    }
    straighten((walk, crew), work.labels, work.order, grid, STRAIGHTENINGS)?;
    knots::join((walk, crew), deblending.knots, field, work.labels, regions)?;
    connect(walk, joining, grid, work.labels, (work.order, work.parents), regions)
}

/// Makes the connected components of the pixels inside the outlines that have a signal regions, in
/// raster order of their first pixels.
pub(crate) fn components<L: Level>(
    walk: &mut Walk,
    growing: &mut Growing,
    grid: Grid,
    has_signal: impl Fn(usize) -> bool,
    connectivity: Connectivity,
    work: &mut Planes<'_, L>,
) -> Option<()> {
    let width = grid.width.get();
    walk.pass(grid.height, width, |rows| mark_inside::<L>(has_signal, rows, width, work.labels))?;
    let mark = walk.mark();
    while let Some(first) = walk.seek_bits(work.labels, &mut growing.next, INSIDE)? {
        let Growing { count, label, .. } = growing;
        walk.once(1, || {
            *label = match work.regions.get_mut(count.regions) {
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
        })?;
        relabel(walk, (grid, connectivity), (first, [INSIDE, *label]), work.labels, work.order)?;
        growing.next = first + 1;
        walk.again(mark);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::num::NonZero;

    extern crate std;
    use std::vec::Vec;

    const SIDE: usize = 160;

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
        let mut share = Share { first: 0, order, parents: &mut parents, regions: &mut regions };
        let (mut count, setting) = (Count::default(), (&Config::NOISE_AWARE, 0.0));
        grow(&mut count, field, &mut share, 0..order.len(), &ranks, setting);
        let large = regions[..count.regions].iter().filter(|region| region.area >= LEAST_AREA);
        let mut large: Vec<(u32, u32)> = large.map(|region| (region.peak, region.area)).collect();
        large.sort_unstable();
        large
    }

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

    fn grid(width: usize, height: usize) -> Grid {
        Grid { width: NonZero::new(width).expect("not 0"), height }
    }

    /// Components as they are found pixel by pixel.
    #[test]
    fn runs_that_touch_are_one_component() {
        let (mut state, grid) = (1u32, grid(37, 29));
        for percent in [3, 20, 40, 55, 70, 100] {
            let mut draw = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if (state >> 8) % 100 < percent { INSIDE } else { 0 }
            };
            let mut labels: Vec<u32> = (0..grid.cells()).map(|_| draw()).collect();
            let (mut left, mut queue) = (labels.clone(), std::vec![0; labels.len()]);
            let [mut order, mut ends] = [(); 2].map(|()| std::vec![0; labels.len()]);
            let mut growing = Growing::NOTHING;
            by_component(&mut Walk::whole(), &mut growing, grid, &mut labels, &mut order, &mut ends).expect("all");
            let (mut found, mut expected) = (0, Vec::new());
            while let Some(first) = left.iter().position(|&label| label == INSIDE) {
                let corners = (grid, Connectivity::Eight);
                let count = relabel(&mut Walk::whole(), corners, (first, [INSIDE, 0]), &mut left, &mut queue);
                let component = &mut queue[..count.expect("all")];
                component.sort_unstable();
                expected.extend_from_slice(component);
                assert_eq!(ends[found] as usize, expected.len(), "{percent} %: component {found}");
                found += 1;
            }
            assert_eq!((growing.components, &order[..growing.listed]), (found, &expected[..]), "{percent} %");
        }
    }

    #[test]
    fn the_order_of_components_changes_nothing() {
        let (light, grid) = (crowd(), grid(SIDE, SIDE));
        let field = Field { values: &light, grid };
        for threshold in [1.0, 4.0, 8.0, 16.0] {
            let list = |hands: usize, cells: usize| {
                let mut labels: Vec<u32> = light.iter().map(|value| (value - threshold).to_bits()).collect();
                let [mut order, mut spare] = [(); 2].map(|()| std::vec![0; light.len()]);
                mark_inside::<f32>(|_| true, 0..SIDE, SIDE, &mut labels);
                let (mut walk, mut growing, crew) = (Walk::whole(), Growing::NOTHING, Hands(hands));
                let mut list = |walk: &mut Walk| {
                    walk.resume(cells);
                    by_brightness((walk, &crew), &mut growing, field, &mut labels, &mut order, &mut spare)
                };
                while list(&mut walk).is_none() {}
                order.truncate(growing.listed);
                (order, spare, labels, growing.components)
            };
            let (by_component, ends, ranks, components) = list(1, usize::MAX);
            let mut over_all = by_component.clone();
            over_all.sort_by_key(|&at| (!light[at as usize].key(), at));
            assert_ne!(over_all, by_component, "there are several components");
            let regions = grown(&light, &by_component);
            assert!(regions.len() > 100, "{} regions above {threshold}", regions.len());
            assert_eq!(regions, grown(&light, &over_all), "above {threshold}");
            for (hands, cells) in [(2, usize::MAX), (3, usize::MAX), (50, usize::MAX), (1, 100), (1, 1 << 14)] {
                assert_eq!(list(hands, cells).0, by_component, "{hands} hands, parts of {cells}, above {threshold}");
            }
            let grow = |hands: usize, room: usize| {
                let (mut parents, mut regions) = (ends.clone(), std::vec![Region::<f32>::BLANK; room]);
                let (mut count, setting) = (Count::default(), (&Config::NOISE_AWARE, 0.0));
                let mut share = Share { first: 0, order: &by_component, parents: &mut parents, regions: &mut regions };
                grow_by(&Hands(hands), &mut count, field, &mut share, components, &ranks, setting);
                parents.truncate(by_component.len());
                regions.truncate(count.regions);
                (count, parents, regions)
            };
            let alone = grow(1, light.len());
            let room = alone.0.regions;
            assert!(components > 3 && room > components && alone.0.left_out == 0);
            for hands in [2, 3, 50] {
                assert!(grow(hands, light.len()) == alone, "{hands} hands above {threshold}");
                // Too few for one of them, and for all.
                assert!(grow(hands, room) == alone && grow(hands, room - 1) == grow(1, room - 1));
            }
        }
    }
}
