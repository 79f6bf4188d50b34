//! A plane that is read between its pixels and across a centre.

use crate::arithmetic::{Level, Real};
use crate::plane::grid::Grid;
use crate::plane::sort;

/// Parts of a pixel to which centres are known.
const PARTS: f32 = 256.0;

/// A distance that is added to a column or row, in whole parts of a pixel: single precision then holds places up to
/// 2^15 columns and their mirror images without rounding, and a source comes out the same wherever it lies in a frame.
pub fn offset<L: Level>(pixels: f32) -> L {
    L::of(libm::roundf(pixels * PARTS) / PARTS)
}

/// A plane that is read at any place.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a, L> {
    /// Values, row-major.
    pub values: &'a [L],
    /// Its shape.
    pub grid: Grid,
}

impl<L: Level> Field<'_, L> {
    /// The value at an index; 0 beyond the plane.
    #[inline]
    pub fn at(&self, index: usize) -> L {
        self.values.get(index).copied().unwrap_or(L::ZERO)
    }

    /// The vertex of the parabolas through a peak and its neighbours.
    pub fn centre(&self, peak: usize) -> (L, L) {
        let (Grid { width, height }, (x, y)) = (self.grid, self.grid.place(peak));
        let half = L::Weight::of(0.5);
        let most = L::ONE.scaled(half);
        let vertex = |before: usize, after: usize| {
            let (before, own, after) = (self.at(before), self.at(peak), self.at(after));
            let bend = own + own - before - after;
            if bend > L::of(1e-6) {
                (after - before).scaled(half).ratio(bend).least(most).greatest(-most)
            } else {
                L::ZERO
            }
        };
        let inner = |at: usize, length: usize| at > 0 && at + 1 < length;
        let dx = if inner(x, width.get()) { vertex(peak.wrapping_sub(1), peak + 1) } else { L::ZERO };
        let (below, above) = (peak.wrapping_sub(width.get()), peak + width.get());
        let dy = if inner(y, height) { vertex(below, above) } else { L::ZERO };
        (L::whole(x) + offset(dx.to_f32()), L::whole(y) + offset(dy.to_f32()))
    }

    /// The value across a centre, bilinear, not below 0: what a symmetric source has at `index`.
    /// `None` where that is beyond the frame.
    pub fn mirrored(&self, centre: (L, L), index: usize) -> Option<L> {
        self.between(self.across(centre, index))
    }

    /// The median of the values as far from a centre as a place, at the seven others in steps of 45
    /// degrees; 0 counts for what is beyond the frame.
    pub fn around(&self, centre: (L, L), place: (L, L)) -> L {
        let (x, y) = (place.0 - centre.0, place.1 - centre.1);
        let slanted = |value: L| value.scaled(L::Weight::of(core::f32::consts::FRAC_1_SQRT_2));
        let (u, v) = (slanted(x - y), slanted(x + y));
        let turned = [(u, v), (-y, x), (-v, u), (-x, -y), (-u, -v), (y, -x), (v, -u)];
        let mut values = turned.map(|(x, y)| self.between((centre.0 + x, centre.1 + y)).unwrap_or(L::ZERO));
        sort::few(&mut values, |a, b| a.key() < b.key());
        let [_, _, _, median, ..] = values;
        median
    }

    /// The place, (x, y), of a pixel.
    pub fn place(&self, index: usize) -> (L, L) {
        let (x, y) = self.grid.place(index);
        (L::whole(x), L::whole(y))
    }

    /// The place on the other side of a centre.
    pub fn across(&self, centre: (L, L), index: usize) -> (L, L) {
        opposite(centre, self.place(index))
    }

    /// The value at a place between pixels, bilinear, not below 0; `None` beyond the frame.
    pub fn between(&self, place: (L, L)) -> Option<L> {
        let width = self.grid.width.get();
        let ((left, part_x), (below, part_y)) = self.cell(place)?;
        let first = below * width + left;
        let row = |first: usize| self.at(first) * (L::ONE - part_x) + self.at(first + 1) * part_x;
        Some((row(first) * (L::ONE - part_y) + row(first + width) * part_y).positive())
    }

    /// The index of the pixel nearest to a place; `None` beyond the frame.
    pub fn nearest(&self, place: (L, L)) -> Option<usize> {
        let ((left, part_x), (below, part_y)) = self.cell(place)?;
        let half = L::of(0.5);
        Some((below + usize::from(part_y > half)) * self.grid.width.get() + left + usize::from(part_x > half))
    }

    /// The first of the four pixels around a place, by column and row, and how far the place is
    /// from it towards the others.
    fn cell(&self, (x, y): (L, L)) -> Option<((usize, L), (usize, L))> {
        let (last_x, last_y) = (self.grid.width.get().checked_sub(2)?, self.grid.height.checked_sub(2)?);
        if x < L::ZERO || y < L::ZERO || x > L::whole(last_x + 1) || y > L::whole(last_y + 1) {
            return None;
        }
        Some((x.split(last_x), y.split(last_y)))
    }
}

/// The place on the other side of a centre.
pub fn opposite<L: Level>(centre: (L, L), place: (L, L)) -> (L, L) {
    (centre.0 + centre.0 - place.0, centre.1 + centre.1 - place.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::Fixed14;

    /// Around the centre (3, 3) the values are those of the directions, from the right upwards.
    fn around<L: Level>(light: [f32; 8]) -> f32 {
        let mut values = [L::ZERO; 49];
        // At the corners the distance 3 lies between four pixels.
        let places: [&[usize]; 8] =
            [&[27], &[40, 41, 47, 48], &[45], &[35, 36, 42, 43], &[21], &[0, 1, 7, 8], &[3], &[5, 6, 12, 13]];
        for (place, light) in places.into_iter().zip(light) {
            place.iter().for_each(|&at| values[at] = L::of(light));
        }
        let field = Field { values: &values, grid: Grid::of(49, 7).expect("there are columns") };
        field.around((L::of(3.0), L::of(3.0)), (L::of(6.0), L::of(3.0))).to_f32()
    }

    #[test]
    fn three_of_seven_places_do_not_count() {
        for light in [[90.0, 2.0, 1.0, 3.0, 50.0, 4.0, 60.0, 70.0], [0.0, 50.0, 60.0, 70.0, 4.0, 1.0, 2.0, 3.0]] {
            assert!((around::<f32>(light) - 4.0).abs() < 1e-3, "{}", around::<f32>(light));
            assert!((around::<Fixed14>(light) - 4.0).abs() < 1e-2, "{}", around::<Fixed14>(light));
        }
    }
}
