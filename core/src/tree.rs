//! The tree of level sets: pixels from the brightest down, regions that grow, and where two of
//! them meet the question whether the fainter is a source of its own.
//!
//! After Bijaoui and others; the test of significance follows the idea of MTObjects (Teeninga et
//! al. 2016, doi:10.1515/mathm-2016-0006), the mirror that of the SDSS deblender (Lupton 2001).

use crate::detection::Detection;
use crate::grid::Grid;
use crate::sort;

/// A region of the tree, in the end a source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Index of its brightest pixel.
    pub peak: u32,
    /// Value there.
    pub value: f32,
    /// Number of pixels.
    pub area: u32,
    /// Sum of its values.
    pub sum: f64,
    /// Its centre, (x, y), to a fraction of a pixel.
    pub centre: (f32, f32),
    /// Of its pixels above half its peak: how many, the sum of the values, and of the values times
    /// the distances from the peak along x and y.
    pub core: (u32, f32, f32, f32),
    /// The label it ends with.
    pub label: u32,
}

impl Region {
    /// All bits 0: static memory full of it takes no room in a program's image.
    pub const BLANK: Region =
        Region { peak: 0, value: 0.0, area: 0, sum: 0.0, centre: (0.0, 0.0), core: (0, 0.0, 0.0, 0.0), label: 0 };
}

/// Parent of a pixel that is in no region.
pub const NONE: u32 = u32::MAX;

/// A plane that is read at any place.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    /// Values, row-major.
    pub values: &'a [f32],
    /// Its shape.
    pub grid: Grid,
}

impl Field<'_> {
    /// The value at an index; 0 beyond the plane.
    pub fn at(&self, index: usize) -> f32 {
        self.values.get(index).copied().unwrap_or(0.0)
    }

    /// The vertex of the parabolas through a peak and its neighbours.
    pub fn centre(&self, peak: usize) -> (f32, f32) {
        let (Grid { width, height }, (x, y)) = (self.grid, self.grid.place(peak));
        let vertex = |before: f32, after: f32| {
            let bend = before - 2.0 * self.at(peak) + after;
            if bend < -1e-6 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 }
        };
        let inner = |at: usize, length: usize| at > 0 && at + 1 < length;
        let dx = if inner(x, width.get()) { vertex(self.at(peak - 1), self.at(peak + 1)) } else { 0.0 };
        let (below, above) = (peak.wrapping_sub(width.get()), peak + width.get());
        let dy = if inner(y, height) { vertex(self.at(below), self.at(above)) } else { 0.0 };
        (x as f32 + dx, y as f32 + dy)
    }

    /// The value across a centre, bilinear, not below 0: what a symmetric source has at `index`.
    /// `None` where that is beyond the frame.
    pub fn mirrored(&self, centre: (f32, f32), index: usize) -> Option<f32> {
        let (width, (x, y)) = (self.grid.width.get(), self.grid.place(index));
        let (x, y) = (2.0 * centre.0 - x as f32, 2.0 * centre.1 - y as f32);
        let (last_x, last_y) = (width.checked_sub(2)?, self.grid.height.checked_sub(2)?);
        if x < 0.0 || y < 0.0 || x > (last_x + 1) as f32 || y > (last_y + 1) as f32 {
            return None;
        }
        let (left, below) = ((x as usize).min(last_x), (y as usize).min(last_y));
        let (part_x, part_y) = (x - left as f32, y - below as f32);
        let first = below * width + left;
        let row = |first: usize| self.at(first) * (1.0 - part_x) + self.at(first + 1) * part_x;
        let value = row(first) * (1.0 - part_y) + row(first + width) * part_y;
        Some(if value > 0.0 { value } else { 0.0 })
    }
}

/// The root of a pixel's region; paths are halved on the way.
pub fn root(parents: &mut [u32], mut at: u32) -> u32 {
    let parent = |parents: &[u32], at: u32| parents.get(at as usize).copied().unwrap_or(at);
    while parent(parents, at) != at {
        let grand = parent(parents, parent(parents, at));
        if let Some(cell) = parents.get_mut(at as usize) {
            *cell = grand;
        }
        at = grand;
    }
    at
}

/// Grows the regions of `order`, the pixels in use from the brightest down. `parents` holds
/// [`NONE`] everywhere; `ids` gets the region of each root; `photon` is the photon noise. Gives the
/// number of regions, and of peaks for which none was free: they stay out.
pub fn grow(
    field: Field<'_>,
    order: &[u32],
    parents: &mut [u32],
    ids: &mut [u32],
    regions: &mut [Region],
    (setting, photon): (&Detection, f32),
) -> (usize, u32) {
    let (mut count, mut left_out) = (0, 0);
    for &pixel in order {
        let at = pixel as usize;
        let value = field.at(at);
        let (mut roots, mut found, mut nearest) = ([NONE; 8], 0, (f32::NEG_INFINITY, NONE));
        for near in field.grid.neighbours(at) {
            if parents.get(near).is_none_or(|&parent| parent == NONE) {
                continue;
            }
            let root = root(parents, near as u32);
            if field.at(near) > nearest.0 {
                nearest = (field.at(near), root);
            }
            if !roots.contains(&root)
                && let Some(free) = roots.get_mut(found)
            {
                *free = root;
                found += 1;
            }
        }
        let id = |ids: &[u32], root: u32| ids.get(root as usize).map_or(usize::MAX, |&id| id as usize);
        if found == 0 {
            let Some(region) = regions.get_mut(count) else {
                left_out += 1;
                continue;
            };
            *region = Region { peak: pixel, value, area: 1, sum: f64::from(value), ..Region::BLANK };
            if let (Some(parent), Some(id)) = (parents.get_mut(at), ids.get_mut(at)) {
                (*parent, *id) = (pixel, count as u32);
            }
            count += 1;
            continue;
        }
        let brightness = |root: u32| regions.get(id(ids, root)).map_or(0.0, |region| region.value);
        let roots = roots.get_mut(..found).unwrap_or(&mut []);
        let key = |root: u32| (!sort::key(brightness(root)), root);
        sort::few(roots, |a, b| key(a) < key(b));
        let Some((&host, others)) = roots.split_first() else { continue };
        for &other in others {
            let (host_id, other_id) = (id(ids, host), id(ids, other));
            let (Some(&bright), Some(&faint)) = (regions.get(host_id), regions.get(other_id)) else { continue };
            if setting.stands_apart(field, [&bright, &faint], value, photon) {
                continue;
            }
            if let Some(parent) = parents.get_mut(other as usize) {
                *parent = host;
            }
            if let Some(region) = regions.get_mut(host_id) {
                region.area += faint.area;
                region.sum += faint.sum;
            }
            if let Some(region) = regions.get_mut(other_id) {
                region.area = 0;
            }
            if nearest.1 == other {
                nearest.1 = host;
            }
        }
        if let Some(parent) = parents.get_mut(at) {
            *parent = nearest.1;
        }
        if let Some(region) = regions.get_mut(id(ids, nearest.1)) {
            region.area += 1;
            region.sum += f64::from(value);
        }
    }
    (count, left_out)
}
