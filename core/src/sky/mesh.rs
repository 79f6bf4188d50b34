//! The mesh of cells over a frame.

use super::{Sky, clipped};
use crate::arithmetic::Level;
use crate::grid::Grid;
use crate::sort::{self, Keys};
use core::num::NonZero;

/// Side of a mesh cell in pixels; a frame has a whole number of cells along each axis.
pub const CELL: usize = 64;
/// The most cells along an axis; larger frames have larger cells.
pub const MOST_CELLS: usize = 64;

/// The mesh over a frame, in the caller's memory.
#[derive(Debug)]
pub struct Mesh<'m> {
    cells: &'m mut [Sky],
    grid: Grid,
    /// Cells per pixel along each axis.
    scale: (f32, f32),
}

/// Cells along an axis of `length` pixels.
pub const fn cells_along(length: usize) -> NonZero<usize> {
    let cells = (length + CELL / 2) / CELL;
    match NonZero::new(if cells > MOST_CELLS { MOST_CELLS } else { cells }) {
        Some(cells) => cells,
        None => NonZero::<usize>::MIN,
    }
}

/// Elements of the memory that [`Mesh::measure`] needs: the mesh, and a copy to filter it from.
pub const fn mesh_cells(width: usize, height: usize) -> usize {
    2 * cells_along(width).get() * cells_along(height).get()
}

/// The most pixels of a cell.
pub const fn cell_pixels(width: usize, height: usize) -> usize {
    width.div_ceil(cells_along(width).get()) * height.div_ceil(cells_along(height).get())
}

impl<'m> Mesh<'m> {
    /// The mesh of a frame that [`Mesh::measure`] left in `cells`.
    pub fn over(cells: &'m mut [Sky], (width, height): (usize, usize)) -> Mesh<'m> {
        let (columns, rows) = (cells_along(width), cells_along(height).get());
        let scale = (columns.get() as f32 / width as f32, rows as f32 / height as f32);
        Mesh { cells, grid: Grid { width: columns, height: rows }, scale }
    }

    /// Measures the sky of `pixels` (row-major, not finite = undefined) where `sky` allows. `keys` needs room for [`cell_pixels`], `cells` [`mesh_cells`]. Cost: about twenty
    /// looks at each pixel.
    pub fn measure(
        pixels: &[f32],
        sky: impl Fn(usize) -> bool,
        (width, height): (usize, usize),
        cells: &'m mut [Sky],
        mut keys: Keys<'_>,
    ) -> Mesh<'m> {
        let (columns, rows) = (cells_along(width), cells_along(height));
        let (cells, copy) = cells.split_at_mut_checked(columns.get() * rows.get()).unwrap_or((&mut [], &mut []));
        let mut mesh = Mesh::over(cells, (width, height));
        for (index, cell) in mesh.cells.iter_mut().enumerate() {
            let (column, row) = mesh.grid.place(index);
            let (left, right) = (column * width / columns, (column + 1) * width / columns);
            let (bottom, top) = (row * height / rows, (row + 1) * height / rows);
            let places = (bottom..top).flat_map(|y| y * width + left..y * width + right).filter(|&at| sky(at));
            let values = places.filter_map(|at| pixels.get(at).copied()).filter(|value| value.is_finite());
            let sorted = keys.sorted(values);
            let enough = sorted.len() * 10 > (right - left) * (top - bottom);
            *cell = if enough { clipped(sorted) } else { Sky::UNKNOWN };
        }
        mesh.fill(copy);
        mesh.smooth(copy);
        mesh
    }

    fn cell(cells: &[Sky], index: usize) -> Sky {
        cells.get(index).copied().unwrap_or(Sky::UNKNOWN)
    }

    /// The cells of a copy around one, and itself.
    fn around(copy: &[Sky], grid: Grid, index: usize) -> impl Iterator<Item = Sky> {
        let (column, row) = grid.place(index);
        let rows = row.saturating_sub(1)..(row + 2).min(grid.height);
        let columns = column.saturating_sub(1)..(column + 2).min(grid.width.get());
        rows.flat_map(move |y| columns.clone().map(move |x| Self::cell(copy, y * grid.width.get() + x)))
    }

    /// Unknown cells take the mean of their known neighbours, ring by ring.
    fn fill(&mut self, copy: &mut [Sky]) {
        for _ in 0..self.grid.width.get() + self.grid.height {
            copy.iter_mut().zip(self.cells.iter()).for_each(|(copy, cell)| *copy = *cell);
            if copy.iter().take(self.cells.len()).all(|cell| cell.known()) {
                return;
            }
            for (index, cell) in self.cells.iter_mut().enumerate().filter(|(_, cell)| !cell.known()) {
                let (mut level, mut noise, mut count) = (0.0, 0.0, 0.0);
                for near in Self::around(copy, self.grid, index).filter(|near| near.known()) {
                    (level, noise, count) = (level + near.level, noise + near.noise, count + 1.0);
                }
                if count > 0.0 {
                    *cell = Sky { level: level / count, noise: noise / count };
                }
            }
        }
    }

    /// Each cell becomes the median of the 3 x 3 cells around it.
    fn smooth(&mut self, copy: &mut [Sky]) {
        copy.iter_mut().zip(self.cells.iter()).for_each(|(copy, cell)| *copy = *cell);
        for (index, cell) in self.cells.iter_mut().enumerate() {
            let near = || Self::around(copy, self.grid, index);
            *cell = Sky { level: middle(near().map(|sky| sky.level)), noise: middle(near().map(|sky| sky.noise)) };
        }
    }

    /// Background and noise at a pixel.
    pub fn at(&self, x: usize, y: usize) -> Sky {
        let place = |at: usize, cells: usize, scale: f32| {
            let place = (at as f32 + 0.5) * scale - 0.5;
            let place = if place > 0.0 { place } else { 0.0 };
            let first = (place as usize).min(cells.saturating_sub(2));
            let part = place - first as f32;
            (first, (first + 1).min(cells.saturating_sub(1)), if part > 1.0 { 1.0 } else { part })
        };
        let columns = self.grid.width.get();
        let (left, right, part_x) = place(x, columns, self.scale.0);
        let (below, above, part_y) = place(y, self.grid.height, self.scale.1);
        let blend = |value: fn(Sky) -> f32| {
            let row = |row: usize| {
                value(Self::cell(self.cells, row * columns + left)) * (1.0 - part_x)
                    + value(Self::cell(self.cells, row * columns + right)) * part_x
            };
            row(below) * (1.0 - part_y) + row(above) * part_y
        };
        Sky { level: blend(|sky| sky.level), noise: blend(|sky| sky.noise) }
    }
}

/// The median of at most nine values; the mean of the middle two of an even number.
fn middle(of: impl Iterator<Item = f32>) -> f32 {
    let (mut values, mut count) = ([0.0; 9], 0);
    for (out, value) in values.iter_mut().zip(of) {
        *out = value;
        count += 1;
    }
    let values = values.get_mut(..count).unwrap_or(&mut []);
    sort::few(values, |a, b| a.key() < b.key());
    let at = |index: usize| values.get(index).copied().unwrap_or(0.0);
    if count % 2 == 1 { at(count / 2) } else { 0.5 * (at((count / 2).saturating_sub(1)) + at(count / 2)) }
}
