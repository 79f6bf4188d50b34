//! The frame's typical source: how the light of a point is spread by these optics, as far as the
//! frame's bright sources show it. What they all have, a coma, a trail, a ring, rays, is no source.
//!
//! Around each of the brightest sources the light is taken at the same distances from the centre,
//! as a part of that at the peak; of all sources the lower quartile is kept, in which neither
//! neighbours nor wide sources have a share.

use crate::arithmetic::{Level, Real};
use crate::sort;
use crate::tree::{Field, Region};

/// The farthest distance along an axis, pixels.
const RADIUS: usize = 24;
/// Cells along an axis.
const SIDE: usize = 2 * RADIUS + 1;
/// The most sources that are looked at.
const MOST: usize = 64;
/// With fewer, there is no typical one.
const LEAST: usize = 16;
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
    /// Looks at the sources of a frame. `cells` and `spare` are as long as the plane; where that is
    /// too short there is no typical source. Cost: 154 thousand samples.
    pub fn of<L: Level>(
        field: Field<'_, L>,
        noise: L,
        regions: &[Region<L>],
        (cells, spare): (&'m mut [u32], &mut [u32]),
    ) -> Typical<'m> {
        let bright = noise.scaled(L::Weight::of(BRIGHT));
        let mut count = 0;
        let stands = |region: &Region<L>| region.area > 0 && region.plateau <= 0.0 && region.value > bright;
        for (id, _) in (0..).zip(regions).filter(|(_, region)| stands(region)) {
            if let Some(place) = cells.get_mut(count) {
                *place = id;
                count += 1;
            }
        }
        let ids = cells.get_mut(..count).unwrap_or(&mut []);
        let region = |id: u32| regions.get(id as usize);
        sort::by_key(ids, spare, |id| !region(id).map_or(L::ZERO, |region| region.value).key());
        let mut chosen = [0; MOST];
        let count = count.min(MOST);
        chosen.iter_mut().zip(ids.iter()).for_each(|(chosen, id)| *chosen = *id);
        let chosen = chosen.get(..count).unwrap_or(&[]);
        let Some(cells) = cells.get_mut(..SIDE * SIDE).filter(|_| count >= LEAST) else {
            return Typical { cells: &[] };
        };
        for (at, cell) in cells.iter_mut().enumerate() {
            let off = |cell: usize| L::whole(cell) - L::whole(RADIUS);
            let (x, y) = (off(at % SIDE), off(at / SIDE));
            let light = |id: &u32| {
                let region = region(*id)?;
                let light = field.between((region.centre.0 + x, region.centre.1 + y))?;
                Some(light.to_f32() / region.value.to_f32())
            };
            *cell = quartile(chosen.iter().filter_map(light)).to_bits();
        }
        Typical { cells }
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
    let (mut sorted, mut count) = ([0.0; MOST], 0);
    for (place, value) in sorted.iter_mut().zip(values) {
        *place = value;
        count += 1;
    }
    let sorted = sorted.get_mut(..count).unwrap_or(&mut []);
    sort::few(sorted, |a, b| a < b);
    sorted.get(count / 4).copied().unwrap_or(0.0)
}
