//! Every label one connected piece.
//!
//! Pixels change their owner one by one where sources compete, and may leave a part of a source cut off
//! from the rest. The piece with its peak stays, or a much larger one; the others go to the sources that they lie on.

use crate::arithmetic::Level;
use crate::arithmetic::codec::Codec;
use crate::config::Connectivity;
use crate::plane::grid::Grid;
use crate::plane::rows::{row_of, row_of_mut, runs};
use crate::plane::walk::Walk;
use crate::sources::tree::{ROOT, Region, root_of};

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

/// Where the region with a label is in the table; for 0 beyond it.
pub(crate) fn index(label: u32) -> usize {
    (label as usize).wrapping_sub(1)
}

/// Leaves of every source one piece, connected also by corners: that with its peak, if the source still
/// has it, unless another is [`PEAK`] times as large; else the largest, the first of equals. Gives the
/// others to the source that they touch most, pixel by pixel; what touches none is given up. `queue` and `known` are
/// as long as the plane; `area` and `peak` of the regions do not outlast it. Cost: two looks at each pixel, and four at
/// those that a source loses and at their neighbours.
pub(crate) fn connect<L: Level>(
    walk: &mut Walk,
    joining: &mut Joining,
    grid: Grid,
    labels: &mut [u32],
    (queue, known): (&mut [u32], &mut [u32]),
    regions: &mut [Region<L>],
) -> Option<()> {
    let width = grid.width.get();
    walk.pass(regions.len(), 1, |part| reset_areas(regions.get_mut(part)))?;
    walk.pass(grid.height, 2 * width, |rows| {
        rows.for_each(|y| count_pieces(y, joining, grid, labels, (queue, known), regions));
    })?;
    // Of sources of more than one, that which is known to stay.
    let starts = queue.get(..joining.runs).unwrap_or(&[]);
    walk.pass(regions.len(), 2, |part| {
        let labelled = (part.start as u32 + 1..).zip(regions.get_mut(part).unwrap_or(&mut []));
        for (label, region) in labelled {
            if region.area <= 1 {
                region.area = if region.area == 1 { WHOLE } else { 0 };
                continue;
            }
            let peak = region.peak;
            (region.area, region.peak) = (0, 0);
            if label_at(labels, peak as usize) == label {
                let run = starts.partition_point(|&start| start <= peak).saturating_sub(1);
                let first = root_of(known, run as u32);
                (region.area, region.peak) = (area_of(known, first).saturating_mul(PEAK), first);
            }
        }
    })?;
    walk.pass(starts.len(), 1, |part| {
        for (run, &start) in (0..).zip(starts).take(part.end).skip(part.start) {
            let region = regions.get_mut(index(label_at(labels, start as usize)));
            let area = area_of(known, run);
            if let Some(region) = region.filter(|region| area > region.area) {
                (region.area, region.peak) = (area, run);
            }
        }
    })?;
    walk.once(1, || joining.runs = 0)?;
    walk.pass(grid.height, width, |rows| {
        rows.for_each(|y| loosen(row_of_mut(labels, width, y), joining, known, regions));
    })?;
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
/// touches, also by a corner. `starts` has the first pixels of the runs, `known` an earlier one of its piece, or of the
/// first of a piece its area.
fn count_pieces<L: Level>(
    y: usize,
    joining: &mut Joining,
    grid: Grid,
    labels: &[u32],
    (starts, known): (&mut [u32], &mut [u32]),
    regions: &mut [Region<L>],
) {
    let (width, end_above) = (grid.width.get(), joining.runs);
    // A row has no more runs than columns.
    let (left, mut above) = (y * width, joining.first.max(end_above.saturating_sub(width)));
    for (x, end, label) in runs(row_of(labels, width, y)) {
        let own = joining.runs;
        joining.runs = joining.runs.saturating_add(1);
        set(starts, own, (left + x) as u32);
        set(known, own, ROOT | (end - x) as u32);
        let mut pieces = 1;
        // Of the row above: from the corner on the left to that on the right.
        let corner = (left + x.saturating_sub(1)).wrapping_sub(width);
        let begins_by =
            |run: usize, at: usize| run < end_above && starts.get(run).is_some_and(|&start| start as usize <= at);
        while begins_by(above + 1, corner) {
            above += 1;
        }
        let corner_behind = (left + end).wrapping_sub(width);
        for near in (above..).take(end - x + 2).take_while(|&near| begins_by(near, corner_behind)) {
            let first = corner.max(label_at(starts, near) as usize);
            if label_at(labels, first) == label && join(known, near, own) {
                pieces -= 1;
            }
        }
        if let Some(region) = regions.get_mut(index(label)) {
            region.area = region.area.wrapping_add_signed(pieces);
        }
    }
    joining.first = end_above;
}

/// Makes the pieces of two runs one; whether they were two.
fn join(known: &mut [u32], one: usize, other: usize) -> bool {
    let (one, other) = (root_of(known, one as u32), root_of(known, other as u32));
    if one == other {
        return false;
    }
    let (first, later) = (one.min(other), one.max(other));
    let area = area_of(known, one).saturating_add(area_of(known, other));
    set(known, first as usize, ROOT | area);
    set(known, later as usize, first);
    true
}

/// The area of the piece that begins with a run; 0 where none does.
fn area_of(known: &[u32], run: u32) -> u32 {
    known.get(run as usize).filter(|&word| word & ROOT != 0).map_or(0, |word| word & !ROOT)
}

/// Marks the pixels of a row that are not of the piece that stays, of sources that have others.
fn loosen<L: Level>(row: &mut [u32], joining: &mut Joining, known: &mut [u32], regions: &[Region<L>]) {
    let mut next = 0;
    loop {
        let found = runs(row.get(next..).unwrap_or(&[])).next();
        let Some((first, end, label)) = found else { break };
        let run = joining.runs as u32;
        joining.runs = joining.runs.saturating_add(1);
        let region = regions.get(index(label)).filter(|region| region.area != WHOLE);
        if region.is_some_and(|region| root_of(known, run) != region.peak) {
            row.get_mut(next + first..next + end).unwrap_or(&mut []).fill(label | LOOSE);
        }
        next += end;
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
