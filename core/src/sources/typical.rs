//! The frame's typical source: how the light of a point is spread by these optics, as far as the
//! frame's bright sources show it. What they all have, a coma, a trail, a ring, rays, is no source.
//!
//! Around each of the brightest sources the light is taken at the same distances from the centre,
//! as a part of that at the peak; of all sources the lower quartile is kept, in which neither
//! neighbours nor wide sources have a share.

use crate::arithmetic::{Level, Real};
use crate::plane::crew::Crew;
use crate::plane::field::Field;
use crate::plane::part::{Question, Whole};
use crate::plane::sort;
use crate::plane::walk::Walk;
use crate::sources::tree::Region;

/// The farthest distance along an axis, pixels.
const RADIUS: usize = 24;
/// Cells along an axis.
const SIDE: usize = 2 * RADIUS + 1;
/// The most sources that are looked at.
pub const MOST: usize = 64;
/// Words of a source in the answer of all parts of an image: a key by which the brightest comes first, the index of
/// its peak in the image, and the bits of its light, NaN beyond the image. The answer has the first [`MOST`] of them.
pub const RECORD: usize = RECORD_HEAD + SIDE * SIDE;
const RECORD_HEAD: usize = 2;
/// With fewer, there is no typical one.
const LEAST: usize = 12;
/// A source is looked at when its peak is this many times the noise.
const BRIGHT: f32 = 100.0;
/// A source may have this many times the light of the typical one.
const MARGIN: f32 = 1.3;

/// Light by the distance from the centre along x and y, as parts of a peak's.
#[derive(Clone, Copy, Debug)]
pub struct Typical<'m> {
    /// [`SIDE`] rows of as many cells, the bits of `f32`; empty where there is no typical source.
    cells: &'m [u32],
}

impl<'m> Typical<'m> {
    /// None that is known.
    pub const NONE: Typical<'static> = Typical { cells: &[] };

    /// The typical source that [`Typical::find`] has left in `cells`, if there is one.
    pub(crate) fn over(cells: &'m [u32], is_known: bool) -> Typical<'m> {
        Typical { cells: cells.get(..SIDE * SIDE).filter(|_| is_known).unwrap_or(&[]) }
    }

    /// Looks at the sources of a frame, and tells whether there is a typical one. `cells` and `spare` are as long as the
    /// plane; where that is too short there is none. Cost: 154 thousand samples.
    pub(crate) fn find<L: Level>(
        (walk, crew): (&mut Walk, &impl Crew),
        is_known: &mut bool,
        whole: Option<&dyn Whole>,
        field: Field<'_, L>,
        noise: L,
        regions: &[Region<L>],
        (cells, spare): (&'m mut [u32], &mut [u32]),
    ) -> Option<()> {
        let bright = noise.scaled(L::Weight::of(BRIGHT));
        let stands = |region: &Region<L>| region.area > 0 && region.plateau <= 0.0 && region.value > bright;
        let part = whole.map(Whole::part);
        let is_own =
            |region: &Region<L>| part.as_ref().is_none_or(|part| part.owns(field.grid.place(region.peak as usize)));
        walk.tally(regions.len(), 1, |tally, part| {
            if part.start == 0 {
                tally.count = 0;
            }
            let some = (0..).zip(regions).take(part.end).skip(part.start);
            for (id, _) in some.filter(|(_, region)| stands(region) && is_own(region)) {
                if let Some(place) = cells.get_mut(tally.count) {
                    *place = id;
                    tally.count += 1;
                }
            }
        })?;
        let count = walk.tally.count;
        let ids = cells.get_mut(..count).unwrap_or(&mut []);
        let region = |id: u32| regions.get(id as usize);
        // The order of equal ones must not depend on the order of the table.
        sort::by_key_in(walk, ids, spare, |id| region(id).map_or(0, |region| region.peak))?;
        sort::by_key_in(walk, ids, spare, |id| !region(id).map_or(L::ZERO, |region| region.value).key())?;
        let count = count.min(MOST);
        let chosen = spare.get_mut(..count).unwrap_or(&mut []);
        walk.once(MOST, || chosen.iter_mut().zip(ids.iter()).for_each(|(chosen, id)| *chosen = *id))?;
        let chosen = &*chosen;
        let light = |id: u32, at: usize| {
            let off = |cell: usize| L::whole(cell) - L::whole(RADIUS);
            let region = region(id)?;
            let light = field.between((region.centre.0 + off(at % SIDE), region.centre.1 + off(at / SIDE)))?;
            Some(light.to_f32() / region.value.to_f32())
        };
        let mut count = count;
        let mut records = None;
        if let (Some(whole), Some(part)) = (whole, &part) {
            let mut own = chosen.iter().flat_map(|&id| {
                let (value, peak) = region(id).map_or((L::ZERO, 0), |region| (region.value, region.peak as usize));
                let (x, y) = part.place(field.grid.place(peak));
                let head = [!value.key(), (y * part.image.0 + x) as u32];
                head.into_iter().chain((0..SIDE * SIDE).map(move |at| light(id, at).unwrap_or(f32::NAN).to_bits()))
            });
            let words = whole.words(Question::Typical, &mut own).unwrap_or(&[]);
            count = words.len() / RECORD;
            records = Some(words);
        }
        walk.once(1, || *is_known = count >= LEAST && cells.len() >= SIDE * SIDE)?;
        walk.pass(if *is_known { SIDE * SIDE } else { 0 }, MOST, |part| {
            let first = part.start;
            let pieces = cells.get_mut(part).unwrap_or(&mut []).chunks_mut(SIDE);
            crew.each((first..).step_by(SIDE).zip(pieces), |(first, cells): (usize, _)| {
                for (at, cell) in (first..).zip(cells) {
                    let told = |record: &[u32]| record.get(RECORD_HEAD + at).map(|&bits| f32::from_bits(bits));
                    let value = match records {
                        None => quartile(chosen.iter().filter_map(|&id| light(id, at))),
                        Some(records) => {
                            quartile(records.chunks_exact(RECORD).filter_map(told).filter(|light| !light.is_nan()))
                        }
                    };
                    *cell = value.to_bits();
                }
            });
        })
    }

    /// The most light that a source of this kind with the given peak and centre has at a place.
    pub fn light<L: Level>(&self, peak: L, centre: (L, L), place: (L, L)) -> L {
        let cell = |place: L, centre: L| {
            let off = place - centre + L::whole(RADIUS) + L::of(0.5);
            (off >= L::ZERO).then(|| off.split(SIDE).0).filter(|&cell| cell < SIDE)
        };
        let cells = cell(place.0, centre.0).zip(cell(place.1, centre.1));
        let part = cells.and_then(|(column, row)| self.cells.get(row * SIDE + column));
        let part = part.map_or(0.0, |&bits| f32::from_bits(bits));
        peak.positive().scaled(L::Weight::of(MARGIN * part))
    }
}

/// The lower quartile of at most [`MOST`] values; 0 of none.
fn quartile(values: impl Iterator<Item = f32>) -> f32 {
    let (mut least, mut count) = ([f32::INFINITY; MOST / 4 + 1], 0);
    for value in values.take(MOST) {
        count += 1;
        if let Some(last) = least.last_mut().filter(|last| value < **last) {
            *last = value;
            sort::settle(&mut least, |a, b| a < b);
        }
    }
    least.get(count / 4).copied().filter(|_| count > 0).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::Fixed14;
    use crate::plane::crew::Alone;
    use crate::plane::grid::Grid;

    extern crate std;
    use std::vec;
    use std::vec::Vec;

    const WIDTH: usize = 256;

    /// So many bright sources of 200 or more, each with a fifth of that three pixels to the right, the first
    /// two with a companion as bright below.
    fn sources<L: Level>(count: usize) -> (Vec<L>, Vec<Region<L>>) {
        let mut plane = vec![L::ZERO; WIDTH * WIDTH];
        let mut regions = Vec::new();
        for index in 0..count {
            let (at, peak) = ((30 + 50 * (index / 5)) * WIDTH + 30 + 45 * (index % 5), 200.0 + index as f32);
            plane[at] = L::of(peak);
            plane[at + 3] = L::of(0.2 * peak);
            if index < 2 {
                plane[at + 5 * WIDTH] = L::of(peak);
            }
            let centre = (L::whole(at % WIDTH), L::whole(at / WIDTH));
            regions.push(Region { peak: at as u32, value: plane[at], area: 9, centre, ..Region::BLANK });
        }
        (plane, regions)
    }

    fn typical<'m, L: Level>(
        field: Field<'_, L>,
        regions: &[Region<L>],
        cells: &'m mut [u32],
        spare: &mut [u32],
    ) -> Typical<'m> {
        let mut is_known = false;
        let _ =
            Typical::find((&mut Walk::whole(), &Alone), &mut is_known, None, field, L::ONE, regions, (cells, spare));
        Typical::over(cells, is_known)
    }

    /// The typical light, to the right, to the left and below, of a source with a peak of 1000.
    fn light<L: Level>(count: usize) -> [f32; 3] {
        let (plane, regions) = sources::<L>(count);
        let field = Field { values: &plane, grid: Grid::of(plane.len(), WIDTH).expect("there are columns") };
        let [mut cells, mut spare] = [(); 2].map(|()| vec![0; plane.len()]);
        let typical = typical(field, &regions, &mut cells, &mut spare);
        let centre = (L::of(100.0), L::of(100.0));
        let places = [(103.0, 100.0), (97.0, 100.0), (100.0, 105.0)];
        places.map(|(x, y)| typical.light(L::of(1000.0), centre, (L::of(x), L::of(y))).to_f32())
    }

    #[test]
    fn what_all_sources_have_is_typical_and_companions_are_not() {
        for [right, left, below] in [light::<f32>(LEAST), light::<Fixed14>(LEAST)] {
            assert!((right - 1000.0 * 0.2 * MARGIN).abs() < 0.1, "{right}");
            assert_eq!([left, below], [0.0; 2]);
        }
    }

    #[test]
    fn a_few_sources_have_no_typical_one() {
        assert_eq!(light::<f32>(LEAST - 1), [0.0; 3]);
    }

    #[test]
    fn far_away_and_on_small_frames_there_is_none() {
        let (plane, regions) = sources::<f32>(LEAST);
        let field = Field { values: &plane, grid: Grid::of(plane.len(), WIDTH).expect("there are columns") };
        let (mut cells, mut spare) = (vec![0; plane.len()], vec![0; plane.len()]);
        let known = typical(field, &regions, &mut cells, &mut spare);
        let right = |off: f32| known.light(1000.0, (100.0, 100.0), (100.0 + off, 100.0));
        assert!(right(0.0) > 1000.0 && right(2.6) > 0.0 && right(3.4) > 0.0);
        assert_eq!([right(2.4), right(3.6), right(24.6), right(-24.6)], [0.0; 4]);
        let none = typical(field, &regions, &mut cells[..SIDE * SIDE - 1], &mut spare);
        assert_eq!(none.light(1000.0, (100.0, 100.0), (103.0, 100.0)), 0.0);
    }

    #[test]
    fn a_quarter_of_the_sources_have_less_light() {
        assert_eq!(quartile([7.0, 3.0, 5.0, 1.0, 6.0, 2.0, 8.0, 4.0].into_iter()), 3.0);
        assert_eq!(quartile([9.0, 2.0, 5.0].into_iter()), 2.0);
        assert_eq!(quartile(core::iter::empty()), 0.0);
    }
}
