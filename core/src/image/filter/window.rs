//! Filters that make each pixel of the 5 x 5 around it.

use super::Planes;
use crate::arithmetic::Arithmetic;
use crate::plane::lattice::{self, Five, five_columns};
use core::ops::Range;

/// A filter of 5 x 5 pixels.
pub trait Window<A: Arithmetic> {
    /// The new value of the pixel in the middle.
    fn pixel(&self, around: [[A::Real; 5]; 5]) -> A::Real;
}

/// Does some rows of a pass of `filter`.
#[inline(always)]
pub fn rows<A: Arithmetic>(filter: &impl Window<A>, planes: &mut Planes<'_, A::Cell>, rows: Range<usize>) {
    lattice::sweep(planes.image, planes.ring, planes.width, 1, rows, |five| {
        let Five { far_before, before, centre, after, far_after, new, .. } = five;
        let old = [&*far_before, before, centre, after, far_after];
        for (x, new) in new.iter_mut().enumerate() {
            let columns = |row: &[A::Cell]| five_columns(row, x, 1).map(|cells| cells.map(A::pixel));
            let [Some(a), Some(b), Some(c), Some(d), Some(e)] = old.map(columns) else { continue };
            *new = A::to_pixel(filter.pixel([a, b, c, d, e]));
        }
    });
}
