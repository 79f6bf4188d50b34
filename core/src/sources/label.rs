//! Step 6: the connected components of {u > 0} become labels, in the caller's two planes.
//!
//! The front plane turns into labels; the image plane, no longer needed, holds the table: the
//! label that each provisional label was found to be equal to, from the front, and the areas (then
//! the final numbers), from the back. Five bounded passes:
//!
//! 1. [`Table::provisional_row`]: labels of the neighbours already seen, or a new one;
//! 2. [`Table::resolve`]: every label points to the first label of its component;
//! 3. [`Table::count_row`]: pixels become first labels, and their areas are counted;
//! 4. [`Table::number`]: first labels of components that are large enough are numbered in order;
//! 5. [`Table::final_row`]: pixels become final labels.
//!
//! A provisional label is made where a component's first pixel is met, so that the first label of
//! a component is also its least, and final labels are in raster order of first pixels.

use crate::arithmetic::{Arithmetic, Cell, Real};
use crate::config::Connectivity;

/// The memory between two polls was damaged: a table entry that no run can have written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Damaged;

/// Pixels that are looked at together, whether any belongs to an object.
const PIECE: usize = 32;

/// The pieces of a row in which a cell holds a label, and the column where each begins.
pub(crate) fn labelled_pieces<C: Cell>(row: &[C]) -> impl Iterator<Item = (usize, &[C])> {
    let pieces = (0usize..).step_by(PIECE).zip(row.chunks(PIECE));
    pieces.filter(|(_, piece)| !is_blank(piece))
}

/// The cells of a row that hold a label.
fn labelled<C: Cell>(row: &mut [C]) -> impl Iterator<Item = &mut C> {
    let pieces = row.chunks_mut(PIECE).filter(|piece| !is_blank(piece));
    pieces.flatten().filter(|cell| cell.bits() != C::BLANK.bits())
}

/// Whether no cell holds a label: most of an image belongs to nothing.
fn is_blank<C: Cell>(piece: &[C]) -> bool {
    piece.iter().fold(0, |any, cell| any | cell.bits()) == C::BLANK.bits()
}

/// The label table in a plane.
#[derive(Debug)]
pub struct Table<'a, C: Cell> {
    cells: &'a mut [C],
}

impl<'a, C: Cell> Table<'a, C> {
    /// A table in the cells of a plane.
    pub fn new(cells: &'a mut [C]) -> Self {
        Table { cells }
    }

    /// The most labels that the table, its cells and its areas can hold.
    pub fn capacity(&self) -> u32 {
        let half = u32::try_from(self.cells.len() / 2).unwrap_or(u32::MAX);
        half.min(C::MAX_LABEL)
    }

    fn equal(&self, label: u32) -> Result<u32, Damaged> {
        self.cells.get(label.wrapping_sub(1) as usize).map(|cell| cell.label()).ok_or(Damaged)
    }

    fn set_equal(&mut self, label: u32, to: u32) {
        if let Some(cell) = self.cells.get_mut(label.wrapping_sub(1) as usize) {
            *cell = C::from_label(to);
        }
    }

    fn back(&mut self, label: u32) -> Option<&mut C> {
        let index = self.cells.len().checked_sub(label as usize)?;
        self.cells.get_mut(index)
    }

    /// The first label of the component of `label`, halving the way there for the next time.
    /// Every step goes to a smaller label, so the walk ends within `label` steps.
    fn first(&mut self, mut label: u32) -> Result<u32, Damaged> {
        loop {
            let next = self.equal(label)?;
            if next == label {
                return Ok(label);
            }
            let after = self.equal(next)?;
            if next > label || after > next || after == 0 {
                return Err(Damaged);
            }
            self.set_equal(label, after);
            label = after;
        }
    }

    /// Notes that two labels are of one component; its first label.
    fn join(&mut self, a: u32, b: u32) -> Result<u32, Damaged> {
        let (a, b) = (self.first(a)?, self.first(b)?);
        let (first, other) = if a < b { (a, b) } else { (b, a) };
        self.set_equal(other, first);
        Ok(first)
    }

    /// Pass 1: turns a row of the front into provisional labels, given the labels of the row
    /// before (empty for row 0) and the original pixels (undefined ones belong to nothing).
    /// `labels` is the number of labels so far; the number of pixels that found no free label is
    /// returned.
    ///
    /// # Errors
    /// [`Damaged`] where the table does not hold what earlier rows wrote.
    pub fn provisional_row<A: Arithmetic<Cell = C>>(
        &mut self,
        row: &mut [C],
        before: &[C],
        pixels: &[f32],
        connectivity: Connectivity,
        labels: &mut u32,
    ) -> Result<u32, Damaged> {
        let diagonal = connectivity == Connectivity::Eight;
        let before = |x: usize| before.get(x).map_or(0, |cell| cell.label());
        let (mut left, mut unlabelled) = (0, 0);
        for (start, cells) in (0usize..).step_by(PIECE).zip(row.chunks_mut(PIECE)) {
            // Most of an image belongs to nothing.
            if !cells.iter().fold(false, |any, cell| any | (A::level(*cell) > A::Real::ZERO)) {
                cells.fill(C::from_label(0));
                left = 0;
                continue;
            }
            for ((x, cell), pixel) in (start..).zip(cells).zip(pixels.get(start..).unwrap_or(&[])) {
                let mut label = 0;
                if A::level(*cell) > A::Real::ZERO && pixel.is_finite() {
                    let corners = if diagonal { [before(x.wrapping_sub(1)), before(x + 1)] } else { [0, 0] };
                    for neighbour in [left, before(x)].into_iter().chain(corners) {
                        if neighbour != 0 && neighbour != label {
                            label = if label == 0 { self.first(neighbour)? } else { self.join(label, neighbour)? };
                        }
                    }
                    if label == 0 {
                        label = self.new_label(labels);
                    }
                    unlabelled += u32::from(label == 0);
                }
                *cell = C::from_label(label);
                left = label;
            }
        }
        Ok(unlabelled)
    }

    /// A label that is equal to no other yet; 0 where the table is full.
    fn new_label(&mut self, labels: &mut u32) -> u32 {
        if *labels >= self.capacity() {
            return 0;
        }
        *labels = labels.saturating_add(1);
        let label = *labels;
        self.set_equal(label, label);
        if let Some(area) = self.back(label) {
            *area = C::from_label(0);
        }
        label
    }

    /// Pass 2, for labels in increasing order: points a label to its component's first label.
    ///
    /// # Errors
    /// [`Damaged`], as in pass 1.
    pub fn resolve(&mut self, label: u32) -> Result<(), Damaged> {
        let first = self.first(label)?;
        self.set_equal(label, first);
        Ok(())
    }

    /// Takes the components of a piece of a row that pass 3 has seen out of the numbers: their first
    /// labels are equal to none.
    pub fn drop_row(&mut self, row: &[C]) {
        for (_, piece) in labelled_pieces(row) {
            piece.iter().filter(|cell| cell.bits() != C::BLANK.bits()).for_each(|cell| self.set_equal(cell.label(), 0));
        }
    }

    /// Pass 3: first labels in place of provisional ones, and their areas (saturated).
    ///
    /// # Errors
    /// [`Damaged`] where a pixel has a label that was never given.
    pub fn count_row(&mut self, row: &mut [C]) -> Result<(), Damaged> {
        for cell in labelled(row) {
            let first = self.equal(cell.label())?;
            *cell = C::from_label(first);
            if first == 0 {
                continue;
            }
            let area = self.back(first).ok_or(Damaged)?;
            *area = C::from_label(area.label().saturating_add(1));
        }
        Ok(())
    }

    /// Pass 4, for labels in increasing order: the final number of a first label takes the place
    /// of its area; 0 where the component is too small. `numbered` counts the numbers given.
    ///
    /// # Errors
    /// [`Damaged`] where the table ends before the label.
    pub fn number(&mut self, label: u32, min_area: u32, numbered: &mut u32) -> Result<(), Damaged> {
        let is_first = self.equal(label)? == label;
        let area = self.back(label).ok_or(Damaged)?;
        let keep = is_first && area.label() >= min_area.min(C::MAX_LABEL);
        *numbered = numbered.saturating_add(u32::from(keep));
        *area = C::from_label(if keep { *numbered } else { 0 });
        Ok(())
    }

    /// Pass 5: final labels in place of first labels.
    ///
    /// # Errors
    /// [`Damaged`] where a pixel has a label that was never given.
    pub fn final_row(&mut self, row: &mut [C]) -> Result<(), Damaged> {
        for cell in labelled(row) {
            *cell = *self.back(cell.label()).ok_or(Damaged)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    const WIDTH: usize = 6;

    fn labelled(rows: [&[u8; WIDTH]; 4], connectivity: Connectivity, min_area: u32) -> [[u8; WIDTH]; 4] {
        let mut front = rows.map(|row| row.map(|cell| if cell == b'#' { 1.0f32 } else { -1.0 }));
        let (mut cells, mut labels, mut numbered) = ([0.0f32; 4 * WIDTH], 0, 0);
        let mut table = Table::new(&mut cells);
        for y in 0..4 {
            let (before, rest) = front.split_at_mut(y);
            let before = before.last().map_or(&[][..], |row| row);
            let left = table.provisional_row::<F32>(&mut rest[0], before, &[0.0; WIDTH], connectivity, &mut labels);
            assert_eq!(left, Ok(0));
        }
        (1..=labels).for_each(|label| assert_eq!(table.resolve(label), Ok(())));
        front.iter_mut().for_each(|row| assert_eq!(table.count_row(row), Ok(())));
        (1..=labels).for_each(|label| assert_eq!(table.number(label, min_area, &mut numbered), Ok(())));
        front.iter_mut().for_each(|row| assert_eq!(table.final_row(row), Ok(())));
        front.map(|row| row.map(|cell| if cell == 0.0 { b'.' } else { b'0' + cell as u8 }))
    }

    /// Two arms that meet below, two pixels that meet at a corner, and one alone.
    #[test]
    fn components_are_numbered_in_the_order_of_their_first_pixels() {
        let rows = [b"#.#..#", b"#.#.#.", b"###...", b".....#"];
        let eight = [b"1.1..2", b"1.1.2.", b"111...", b".....3"];
        let four = [b"1.1..2", b"1.1.3.", b"111...", b".....4"];
        let large = [b"1.1..2", b"1.1.2.", b"111...", b"......"];
        assert_eq!(labelled(rows, Connectivity::Eight, 1), eight.map(|row| *row));
        assert_eq!(labelled(rows, Connectivity::Four, 1), four.map(|row| *row));
        assert_eq!(labelled(rows, Connectivity::Eight, 2), large.map(|row| *row));
    }

    #[test]
    fn labels_lead_to_the_first_and_what_leads_elsewhere_is_damage() {
        let first = |cells: &mut [f32], label| Table::new(cells).first(label);
        assert_eq!(first(&mut [1.0, 1.0, 2.0, 3.0], 4), Ok(1));
        for (mut cells, label) in [([2.0f32, 2.0, 0.0], 1), ([1.0, 3.0, 2.0], 3), ([0.0, 1.0, 1.0], 2)] {
            assert_eq!(first(&mut cells, label), Err(Damaged), "{cells:?}");
        }
    }
}
