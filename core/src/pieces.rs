//! Every label one connected piece.
//!
//! Pixels change their owner one by one where sources compete, and may leave a part of a source cut off
//! from the rest. The largest piece of a source stays; the others go to the sources that they lie on.

use crate::arithmetic::Level;
use crate::grid::Grid;
use crate::tree::Region;

/// A pixel of a piece that is not, or not yet, the largest of its source.
const LOOSE: u32 = 1 << 31;
/// How often loose pieces ask their neighbours: one may lie within others.
const ROUNDS: u32 = 4;

fn label_at(labels: &[u32], at: usize) -> u32 {
    labels.get(at).copied().unwrap_or(0)
}

/// Leaves of every source the largest of its pieces (connected also by corners; the first of equals)
/// and gives the others to the source that they share most edges with; what shares none with any is
/// given up. `queue` is as long as the plane; `area` and `peak` of the regions become pixels and first
/// pixel of the largest piece. Cost: four looks at each pixel and its neighbours.
pub fn connect<L: Level>(grid: Grid, labels: &mut [u32], queue: &mut [u32], regions: &mut [Region<L>]) {
    for region in regions.iter_mut() {
        region.area = 0;
    }
    for first in 0..labels.len() {
        let label = label_at(labels, first);
        if let Some(region) = regions.get_mut((label as usize).wrapping_sub(1)) {
            let area = relabel(grid, first, label | LOOSE, labels, queue);
            if area > region.area as usize {
                (region.area, region.peak) = (area as u32, first as u32);
            }
        }
    }
    for (label, region) in (1..).zip(regions.iter()).filter(|(_, region)| region.area > 0) {
        relabel(grid, region.peak as usize, label, labels, queue);
    }
    for region in regions.iter_mut() {
        region.area = 0;
    }
    for round in 1..=ROUNDS {
        for first in 0..labels.len() {
            let loose = label_at(labels, first);
            if loose & LOOSE != 0 {
                let count = relabel(grid, first, 0, labels, queue);
                let piece = queue.get(..count).unwrap_or(&[]);
                let owner = owner(grid, piece, labels, regions);
                let label = if owner == 0 && round < ROUNDS { loose } else { owner };
                for &at in piece {
                    set(labels, at as usize, label);
                }
            }
        }
    }
}

/// Gives the connected pixels that have the label of the first one another, not 0 instead of 0; lists them in
/// the queue and gives their number.
fn relabel(grid: Grid, first: usize, to: u32, labels: &mut [u32], queue: &mut [u32]) -> usize {
    let from = label_at(labels, first);
    let (mut next, mut end) = (0, 0);
    let mut take = |at: usize, labels: &mut [u32], queue: &mut [u32]| {
        if let Some(place) = queue.get_mut(end).filter(|_| label_at(labels, at) == from) {
            *place = at as u32;
            set(labels, at, to);
            end += 1;
        }
        end
    };
    let mut known = take(first, labels, queue);
    while next < known {
        let at = queue.get(next).map_or(0, |&at| at as usize);
        next += 1;
        for near in grid.neighbours(at) {
            known = take(near, labels, queue);
        }
    }
    known
}

/// The settled source that shares most edges with a piece, of equals the one that is met first; 0 for none.
/// `area` of the regions counts the edges, from 0 and back to it.
fn owner<L: Level>(grid: Grid, piece: &[u32], labels: &[u32], regions: &mut [Region<L>]) -> u32 {
    let across = |at: &u32| grid.neighbours(*at as usize).take(4).map(|near| label_at(labels, near));
    let index = |label: u32| (label as usize).wrapping_sub(1);
    for label in piece.iter().flat_map(across) {
        if let Some(region) = regions.get_mut(index(label)) {
            region.area = region.area.saturating_add(1);
        }
    }
    let (mut owner, mut most) = (0, 0);
    for label in piece.iter().flat_map(across) {
        if let Some(region) = regions.get_mut(index(label)) {
            if region.area > most {
                (owner, most) = (label, region.area);
            }
            region.area = 0;
        }
    }
    owner
}

fn set(labels: &mut [u32], at: usize, label: u32) {
    if let Some(cell) = labels.get_mut(at) {
        *cell = label;
    }
}
