//! Where the centres of sources are: at the peak, or in a flat source in the middle of its light;
//! which sources end in a plateau, as saturated stars do; and the shapes of sources.

use crate::arithmetic::{Level, Real};
use crate::plane::crew::Crew;
use crate::plane::field::{Field, offset};
use crate::plane::grid::Grid;
use crate::plane::rows::runs;
use crate::plane::walk::Walk;
use crate::sources::tree::{Noise, Region};
use core::ops::Range;

/// A source is wide when so many of its pixels are above half its peak: a disc of eight pixels.
const WIDE: u32 = 50;
/// A source of at least so many pixels there may be flat without being wide: a trailed star is.
const FLAT_AREA: u32 = 20;
/// It is, where the middle of these pixels and the place opposite its peak have this part of the
/// peak; between two equal stars at one and a half of their widths is less.
const FLAT: f32 = 0.85;
/// A pixel with this part of its source's peak is of the plateau, if there is one.
const LEVEL: f32 = 0.97;
/// Pixels of a plateau, at least.
const LEAST: f32 = 5.0;
/// Of the pixels above half the peak a plateau has this part or more; of a Gaussian 0.044 are so high.
const SHARE: f32 = 0.125;

/// Centres wide and flat sources on their pixels above half the peak, for in these the brightest pixel
/// is where the noise puts it; in a narrow one it is not, and neighbours would draw the centre away.
/// Marks those whose top is level and its rim steep (see [`Region::plateau`]).
///
/// `field` is the plane that was divided. `light` is not sharpened, because that overshoots at a rim;
/// `noise` is its noise.
pub(crate) fn centre_on_light<L: Level>(
    (walk, crew): (&mut Walk, &impl Crew),
    [field, light]: [Field<'_, L>; 2],
    labels: &[u32],
    regions: &mut [Region<L>],
    noise: Noise<L>,
) -> Option<()> {
    walk.pass(regions.len(), 1, |part| {
        for region in some_of(regions, part) {
            (region.area, region.plateau, region.offsets, region.label) = (0, 0.0, (0.0, 0.0), 0);
        }
    })?;
    let (half, level) = (L::Weight::of(0.5), L::Weight::of(LEVEL));
    each_pixel((walk, crew), (field.grid, labels), regions, |region, at, place| {
        let peak = region.peak as usize;
        if field.at(at) > field.at(peak).scaled(half) {
            add(field, region, at, place);
        }
        region.label += u32::from(light.at(at) > light.at(peak).scaled(level));
    })?;
    walk.pass(regions.len(), 10, |part| {
        for region in some_of(regions, part) {
            if region.plateau > 0.0 {
                let middle = middle(field, region);
                if is_wide(region) || (region.area > FLAT_AREA && is_flat(light, region, middle)) {
                    region.centre = middle;
                }
            }
            (region.plateau, region.label) = (plateau(light, region, noise), 0);
        }
    })
}

/// Whether a source that has been centred is wide.
pub(crate) fn is_wide<L: Level>(region: &Region<L>) -> bool {
    region.area > WIDE
}

fn some_of<L: Level>(regions: &mut [Region<L>], part: Range<usize>) -> &mut [Region<L>] {
    regions.get_mut(part).unwrap_or(&mut [])
}

/// Takes every pixel of a region to it, by index and by column and row, in the order of the frame; each hand has a group
/// of regions, and looks at all labels.
pub(crate) fn each_pixel<L: Level>(
    (walk, crew): (&mut Walk, &impl Crew),
    (grid, labels): (Grid, &[u32]),
    regions: &mut [Region<L>],
    take: impl Fn(&mut Region<L>, usize, (usize, usize)) + Sync,
) -> Option<()> {
    let (size, width) = (regions.len().div_ceil(crew.hands().max(1)).max(1), grid.width.get());
    walk.pass(labels.len(), 1, |part| {
        crew.each((1..).step_by(size).zip(regions.chunks_mut(size)), |(first, regions): (usize, _)| {
            for y in part.start / grid.width..part.end.div_ceil(width) {
                let (left, start) = (y * width, part.start.max(y * width));
                let row = labels.get(start..part.end.min(left + width)).unwrap_or(&[]);
                for (x, end, label) in runs(row) {
                    let Some(region) = regions.get_mut((label as usize).wrapping_sub(first)) else { continue };
                    // A copy, whose sums need not go through memory from pixel to pixel.
                    let mut own = *region;
                    (start + x..start + end).for_each(|at| take(&mut own, at, (at - left, y)));
                    *region = own;
                }
            }
        });
    })
}

/// Adds a pixel to those above half the peak.
fn add<L: Level>(field: Field<'_, L>, region: &mut Region<L>, at: usize, (x, y): (usize, usize)) {
    let distance = |place: usize, peak: usize| place as f32 - peak as f32;
    let (peak_x, peak_y) = field.grid.place(region.peak as usize);
    let value = field.at(at).to_f32();
    region.area += 1;
    region.plateau += value;
    region.offsets.0 += value * distance(x, peak_x);
    region.offsets.1 += value * distance(y, peak_y);
}

/// Measures the shape of every source: the second moments of its light around its centre. `field` is the plane that was
/// divided; `area` does not outlast it.
pub(crate) fn shape<L: Level>(
    (walk, crew): (&mut Walk, &impl Crew),
    field: Field<'_, L>,
    labels: &[u32],
    regions: &mut [Region<L>],
) -> Option<()> {
    walk.pass(regions.len(), 1, |part| {
        for region in some_of(regions, part) {
            (region.area, region.plateau, region.offsets) = (region.plateau as u32, 0.0, (0.0, 0.0));
        }
    })?;
    each_pixel((walk, crew), (field.grid, labels), regions, |region, at, (column, row)| {
        let (place, centre) = ((L::whole(column), L::whole(row)), region.centre);
        let (x, y) = ((place.0 - centre.0).to_f32(), (place.1 - centre.1).to_f32());
        // As a part of the peak's: however bright, the sums stay finite.
        let light = field.at(at).positive().to_f32().ratio(field.at(region.peak as usize).to_f32());
        region.plateau += light * (x * x + y * y);
        region.offsets.0 += light * (x * x - y * y);
        region.offsets.1 += light * (x * y);
    })?;
    walk.pass(regions.len(), 1, |part| {
        for region in some_of(regions, part) {
            let part = |sum: f32| if region.plateau > 0.0 { sum / region.plateau } else { 0.0 };
            region.offsets = (part(region.offsets.0), part(2.0 * region.offsets.1));
            region.plateau = region.area as f32;
        }
    })
}

/// Pixels of the plateau that a region ends in; `area` is that above half the peak, `label` that near it.
fn plateau<L: Level>(light: Field<'_, L>, region: &Region<L>, noise: Noise<L>) -> f32 {
    let (top, count) = (light.at(region.peak as usize), region.label as f32);
    let seen = top - top.scaled(L::Weight::of(LEVEL)) > noise.at(top);
    if !seen || count < LEAST || count < SHARE * region.area as f32 { 0.0 } else { count }
}

/// Whether a region has nearly the light of its peak in its middle and opposite its peak.
fn is_flat<L: Level>(light: Field<'_, L>, region: &Region<L>, middle: (L, L)) -> bool {
    let peak = region.peak as usize;
    let least = light.at(peak).scaled(L::Weight::of(FLAT));
    [light.between(middle), light.mirrored(middle, peak)].into_iter().flatten().filter(|&light| light > least).count()
        == 2
}

/// The middle of the light that was added to a region.
fn middle<L: Level>(field: Field<'_, L>, region: &Region<L>) -> (L, L) {
    let (x, y) = field.grid.place(region.peak as usize);
    let along = |peak: usize, sum: f32| L::whole(peak) + offset(sum / region.plateau);
    (along(x, region.offsets.0), along(y, region.offsets.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::Fixed14;
    use crate::plane::crew::Alone;
    use crate::plane::field::Ellipse;

    extern crate std;

    /// A Gaussian with variances of 16 and 4 along its axes, the longer towards (4, 3), has these moments.
    fn moments<L: Level>() -> (Region<L>, Ellipse<L>) {
        let light = |at: usize| {
            let (x, y) = ((at % 49) as f32 - 24.0, (at / 49) as f32 - 24.0);
            let (along, across) = (0.8 * x + 0.6 * y, 0.8 * y - 0.6 * x);
            L::of(3000.0 * libm::expf(-0.5 * (along * along / 16.0 + across * across / 4.0)))
        };
        let values: std::vec::Vec<L> = (0..49 * 49).map(light).collect();
        let labels: std::vec::Vec<u32> = values.iter().map(|&value| u32::from(value > L::ONE)).collect();
        let centre = (L::whole(24), L::whole(24));
        let mut regions = [Region { peak: 24 * 49 + 24, plateau: 7.0, centre, ..Region::BLANK }];
        let field = Field { values: &values, grid: Grid::of(values.len(), 49).expect("there are columns") };
        let _ = shape((&mut Walk::whole(), &Alone), field, &labels, &mut regions);
        let [region] = regions;
        assert_eq!(region.shape(), Some(Ellipse::ROUND), "a saturated star is round");
        (region, Region { plateau: 0.0, ..region }.shape().expect("it is no needle"))
    }

    #[test]
    fn the_shape_is_that_of_the_light() {
        let (single, fixed) = (moments::<f32>(), moments::<Fixed14>());
        for (offsets, plateau) in [(single.0.offsets, single.0.plateau), (fixed.0.offsets, fixed.0.plateau)] {
            let (along, across) = (offsets.0 - 0.6 * 0.28, offsets.1 - 0.6 * 0.96);
            assert!(along.abs() < 0.005 && across.abs() < 0.005, "{offsets:?}");
            assert_eq!(plateau, 7.0, "it outlasts the measurement");
        }
        assert_ne!(single.1, Ellipse::ROUND);
    }

    #[test]
    fn without_light_a_source_is_round() {
        let values = [-1.0; 25];
        let field = Field { values: &values, grid: Grid::of(25, 5).expect("there are columns") };
        let mut regions = [Region::<f32>::BLANK];
        let _ = shape((&mut Walk::whole(), &Alone), field, &[1; 25], &mut regions);
        assert_eq!(regions.map(|region| region.shape()), [Some(Ellipse::ROUND)]);
    }

    const SIDE: usize = 41;
    const PEAK: usize = 20 * SIDE + 22;

    /// The centre of a source around (20, 20) whose brightest pixel is two columns beside that, alone.
    fn centre(scale: f32) -> (f32, f32) {
        let mut light = [0.0f32; SIDE * SIDE];
        for (at, value) in light.iter_mut().enumerate() {
            let (x, y) = ((at % SIDE) as f32 - 20.0, (at / SIDE) as f32 - 20.0);
            *value = 100.0 * libm::expf(-0.5 * (x * x + y * y) / (scale * scale));
        }
        light[PEAK] = 130.0;
        let field = Field { values: &light, grid: Grid::of(light.len(), SIDE).expect("there are columns") };
        let mut regions = [Region { peak: PEAK as u32, value: 130.0, centre: (22.0, 20.0), ..Region::BLANK }];
        let noise = Noise { least: 1.0, photon: 0.0 };
        let _ = centre_on_light((&mut Walk::whole(), &Alone), [field, field], &[1; SIDE * SIDE], &mut regions, noise);
        let [region] = regions;
        region.centre
    }

    #[test]
    fn a_wide_source_is_centred_on_its_light_and_a_narrow_one_on_its_peak() {
        let (x, y) = centre(6.0);
        assert!((x - 20.0).abs() < 0.05 && (y - 20.0).abs() < 0.05, "{x}, {y}");
        assert_eq!(centre(3.0), (22.0, 20.0));
    }

    /// Whether a source with so many pixels at its top and so many others above half of it ends in a plateau.
    fn is_plateau(level: usize, others: usize, noise: f32) -> bool {
        let mut light = [0.0f32; SIDE * SIDE];
        light.iter_mut().take(level + others).for_each(|value| *value = 600.0);
        light.iter_mut().take(level).for_each(|value| *value = 1000.0);
        let field = Field { values: &light, grid: Grid::of(light.len(), SIDE).expect("there are columns") };
        let mut regions = [Region { value: 1000.0, ..Region::BLANK }];
        let noise = Noise { least: noise, photon: 0.0 };
        let _ = centre_on_light((&mut Walk::whole(), &Alone), [field, field], &[1; SIDE * SIDE], &mut regions, noise);
        let [region] = regions;
        region.plateau > 0.0
    }

    #[test]
    fn a_plateau_is_an_eighth_of_a_source_five_pixels_and_above_the_noise() {
        assert!(is_plateau(5, 35, 29.0) && is_plateau(10, 0, 1.0));
        assert!(!is_plateau(5, 36, 1.0) && !is_plateau(4, 0, 1.0) && !is_plateau(5, 35, 31.0));
    }

    #[test]
    fn a_flat_source_has_more_than_a_limit_of_its_peak_s_light_in_its_middle() {
        let is_flat_with = |others: f32| {
            let mut light = [others; SIDE * SIDE];
            light[PEAK] = 100.0;
            let field = Field { values: &light, grid: Grid::of(light.len(), SIDE).expect("there are columns") };
            is_flat(field, &Region { peak: PEAK as u32, ..Region::BLANK }, (20.0, 20.0))
        };
        assert!(!is_flat_with(FLAT * 100.0) && is_flat_with(FLAT * 100.0 + 0.01));
    }
}
