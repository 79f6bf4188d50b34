//! Outlined pixels become regions: connected components, or parts of the tree of level sets.

use crate::arithmetic::Level;
use crate::arithmetic::codec::Codec;
use crate::config::{Config, Connectivity, Deblending};
use crate::plane::crew::Crew;
use crate::plane::field::Field;
use crate::plane::grid::Grid;
use crate::plane::part::Whole;
use crate::plane::rows::rows_of_mut;
use crate::plane::smooth::Weights;
use crate::plane::sort;
use crate::plane::walk::Walk;
use crate::sources::centre::{centre_on_light, shape};
use crate::sources::deblend::{Contest, Opening, Reopening, compete, reopen, straighten};
use crate::sources::pieces::{Joining, connect, relabel};
use crate::sources::tree::{Count, Noise, Region, grow, region_at, root};
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
    /// Pixels that are listed.
    listed: usize,
    /// The next pixel.
    next: usize,
    /// The label of the component at hand.
    label: u32,
}

impl Growing {
    /// Before the first pass.
    pub const NOTHING: Growing = Growing { count: Count { regions: 0, left_out: 0 }, listed: 0, next: 0, label: 0 };

    /// The list of fields, out or in.
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        self.count.code(codec)?;
        codec.size(&mut self.listed)?;
        codec.size(&mut self.next)?;
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
    by_brightness(walk, growing, field, work.labels, work.order, work.parents)?;
    let order = work.order.get(..growing.listed).unwrap_or(&[]);
    walk.pass(order.len(), 2, |part| {
        let setting = (config, photon);
        grow(&mut growing.count, field, (order, part), work.parents, work.labels, work.regions, setting);
    })?;
    walk.pass(growing.count.regions, 2, |part| {
        for region in work.regions.get_mut(part).unwrap_or(&mut []) {
            region.centre = field.centre(region.peak as usize);
        }
    })?;
    walk.pass(order.len(), 1, |part| {
        for (rank, &at) in (0..).zip(order).take(part.end).skip(part.start) {
            let root = root(work.parents, rank);
            let index = region_at(work.parents, root);
            let large = work.regions.get(index).is_some_and(|region| region.area >= LEAST_AREA);
            set(work.labels, at, if large { index as u32 + 1 } else { 0 });
        }
    })
}

/// A pixel inside the outlines that is not listed yet.
const INSIDE: u32 = 1 << 31;
/// One that is listed, and has no rank yet.
const LISTED: u32 = 1 << 30;

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
/// them; `spare` is as long as the list.
fn by_brightness<L: Level>(
    walk: &mut Walk,
    growing: &mut Growing,
    field: Field<'_, L>,
    labels: &mut [u32],
    order: &mut [u32],
    spare: &mut [u32],
) -> Option<()> {
    /// Fewer are sorted by insertion.
    const FEW: usize = 32;
    let key = |at: u32| !field.at(at as usize).key();
    let mark = walk.mark();
    while let Some(first) = walk.seek_bits(labels, &mut growing.next, INSIDE)? {
        let free = order.get_mut(growing.listed..).unwrap_or(&mut []);
        let count = relabel(walk, (field.grid, Connectivity::Eight), (first, [INSIDE, LISTED]), labels, free)?;
        let component = free.get_mut(..count).unwrap_or(&mut []);
        if count < FEW {
            walk.once(count, || sort::few(component, |a, b| (key(a), a) < (key(b), b)))?;
        } else {
            sort::by_key_in(walk, component, spare, |at| at)?;
            sort::by_key_in(walk, component, spare, key)?;
        }
        walk.pass(count, 1, |part| {
            for (rank, &at) in (growing.listed as u32 + 1..).zip(component.iter()).take(part.end).skip(part.start) {
                set(labels, at, rank);
            }
        })?;
        growing.listed += count;
        growing.next = first + 1;
        walk.again(mark);
    }
    Some(())
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
    centre_on_light(walk, [field, light], work.labels, regions, noise)?;
    Typical::find(walk, is_typical, whole, field, noise.least, regions, (work.parents, work.order))?;
    if whole.is_some_and(Whole::is_waiting) {
        return Some(());
    }
    let typical = Typical::over(work.parents, *is_typical);
    let Config { deblending, connectivity, .. } = *config;
    let Deblending { excess, reopened_area, .. } = deblending;
    let reopening = Reopening { field, typical, noise, excess, least_area: reopened_area, connectivity };
    for _ in 0..REOPENINGS {
        reopen(walk, opening, &reopening, work.labels, work.order, work.regions)?;
    }
    let regions = work.regions.get_mut(..opening.count.regions).unwrap_or(&mut []);
    for _ in 0..COMPETITIONS {
        shape(walk, field, work.labels, regions)?;
        compete((walk, crew), contest, field, work.labels, regions, SWEEPS)?;
    }
    straighten((walk, crew), work.labels, work.order, grid, STRAIGHTENINGS)?;
    connect(walk, joining, grid, work.labels, work.order, regions)
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
        let (mut count, all) = (Count::default(), (order, 0..order.len()));
        grow(&mut count, field, all, &mut parents, &ranks, &mut regions, (&Config::NOISE_AWARE, 0.0));
        let large = regions[..count.regions].iter().filter(|region| region.area >= LEAST_AREA);
        let mut large: Vec<(u32, u32)> = large.map(|region| (region.peak, region.area)).collect();
        large.sort_unstable();
        large
    }

    #[test]
    fn the_order_of_components_changes_nothing() {
        let light = crowd();
        let grid = Grid { width: NonZero::new(SIDE).expect("not 0"), height: SIDE };
        for threshold in [1.0, 4.0, 8.0, 16.0] {
            let mut labels: Vec<u32> = light.iter().map(|value| (value - threshold).to_bits()).collect();
            let [mut order, mut spare] = [(); 2].map(|()| std::vec![0; light.len()]);
            mark_inside::<f32>(|_| true, 0..SIDE, SIDE, &mut labels);
            let (mut growing, field) = (Growing::NOTHING, Field { values: &light, grid });
            let _ = by_brightness(&mut Walk::whole(), &mut growing, field, &mut labels, &mut order, &mut spare);
            let by_component = &order[..growing.listed];
            let mut over_all: Vec<u32> = by_component.to_vec();
            over_all.sort_by_key(|&at| (!light[at as usize].key(), at));
            assert_ne!(over_all, by_component, "there are several components");
            let regions = grown(&light, by_component);
            assert!(regions.len() > 100, "{} regions above {threshold}", regions.len());
            assert_eq!(regions, grown(&light, &over_all), "above {threshold}");
        }
    }
}
