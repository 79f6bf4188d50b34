//! The median filter: spikes and lone noisy pixels vanish, edges stay where they are
//! (J. W. Tukey 1977, Exploratory Data Analysis; fast form after doi:10.1109/TASSP.1979.1163188).

use crate::arithmetic::{Arithmetic, Real};
use crate::plane::sweep::Kernel;

/// Each pixel becomes the median of the 3 x 3 pixels around it; a sweep is one step.
#[derive(Clone, Copy, Debug)]
pub struct Median;

/// Three values in their order.
#[inline(always)]
fn sorted<R: Real>([a, b, c]: [R; 3]) -> [R; 3] {
    let (low, high) = (a.least(b), a.greatest(b));
    [low.least(c), low.greatest(high.least(c)), high.greatest(c)]
}

impl<A: Arithmetic> Kernel<A, 3> for Median {
    #[inline(always)]
    fn row(&mut self, old: &[&[A::Cell]; 3], _aux: &[A::Cell], new: &mut [A::Cell]) {
        let [below, own, above] = old.map(|row| row.array_windows::<3>());
        for (((new, below), own), above) in new.iter_mut().zip(below).zip(own).zip(above) {
            // The median of nine is that of the greatest least, the middle middle and the least greatest.
            let [[a, b, c], [d, e, f], [g, h, i]] = [below, own, above].map(|row| sorted(row.map(A::pixel)));
            let least = a.greatest(d).greatest(g);
            let [_, middle, _] = sorted([b, e, h]);
            let greatest = c.least(f).least(i);
            let [_, median, _] = sorted([least, middle, greatest]);
            *new = A::to_pixel(median);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    #[test]
    fn the_fifth_of_nine() {
        let rows: [[f32; 5]; 3] = [[0.9, 0.1, 0.4, 0.0, 1.0], [0.2, 0.8, 0.5, 0.5, 0.0], [0.3, 0.7, 0.6, 0.2, 0.1]];
        let mut new = [0.0; 3];
        Kernel::<F32, 3>::row(&mut Median, &rows.each_ref().map(|row| &row[..]), &[], &mut new);
        for (x, found) in new.into_iter().enumerate() {
            let mut nine: [f32; 9] = core::array::from_fn(|at| rows[at / 3][x + at % 3]);
            nine.sort_by(f32::total_cmp);
            assert_eq!(found, nine[4], "column {x}");
        }
    }
}
