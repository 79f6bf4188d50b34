//! Whose light is it: pixels that a source's mirror image does not explain become sources, and
//! at a border each pixel goes to the source that has the most light there.

use crate::arithmetic::codec::Codec;
use crate::arithmetic::machine::Task;
use crate::arithmetic::{Level, Real};
use crate::config::Connectivity;
use crate::plane::crew::Crew;
use crate::plane::field::{Field, opposite};
use crate::plane::grid::Grid;
use crate::plane::rows::{last_with, next_with, rows_of_mut, sweep, whole_piece};
use crate::plane::walk::Walk;
use crate::sky::photon::grown;
use crate::sources::centre::is_wide;
use crate::sources::pieces::index;
use crate::sources::tree::{Count, Noise, Region};
use crate::sources::typical::Typical;
use core::ops::Range;

/// A pixel under examination.
const OPEN: u32 = 1 << 31;
/// A pixel that was, and is its host's: in the next search it is open again.
const AGAIN: u32 = 1 << 30;

/// Light of the pixel beyond what its source, mirrored, has there.
fn excess<L: Level>(field: Field<'_, L>, centre: (L, L), at: usize) -> L {
    field.at(at) - field.mirrored(centre, at).unwrap_or(L::ZERO)
}

fn label_at(labels: &[u32], at: usize) -> u32 {
    labels.get(at).copied().unwrap_or(0)
}

/// The same while pixels are under examination.
fn owner_at(labels: &[u32], at: usize) -> u32 {
    label_at(labels, at) & !(OPEN | AGAIN)
}

/// The region with a label.
pub(crate) fn region_of<L: Level>(regions: &[Region<L>], label: u32) -> Option<&Region<L>> {
    regions.get(index(label))
}

fn centre_of<L: Level>(regions: &[Region<L>], label: u32) -> (L, L) {
    region_of(regions, label).map_or((L::ZERO, L::ZERO), |region| region.centre)
}

fn light_of<L: Level>(regions: &[Region<L>], label: u32) -> L::Sum {
    region_of(regions, label).map_or(L::NOTHING, |region| region.sum)
}

/// A pixel belongs to another source where it has more than this many times its host's light.
const OTHER: f32 = 2.0;
/// The same for a pixel that begins a new source.
const NEW: f32 = 2.5;
/// In a group of fewer pixels in a wide host only those count that have [`APART`] times the host's light: galaxies have
/// knots and lopsided arms, which noise would make sources of in one image and not in the next.
const KNOT: usize = 16;
/// See [`KNOT`].
const APART: f32 = 3.5;

/// The mirror image of a host may lie so far off, in pixels: at the steep rim of a star out of focus this counts.
const CENTRE: f32 = 0.2;
/// A new source's brightest pixel has this much more, in noise of the plane, than there is around it at the distance
/// [`AROUND`]: an uneven edge has no peak of its own.
const PEAK: f32 = 3.0;
/// In pixels.
const AROUND: f32 = 4.0;

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

/// Whether what `other` alone has at a place ([`alone`]) is more than a bound, which is not below 0. Looks no farther than
/// it takes to know.
fn is_more_alone<L: Level>(field: Field<'_, L>, [host, other]: [(L, L); 2], place: (L, L), bound: L) -> bool {
    let across = opposite(other, place);
    let Some(light) = field.between(across).filter(|&light| light > bound) else { return false };
    let is_more = |taken: L| light - taken > bound;
    is_more(field.between(opposite(host, across)).unwrap_or(L::ZERO)) || field.is_low_around(host, across, is_more)
}

/// Whether a pixel has more than [`OTHER`] times the light that a source has there: what lies across its centre or, where
/// that is beyond the frame or too much of it another's, what is on its ellipse there, of it or of the sky. `None` where
/// the frame does not show it, or it is a needle.
fn is_beyond<L: Level>(
    field: Field<'_, L>,
    labels: &[u32],
    regions: &[Region<L>],
    label: u32,
    at: usize,
) -> Option<bool> {
    let region = region_of(regions, label)?;
    let across = field.across(region.centre, at);
    let is_own = |light: L| {
        let other = field.nearest(across).map_or(0, |at| label_at(labels, at));
        let centres = || [region.centre, centre_of(regions, other)];
        let bound = light.scaled(L::Weight::of(FOREIGN));
        other == 0 || other == label || !is_more_alone(field, centres(), across, bound)
    };
    let is_low = |light: L| field.at(at) > light.scaled(L::Weight::of(OTHER));
    if let Some(light) = field.between(across).filter(|&light| is_own(light)) {
        return Some(is_low(light));
    }
    let counts = |at: usize| [0, label].contains(&label_at(labels, at));
    field.is_low_on_ellipse((region.centre, region.shape()?), field.place(at), counts, is_low)
}

/// The most light that a host may have at a pixel: what is mirrored at its centre, as well as that is known, or what the
/// frame's typical source has. `None` where the mirror shows what is beyond the frame.
fn host_light<L: Level>((field, typical): (Field<'_, L>, Typical<'_>), host: &Region<L>, at: usize) -> Option<L> {
    let (x, y) = field.across(host.centre, at);
    let off = L::of(CENTRE);
    let beside = [(x - off, y), (x + off, y), (x, y - off), (x, y + off)];
    let mirrored =
        beside.into_iter().filter_map(|place| field.between(place)).fold(field.between((x, y))?, L::greatest);
    Some(mirrored.greatest(typical.light(host.value, host.centre, field.place(at))))
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

impl<L: Level> Reopening<'_, L> {
    /// The least light beyond a host's that counts.
    fn least(&self) -> L {
        L::of(self.excess * self.noise.least.to_f32())
    }

    /// Whether a pixel has more light than its host there by what its own noise may bring.
    fn is_significant(&self, at: usize, host: L) -> bool {
        self.field.at(at) - host > self.least() * grown(self.noise.photon, self.field.at(at))
    }
}

/// How far the search for sources beyond their hosts' light is, part by part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Opening<L: Level> {
    /// The regions.
    pub count: Count,
    /// The next pixel.
    next: usize,
    /// The host of the group at hand.
    host: u32,
    /// Of the other sources beside it the one with the most light; 0 for none.
    beside: u32,
    /// Pixels of the group that these two do not explain.
    unexplained: u32,
    /// The group as a region.
    group: Region<L>,
    /// Whether one of its pixels is a maximum of the plane.
    has_maximum: bool,
    /// Whether it becomes one.
    is_new: bool,
}

impl<L: Level> Opening<L> {
    /// Before the first pass.
    pub const NOTHING: Opening<L> = Opening {
        count: Count { regions: 0, left_out: 0 },
        next: 0,
        host: 0,
        beside: 0,
        unexplained: 0,
        group: Region::BLANK,
        has_maximum: false,
        is_new: false,
    };

    /// The list of fields, out or in.
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        self.count.code(codec)?;
        codec.size(&mut self.next)?;
        for word in [&mut self.host, &mut self.beside, &mut self.unexplained] {
            codec.word(word)?;
        }
        self.group.code(codec)?;
        codec.flag(&mut self.has_maximum)?;
        codec.flag(&mut self.is_new)
    }
}

/// Opens the pixels that neither their host's mirrored light nor that of the frame's typical source
/// explains, but none of a source that ends in a plateau, and makes each connected
/// group of them a region that is large enough, also when a second source's light is taken away:
/// where two large galaxies meet there is the light of both. All this so many times. `queue` is as long as the plane;
/// regions are added to those that are counted.
pub(crate) fn reopen<L: Level>(
    (walk, crew): (&mut Walk, &impl Crew),
    opening: &mut Opening<L>,
    reopening: &Reopening<'_, L>,
    labels: &mut [u32],
    queue: &mut [u32],
    (regions, searches): (&mut [Region<L>], u32),
) -> Option<()> {
    let (height, width) = (reopening.field.grid.height, reopening.field.grid.width.get());
    for search in 1..=searches {
        walk.pass(height, width, |rows| open(crew, rows, reopening, search == 1, labels, regions))?;
        let stays = if search < searches { AGAIN } else { 0 };
        divide(walk, opening, reopening, (labels, stays), queue, regions)?;
    }
    Some(())
}

/// Opens pixels of some rows. What the search before found of a pixel holds while it has the same host: only new regions,
/// whose area is not known yet, are asked again.
fn open<L: Level>(
    crew: &impl Crew,
    rows: Range<usize>,
    reopening: &Reopening<'_, L>,
    is_first: bool,
    labels: &mut [u32],
    regions: &[Region<L>],
) {
    let &Reopening { field, typical, .. } = reopening;
    let (new, least, width) = (L::Weight::of(NEW), reopening.least(), field.grid.width.get());
    let band = (width * crew.rows(field.grid)).max(1);
    let bands = (rows.start * width..).step_by(band).zip(rows_of_mut(labels, &rows, width).chunks_mut(band));
    crew.each(bands, |(first, labels): (usize, _)| {
        let mut next = 0;
        while let Some(index) = next_with(labels, next, u32::MAX) {
            next = index + 1;
            let (Some(label), at) = (labels.get_mut(index), first + index) else { continue };
            if *label & AGAIN != 0 {
                *label = *label & !AGAIN | OPEN;
            // Hosts have no light below 0.
            } else if field.at(at) > least
                && let Some(region) = region_of(regions, *label).filter(|region| region.plateau <= 0.0)
                && (is_first || region.area == 0)
                && let Some(mirrored) = field.mirrored(region.centre, at)
                && field.at(at) > mirrored.scaled(new)
                && let host = mirrored.greatest(typical.light(region.value, region.centre, field.place(at)))
                && field.at(at) > host.scaled(new)
                && reopening.is_significant(at, host)
            {
                *label |= OPEN;
            }
        }
    });
}

/// Makes each connected group of open pixels a region, or gives it back to its host, whose label then has the bits of
/// `stays` too.
fn divide<L: Level>(
    walk: &mut Walk,
    opening: &mut Opening<L>,
    reopening: &Reopening<'_, L>,
    (labels, stays): (&mut [u32], u32),
    queue: &mut [u32],
    regions: &mut [Region<L>],
) -> Option<()> {
    let &Reopening { field, typical, noise, least_area, connectivity, .. } = reopening;
    walk.once(1, || opening.next = 0)?;
    let mark = walk.mark();
    while let Some(first) = walk.seek_bits(labels, &mut opening.next, OPEN)? {
        walk.once(1, || (opening.host, opening.beside) = (owner_at(labels, first), 0))?;
        let light = |label: u32| light_of(regions, label);
        let known = gather(walk, opening, (field.grid, connectivity, first), (labels, stays), queue, light)?;
        let group = |part: Range<usize>| queue.get(part).unwrap_or(&[]);
        walk.pass(known, 8, |part| {
            let before = if part.start == 0 { 0 } else { opening.unexplained };
            let explained = explained((field, typical), labels, regions, [opening.host, opening.beside]);
            let knot = region_of(regions, opening.host).filter(|host| is_wide(host) && known < KNOT);
            let is_of_host = |at: usize| {
                let mirrored = |host: &Region<L>| field.mirrored(host.centre, at).unwrap_or(L::ZERO);
                knot.is_some_and(|host| field.at(at) <= mirrored(host).scaled(L::Weight::of(APART)))
            };
            let unexplained = group(part)
                .iter()
                .map(|&at| at as usize)
                .filter(|&at| reopening.is_significant(at, explained(at)) && !is_of_host(at));
            opening.unexplained = before.saturating_add(unexplained.count() as u32);
        })?;
        walk.pass(known, 4, |part| {
            if part.start == 0 {
                (opening.group, opening.has_maximum) = (Region { peak: first as u32, ..Region::BLANK }, false);
            }
            let pixels = group(part);
            opening.group = brightest(field, centre_of(regions, opening.host), opening.group, pixels);
            opening.has_maximum =
                opening.has_maximum || pixels.iter().any(|&at| is_greatest(field.grid, at as usize, |at| field.at(at)));
        })?;
        walk.once(16, || {
            let Opening { host, group, count, .. } = opening;
            let peak = group.peak as usize;
            let centre = centre_of(regions, *host);
            // On the flank of a lopsided star what is beyond the mirrored light rises on towards the star.
            let has_peak = is_peak(field, noise, peak)
                && (opening.has_maximum || is_greatest(field.grid, peak, |at| excess(field, centre, at)));
            let is_source = opening.unexplained >= least_area && has_peak;
            opening.is_new = is_source && count.regions < regions.len();
            if opening.is_new {
                add(field, *group, *host, regions, count.regions);
                count.regions += 1;
            } else if is_source {
                count.left_out += 1;
            }
        })?;
        walk.pass(if opening.is_new { known } else { 0 }, 1, |part| {
            for &at in group(part) {
                if let Some(label) = labels.get_mut(at as usize) {
                    *label = opening.count.regions as u32;
                }
            }
        })?;
        opening.next = first + 1;
        walk.again(mark);
    }
    Some(())
}

/// Gives the connected group of open pixels around the first back to its host, whose label then has the bits of `stays`
/// too, and lists it in the queue. Gives its length, and finds of the other sources beside it the one with the most light.
fn gather<L: Level>(
    walk: &mut Walk,
    opening: &mut Opening<L>,
    (grid, connectivity, first): (Grid, Connectivity, usize),
    (labels, stays): (&mut [u32], u32),
    queue: &mut [u32],
    light: impl Fn(u32) -> L::Sum,
) -> Option<usize> {
    let (host, beside) = (opening.host, &mut opening.beside);
    walk.until(|tally, next| {
        let known = &mut tally.count;
        let take = |at: usize, known: &mut usize, labels: &mut [u32], queue: &mut [u32]| {
            if let (Some(label), Some(place)) = (labels.get_mut(at), queue.get_mut(*known)) {
                (*label, *place) = (host | stays, at as u32);
                *known += 1;
            }
        };
        if next == 0 {
            *known = 0;
            take(first, known, labels, queue);
        }
        let Some(&at) = queue.get(next).filter(|_| next < *known) else { return false };
        for near in grid.touching(at as usize, connectivity.neighbours()) {
            let owner = owner_at(labels, near);
            if label_at(labels, near) == host | OPEN {
                take(near, known, labels, queue);
            } else if owner != host && light(owner) > light(*beside) {
                *beside = owner;
            }
        }
        next + 1 < *known
    })?;
    Some(walk.tally.count)
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
    let divided = owner_at(labels, divided.wrapping_sub(1));
    let other = if beside != 0 { beside } else { divided };
    let region = region_of(regions, host).copied().unwrap_or(Region::BLANK);
    let there = centre_of(regions, other);
    move |at| {
        let own = host_light((field, typical), &region, at).unwrap_or(L::ZERO);
        let shown = || field.nearest(field.across(there, at)).map_or(0, |at| owner_at(labels, at));
        if other == 0 || other == host || (beside == 0 && shown() != other) {
            return own;
        }
        own + alone(field, [region.centre, there], field.place(at)).unwrap_or(L::ZERO)
    }
}

/// Adds pixels to a group as a region: the pixel with most light beyond the mirrored host's, and that light in all.
fn brightest<L: Level>(field: Field<'_, L>, host: (L, L), group: Region<L>, pixels: &[u32]) -> Region<L> {
    let mut found = group;
    for &at in pixels {
        let light = excess(field, host, at as usize);
        found.sum = found.sum + light.times(1);
        if light > found.value {
            (found.value, found.peak) = (light, at);
        }
    }
    found
}

/// Whether a pixel rises above what is around it: on a slope as much is missing on one side as there is on the other.
fn is_peak<L: Level>(field: Field<'_, L>, noise: Noise<L>, at: usize) -> bool {
    let centre = field.place(at);
    let around = field.around(centre, (centre.0 + L::of(AROUND), centre.1));
    field.at(at) - around > noise.at(field.at(at)).scaled(L::Weight::of(PEAK))
}

/// Whether no neighbour of a pixel has more.
fn is_greatest<L: Level>(grid: Grid, at: usize, of: impl Fn(usize) -> L) -> bool {
    let own = of(at);
    grid.touching(at, 8).all(|near| of(near) <= own)
}

/// Makes a group of pixels the region with index `count`, divided from its host.
fn add<L: Level>(field: Field<'_, L>, group: Region<L>, host: u32, regions: &mut [Region<L>], count: usize) {
    let mut divided = 0;
    if let Some(host) = regions.get_mut(index(host)) {
        divided = host.peak.saturating_add(1);
        host.divide(field, group.peak);
    }
    if let Some(region) = regions.get_mut(count) {
        *region = Region { centre: field.place(group.peak as usize), divided, ..group };
    }
}

/// How far sources have competed, part by part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contest {
    /// Whether a pixel has changed its owner in this sweep.
    has_changed: bool,
    /// Whether none has in the one before.
    is_settled: bool,
}

impl Contest {
    /// Before the first pass.
    pub const NOTHING: Contest = Contest { has_changed: false, is_settled: false };

    /// The list of fields, out or in.
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        codec.flag(&mut self.has_changed)?;
        codec.flag(&mut self.is_settled)
    }
}

/// Lets sources compete for the pixels at their borders, forwards and backwards `sweeps` times:
/// of two neighbours the one with less light in all owns a pixel where the value is more than
/// `OTHER` times the other's own light. Where that is not known, the pixel stays.
pub(crate) fn compete<L: Level>(
    (walk, crew): (&mut Walk, &impl Crew),
    contest: &mut Contest,
    field: Field<'_, L>,
    labels: &mut [u32],
    regions: &[Region<L>],
    sweeps: u32,
) -> Option<()> {
    let count = labels.len();
    for sweep_number in 0..sweeps {
        walk.once(1, || {
            contest.is_settled = sweep_number > 0 && !contest.has_changed;
            contest.has_changed = false;
        })?;
        walk.pass(if contest.is_settled { 0 } else { count }, 1, |part| {
            let (Contest { has_changed, .. }, forwards) = (&mut *contest, sweep_number % 2 == 0);
            let mut piece = |labels: &mut [u32], cells: Range<usize>| {
                let (first, length) = (cells.start, cells.len());
                let open = crew.wide(Piece { labels, grid: field.grid, first, length });
                sweep(open, length, forwards, |at| {
                    let changes = changes_owner(field, labels, regions, first + at);
                    *has_changed |= changes;
                    changes
                });
            };
            if forwards {
                let mut next = part.start;
                while let Some(at) = next_with(labels.get(..part.end).unwrap_or(&[]), next, u32::MAX) {
                    next = part.end.min(at + PIECE);
                    piece(labels, at..next);
                }
            } else {
                let (low, mut end) = (count - part.end, count - part.start);
                while let Some(at) = last_with(labels.get(low..).unwrap_or(&[]), end - low, u32::MAX) {
                    let last = low + at + 1;
                    end = low.max(last.saturating_sub(PIECE));
                    piece(labels, end..last);
                }
            }
        })?;
    }
    Some(())
}

/// Gives a pixel to the source that owns it; whether that is another than before.
fn changes_owner<L: Level>(field: Field<'_, L>, labels: &mut [u32], regions: &[Region<L>], at: usize) -> bool {
    let own = label_at(labels, at);
    if own == 0 {
        return false;
    }
    let (mut best, mut asked, mut is_other) = (own, 0, None);
    for near in field.grid.touching(at, 4) {
        let other = label_at(labels, near);
        if other == 0 || other == best || near.abs_diff(at) > field.grid.width.get() {
            continue;
        }
        let brighter = light_of(regions, best) >= light_of(regions, other);
        let (bright, faint) = if brighter { (best, other) } else { (other, best) };
        // Most pixels at a border touch the other source twice, or the brightest of three beside both others.
        if bright != asked {
            (asked, is_other) = (bright, is_beyond(field, labels, regions, bright, at));
        }
        if let Some(is_other) = is_other {
            best = if is_other { faint } else { bright };
        }
    }
    match labels.get_mut(at).filter(|_| best != own) {
        Some(label) => {
            *label = best;
            true
        }
        None => false,
    }
}

/// A piece of the plane, as the question which of its pixels may be a source's that touches another along an edge: a bit
/// for each, the lowest for the first. Where the plane ends it is not told.
struct Piece<'a> {
    labels: &'a [u32],
    grid: Grid,
    first: usize,
    length: usize,
}

impl Task for Piece<'_> {
    type Output = u32;

    #[inline(always)]
    fn run(self) -> u32 {
        let Piece { labels, grid, first, length } = self;
        let unknown = whole_piece(length);
        if length < PIECE {
            return unknown;
        }
        let piece = |first: Option<usize>| labels.get(first?..)?.first_chunk::<PIECE>();
        let Some(own) = piece(Some(first)) else { return unknown };
        let width = grid.width.get();
        let (left, right) = (piece(first.checked_sub(1)), piece(Some(first + 1)));
        let (below, above) = (piece(first.checked_sub(width)), piece(Some(first + width)));
        let (Some(left), Some(right), Some(below), Some(above)) = (left, right, below, above) else { return unknown };
        let is_other = |near: u32, own: u32| (near != 0) & (near != own);
        let mut open = [0; PIECE];
        let near = left.iter().zip(right).zip(below.iter().zip(above));
        for ((open, &own), ((&left, &right), (&below, &above))) in open.iter_mut().zip(own).zip(near) {
            let along = is_other(left, own) | is_other(right, own);
            *open = u32::from((own != 0) & (along | is_other(below, own) | is_other(above, own)));
        }
        if open.iter().fold(0, |any, open| any | open) == 0 {
            return 0;
        }
        (0..).zip(open).fold(0, |bits, (bit, open)| bits | open << bit)
    }
}

/// Moves outlines by their curvature: a pixel takes the label that at least six of the nine
/// pixels around it have. `old` has room for two rows; in less than three rows no pixel has six neighbours of another.
pub(crate) fn straighten(
    (walk, crew): (&mut Walk, &impl Crew),
    labels: &mut [u32],
    old: &mut [u32],
    grid: Grid,
    steps: u32,
) -> Option<()> {
    let width = grid.width.get();
    for _ in 0..steps {
        walk.pass(grid.height, width, |rows| straighten_rows(rows, labels, old, width, crew))?;
    }
    Some(())
}

/// Straightens some rows that go on where others ended.
fn straighten_rows(rows: Range<usize>, labels: &mut [u32], old: &mut [u32], width: usize, crew: &impl Crew) {
    let Some((mut below, rest)) = old.split_at_mut_checked(width) else { return };
    let Some(mut own) = rest.get_mut(..width) else { return };
    if rows.start % 2 == 1 {
        (below, own) = (own, below);
    }
    let mut rest = labels.get_mut(rows.start * width..).unwrap_or(&mut []);
    for y in rows {
        let Some((row, above)) = rest.split_at_mut_checked(width) else { break };
        own.iter_mut().zip(row.iter()).for_each(|(own, label)| *own = *label);
        if let (true, Some(above)) = (y > 0, above.get(..width)) {
            crew.wide(Row { labels: row, old: [below, own, above] });
        }
        (below, own, rest) = (own, below, above);
    }
}

/// Pixels of a row that are looked at together.
const PIECE: usize = 16;

/// A row that is straightened between its neighbours, all as they were before.
struct Row<'a> {
    labels: &'a mut [u32],
    old: [&'a [u32]; 3],
}

impl Task for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let [below, own, above] = self.old;
        for (first, labels) in (0..).step_by(PIECE).zip(self.labels.chunks_mut(PIECE)) {
            if !all_stay(self.old, first) {
                straighten_piece(labels, first, [below, own, above]);
            }
        }
    }
}

/// Straightens a piece of a row that begins at a column.
fn straighten_piece(labels: &mut [u32], first: usize, [below, own, above]: [&[u32]; 3]) {
    for (x, label) in (first..).zip(labels) {
        let near = |row: &[u32]| row.get(x.wrapping_sub(1)..)?.first_chunk::<3>().copied();
        if let (Some(below), Some(own), Some(above)) = (near(below), near(own), near(above))
            && let Some(other) = straighter([below, own, above])
        {
            *label = other;
        }
    }
}

/// Whether every pixel of a whole piece has three neighbours of its own, which are enough to stay; at the ends of a
/// row it may not be told.
#[inline(always)]
fn all_stay([below, own, above]: [&[u32]; 3], first: usize) -> bool {
    let Some(first) = first.checked_sub(1) else { return false };
    let [Some(below), Some(own), Some(above)] = [window(below, first), window(own, first), window(above, first)] else {
        return false;
    };
    let mut same = [0; PIECE];
    for row in [below, own, above] {
        add_same(&mut same, row, own);
    }
    // Each is its own neighbour here.
    same.iter().fold(true, |all, &same| all & (same > 3))
}

/// A piece with a column on either side.
const WINDOW: usize = PIECE + 2;

#[inline(always)]
fn window(row: &[u32], first: usize) -> Option<&[u32; WINDOW]> {
    row.get(first..)?.first_chunk()
}

/// Counts which of the three pixels of a row around each column have the label of the middle row's pixel.
#[inline(always)]
fn add_same(same: &mut [u32; PIECE], row: &[u32; WINDOW], own: &[u32; WINDOW]) {
    for (x, same) in same.iter_mut().enumerate() {
        let at = |row: &[u32; WINDOW], x: usize| row.get(x).copied().unwrap_or(0);
        let label = at(own, x + 1);
        *same += u32::from(at(row, x) == label);
        *same += u32::from(at(row, x + 1) == label);
        *same += u32::from(at(row, x + 2) == label);
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::Fixed14;
    use crate::plane::crew::Alone;

    extern crate std;
    use std::vec::Vec;

    const SIDE: usize = 64;

    /// A round source of 1000 in the middle of a frame, of which so many pixels are above half its peak, with light
    /// `beside` it.
    fn blend<L: Level>(area: u32, beside: impl Fn(f32, f32) -> f32) -> (Vec<L>, Vec<u32>, [Region<L>; 9]) {
        let light = |at: usize| {
            let (x, y) = ((at % SIDE) as f32, (at / SIDE) as f32);
            let squared = (x - 32.0) * (x - 32.0) + (y - 32.0) * (y - 32.0);
            L::of(1000.0 * libm::expf(-squared / 18.0) + beside(x, y))
        };
        let values: Vec<L> = (0..SIDE * SIDE).map(light).collect();
        let centre = (L::whole(32), L::whole(32));
        let mut regions = [Region::<L>::BLANK; 9];
        regions[0] = Region { peak: 32 * 64 + 32, value: L::of(1000.0), area, centre, ..Region::BLANK };
        let labels = std::vec![1; values.len()];
        (values, labels, regions)
    }

    fn reopening<L: Level>(values: &[L]) -> Reopening<'_, L> {
        Reopening {
            field: Field { values, grid: Grid::of(values.len(), SIDE).expect("there are columns") },
            typical: Typical::NONE,
            noise: Noise { least: L::of(0.4), photon: 0.0 },
            excess: 5.5,
            least_area: 4,
            connectivity: Connectivity::Eight,
        }
    }

    const ONE: Count = Count { regions: 1, left_out: 0 };

    /// Sources that are opened there.
    fn opened<L: Level>(area: u32, beside: impl Fn(f32, f32) -> f32) -> usize {
        let (values, mut labels, mut regions) = blend::<L>(area, beside);
        let (mut opening, mut queue) = (Opening { count: ONE, ..Opening::NOTHING }, std::vec![0; values.len()]);
        let (walk, regions) = (&mut Walk::whole(), (&mut regions[..], 1));
        let _ = reopen((walk, &Alone), &mut opening, &reopening(&values), &mut labels, &mut queue, regions);
        opening.count.regions - 1
    }

    /// Pixels that a second search opens, which knows of the first, and those that are opened where all are asked again.
    fn what_a_search_has_found_holds<L: Level>() {
        let star = |x: f32, y: f32, peak: f32, at: (f32, f32)| {
            peak * libm::expf(-((x - at.0) * (x - at.0) + (y - at.1) * (y - at.1)) / 5.0)
        };
        // Two stars, which are one region at first, and three pixels, which are too few.
        let few = |x: f32, y: f32| if y == 50.0 && (12.0..15.0).contains(&x) { 9.0 } else { 0.0 };
        let beside = |x: f32, y: f32| star(x, y, 300.0, (50.0, 40.0)) + star(x, y, 90.0, (50.0, 47.0)) + few(x, y);
        let (values, mut labels, mut regions) = blend::<L>(9, beside);
        let (mut opening, mut queue) = (Opening { count: ONE, ..Opening::NOTHING }, std::vec![0; values.len()]);
        let reopening = reopening(&values);
        open(&Alone, 0..SIDE, &reopening, true, &mut labels, &regions);
        let _ = divide(&mut Walk::whole(), &mut opening, &reopening, (&mut labels, AGAIN), &mut queue, &mut regions);
        let mut asked: Vec<u32> = labels.iter().map(|label| label & !AGAIN).collect();
        open(&Alone, 0..SIDE, &reopening, true, &mut asked, &regions);
        open(&Alone, 0..SIDE, &reopening, false, &mut labels, &regions);
        assert_eq!(labels, asked, "{}", L::NAME);
        let open_of = |host: u32| labels.iter().filter(|&&label| label == host | OPEN).count();
        assert!(open_of(1) == 3 && open_of(2) > 10, "{}: {} and {} pixels", L::NAME, open_of(1), open_of(2));
    }

    #[test]
    fn what_a_search_has_found_holds_in_both_arithmetics() {
        what_a_search_has_found_holds::<f32>();
        what_a_search_has_found_holds::<Fixed14>();
    }

    /// By a look at as little as it takes, and at all there is.
    fn what_another_has_alone_is_compared_as_it_is<L: Level>() {
        let light = |at: usize| L::of((at * 7919 % 101) as f32 - 20.0);
        let values: Vec<L> = (0..SIDE * SIDE).map(light).collect();
        let field = Field { values: &values, grid: Grid::of(values.len(), SIDE).expect("there are columns") };
        let place = |x: f32, y: f32| (L::of(x), L::of(y));
        let mut more = 0;
        for at in 0..SIDE * SIDE {
            let centres = [place(30.25, 31.5), place((at % 61) as f32 + 0.5, (at % 53) as f32)];
            let alone = alone(field, centres, field.place(at)).unwrap_or(L::ZERO);
            for bound in [L::ZERO, L::of(8.0), L::of(25.0), alone] {
                let is_more = is_more_alone(field, centres, field.place(at), bound);
                assert_eq!(is_more, alone > bound, "{at}: {alone:?} and {bound:?}");
                more += usize::from(is_more);
            }
        }
        assert!((1000..3 * SIDE * SIDE).contains(&more), "{more}");
    }

    #[test]
    fn what_another_has_alone_is_compared_as_it_is_in_both_arithmetics() {
        what_another_has_alone_is_compared_as_it_is::<f32>();
        what_another_has_alone_is_compared_as_it_is::<Fixed14>();
    }

    #[test]
    fn light_with_a_peak_is_a_source_and_an_uneven_edge_is_none() {
        let star = |x: f32, y: f32| 9.0 * libm::expf(-((x - 50.0) * (x - 50.0) + (y - 36.0) * (y - 36.0)) / 8.0);
        let edge = |x: f32, y: f32| {
            let (dx, dy) = (x - 32.0, y - 32.0);
            let distance = libm::hypotf(dx, dy);
            let (off, to_the_right) = (distance - 16.0, 0.5 + 0.5 * dx / (distance + 1.0));
            8.0 * to_the_right * to_the_right * libm::expf(-off * off / 100.0)
        };
        assert_eq!([opened::<f32>(9, star), opened::<Fixed14>(9, star)], [1; 2]);
        assert_eq!([opened::<f32>(9, edge), opened::<Fixed14>(9, edge)], [0; 2]);
    }

    #[test]
    fn a_small_knot_is_of_its_galaxy_unless_it_outshines_it_and_a_star_has_none() {
        // In its middle it has so many times the light of its host, and beyond it a pixel that is a maximum.
        let knot = |times: f32, width: f32| {
            move |x: f32, y: f32| {
                let squared = |centre: f32| (x - centre) * (x - centre) + (y - 32.0) * (y - 32.0);
                let host = 1000.0 * libm::expf(-squared(32.0) / 18.0);
                let maximum = if (x, y) == (43.0, 32.0) { 30.0 } else { 0.0 };
                maximum + host * (times - 1.0) * libm::expf(-squared(41.0) / (2.0 * width * width))
            }
        };
        let [wide, narrow] = [51, 50];
        let both =
            |area, beside: &dyn Fn(f32, f32) -> f32| [opened::<f32>(area, beside), opened::<Fixed14>(area, beside)];
        assert_eq!(both(wide, &knot(3.4, 1.5)), [0; 2]);
        assert_eq!(both(narrow, &knot(3.4, 1.5)), [1; 2]);
        assert_eq!(both(wide, &knot(8.0, 1.5)), [1; 2]);
        assert_eq!(both(wide, &knot(3.4, 4.0)), [1; 2]);
    }

    #[test]
    fn the_flank_of_a_lopsided_star_is_no_source_and_a_companions_shoulder_is_one() {
        // To the right of the star, without a maximum of its own in either.
        let flank = |x: f32, y: f32| {
            let (dx, dy) = (x - 32.0, y - 32.0);
            let (squared, to_the_right) = (dx * dx + dy * dy, 0.5 + 0.5 * dx / (libm::hypotf(dx, dy) + 1.0));
            120.0 * to_the_right * to_the_right * libm::expf(-squared / 50.0)
        };
        let shoulder = |x: f32, y: f32| 22.0 * libm::expf(-((x - 41.0) * (x - 41.0) + (y - 32.0) * (y - 32.0)) / 4.5);
        assert_eq!([opened::<f32>(9, flank), opened::<Fixed14>(9, flank)], [0; 2]);
        assert_eq!([opened::<f32>(9, shoulder), opened::<Fixed14>(9, shoulder)], [1; 2]);
        // Where the flank is not the companion's own.
        let on_the_flank = |x: f32, y: f32| flank(x, y) + 3.0 * shoulder(x, y);
        assert_eq!([opened::<f32>(9, on_the_flank), opened::<Fixed14>(9, on_the_flank)], [1; 2]);
    }

    #[test]
    fn a_pixel_takes_the_label_of_six_of_its_neighbours() {
        for (around, taken) in [
            ([[1, 1, 1], [1, 2, 1], [2, 2, 1]], Some(1)),
            ([[2, 2, 1], [1, 2, 1], [1, 1, 1]], Some(1)),
            ([[1, 1, 1], [1, 2, 1], [2, 2, 2]], None),
            ([[1, 1, 1], [1, 2, 1], [3, 2, 1]], Some(1)),
            ([[1, 1, 3], [1, 2, 3], [3, 2, 1]], None),
            ([[1, 2, 1], [2, 2, 2], [1, 1, 1]], None),
        ] {
            assert_eq!(straighter(around), taken, "{around:?}");
        }
    }
}
