//! A galaxy with knots is one source.
//!
//! Clusters and regions of star formation shine through a galaxy's light as sharp as stars, with peaks of their own. One
//! may as well lie before it or behind it; where there are several, they are the galaxy's.

use crate::arithmetic::{Level, Real};
use crate::plane::crew::Crew;
use crate::plane::field::Field;
use crate::plane::rows::{next_with, row_of, runs};
use crate::plane::walk::Walk;
use crate::sources::centre::each_pixel;
use crate::sources::deblend::region_of;
use crate::sources::pieces::index;
use crate::sources::tree::Region;

/// A galaxy has the light of more than so many pixels like its brightest.
const EXTENDED: f32 = 50.0;
/// But of fewer than this part of its area: a cloud, with stars before it, is nearly as bright everywhere.
const CONCENTRATED: f32 = 0.05;
/// The middle of its light is nearer to its peak than this part of the root of its area.
const MIDDLE: f32 = 0.1;
/// A knot has the light of fewer pixels like its brightest.
const SHARP: f32 = 25.0;
/// A knot has more than the first and less than the second part of its galaxy's light.
const SHARE: (f32, f32) = (0.001, 0.007);
/// In place of the number of its knots: no galaxy.
const NO_GALAXY: u32 = u32::MAX;

/// Gives each galaxy the knots that touch it, if they are `least` or more; with 0 none. Of the regions `label`, `area`,
/// `sum` and `offsets` do not outlast it. Cost: three looks at each pixel.
pub(crate) fn join<L: Level>(
    (walk, crew): (&mut Walk, &impl Crew),
    least: u32,
    field: Field<'_, L>,
    labels: &mut [u32],
    regions: &mut [Region<L>],
) -> Option<()> {
    if least == 0 {
        return Some(());
    }
    let (width, count) = (field.grid.width.get(), regions.len());
    walk.pass(count, 1, |part| {
        for region in regions.get_mut(part).unwrap_or(&mut []) {
            (region.label, region.area, region.sum, region.offsets) = (0, 0, L::NOTHING, (0.0, 0.0));
        }
    })?;
    each_pixel((walk, crew), (field.grid, labels), regions, |region, at, (column, row)| {
        let (peak_x, peak_y) = field.grid.place(region.peak as usize);
        let light = field.at(at).positive();
        let part = light.to_f32().ratio(field.at(region.peak as usize).to_f32());
        (region.area, region.sum) = (region.area + 1, region.sum + light.times(1));
        region.offsets.0 += part * (column as f32 - peak_x as f32);
        region.offsets.1 += part * (row as f32 - peak_y as f32);
    })?;
    walk.pass(count, 1, |part| {
        for region in regions.get_mut(part).unwrap_or(&mut []) {
            region.area = if is_galaxy(field, region) { 0 } else { NO_GALAXY };
        }
    })?;
    walk.pass(field.grid.height, width, |rows| rows.for_each(|y| meet(y, width, labels, regions)))?;
    walk.pass(count, 1, |part| {
        for place in part {
            let galaxy = galaxy_of(field, regions, place).unwrap_or(0);
            if let Some(galaxy) = regions.get_mut(index(galaxy)) {
                galaxy.area += 1;
            }
            if let Some(region) = regions.get_mut(place) {
                region.label = galaxy;
            }
        }
    })?;
    walk.tally(count, 1, |tally, part| {
        tally.count = if part.start == 0 { 0 } else { tally.count };
        for place in part {
            let galaxy = regions.get(place).and_then(|region| region_of(regions, region.label));
            if galaxy.is_some_and(|galaxy| galaxy.area >= least) {
                tally.count += 1;
            } else if let Some(region) = regions.get_mut(place) {
                region.label = place as u32 + 1;
            }
        }
    })?;
    walk.pass(if walk.tally.count > 0 { labels.len() } else { 0 }, 1, |part| {
        let mut next = part.start;
        while let Some(at) = next_with(labels.get(..part.end).unwrap_or(&[]), next, u32::MAX) {
            next = at + 1;
            if let Some(label) = labels.get_mut(at) {
                *label = region_of(regions, *label).map_or(0, |region| region.label);
            }
        }
    })
}

/// The light of a region in that of its brightest pixel.
fn extent<L: Level>(field: Field<'_, L>, region: &Region<L>) -> f32 {
    L::sum_to_f32(region.sum).ratio(field.at(region.peak as usize).to_f32())
}

/// Whether a region whose light is summed up is a galaxy.
fn is_galaxy<L: Level>(field: Field<'_, L>, region: &Region<L>) -> bool {
    let (extent, area, (x, y)) = (extent(field, region), region.area as f32, region.offsets);
    let radius = MIDDLE * extent;
    extent > EXTENDED && extent < CONCENTRATED * area && x * x + y * y < radius * radius * area
}

/// Lets sources that touch along an edge, within a row or between it and the next, know of each other.
fn meet<L: Level>(y: usize, width: usize, labels: &[u32], regions: &mut [Region<L>]) {
    let (row, above) = (row_of(labels, width, y), row_of(labels, width, y + 1));
    let mut met = [0; 2];
    for (first, end, own) in runs(row) {
        let last = end.saturating_sub(1);
        let near = above.get(first..last).unwrap_or(&[]).iter().chain(row.get(end)).chain(above.get(last));
        for &near in near {
            if near != 0 && near != own && met != [own, near] {
                met = [own, near];
                remember(regions, own, near);
                remember(regions, near, own);
            }
        }
    }
}

/// A source keeps the label of the brightest other that it has met, of equals the first.
fn remember<L: Level>(regions: &mut [Region<L>], own: u32, other: u32) {
    let light_of = |label: u32| region_of(regions, label).map(|region| region.sum);
    let known = region_of(regions, own).and_then(|own| light_of(own.label));
    if known.is_none_or(|known| light_of(other).is_some_and(|other| other > known))
        && let Some(own) = regions.get_mut(index(own))
    {
        own.label = other;
    }
}

/// The label of the galaxy of which a region is a knot.
fn galaxy_of<L: Level>(field: Field<'_, L>, regions: &[Region<L>], index: usize) -> Option<u32> {
    let region = regions.get(index)?;
    let galaxy = region_of(regions, region.label).filter(|galaxy| galaxy.area != NO_GALAXY)?;
    let [least, most] = [SHARE.0, SHARE.1].map(|part| L::share(galaxy.sum, part));
    (region.sum > least && region.sum < most && extent(field, region) < SHARP).then_some(region.label)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::Fixed14;
    use crate::plane::crew::Alone;
    use crate::plane::grid::Grid;

    extern crate std;
    use std::vec::Vec;

    const SIDE: usize = 64;
    /// What has less light is in no source.
    const FAINT: f32 = 0.2;
    const KNOTS: [(f32, f32); 3] = [(54.0, 32.0), (21.0, 51.0), (21.0, 13.0)];

    type Light = fn(f32) -> f32;

    fn galaxy(far: f32) -> f32 {
        200.0 * libm::expf(-far / 4.0)
    }

    fn knot(off: f32) -> f32 {
        libm::expf(-off * off / 2.0)
    }

    /// How many of three knots, of so much light at the peak and so wide (1: nine pixels), are joined to a host of that
    /// light by distance from the middle of the frame, of which a peak that many columns to the right is known.
    fn joined<L: Level>(host: Light, right: usize, (peak, width): (f32, f32), least: u32, cells: usize) -> usize {
        let place = |at: usize| ((at % SIDE) as f32, (at / SIDE) as f32);
        let near = |at: usize| KNOTS.map(|(x, y)| libm::hypotf(place(at).0 - x, place(at).1 - y));
        let light = |at: usize| {
            let far = libm::hypotf(place(at).0 - 32.0, place(at).1 - 32.0);
            host(far) + near(at).map(|off| peak * knot(off / width)).iter().sum::<f32>()
        };
        let mut values: Vec<L> = (0..SIDE * SIDE).map(|at| L::of(light(at))).collect();
        values[32 * SIDE + 32 + right] = values[32 * SIDE + 32];
        let label = |at: usize| match near(at).iter().position(|&off| off < 2.0 * width) {
            Some(knot) => knot as u32 + 2,
            None => u32::from(light(at) > FAINT),
        };
        let mut labels: Vec<u32> = (0..SIDE * SIDE).map(label).collect();
        let before = labels.clone();
        let mut regions = [Region::<L>::BLANK; 4];
        regions[0].peak = (32 * SIDE + 32 + right) as u32;
        for (region, (x, y)) in regions[1..].iter_mut().zip(KNOTS) {
            region.peak = (y as usize * SIDE + x as usize) as u32;
        }
        let field = Field { values: &values, grid: Grid::of(values.len(), SIDE).expect("there are columns") };
        let mut walk = Walk::whole();
        walk.resume(cells);
        while join((&mut walk, &Alone), least, field, &mut labels, &mut regions).is_none() {
            walk.resume(cells);
        }
        let all = |own: u32, now: u32| {
            labels.iter().zip(&before).filter(|&(_, &label)| label == own).all(|(&label, _)| label == now)
        };
        assert!(all(0, 0) && all(1, 1));
        (2..5).filter(|&knot| all(knot, 1) || !all(knot, knot)).count()
    }

    fn both(host: Light, right: usize, peak: f32, least: u32) -> usize {
        wide(host, right, (peak, 1.0), least)
    }

    fn wide(host: Light, right: usize, peak: (f32, f32), least: u32) -> usize {
        let found = joined::<f32>(host, right, peak, least, usize::MAX);
        assert_eq!(joined::<Fixed14>(host, right, peak, least, usize::MAX), found);
        assert_eq!(joined::<f32>(host, right, peak, least, 1), found);
        found
    }

    #[test]
    fn a_galaxy_has_its_knots_where_they_are_enough() {
        assert_eq!([0, 1, 2, 3, 4].map(|least| both(galaxy, 0, 10.0, least)), [0, 3, 3, 3, 0]);
    }

    #[test]
    fn what_is_too_faint_or_too_bright_is_no_knot() {
        // The galaxy has 20 000, a knot 4.9 times its peak and 7.
        assert_eq!([1.0, 3.5, 26.0, 29.0].map(|peak| both(galaxy, 0, peak, 3)), [0, 3, 3, 0]);
    }

    #[test]
    fn of_several_neighbours_the_brightest_is_known() {
        for labels in [[2, 1, 3], [3, 1, 2]] {
            let mut regions = [5.0, 7.0, 9.0].map(|sum| Region::<f32> { sum, ..Region::BLANK });
            meet(0, 3, &labels, &mut regions);
            assert_eq!(regions.map(|region| region.label), [3, 1, 1]);
        }
    }

    #[test]
    fn what_is_as_wide_as_a_galaxy_is_no_knot() {
        // Extents of 20 and 27 pixels.
        assert_eq!([1.7, 2.0].map(|width| wide(galaxy, 0, (3.0, width), 3)), [3, 0]);
    }

    #[test]
    fn a_cloud_and_a_star_have_none() {
        let cloud: Light = |far| if far < 26.0 { 20.0 - 0.4 * far } else { 0.0 };
        assert_eq!(both(cloud, 0, 5.0, 3), 0);
        let star: Light = |far| 5000.0 * libm::expf(-far * far / 2.0) + 2.0 * libm::expf(-far / 8.0);
        assert_eq!(both(star, 0, 30.0, 3), 0);
        assert_eq!([3, 5].map(|right| both(galaxy, right, 10.0, 3)), [3, 0], "its light has no middle there");
    }
}
