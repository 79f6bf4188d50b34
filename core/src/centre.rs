//! Where the centres of sources are: at the peak, or in a flat source in the middle of its light;
//! and which sources end in a plateau, as saturated stars do.

use crate::arithmetic::{Level, Real};
use crate::detection::grown;
use crate::tree::{Field, Region};

/// A source is wide when so many of its pixels are above half its peak: a disc of eight pixels.
const WIDE: u32 = 50;
/// A pixel with this part of its source's peak is of the plateau, if there is one.
const LEVEL: f32 = 0.97;
/// Pixels of a plateau, at least.
const LEAST: u32 = 5;
/// A plateau has one of so many pixels above half the peak, or more; a Gaussian has one of 23 there.
const STEEP: u32 = 8;

/// Centres flat sources on their pixels above half the peak, for in these the brightest pixel is where
/// the noise puts it; in a narrow one it is not, and neighbours would draw the centre away. Marks
/// those whose top is level and its rim steep (see [`Region::plateau`]).
///
/// `light` is lightly smoothed and not sharpened, because that overshoots at a rim; `noise` is its
/// noise, which grows with the photon noise `photon`.
pub fn centre_on_light<L: Level>(
    light: Field<'_, L>,
    labels: &[u32],
    regions: &mut [Region<L>],
    (noise, photon): (L, f32),
) {
    for region in regions.iter_mut() {
        (region.area, region.plateau, region.offsets) = (0, 0, (0, 0));
    }
    let [half, level] = [0.5, LEVEL].map(L::Weight::of);
    for (at, &label) in labels.iter().enumerate() {
        let Some(region) = regions.get_mut((label as usize).wrapping_sub(1)) else { continue };
        let (own, top) = (light.at(at), light.at(region.peak as usize));
        if own > top.scaled(half) {
            let ((x, y), (peak_x, peak_y)) = (light.grid.place(at), light.grid.place(region.peak as usize));
            let (sum_x, sum_y) = region.offsets;
            let add = |sum: i32, place: usize, peak: usize| sum.saturating_add(place as i32 - peak as i32);
            region.offsets = (add(sum_x, x, peak_x), add(sum_y, y, peak_y));
            region.area += 1;
            region.plateau += u32::from(own > top.scaled(level));
        }
    }
    for region in regions.iter_mut() {
        let top = light.at(region.peak as usize);
        let seen = top - top.scaled(level) > noise * grown(photon, top);
        if !seen || region.plateau < LEAST || region.plateau.saturating_mul(STEEP) < region.area {
            region.plateau = 0;
        }
        if region.area > WIDE || region.plateau > 0 {
            region.centre = middle(light, region);
        }
    }
}

/// The mean place of the pixels of a region that were counted.
fn middle<L: Level>(light: Field<'_, L>, region: &Region<L>) -> (L, L) {
    let (x, y) = light.grid.place(region.peak as usize);
    let along = |peak: usize, sum: i32| L::of(peak as f32 + sum as f32 / region.area.max(1) as f32);
    let (sum_x, sum_y) = region.offsets;
    (along(x, sum_x), along(y, sum_y))
}
