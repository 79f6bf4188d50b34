//! The tree of level sets: pixels from the brightest down, regions that grow, and where two of
//! them meet the question whether the fainter is a source of its own.
//!
//! After Bijaoui and others; the test of significance follows the idea of MTObjects (Teeninga et
//! al. 2016, doi:10.1515/mathm-2016-0006), the mirror that of the SDSS deblender (Lupton 2001).

use crate::arithmetic::codec::Codec;
use crate::arithmetic::{Level, Real};
use crate::config::{Config, Deblending};
use crate::plane::crew::Crew;
use crate::plane::field::{Ellipse, Field};
use crate::plane::sort;
use crate::sky::photon::grown;
use core::ops::Range;

/// A region of the tree, in the end a source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region<L: Level> {
    /// Index of its brightest pixel.
    pub peak: u32,
    /// Value there.
    pub value: L,
    /// Number of pixels; while the centre is looked for, of those above half the peak, and of a galaxy's knots at last.
    pub area: u32,
    /// Sum of its values.
    pub sum: L::Sum,
    /// Its centre, (x, y), to a fraction of a pixel.
    pub centre: (L, L),
    /// Of its pixels above half its peak, the sums of the values times the distances from the peak along
    /// x and y; while sources compete, its shape (see [`Ellipse::of`]); while they are selected, its peaks in
    /// the narrow and in the matched image.
    pub offsets: (f32, f32),
    /// Pixels of the plateau that it ends in, as a saturated star does; 0 where it ends in a peak.
    /// While the centre is looked for, the sum of the values above half the peak; while the shape is, that of second
    /// moments.
    pub plateau: f32,
    /// 1 + the index of a pixel in the brightest part that was divided from it; 0 for none.
    pub divided: u32,
    /// The label it ends with; while the centre is looked for, the number of its pixels that are as bright as a plateau,
    /// and while knots are, the label of the brightest source that it touches.
    pub label: u32,
}

impl<L: Level> Region<L> {
    /// All bits 0: static memory full of it takes no room in a program's image.
    pub const BLANK: Region<L> = Region {
        peak: 0,
        value: L::ZERO,
        area: 0,
        sum: L::NOTHING,
        centre: (L::ZERO, L::ZERO),
        offsets: (0.0, 0.0),
        plateau: 0.0,
        divided: 0,
        label: 0,
    };

    /// The shape of its isophotes; round for a plateau, of whose light a bleed trail would make an ellipse. None for a
    /// needle: what lies around it tells nothing of it.
    pub fn shape(&self) -> Option<Ellipse<L>> {
        if self.plateau > 0.0 { Some(Ellipse::ROUND) } else { Ellipse::of(self.offsets) }
    }

    /// Remembers the part that has a pixel, where no brighter one is known.
    pub fn divide(&mut self, field: Field<'_, L>, pixel: u32) {
        let known = |place: u32| (place as usize).checked_sub(1).map(|at| field.at(at));
        if known(self.divided).is_none_or(|value| field.at(pixel as usize) > value) {
            self.divided = pixel.saturating_add(1);
        }
    }

    /// The label of another source that the region was divided from, where both became sources: then
    /// both are blended. `labels` are the final ones.
    pub fn divided_from(&self, labels: &[u32]) -> Option<u32> {
        let other = (self.divided as usize).checked_sub(1).and_then(|at| labels.get(at).copied());
        other.filter(|&other| self.label != 0 && other != 0 && other != self.label)
    }

    /// The list of fields, out or in.
    pub(crate) fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        let mut sum = L::sum_bits(self.sum);
        for word in [&mut self.peak, &mut self.area, &mut self.divided, &mut self.label] {
            codec.word(word)?;
        }
        for level in [&mut self.value, &mut self.centre.0, &mut self.centre.1] {
            codec.bits(level)?;
        }
        for real in [&mut self.offsets.0, &mut self.offsets.1, &mut self.plateau] {
            codec.real(real)?;
        }
        codec.long(&mut sum)?;
        self.sum = L::sum_of_bits(sum);
        Ok(())
    }

    /// A region of one pixel.
    fn of(peak: u32, value: L) -> Region<L> {
        Region { peak, value, area: 1, sum: value.times(1), ..Region::BLANK }
    }
}

/// How far a peak must rise above the saddle, as a part of the saddle's light: the image of a point
/// in real optics is that uneven, as the ring of a mirror out of focus and the rim of a saturated star.
const DEPTH: f32 = 0.15;

/// The noise of the lightly smoothed plane, and how it grows with light.
#[derive(Clone, Copy, Debug)]
pub struct Noise<L> {
    /// Of a pixel without light.
    pub least: L,
    /// The photon noise ([`crate::sky::photon`]).
    pub photon: f32,
}

impl<L: Level> Noise<L> {
    /// The noise of a pixel with the light `value`.
    pub fn at(&self, value: L) -> L {
        self.least * grown(self.photon, value)
    }
}

/// Regions that were made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Regions in the table.
    pub regions: usize,
    /// Peaks or components for which the table had no room: their pixels are in none.
    pub left_out: u32,
}

impl Count {
    /// The list of fields, out or in.
    pub(crate) fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        codec.size(&mut self.regions)?;
        codec.word(&mut self.left_out)
    }
}

/// Of the nine pixels around a peak so many must be its own: most of them.
const MOST: usize = 5;

/// In place of a parent: the rest is the index of the region whose first pixel this is.
pub(crate) const ROOT: u32 = 1 << 31;
/// Parent of a pixel that is in no region.
const NONE: u32 = u32::MAX;

/// The first pixel of a pixel's region, both by rank; paths are halved on the way. What is no earlier rank ends the
/// path: the mark of a root, and whatever else a damaged word may hold.
pub fn root_of(parents: &mut [u32], mut rank: u32) -> u32 {
    let parent = |parents: &[u32], rank: u32| parents.get(rank as usize).copied().unwrap_or(NONE);
    loop {
        let near = parent(parents, rank);
        if near >= rank {
            return rank;
        }
        let far = parent(parents, near);
        if far >= near {
            return near;
        }
        if let Some(cell) = parents.get_mut(rank as usize) {
            *cell = far;
        }
        rank = far;
    }
}

/// The index of the region whose first pixel has this rank; beyond all tables for a pixel that is in none.
#[inline]
pub fn region_at(parents: &[u32], root: u32) -> usize {
    parents.get(root as usize).map_or(usize::MAX, |parent| (parent & !ROOT) as usize)
}

/// Some components, of which the regions grow by themselves.
pub(crate) struct Share<'a, L: Level> {
    /// Pixels in the list before these.
    pub first: usize,
    /// Their pixels, of each component from the brightest down.
    pub order: &'a [u32],
    /// As many: each pixel's parent, by its place here.
    pub parents: &'a mut [u32],
    /// Their regions.
    pub regions: &'a mut [Region<L>],
}

/// Grows the regions of a share by the pixels of some places there. `ranks` has 1 + the place in the whole list of each
/// pixel in use and 0 elsewhere; `photon` is the photon noise. Counts the regions, and peaks for which none was free:
/// they stay out.
pub(crate) fn grow<L: Level>(
    counted: &mut Count,
    field: Field<'_, L>,
    share: &mut Share<'_, L>,
    part: Range<usize>,
    ranks: &[u32],
    (config, photon): (&Config, f32),
) {
    let Count { regions: mut count, mut left_out } = *counted;
    let Share { first, order, parents, regions } = share;
    let listed = |at: usize| ranks.get(at).and_then(|rank| rank.checked_sub(1));
    // In the share; nothing for what lies before.
    let before = *first as u32;
    let rank_of = |at: usize| listed(at)?.checked_sub(before);
    // The same, and beyond all ranks for what is in none.
    let rank_in = |at: usize| ranks.get(at).map_or(NONE, |rank| rank.wrapping_sub(before.wrapping_add(1)));
    for (rank, &pixel) in (0..).zip(*order).take(part.end).skip(part.start) {
        let at = pixel as usize;
        let value = field.at(at);
        let (mut roots, mut found, mut root) = ([NONE; 8], 0, NONE);
        let (around, open) = field.grid.around(at, config.connectivity.neighbours());
        let ranks = (0..).zip(around).map(|(bit, near)| if open >> bit & 1 == 1 { rank_in(near) } else { NONE });
        for &known in earlier(ranks, rank, &mut [0; 8]) {
            // Most neighbours are of one region, and some know its root.
            let parent = parents.get(known as usize).copied().unwrap_or(NONE);
            if parent != NONE && known != root && parent != root {
                root = root_of(parents, known);
                if !roots.contains(&root)
                    && let Some(free) = roots.get_mut(found)
                {
                    *free = root;
                    found += 1;
                }
            }
        }
        // Of several the one whose pixel is the brightest of the neighbours.
        let nearest = match found {
            0 => None,
            1 => Some(root),
            _ => {
                let near = field.grid.touching(at, config.connectivity.neighbours());
                let known = |near: usize| rank_of(near).filter(|&near| near < rank && !is_out(parents, near));
                let known = near.filter_map(|near| Some((field.at(near), known(near)?)));
                let brighter =
                    |(bright, of), (value, known)| if value > bright { (value, known) } else { (bright, of) };
                known.reduce(brighter).map(|(_, known)| root_of(parents, known))
            }
        };
        let Some(own) = parents.get_mut(rank as usize) else { break };
        let Some(mut nearest) = nearest else {
            let Some(region) = regions.get_mut(count) else {
                *own = NONE;
                left_out += 1;
                continue;
            };
            *region = Region::of(pixel, value);
            *own = ROOT | count as u32;
            count += 1;
            continue;
        };
        // Nothing looks at it before it has one.
        *own = NONE;
        let roots = roots.get_mut(..found).unwrap_or(&mut []);
        // By rank: that with the brightest peak comes first.
        sort::few(roots, |a, b| a < b);
        let Some((&host, others)) = roots.split_first() else { continue };
        for &other in others {
            let (host_id, other_id) = (region_at(parents, host), region_at(parents, other));
            let (Some(&bright), Some(&faint)) = (regions.get(host_id), regions.get(other_id)) else { continue };
            // What is brighter is in the tree, or will be: the components are gone through one after another.
            let key = |at: usize| (!field.at(at).key(), at);
            let foreign = |near: usize| match rank_of(near) {
                Some(known) if known < rank && !is_out(parents, known) => root_of(parents, known) != host,
                Some(_) => key(near) < key(at),
                // What lies before the share is in a region of another.
                None => listed(near).is_some(),
            };
            if stands_apart((&config.deblending, photon), field, [&bright, &faint], value, foreign) {
                for (id, other) in [(host_id, faint.peak), (other_id, bright.peak)] {
                    if let Some(region) = regions.get_mut(id) {
                        region.divide(field, other);
                    }
                }
                continue;
            }
            if let Some(parent) = parents.get_mut(other as usize) {
                *parent = host;
            }
            if let Some(region) = regions.get_mut(host_id) {
                region.area += faint.area;
                region.sum = region.sum + faint.sum;
                if let Some(other) = faint.divided.checked_sub(1) {
                    region.divide(field, other);
                }
            }
            if let Some(region) = regions.get_mut(other_id) {
                region.area = 0;
            }
            if nearest == other {
                nearest = host;
            }
        }
        if let Some(parent) = parents.get_mut(rank as usize) {
            *parent = nearest;
        }
        if let Some(region) = regions.get_mut(region_at(parents, nearest)) {
            region.area += 1;
            region.sum = region.sum + value.times(1);
        }
    }
    *counted = Count { regions: count, left_out };
}

/// The most hands among which components are shared.
const MOST_HANDS: usize = 16;

/// The same of all that is listed, by a crew; `ends` has where in the list each component ends, without the last.
pub(crate) fn grow_by<L: Level>(
    crew: &impl Crew,
    counted: &mut Count,
    field: Field<'_, L>,
    all: &mut Share<'_, L>,
    components: usize,
    ranks: &[u32],
    setting: (&Config, f32),
) {
    let (listed, room, hands) = (all.order.len(), all.regions.len() as u64, crew.hands().clamp(1, MOST_HANDS));
    // From which place in the list, and from which region on, each hand works: the last one's end is that of all.
    let mut bounds = [(listed, all.regions.len()); MOST_HANDS + 1];
    let ends = all.parents.get(..components.saturating_sub(1)).unwrap_or(&[]);
    for (hand, bound) in bounds.iter_mut().enumerate().take(hands) {
        let least = listed * hand / hands;
        let end = ends.get(ends.partition_point(|&end| (end as usize) < least)).map_or(listed, |&end| end as usize);
        let first = if hand == 0 { 0 } else { end };
        *bound = (first, (room * first as u64 / listed.max(1) as u64) as usize);
    }
    let mut counts = [Count::default(); MOST_HANDS];
    crew.each(shares(all, &bounds).zip(&mut counts), |(mut share, count)| {
        let part = 0..share.order.len();
        grow(count, field, &mut share, part, ranks, setting);
    });
    if counts.iter().any(|count| count.left_out > 0) {
        // One alone has room for as many as there is.
        return grow(counted, field, all, 0..listed, ranks, setting);
    }
    for ((bound, end), count) in bounds.iter().zip(bounds.iter().skip(1)).zip(&counts) {
        gather(all, bound.0..end.0, bound.1, counted.regions, count.regions);
        counted.regions += count.regions;
    }
}

/// The shares of the hands.
fn shares<'a, L: Level>(
    all: &'a mut Share<'_, L>,
    bounds: &'a [(usize, usize); MOST_HANDS + 1],
) -> impl Iterator<Item = Share<'a, L>> + Send {
    let (mut order, mut parents, mut regions) = (all.order, &mut *all.parents, &mut *all.regions);
    bounds.iter().zip(bounds.iter().skip(1)).map_while(move |(bound, end)| {
        let (pixels, room) = (end.0.saturating_sub(bound.0), end.1.saturating_sub(bound.1));
        let (own_order, order_rest) = order.split_at_checked(pixels)?;
        let (own_parents, parents_rest) = core::mem::take(&mut parents).split_at_mut_checked(pixels)?;
        let (own_regions, regions_rest) = core::mem::take(&mut regions).split_at_mut_checked(room)?;
        (order, parents, regions) = (order_rest, parents_rest, regions_rest);
        Some(Share { first: bound.0, order: own_order, parents: own_parents, regions: own_regions })
    })
}

/// Moves the regions of a share from a place in the table to another, and lets its pixels know them there.
fn gather<L: Level>(all: &mut Share<'_, L>, share: Range<usize>, from: usize, to: usize, count: usize) {
    if share.start == 0 {
        return;
    }
    for index in 0..count {
        let region = all.regions.get(from + index).copied();
        if let (Some(region), Some(place)) = (region, all.regions.get_mut(to + index)) {
            *place = region;
        }
    }
    let (first, to) = (share.start as u32, to as u32);
    for parent in all.parents.get_mut(share).unwrap_or(&mut []).iter_mut().filter(|parent| **parent != NONE) {
        *parent = parent.wrapping_add(if *parent & ROOT != 0 { to } else { first });
    }
}

/// Those of at most eight ranks that are below one, without asking for each: half of them are.
#[inline]
fn earlier(ranks: impl Iterator<Item = u32>, rank: u32, room: &mut [u32; 8]) -> &[u32] {
    let mut count = 0;
    for near in ranks {
        if let Some(free) = room.get_mut(count) {
            *free = near;
        }
        count += usize::from(near < rank);
    }
    room.get(..count).unwrap_or(&[])
}

/// Whether a pixel that was met is in no region.
#[inline]
fn is_out(parents: &[u32], rank: u32) -> bool {
    parents.get(rank as usize).is_none_or(|&parent| parent == NONE)
}

/// Whether the fainter of two regions that meet at `saddle` is a source of its own: enough
/// pixels and light above the saddle for the noise there, a peak that rises above it by more than
/// the noise and the unevenness of optics, and in most pixels around its peak more than twice the
/// light of the brighter: what lies across that's centre or, where this is of a third region, what there is
/// around it at that distance.
fn stands_apart<L: Level>(
    (setting, photon): (&Deblending, f32),
    field: Field<'_, L>,
    [bright, faint]: [&Region<L>; 2],
    saddle: L,
    mut foreign: impl FnMut(usize) -> bool,
) -> bool {
    let light = faint.sum - saddle.times(faint.area);
    let noise = grown(photon, saddle);
    let significant = faint.area >= 3
        && light > L::share(noise.times(1), setting.branch)
        && light > L::share(bright.sum, setting.contrast)
        && faint.value - saddle > noise.greatest(saddle.scaled(L::Weight::of(DEPTH)));
    if !significant {
        return false;
    }
    let centre = field.centre(bright.peak as usize);
    let peak = faint.peak as usize;
    let mut own = |&at: &usize| {
        let across = field.across(centre, at);
        let mirrored = field.between(across).unwrap_or(L::ZERO);
        let third = field.nearest(across).is_some_and(&mut foreign);
        let light = if third { mirrored.least(field.around(centre, field.place(at))) } else { mirrored };
        field.at(at) > light + light
    };
    field.grid.neighbours(peak).chain([peak]).filter(&mut own).count() >= MOST
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::grid::Grid;

    #[test]
    fn a_region_begins_as_one_pixel() {
        let Region { peak, value, area, .. } = Region::<f32>::of(3, 2.0);
        assert_eq!((peak, value, area), (3, 2.0, 1));
    }

    #[test]
    fn a_region_is_divided_from_what_became_a_source() {
        let region = Region::<f32> { label: 2, divided: 4, ..Region::BLANK };
        assert_eq!(region.divided_from(&[2, 2, 0, 1]), Some(1));
        assert_eq!(region.divided_from(&[2, 2, 1, 0]), None, "the other was dropped");
        assert_eq!(region.divided_from(&[1, 0, 0, 2]), None, "it took the other's place");
        assert_eq!(Region { divided: 0, ..region }.divided_from(&[1; 4]), None);
        assert_eq!(Region { label: 0, ..region }.divided_from(&[1; 4]), None);
    }

    /// A brighter source with `own` of the nine pixels around a fainter one's peak of this value nearly dark opposite to
    /// them.
    fn is_apart(own: usize, value: f32) -> bool {
        const WIDTH: usize = 21;
        let mut light = [0.0f32; 5 * WIDTH];
        let [bright, faint] = [2 * WIDTH + 8, 2 * WIDTH + 12];
        let nine = [1, 2, 3].into_iter().flat_map(|y| [11, 12, 13].map(|x| (x, y)));
        for (n, (x, y)) in nine.enumerate() {
            light[y * WIDTH + x] = 30.0;
            light[(4 - y) * WIDTH + 16 - x] = if n < own { 10.0 } else { 30.0 };
        }
        (light[bright], light[faint]) = (100.0, 50.0);
        let field = Field { values: &light, grid: Grid::of(light.len(), WIDTH).expect("there are columns") };
        let region = |peak: usize, value, area| Region { area, sum: 290.0, ..Region::of(peak as u32, value) };
        let (bright, faint) = (region(bright, 100.0, 1), region(faint, value, 9));
        stands_apart((&Config::NOISE_AWARE.deblending, 0.0), field, [&bright, &faint], 5.0, |_| false)
    }

    #[test]
    fn most_of_nine_pixels_are_five() {
        assert_eq!([0, 4, 5, 9].map(|own| is_apart(own, 50.0)), [false, false, true, true]);
    }

    /// The saddle is 5.0, and the noise there 1.0.
    #[test]
    fn a_peak_rises_above_its_saddle_by_more_than_the_noise() {
        assert_eq!([6.0, 6.001].map(|value| is_apart(9, value)), [false, true]);
    }
}
