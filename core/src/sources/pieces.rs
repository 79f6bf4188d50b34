//! Every label one connected piece.
//!
//! Pixels change their owner one by one where sources compete, and may leave a part of a source cut off
//! from the rest. The piece with its peak stays, or a much larger one; the others go to the sources that they lie on.

use crate::arithmetic::Level;
use crate::config::Connectivity;
use crate::plane::grid::Grid;
use crate::plane::rows::{next_with, used};
use crate::sources::tree::Region;
use core::ops::Range;

/// A pixel of a piece that is not, or not yet, the one that stays.
const LOOSE: u32 = 1 << 31;
/// The piece with the peak stays, unless another is this many times as large.
const PEAK: u32 = 4;
/// The area of a source that is one piece already.
const WHOLE: u32 = u32::MAX;
/// How often loose pieces ask their neighbours: one may lie within others.
const ROUNDS: u32 = 4;

#[inline]
fn label_at(labels: &[u32], at: usize) -> u32 {
    labels.get(at).copied().unwrap_or(0)
}

/// Leaves of every source one piece, connected also by corners: that with its peak, if the source still
/// has it, unless another is [`PEAK`] times as large; else the largest, the first of equals. Gives the
/// others to the source that they touch most, pixel by pixel; what touches none is given up. `queue` is
/// as long as the plane; `area` and `peak` of the regions do not outlast it. Cost: four looks at each
/// pixel and its neighbours.
pub fn connect<L: Level>(grid: Grid, labels: &mut [u32], queue: &mut [u32], regions: &mut [Region<L>]) {
    for region in regions.iter_mut() {
        region.area = 0;
    }
    for (_, label) in used(labels) {
        if let Some(region) = regions.get_mut((label as usize).wrapping_sub(1)) {
            region.area += 1;
        }
    }
    for (label, region) in (1..).zip(regions.iter_mut()) {
        let (peak, pixels) = (region.peak as usize, region.area);
        region.area = 0;
        if label_at(labels, peak) == label {
            let area = flood(grid, peak, label | LOOSE, labels, queue) as u32;
            region.area = area.saturating_mul(PEAK);
            if area == pixels {
                // It is one piece.
                region.area = WHOLE;
                flood(grid, peak, label, labels, queue);
            }
        }
    }
    let mut next = 0;
    while let Some(first) = next_with(labels, next, u32::MAX) {
        next = first + 1;
        let label = label_at(labels, first);
        if let Some(region) = regions.get_mut((label as usize).wrapping_sub(1)).filter(|region| region.area != WHOLE) {
            let area = flood(grid, first, label | LOOSE, labels, queue) as u32;
            if area > region.area {
                (region.area, region.peak) = (area, first as u32);
            }
        }
    }
    for (label, region) in (1..).zip(regions.iter()).filter(|(_, region)| region.area > 0 && region.area != WHOLE) {
        flood(grid, region.peak as usize, label, labels, queue);
    }
    for region in regions.iter_mut() {
        region.area = 0;
    }
    for round in 1..=ROUNDS {
        let mut next = 0;
        while let Some(first) = next_with(labels, next, LOOSE) {
            next = first + 1;
            let loose = label_at(labels, first);
            let count = relabel((grid, Connectivity::Eight), first, 0, labels, queue);
            let piece = queue.get(..count).unwrap_or(&[]);
            let owner = owner(grid, piece, labels, regions);
            let label = if owner == 0 && round < ROUNDS { loose } else { owner };
            for &at in piece {
                set(labels, at as usize, label);
            }
        }
    }
}

/// Gives the pixels that have the label of the first one, and are connected with it also by corners, another label that
/// none beside them has, and gives their number: as [`relabel`], but run by run in their rows.
fn flood(grid: Grid, first: usize, to: u32, labels: &mut [u32], queue: &mut [u32]) -> usize {
    let (from, width) = (label_at(labels, first), grid.width.get());
    let (mut next, mut known, mut count) = (0, 0, 0);
    // Takes the run around a pixel, queues it and gives its end.
    let mut take = |at: usize, labels: &mut [u32], queue: &mut [u32]| {
        let start = at - at % grid.width;
        let is_other = |label: &u32| *label != from;
        let before =
            labels.get(start..at).and_then(|row| row.iter().rposition(is_other)).map_or(start, |x| start + x + 1);
        let behind = labels.get(at..start + width).and_then(|row| row.iter().position(is_other));
        let end = behind.map_or(start + width, |x| at + x);
        if let (Some(run), Some(place)) = (labels.get_mut(before..end), queue.get_mut(known)) {
            run.fill(to);
            *place = before as u32;
            (known, count) = (known + 1, count + run.len());
        }
        (known, count, end)
    };
    let (mut end, mut area, _) = take(first, labels, queue);
    while next < end {
        let at = queue.get(next).map_or(0, |&at| at as usize);
        next += 1;
        let row = labels.get(at..at - at % grid.width + width).unwrap_or(&[]);
        let length = row.iter().position(|label| *label != to).unwrap_or(row.len());
        let (x, y) = grid.place(at);
        let (left, right) = (at - usize::from(x > 0), at + length + usize::from(x + length < width));
        let rows =
            [(y > 0).then(|| left - width..right - width), (y + 1 < grid.height).then(|| left + width..right + width)];
        for Range { start, end: last } in rows.into_iter().flatten() {
            let mut near = start;
            while near < last {
                let mut behind = near + 1;
                if label_at(labels, near) == from {
                    (end, area, behind) = take(near, labels, queue);
                }
                near = behind;
            }
        }
    }
    area
}

/// Gives the connected pixels that have the label of the first one another, not 0 instead of 0; lists them in
/// the queue and gives their number.
pub fn relabel(
    (grid, connectivity): (Grid, Connectivity),
    first: usize,
    to: u32,
    labels: &mut [u32],
    queue: &mut [u32],
) -> usize {
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
        for near in grid.touching(at, connectivity.neighbours()) {
            known = take(near, labels, queue);
        }
    }
    known
}

/// The settled source that a piece touches most, of equals the one that is met first; 0 for none.
/// `area` of the regions counts the pairs of pixels, from 0 and back to it.
fn owner<L: Level>(grid: Grid, piece: &[u32], labels: &[u32], regions: &mut [Region<L>]) -> u32 {
    let across = |at: &u32| grid.neighbours(*at as usize).map(|near| label_at(labels, near));
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

#[inline]
fn set(labels: &mut [u32], at: usize, label: u32) {
    if let Some(cell) = labels.get_mut(at) {
        *cell = label;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 8;

    /// A picture of labels, one digit per pixel, connected, as a picture; with the peak of source 1.
    fn connected<const CELLS: usize>(picture: [&str; CELLS], peak: u32) -> [[u8; WIDTH]; CELLS] {
        let mut labels = [0; 64];
        let mut regions = [Region::<f32> { peak: 63, ..Region::BLANK }; 9];
        regions[0].peak = peak;
        let digits = picture.iter().flat_map(|row| row.bytes()).map(|digit| u32::from(digit - b'0'));
        labels.iter_mut().zip(digits).for_each(|(label, digit)| *label = digit);
        let grid = Grid::of(CELLS * WIDTH, WIDTH).expect("there are columns");
        connect(grid, &mut labels[..CELLS * WIDTH], &mut [0; 64], &mut regions);
        core::array::from_fn(|y| core::array::from_fn(|x| b'0' + labels[y * WIDTH + x] as u8))
    }

    #[track_caller]
    fn becomes<const CELLS: usize>(from: [&str; CELLS], peak: u32, to: [&str; CELLS]) {
        let found = connected(from, peak);
        let found = found.each_ref().map(|row| core::str::from_utf8(row).expect("digits"));
        assert_eq!(found, to);
    }

    #[test]
    fn the_largest_piece_stays_and_the_rest_goes_to_what_it_lies_on() {
        let picture = ["11222001", "11222000", "11122110", "11122330"];
        becomes(picture, 63, ["11222000", "11222000", "11122330", "11122330"]);
    }

    #[test]
    fn the_piece_with_the_peak_stays_unless_another_is_much_larger() {
        let picture = ["11222001", "11222011", "11122110", "11122330"];
        becomes(picture, 22, ["22222001", "22222011", "22222110", "22222330"]);
        let picture = ["11222000", "11222000", "11122010", "11122010"];
        becomes(picture, 22, ["11222000", "11222000", "11122000", "11122000"]);
    }

    #[test]
    fn a_flood_reaches_what_is_connected() {
        let (mut state, width) = (1u32, 23);
        let grid = Grid::of(31 * width, width).expect("there are columns");
        for percent in [10, 35, 45, 60, 90, 100] {
            let mut draw = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if (state >> 8) % 100 < percent { 1 } else { 2 }
            };
            let mut flooded: [u32; 31 * 23] = core::array::from_fn(|_| draw());
            let (mut expected, mut queue) = (flooded, [0; 31 * 23]);
            for first in [0, 17, 350, 712] {
                let from = label_at(&flooded, first);
                if from & LOOSE == 0 {
                    let count = relabel((grid, Connectivity::Eight), first, from | LOOSE, &mut expected, &mut queue);
                    assert_eq!(flood(grid, first, from | LOOSE, &mut flooded, &mut queue), count, "{percent} %");
                }
                assert_eq!(flooded, expected, "{percent} %, from {first}");
            }
        }
    }

    #[test]
    fn corners_connect() {
        let picture = ["10000000", "01020000", "00100000"];
        becomes(picture, 63, picture);
    }

    #[test]
    fn of_two_equal_pieces_the_first_stays() {
        becomes(["11022011", "11022011"], 63, ["11022000", "11022000"]);
        becomes(["11222211", "11222211"], 63, ["11222222", "11222222"]);
    }

    #[test]
    fn a_piece_within_a_piece_goes_where_that_goes() {
        // The 1 on the right touches only the loose 2, which touches only the 3.
        becomes(
            ["11110000", "22220000", "22222000", "33333333", "33332223", "33332123", "33332223", "33333333"],
            63,
            ["11110000", "22220000", "22222000", "33333333", "33333333", "33333333", "33333333", "33333333"],
        );
    }
}
