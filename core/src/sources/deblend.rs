//! Whose light is it: pixels that a source's mirror image does not explain become sources, and
//! at a border each pixel goes to the source that has the most light there.

use crate::arithmetic::{Level, Real};
use crate::config::Connectivity;
use crate::plane::field::{Field, opposite};
use crate::plane::grid::Grid;
use crate::plane::rows::{last_with, next_with};
use crate::sky::photon::grown;
use crate::sources::tree::{Count, Noise, Region};
use crate::sources::typical::Typical;

/// A pixel under examination.
const OPEN: u32 = 1 << 31;

/// Light of the pixel beyond what its source, mirrored, has there.
fn excess<L: Level>(field: Field<'_, L>, centre: (L, L), at: usize) -> L {
    field.at(at) - field.mirrored(centre, at).unwrap_or(L::ZERO)
}

fn label_at(labels: &[u32], at: usize) -> u32 {
    labels.get(at).copied().unwrap_or(0)
}

fn region_of<L: Level>(regions: &[Region<L>], label: u32) -> Option<&Region<L>> {
    regions.get((label as usize).wrapping_sub(1))
}

fn centre_of<L: Level>(regions: &[Region<L>], label: u32) -> (L, L) {
    region_of(regions, label).map_or((L::ZERO, L::ZERO), |region| region.centre)
}

fn light_of<L: Level>(regions: &[Region<L>], label: u32) -> L::Sum {
    region_of(regions, label).map_or(L::NOTHING, |region| region.sum)
}

/// A pixel belongs to another source where it has more than this many times its host's mirrored light.
const OTHER: f32 = 2.0;
/// The same for a pixel that begins a new source.
const NEW: f32 = 2.5;

/// More of the light across a centre than this part is another source's: the mirror says nothing.
const FOREIGN: f32 = 0.25;

/// What `other` alone has at a place: the light on its other side, less what the host, symmetric
/// too, has there, as far as the frame shows it: no more than around the host at that distance, for
/// across it may lie a third source. `None` where the other side is beyond the frame.
fn alone<L: Level>(field: Field<'_, L>, [host, other]: [(L, L); 2], place: (L, L)) -> Option<L> {
    let across = opposite(other, place);
    let light = field.between(across)?;
    let mirrored = field.between(opposite(host, across)).unwrap_or(L::ZERO);
    Some((light - mirrored.least(field.around(host, across))).positive())
}

/// The mirrored light of a source; `None` beyond the frame, and where too much of it is another's.
fn own_light<L: Level>(field: Field<'_, L>, labels: &[u32], regions: &[Region<L>], label: u32, at: usize) -> Option<L> {
    let centre = centre_of(regions, label);
    let across = field.across(centre, at);
    let light = field.between(across)?;
    let other = field.nearest(across).map_or(0, |at| label_at(labels, at));
    if other == 0 || other == label {
        return Some(light);
    }
    let foreign = alone(field, [centre, centre_of(regions, other)], across).unwrap_or(L::ZERO);
    (foreign <= light.scaled(L::Weight::of(FOREIGN))).then_some(light)
}

/// What pixels beyond their host's light must have to become a source of their own.
#[derive(Clone, Copy, Debug)]
pub struct Reopening<'a, L: Level> {
    /// The plane that is divided.
    pub field: Field<'a, L>,
    /// The frame's typical source.
    pub typical: Typical<'a>,
    /// The noise of the plane.
    pub noise: Noise<L>,
    /// Their light beyond that of the host, in that noise.
    pub excess: f32,
    /// How many they must be, also when a second source's light is taken away.
    pub least_area: u32,
    /// Which of them touch.
    pub connectivity: Connectivity,
}

/// Opens the pixels that neither their host's mirrored light nor that of the frame's typical source
/// explains, but none of a source that ends in a plateau, and makes each connected
/// group of them a region that is large enough, also when a second source's light is taken away:
/// where two large galaxies meet there is the light of both. `queue` is as long as the plane;
/// regions are added to those that `count` knows.
pub fn reopen<L: Level>(
    reopening: &Reopening<'_, L>,
    labels: &mut [u32],
    queue: &mut [u32],
    regions: &mut [Region<L>],
    count: Count,
) -> Count {
    let &Reopening { field, typical, noise, excess, least_area, connectivity } = reopening;
    let Count { regions: mut count, mut left_out } = count;
    let (new, least) = (L::Weight::of(NEW), L::of(excess * noise.least.to_f32()));
    let significant = |at: usize, host: L| field.at(at) - host > least * grown(noise.photon, field.at(at));
    let mut next = 0;
    while let Some(at) = next_with(labels, next, u32::MAX) {
        next = at + 1;
        let label = label_at(labels, at);
        let Some(region) = region_of(regions, label).filter(|region| region.plateau <= 0.0) else { continue };
        // Hosts have no light below 0.
        if field.at(at) > least
            && let Some(mirrored) = field.mirrored(region.centre, at)
            && field.at(at) > mirrored.scaled(new)
            && let host = mirrored.greatest(typical.light(region.value, region.centre, field.place(at)))
            && field.at(at) > host.scaled(new)
            && significant(at, host)
            && let Some(cell) = labels.get_mut(at)
        {
            *cell |= OPEN;
        }
    }
    let mut next = 0;
    while let Some(first) = next_with(labels, next, OPEN) {
        next = first + 1;
        let host = label_at(labels, first) & !OPEN;
        let (known, beside) =
            gather((field.grid, connectivity), first, (labels, queue), |label| light_of(regions, label));
        let group = queue.get(..known).unwrap_or(&[]);
        let unexplained = {
            let explained = explained((field, typical), labels, regions, [host, beside]);
            group.iter().filter(|&&at| significant(at as usize, explained(at as usize))).count()
        };
        if (unexplained as u32) < least_area {
            continue;
        }
        if count >= regions.len() {
            left_out += 1;
            continue;
        }
        add(field, group, host, regions, count);
        count += 1;
        for &at in group {
            if let Some(label) = labels.get_mut(at as usize) {
                *label = count as u32;
            }
        }
    }
    Count { regions: count, left_out }
}

/// Gives a connected group of open pixels back to its host and lists it in the queue. Gives its
/// length, and of the other sources beside it the one with the most light; 0 for none.
fn gather<S: PartialOrd>(
    (grid, connectivity): (Grid, Connectivity),
    first: usize,
    (labels, queue): (&mut [u32], &mut [u32]),
    light: impl Fn(u32) -> S,
) -> (usize, u32) {
    let open = label_at(labels, first);
    let host = open & !OPEN;
    let (mut known, mut next, mut beside) = (0, 0, 0);
    let mut take = |at: usize, labels: &mut [u32], queue: &mut [u32]| {
        if let (Some(label), Some(place)) = (labels.get_mut(at), queue.get_mut(known)) {
            (*label, *place) = (host, at as u32);
            known += 1;
        }
        known
    };
    let mut end = take(first, labels, queue);
    while next < end {
        let at = queue.get(next).map_or(0, |&at| at as usize);
        next += 1;
        for near in grid.touching(at, connectivity.neighbours()) {
            let label = label_at(labels, near);
            if label == open {
                end = take(near, labels, queue);
            } else if label & !OPEN != host && light(label & !OPEN) > light(beside) {
                beside = label & !OPEN;
            }
        }
    }
    (end, beside)
}

/// The light that a host and a second source have at a pixel: the source beside it or, with none
/// there (0), the brightest that was divided from the host, where the mirror shows that and no other.
fn explained<L: Level>(
    (field, typical): (Field<'_, L>, Typical<'_>),
    labels: &[u32],
    regions: &[Region<L>],
    [host, beside]: [u32; 2],
) -> impl Fn(usize) -> L {
    let divided = region_of(regions, host).map_or(0, |host| host.divided as usize);
    let divided = label_at(labels, divided.wrapping_sub(1)) & !OPEN;
    let other = if beside != 0 { beside } else { divided };
    let [centre, there] = [host, other].map(|label| centre_of(regions, label));
    let peak = region_of(regions, host).map_or(L::ZERO, |host| host.value);
    move |at| {
        let mirrored = field.mirrored(centre, at).unwrap_or(L::ZERO);
        let mirrored = mirrored.greatest(typical.light(peak, centre, field.place(at)));
        let shown = || field.nearest(field.across(there, at)).map_or(0, |at| label_at(labels, at) & !OPEN);
        if other == 0 || other == host || (beside == 0 && shown() != other) {
            return mirrored;
        }
        mirrored + alone(field, [centre, there], field.place(at)).unwrap_or(L::ZERO)
    }
}

/// Makes a group of pixels the region with index `count`, divided from its host.
fn add<L: Level>(field: Field<'_, L>, group: &[u32], host: u32, regions: &mut [Region<L>], count: usize) {
    let centre = centre_of(regions, host);
    let (mut value, mut peak, mut sum) = (L::ZERO, group.first().copied().unwrap_or(0), L::NOTHING);
    for &at in group {
        let light = excess(field, centre, at as usize);
        sum = sum + light.times(1);
        if light > value {
            (value, peak) = (light, at);
        }
    }
    let mut divided = 0;
    if let Some(host) = regions.get_mut((host as usize).wrapping_sub(1)) {
        divided = host.peak.saturating_add(1);
        host.divide(field, peak);
    }
    if let Some(region) = regions.get_mut(count) {
        let centre = field.place(peak as usize);
        *region = Region { peak, value, sum, centre, divided, ..Region::BLANK };
    }
}

/// Lets sources compete for the pixels at their borders, forwards and backwards `sweeps` times:
/// of two neighbours the one with less light in all owns a pixel where the value is more than
/// `OTHER` times the other's mirrored light. Where that is a third source's, the pixel stays.
pub fn compete<L: Level>(field: Field<'_, L>, labels: &mut [u32], regions: &[Region<L>], sweeps: u32) {
    let other_from = L::Weight::of(OTHER);
    for sweep in 0..sweeps {
        let (mut changed, mut next) = (false, 0);
        let forwards = sweep % 2 == 0;
        while let Some(index) =
            if forwards { next_with(labels, next, u32::MAX) } else { last_with(labels, labels.len() - next, u32::MAX) }
        {
            let at = index;
            next = if forwards { at + 1 } else { labels.len() - at };
            let own = label_at(labels, at);
            if is_alone(labels, field.grid, at) {
                continue;
            }
            let mut best = own;
            for near in field.grid.touching(at, 4) {
                let other = label_at(labels, near);
                if other == 0 || other == best || near.abs_diff(at) > field.grid.width.get() {
                    continue;
                }
                let brighter = light_of(regions, best) >= light_of(regions, other);
                let (bright, faint) = if brighter { (best, other) } else { (other, best) };
                if let Some(host) = own_light(field, labels, regions, bright, at) {
                    best = if field.at(at) > host.scaled(other_from) { faint } else { bright };
                }
            }
            if best != own
                && let Some(label) = labels.get_mut(at)
            {
                *label = best;
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
}

/// Whether a pixel within the frame touches no other source along an edge.
fn is_alone(labels: &[u32], Grid { width, height }: Grid, at: usize) -> bool {
    let (width, x, y, own) = (width.get(), at % width, at / width, label_at(labels, at));
    let inner = x > 0 && x + 1 < width && y > 0 && y + 1 < height;
    let is_other = |at: usize| ![0, own].contains(&label_at(labels, at));
    inner && ![at - 1, at + 1, at - width, at + width].into_iter().any(is_other)
}

/// Moves outlines by their curvature: a pixel takes the label that at least six of the nine
/// pixels around it have. `old` has room for two rows; in less than three rows no pixel has six neighbours of another.
pub fn straighten(labels: &mut [u32], old: &mut [u32], grid: Grid, steps: u32) {
    let width = grid.width.get();
    let Some((mut below, rest)) = old.split_at_mut_checked(width) else { return };
    let Some(mut own) = rest.get_mut(..width) else { return };
    for _ in 0..steps {
        let mut rest = &mut *labels;
        for y in 0..grid.height {
            let Some((row, above)) = rest.split_at_mut_checked(width) else { break };
            own.iter_mut().zip(row.iter()).for_each(|(own, label)| *own = *label);
            if let (true, Some(above)) = (y > 0, above.get(..width)) {
                straighten_row(row, [below, own, above]);
            }
            (below, own, rest) = (own, below, above);
        }
    }
}

/// Pixels of a row that are looked at together.
const PIECE: usize = 16;

/// Straightens a row between its neighbours, all as they were before.
fn straighten_row(labels: &mut [u32], rows: [&[u32]; 3]) {
    for (first, labels) in (0..).step_by(PIECE).zip(labels.chunks_mut(PIECE)) {
        if is_one(rows, first, labels.len()) {
            continue;
        }
        for (x, label) in (first..).zip(labels) {
            let near = |row: &[u32]| row.get(x.checked_sub(1)?..)?.first_chunk::<3>().copied();
            if let [Some(below), Some(own), Some(above)] = rows.map(near)
                && let Some(other) = straighter([below, own, above])
            {
                *label = other;
            }
        }
    }
}

/// Whether a piece of the middle row and all around it has one label: most of an image has none.
fn is_one(rows: [&[u32]; 3], first: usize, length: usize) -> bool {
    let [_, own, _] = rows;
    let label = label_at(own, first);
    let (start, end) = (first.saturating_sub(1), own.len().min(first + length + 1));
    let all = |piece: &[u32]| piece.iter().fold(true, |all, &near| all & (near == label));
    rows.iter().filter_map(|row| row.get(start..end)).all(all)
}

/// The label that the pixel in the middle takes, if it is not its own.
fn straighter([below, own, above]: [[u32; 3]; 3]) -> Option<u32> {
    let ([below_left, down, below_right], [left, label, right], [above_left, up, above_right]) = (below, own, above);
    // Most pixels lie inside: three neighbours of their own are enough to stay.
    if [left, right, down] == [label; 3] {
        return None;
    }
    let (mut same, mut other, mut others) = (0, label, 0);
    for near in [left, right, down, up, below_left, below_right, above_left, above_right] {
        if near == label {
            same += 1;
        } else if near == other || others == 0 {
            (other, others) = (near, others + 1);
        }
    }
    (others >= 6 && same < 3).then_some(other)
}
