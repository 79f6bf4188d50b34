//! Vector units: the cells of a tile's row in one go.
//!
//! Most loops are left to the compiler, which finds the vectors in them. The one that a front
//! spends its time in is written for vector units here and in [`crate::front::scheme::Fd`]; what a unit
//! of a processor is, the host says. Every operation gives the bits of the same one on single cells.

use core::convert::Infallible;
use core::marker::PhantomData;

/// Columns of a tile.
pub const COLUMNS: usize = 16;

/// A processor's vector units; a value of this type is the proof that it has them.
pub trait Vectors: Copy {
    /// What planes are made of.
    type Cell;
    /// What is computed in.
    type Real;
    /// [`COLUMNS`] numbers.
    type Row: Copy;

    /// The numbers in some cells of the front or of the speed.
    fn load(self, cells: &[Self::Cell; COLUMNS]) -> Self::Row;
    /// Puts numbers back into cells.
    fn store(self, row: Self::Row, cells: &mut [Self::Cell; COLUMNS]);
    /// The same number everywhere.
    fn splat(self, x: Self::Real) -> Self::Row;
    /// `a + b`.
    fn plus(self, a: Self::Row, b: Self::Row) -> Self::Row;
    /// `a - b`.
    fn minus(self, a: Self::Row, b: Self::Row) -> Self::Row;
    /// `a b`.
    fn times(self, a: Self::Row, b: Self::Row) -> Self::Row;
    /// The square root of numbers that are not below 0, correctly rounded.
    fn root(self, row: Self::Row) -> Self::Row;
    /// [`crate::arithmetic::Real::positive`].
    fn positive(self, row: Self::Row) -> Self::Row;
    /// [`crate::arithmetic::Real::least`].
    fn least(self, row: Self::Row, other: Self::Row) -> Self::Row;
    /// [`crate::arithmetic::Real::greatest`].
    fn greatest(self, row: Self::Row, other: Self::Row) -> Self::Row;
    /// [`crate::arithmetic::Arithmetic::change`]; 0 at once where no number is near.
    fn change(self, old: Self::Row, new: Self::Row, limit: Self::Real) -> u64;
    /// A bit for every cell, the first one lowest, that is set where any bit of it differs.
    fn differing(self, a: Self::Row, b: Self::Row) -> u32;
}

/// No vector units: there is no such value.
#[derive(Clone, Copy, Debug)]
pub struct NoVectors<C, R>(Infallible, PhantomData<(C, R)>);

/// Operations that are never reached.
macro_rules! never {
    ($($name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?;)*) => {
        $(fn $name(self, $($argument: $type),*) $(-> $result)? {
            let _ = ($($argument,)*);
            match self.0 {}
        })*
    };
}

impl<C: Copy, R: Copy> Vectors for NoVectors<C, R> {
    type Cell = C;
    type Real = R;
    type Row = ();

    never! {
        load(cells: &[C; COLUMNS]);
        store(row: (), cells: &mut [C; COLUMNS]);
        splat(x: R);
        plus(a: (), b: ());
        minus(a: (), b: ());
        times(a: (), b: ());
        root(row: ());
        positive(row: ());
        least(row: (), other: ());
        greatest(row: (), other: ());
        change(old: (), new: (), limit: R) -> u64;
        differing(a: (), b: ()) -> u32;
    }
}
