//! Whose light is it: pixels that a source's mirror image does not explain become sources, and
//! at a border each pixel goes to the source that has the most light there.

use crate::arithmetic::{Level, Real};
use crate::detection::{Detection, grown};
use crate::grid::Grid;
use crate::tree::{Field, Region};

/// A pixel under examination.
const OPEN: u32 = 1 << 31;

/// Light of the pixel beyond what its source, mirrored, has there.
fn excess<L: Level>(field: Field<'_, L>, centre: (L, L), at: usize) -> L {
    field.at(at) - field.mirrored(centre, at).unwrap_or(L::ZERO)
}

fn label_at(labels: &[u32], at: usize) -> u32 {
    labels.get(at).copied().unwrap_or(0)
}

fn centre_of<L: Level>(regions: &[Region<L>], label: u32) -> (L, L) {
    regions.get((label as usize).wrapping_sub(1)).map_or((L::ZERO, L::ZERO), |region| region.centre)
}

/// A pixel belongs to another source where it has more than this many times its host's mirrored light.
const OTHER: f32 = 2.0;
/// The same for a pixel that begins a new source.
const NEW: f32 = 2.5;

/// Opens the pixels that their host's mirrored light does not explain, and makes each connected
/// group of them that is large enough a region. `noise` is that of a pixel without light, `photon`
/// how it grows; `queue` is as long as the plane. Gives the new number of
/// regions, and how many found no room in the table.
pub fn reopen<L: Level>(
    field: Field<'_, L>,
    (noise, photon): (L, f32),
    labels: &mut [u32],
    queue: &mut [u32],
    regions: &mut [Region<L>],
    mut count: usize,
    setting: &Detection,
) -> (usize, u32) {
    let mut left_out = 0;
    let (new, least) = (L::Weight::of(NEW), L::of(setting.excess * noise.to_f32()));
    for at in 0..labels.len() {
        let label = label_at(labels, at);
        if label == 0 {
            continue;
        }
        if let Some(host) = field.mirrored(centre_of(regions, label), at)
            && field.at(at) > host.scaled(new)
            && field.at(at) - host > least * grown(photon, field.at(at))
            && let Some(cell) = labels.get_mut(at)
        {
            *cell |= OPEN;
        }
    }
    for first in 0..labels.len() {
        let open = label_at(labels, first);
        if open & OPEN == 0 {
            continue;
        }
        let host = open & !OPEN;
        let centre = centre_of(regions, host);
        let (mut members, mut next) = (0, 0);
        let mut take = |at: usize, labels: &mut [u32], queue: &mut [u32]| {
            if let (Some(label), Some(place)) = (labels.get_mut(at), queue.get_mut(members)) {
                (*label, *place) = (host, at as u32);
                members += 1;
            }
            members
        };
        let mut known = take(first, labels, queue);
        while next < known {
            let at = queue.get(next).map_or(0, |&at| at as usize);
            next += 1;
            for near in field.grid.neighbours(at) {
                if label_at(labels, near) == open {
                    known = take(near, labels, queue);
                }
            }
        }
        let group = queue.get(..known).unwrap_or(&[]);
        if (group.len() as u32) < setting.reopened_area {
            continue;
        }
        let of_host = regions.get((host as usize).wrapping_sub(1)).map_or(0, |host| host.peak.saturating_add(1));
        let Some(region) = regions.get_mut(count) else {
            left_out += 1;
            continue;
        };
        let (mut value, mut peak, mut sum) = (excess(field, centre, first), first as u32, L::NOTHING);
        for &at in group {
            let light = excess(field, centre, at as usize);
            sum = sum + light.times(1);
            if light > value {
                (value, peak) = (light, at);
            }
        }
        let (x, y) = field.grid.place(peak as usize);
        let centre = (L::whole(x), L::whole(y));
        *region = Region { peak, value, sum, centre, divided: of_host, ..Region::BLANK };
        if let Some(inside) = regions.get_mut((host as usize).wrapping_sub(1)) {
            inside.divide(field, peak);
        }
        count += 1;
        for &at in group {
            if let Some(label) = labels.get_mut(at as usize) {
                *label = count as u32;
            }
        }
    }
    (count, left_out)
}

/// Lets sources compete for the pixels at their borders, forwards and backwards `sweeps` times:
/// of two neighbours the one with less light in all owns a pixel where the value is more than
/// `OTHER` times the other's mirrored light.
pub fn compete<L: Level>(field: Field<'_, L>, labels: &mut [u32], regions: &[Region<L>], sweeps: u32) {
    let other_from = L::Weight::of(OTHER);
    for sweep in 0..sweeps {
        let mut changed = false;
        for index in 0..labels.len() {
            let at = if sweep % 2 == 0 { index } else { labels.len() - 1 - index };
            let own = label_at(labels, at);
            if own == 0 {
                continue;
            }
            let mut best = own;
            for near in field.grid.neighbours(at).take(4) {
                let other = label_at(labels, near);
                if other == 0 || other == best || near.abs_diff(at) > field.grid.width.get() {
                    continue;
                }
                let light = |label: u32| regions.get(label as usize - 1).map_or(L::NOTHING, |region| region.sum);
                let (bright, faint) = if light(best) >= light(other) { (best, other) } else { (other, best) };
                if let Some(host) = field.mirrored(centre_of(regions, bright), at) {
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

/// Moves outlines by their curvature: a pixel takes the label that at least six of the nine
/// pixels around it have. `before` is as long as the plane.
pub fn straighten(labels: &mut [u32], before: &mut [u32], grid: Grid, steps: u32) {
    for _ in 0..steps {
        before.iter_mut().zip(labels.iter()).for_each(|(before, label)| *before = *label);
        for (at, label) in labels.iter_mut().enumerate() {
            // Most pixels lie inside: three neighbours of their own are enough to stay.
            let inside = [at.wrapping_sub(1), at + 1, at.wrapping_sub(grid.width.get())];
            if inside.into_iter().all(|near| before.get(near) == Some(label)) {
                continue;
            }
            let (mut same, mut other, mut others) = (0, *label, 0);
            for near in grid.neighbours(at) {
                let near = label_at(before, near);
                if near == *label {
                    same += 1;
                } else if near == other || others == 0 {
                    (other, others) = (near, others + 1);
                }
            }
            if others >= 6 && same < 3 {
                *label = other;
            }
        }
    }
}
