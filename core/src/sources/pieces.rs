//! Every label one connected piece.
//!
//! Pixels change their owner one by one where sources compete, and may leave a part of a source cut off
//! from the rest. The piece with its peak stays, or a much larger one; the others go to the sources that they lie on.

use crate::arithmetic::Level;
use crate::arithmetic::codec::Codec;
use crate::config::Connectivity;
use crate::plane::grid::Grid;
use crate::plane::rows::used_in;
use crate::plane::walk::Walk;
use crate::sources::tree::Region;

/// A pixel of a piece that is not, or not yet, the one that stays.
const LOOSE: u32 = 1 << 31;
/// The piece with the peak stays, unless another is this many times as large.
const PEAK: u32 = 4;
/// The area of a source that is one piece already.
const WHOLE: u32 = u32::MAX;
/// How often loose pieces ask their neighbours: one may lie within others.
const ROUNDS: u32 = 4;

fn label_at(labels: &[u32], at: usize) -> u32 {
    labels.get(at).copied().unwrap_or(0)
}

/// How far the pieces are, part by part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joining {
    /// The next region or pixel.
    next: usize,
    /// What the piece at hand was before.
    label: u32,
    /// The pixels of a source.
    pixels: u32,
    /// The source that a piece touches most so far, and how often.
    owner: (u32, u32),
}

impl Joining {
    /// Before the first pass.
    pub const NOTHING: Joining = Joining { next: 0, label: 0, pixels: 0, owner: (0, 0) };

    /// The list of fields, out or in.
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        codec.size(&mut self.next)?;
        for word in [&mut self.label, &mut self.pixels, &mut self.owner.0, &mut self.owner.1] {
            codec.word(word)?;
        }
        Ok(())
    }
}

fn index(label: u32) -> usize {
    (label as usize).wrapping_sub(1)
}

/// Leaves of every source one piece, connected also by corners: that with its peak, if the source still
/// has it, unless another is [`PEAK`] times as large; else the largest, the first of equals. Gives the
/// others to the source that they touch most, pixel by pixel; what touches none is given up. `queue` is
/// as long as the plane; `area` and `peak` of the regions do not outlast it. Cost: four looks at each
/// pixel and its neighbours.
pub(crate) fn connect<L: Level>(
    walk: &mut Walk,
    joining: &mut Joining,
    grid: Grid,
    labels: &mut [u32],
    queue: &mut [u32],
    regions: &mut [Region<L>],
) -> Option<()> {
    let corners = (grid, Connectivity::Eight);
    walk.pass(regions.len(), 1, |part| reset_areas(regions.get_mut(part)))?;
    walk.pass(labels.len(), 1, |part| {
        for (_, label) in used_in(labels, part) {
            if let Some(region) = regions.get_mut(index(label)) {
                region.area += 1;
            }
        }
    })?;
    walk.once(1, || joining.next = 0)?;
    let mark = walk.mark();
    while let Some(at) = walk.each(regions.len(), &mut joining.next)? {
        let (label, peak) = (at as u32 + 1, regions.get(at).map_or(0, |region| region.peak as usize));
        walk.once(1, || {
            joining.label = label_at(labels, peak);
            joining.pixels = regions.get(at).map_or(0, |region| region.area);
            reset_areas(regions.get_mut(at..at + 1));
        })?;
        if joining.label == label {
            let area = relabel(walk, corners, (peak, [label, label | LOOSE]), labels, queue)?;
            let is_one = area as u32 == joining.pixels;
            walk.once(1, || {
                if let Some(region) = regions.get_mut(at) {
                    region.area = if is_one { WHOLE } else { (area as u32).saturating_mul(PEAK) };
                }
            })?;
            let area = if is_one { area } else { 0 };
            walk.pass(area, 1, |part| set_all(labels, queue.get(part), label))?;
        }
        joining.next = at + 1;
        walk.again(mark);
    }
    find_largest(walk, joining, grid, labels, queue, regions)?;
    walk.once(1, || joining.next = 0)?;
    let mark = walk.mark();
    while let Some(at) = walk.each(regions.len(), &mut joining.next)? {
        let (label, largest) = (at as u32 + 1, regions.get(at).filter(|region| ![0, WHOLE].contains(&region.area)));
        if let Some(region) = largest {
            relabel(walk, corners, (region.peak as usize, [label | LOOSE, label]), labels, queue)?;
        }
        joining.next = at + 1;
        walk.again(mark);
    }
    walk.pass(regions.len(), 1, |part| reset_areas(regions.get_mut(part)))?;
    for round in 1..=ROUNDS {
        give_away(walk, joining, (grid, round < ROUNDS), labels, queue, regions)?;
    }
    Some(())
}

fn reset_areas<L: Level>(regions: Option<&mut [Region<L>]>) {
    regions.unwrap_or(&mut []).iter_mut().for_each(|region| region.area = 0);
}

fn set_all(labels: &mut [u32], pixels: Option<&[u32]>, label: u32) {
    pixels.unwrap_or(&[]).iter().for_each(|&at| set(labels, at as usize, label));
}

/// Marks the pieces of sources of more than one as loose, and remembers of each source the largest.
fn find_largest<L: Level>(
    walk: &mut Walk,
    joining: &mut Joining,
    grid: Grid,
    labels: &mut [u32],
    queue: &mut [u32],
    regions: &mut [Region<L>],
) -> Option<()> {
    walk.once(1, || joining.next = 0)?;
    let mark = walk.mark();
    loop {
        let is_open = |&(_, label): &(usize, u32)| regions.get(index(label)).is_some_and(|region| region.area != WHOLE);
        let find = |range| used_in(labels, range).find(is_open).map(|(at, _)| at);
        let Some(first) = walk.seek(labels.len(), &mut joining.next, find)? else { return Some(()) };
        walk.once(1, || joining.label = label_at(labels, first))?;
        let label = joining.label;
        let area = relabel(walk, (grid, Connectivity::Eight), (first, [label, label | LOOSE]), labels, queue)? as u32;
        walk.once(1, || {
            if let Some(region) = regions.get_mut(index(label)).filter(|region| area > region.area) {
                (region.area, region.peak) = (area, first as u32);
            }
        })?;
        joining.next = first + 1;
        walk.again(mark);
    }
}

/// Gives loose pieces to the settled source that they touch most, of equals the one that is met first. What touches
/// none stays loose where it `may_wait`. `area` of the regions counts the pairs of pixels, from 0 and back to it.
fn give_away<L: Level>(
    walk: &mut Walk,
    joining: &mut Joining,
    (grid, may_wait): (Grid, bool),
    labels: &mut [u32],
    queue: &mut [u32],
    regions: &mut [Region<L>],
) -> Option<()> {
    walk.once(1, || joining.next = 0)?;
    let mark = walk.mark();
    while let Some(first) = walk.seek_bits(labels, &mut joining.next, LOOSE)? {
        walk.once(1, || (joining.label, joining.owner) = (label_at(labels, first), (0, 0)))?;
        let loose = joining.label;
        let count = relabel(walk, (grid, Connectivity::Eight), (first, [loose, 0]), labels, queue)?;
        let across = |&at: &u32| grid.neighbours(at as usize).map(|near| label_at(labels, near));
        walk.pass(count, 1, |part| {
            for label in queue.get(part).unwrap_or(&[]).iter().flat_map(across) {
                if let Some(region) = regions.get_mut(index(label)) {
                    region.area = region.area.saturating_add(1);
                }
            }
        })?;
        walk.pass(count, 1, |part| {
            for label in queue.get(part).unwrap_or(&[]).iter().flat_map(across) {
                if let Some(region) = regions.get_mut(index(label)) {
                    if region.area > joining.owner.1 {
                        joining.owner = (label, region.area);
                    }
                    region.area = 0;
                }
            }
        })?;
        let (owner, _) = joining.owner;
        let label = if owner == 0 && may_wait { loose } else { owner };
        walk.pass(count, 1, |part| set_all(labels, queue.get(part), label))?;
        joining.next = first + 1;
        walk.again(mark);
    }
    Some(())
}

/// Gives the connected pixels around the first that have a label another; lists them in the queue and gives their number.
pub(crate) fn relabel(
    walk: &mut Walk,
    (grid, connectivity): (Grid, Connectivity),
    (first, [from, to]): (usize, [u32; 2]),
    labels: &mut [u32],
    queue: &mut [u32],
) -> Option<usize> {
    walk.until(|tally, next| {
        let known = &mut tally.count;
        let mut take = |at: usize, known: &mut usize, queue: &mut [u32]| {
            if let Some(place) = queue.get_mut(*known).filter(|_| label_at(labels, at) == from) {
                *place = at as u32;
                set(labels, at, to);
                *known += 1;
            }
        };
        if next == 0 {
            *known = 0;
            take(first, known, queue);
        }
        if let Some(&at) = queue.get(next).filter(|_| next < *known) {
            let near = grid.touching(at as usize, connectivity.neighbours());
            near.for_each(|near| take(near, known, queue));
        }
        next + 1 < *known
    })?;
    Some(walk.tally.count)
}

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
        let labels_of_rows = &mut labels[..CELLS * WIDTH];
        let _ =
            connect(&mut Walk::whole(), &mut { Joining::NOTHING }, grid, labels_of_rows, &mut [0; 64], &mut regions);
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
