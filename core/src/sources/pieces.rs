//! Every label one connected piece.
//!
//! Pixels change their owner one by one where sources compete, and may leave a part of a source cut off
//! from the rest. The piece with its peak stays, or a much larger one; the others go to the sources that they lie on.

use crate::arithmetic::Level;
use crate::arithmetic::codec::Codec;
use crate::config::Connectivity;
use crate::plane::grid::Grid;
use crate::plane::rows::{next_with, row_of, used_in};
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
    /// Runs of the rows so far, and which of them is the first of the last row.
    runs: usize,
    first: usize,
    /// The source that a piece touches most so far, and how often.
    owner: (u32, u32),
}

impl Joining {
    /// Before the first pass.
    pub const NOTHING: Joining = Joining { next: 0, label: 0, runs: 0, first: 0, owner: (0, 0) };

    /// The list of fields, out or in.
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        for size in [&mut self.next, &mut self.runs, &mut self.first] {
            codec.size(size)?;
        }
        for word in [&mut self.label, &mut self.owner.0, &mut self.owner.1] {
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
/// others to the source that they touch most, pixel by pixel; what touches none is given up. `queue` and `known` are
/// as long as the plane; `area` and `peak` of the regions do not outlast it. Cost: two looks at each pixel, and four at
/// those of sources of more than one piece and at their neighbours.
pub(crate) fn connect<L: Level>(
    walk: &mut Walk,
    joining: &mut Joining,
    grid: Grid,
    labels: &mut [u32],
    (queue, known): (&mut [u32], &mut [u32]),
    regions: &mut [Region<L>],
) -> Option<()> {
    let corners = (grid, Connectivity::Eight);
    walk.pass(regions.len(), 1, |part| reset_areas(regions.get_mut(part)))?;
    walk.pass(grid.height, 2 * grid.width.get(), |rows| {
        rows.for_each(|y| count_pieces(y, joining, grid, labels, (queue, known), regions));
    })?;
    walk.pass(regions.len(), 1, |part| {
        for region in regions.get_mut(part).unwrap_or(&mut []) {
            region.area = if region.area == 1 { WHOLE } else { 0 };
        }
    })?;
    walk.once(1, || joining.next = 0)?;
    let mark = walk.mark();
    loop {
        let has_peak = |&at: &usize| {
            let region = regions.get(at).filter(|region| region.area == 0);
            region.is_some_and(|region| index(label_at(labels, region.peak as usize)) == at)
        };
        let Some(at) = walk.seek(regions.len(), &mut joining.next, |mut range| range.find(has_peak))? else { break };
        let (label, peak) = (at as u32 + 1, regions.get(at).map_or(0, |region| region.peak as usize));
        let area = relabel(walk, corners, (peak, [label, label | LOOSE]), labels, queue)?;
        walk.once(1, || {
            if let Some(region) = regions.get_mut(at) {
                region.area = (area as u32).saturating_mul(PEAK);
            }
        })?;
        joining.next = at + 1;
        walk.again(mark);
    }
    find_largest(walk, joining, grid, labels, queue, regions)?;
    walk.once(1, || joining.next = 0)?;
    let mark = walk.mark();
    loop {
        let is_open = |&at: &usize| regions.get(at).is_some_and(|region| ![0, WHOLE].contains(&region.area));
        let Some(at) = walk.seek(regions.len(), &mut joining.next, |mut range| range.find(is_open))? else { break };
        let (label, largest) = (at as u32 + 1, regions.get(at).map_or(0, |region| region.peak as usize));
        relabel(walk, corners, (largest, [label | LOOSE, label]), labels, queue)?;
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

/// Counts pieces in `area`: in row `y` every run of a source begins one, and is joined to those in the row above that it
/// touches, also by a corner. `starts` has the first pixels of the runs, `known` what each is known by: itself, or
/// an earlier one of its piece.
fn count_pieces<L: Level>(
    y: usize,
    joining: &mut Joining,
    grid: Grid,
    labels: &[u32],
    (starts, known): (&mut [u32], &mut [u32]),
    regions: &mut [Region<L>],
) {
    let (width, end_above) = (grid.width.get(), joining.runs);
    let (left, mut above) = (y * width, joining.first);
    for (x, end, label) in runs(row_of(labels, width, y)) {
        let own = joining.runs;
        joining.runs += 1;
        set(starts, own, (left + x) as u32);
        set(known, own, own as u32);
        let mut pieces = 1;
        // Of the row above: from the corner on the left to that on the right.
        let corner = (left + x.saturating_sub(1)).wrapping_sub(width);
        let begins_by = |run: usize, at: usize| run < end_above && label_at(starts, run) as usize <= at;
        while begins_by(above + 1, corner) {
            above += 1;
        }
        let mut near = above;
        while begins_by(near, (left + end).wrapping_sub(width)) {
            let first = corner.max(label_at(starts, near) as usize);
            if label_at(labels, first) == label && join(known, near, own) {
                pieces -= 1;
            }
            near += 1;
        }
        if let Some(region) = regions.get_mut(index(label)) {
            region.area = region.area.wrapping_add_signed(pieces);
        }
    }
    joining.first = end_above;
}

/// The runs of one label in a row: first column, end and label.
fn runs(row: &[u32]) -> impl Iterator<Item = (usize, usize, u32)> {
    let mut next = 0;
    core::iter::from_fn(move || {
        let first = next_with(row, next, u32::MAX)?;
        let label = label_at(row, first);
        let others = row.get(first..)?.iter().position(|&other| other != label);
        next = others.map_or(row.len(), |length| first + length);
        Some((first, next, label))
    })
}

/// Lets two runs be known by the first that either is known by; whether these were two.
fn join(known: &mut [u32], one: usize, other: usize) -> bool {
    let (one, other) = (first_run(known, one), first_run(known, other));
    set(known, one.max(other), one.min(other) as u32);
    one != other
}

/// The first run that one is known by; what leads there is halved on the way.
fn first_run(known: &mut [u32], run: usize) -> usize {
    let mut run = run;
    loop {
        let near = label_at(known, run) as usize;
        let far = label_at(known, near) as usize;
        // Of two runs the later one is known by the earlier.
        if near >= run || far >= near {
            return near.min(run);
        }
        set(known, run, far as u32);
        run = far;
    }
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
        let (labels_of_rows, room) = (&mut labels[..CELLS * WIDTH], (&mut [0; 64][..], &mut [0; 64][..]));
        let _ = connect(&mut Walk::whole(), &mut { Joining::NOTHING }, grid, labels_of_rows, room, &mut regions);
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

    /// Pieces as they are found pixel by pixel.
    #[test]
    fn runs_that_touch_are_one_piece() {
        const SIDES: (usize, usize) = (23, 31);
        const CELLS: usize = SIDES.0 * SIDES.1;
        let (mut state, grid) = (1u32, Grid::of(CELLS, SIDES.0).expect("there are columns"));
        for percent in [10, 35, 45, 60, 90, 100] {
            let mut labels: [u32; CELLS] = core::array::from_fn(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if (state >> 8) % 100 < percent { 1 + (state >> 16) % 3 } else { 0 }
            });
            let (mut joining, mut starts, mut known) = (Joining::NOTHING, [0; CELLS], [0; CELLS]);
            let (mut regions, mut pieces) = ([Region::<f32>::BLANK; 3], [0; 3]);
            let mut count = |y| count_pieces(y, &mut joining, grid, &labels, (&mut starts, &mut known), &mut regions);
            (0..SIDES.1).for_each(&mut count);
            while let Some(first) = labels.iter().position(|&label| label != 0) {
                let label = labels[first];
                let corners = (grid, Connectivity::Eight);
                let _ = relabel(&mut Walk::whole(), corners, (first, [label, 0]), &mut labels, &mut starts);
                pieces[index(label)] += 1;
            }
            assert_eq!(regions.map(|region| region.area), pieces, "{percent} %");
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
