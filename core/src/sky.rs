//! Sky background and noise: a mesh of cells, each with a clipped mode, a median over the
//! neighbouring cells and bilinear values between their centres.

/// Side of a mesh cell in pixels; a frame has a whole number of cells along each axis.
pub const CELL: usize = 64;
/// The most cells along an axis; larger frames have larger cells.
pub const MOST_CELLS: usize = 64;

/// Background and noise of one cell, in units of the image; NaN where too few pixels are sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// The background level.
    pub level: f32,
    /// Standard deviation of a pixel.
    pub noise: f32,
}

impl Sky {
    /// A cell about which nothing is known.
    pub const UNKNOWN: Sky = Sky { level: f32::NAN, noise: f32::NAN };

    fn known(self) -> bool {
        self.level.is_finite() && self.noise.is_finite()
    }
}

/// The median of `values`, which it reorders; 0 for none. The upper one of an even number.
pub fn median(values: &mut [f32]) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// Clipped at three standard deviations until nothing more is clipped (at most ten times), the
/// mode is `2.5 median - 1.5 mean`, or the median where the distribution is skew (Bertin and
/// Arnouts 1996, doi:10.1051/aas:1996164). The noise makes good the 1.5 % that clipping takes.
pub fn clipped(values: &mut [f32]) -> Sky {
    if values.len() < 8 {
        return Sky::UNKNOWN;
    }
    let mut kept = values.len();
    let mut centre = median(values);
    // Half of the values lie within 0.6745 standard deviations; the lower half has no sources.
    let lower = kept / 4;
    let quartile = *values.select_nth_unstable_by(lower, f32::total_cmp).1;
    let mut noise = (centre - quartile) * 1.4826;
    let mut mean = centre;
    for _ in 0..10 {
        let before = kept;
        let mut next = 0;
        for index in 0..kept {
            let value = values.get(index).copied().unwrap_or(0.0);
            let distance = if value > centre { value - centre } else { centre - value };
            if distance <= 3.0 * noise {
                values.swap(index, next);
                next += 1;
            }
        }
        if next < 8 {
            break;
        }
        kept = next;
        let inside = values.get_mut(..kept).unwrap_or(&mut []);
        centre = median(inside);
        let sum: f64 = inside.iter().map(|&value| f64::from(value)).sum();
        let average = sum / kept as f64;
        let squares: f64 =
            inside.iter().map(|&value| (f64::from(value) - average) * (f64::from(value) - average)).sum();
        mean = average as f32;
        noise = libm::sqrt(squares / kept as f64) as f32 * 1.015;
        if kept == before {
            break;
        }
    }
    let skew = if mean > centre { mean - centre } else { centre - mean };
    Sky { level: if skew < 0.3 * noise { 2.5 * centre - 1.5 * mean } else { centre }, noise }
}

/// The mesh over a frame, in the caller's memory.
#[derive(Debug)]
pub struct Mesh<'m> {
    cells: &'m mut [Sky],
    columns: usize,
    rows: usize,
    /// Cells per pixel along each axis.
    scale: (f32, f32),
}

/// Cells along an axis of `length` pixels.
pub const fn cells_along(length: usize) -> usize {
    let cells = (length + CELL / 2) / CELL;
    if cells == 0 {
        1
    } else if cells > MOST_CELLS {
        MOST_CELLS
    } else {
        cells
    }
}

/// Elements of the memory that [`Mesh::measure`] needs: the mesh, and a copy to filter it from.
pub const fn mesh_cells(width: usize, height: usize) -> usize {
    2 * cells_along(width) * cells_along(height)
}

impl<'m> Mesh<'m> {
    /// The mesh of a frame that [`Mesh::measure`] left in `cells`.
    pub fn over(cells: &'m mut [Sky], (width, height): (usize, usize)) -> Mesh<'m> {
        let (columns, rows) = (cells_along(width), cells_along(height));
        Mesh { cells, columns, rows, scale: (columns as f32 / width as f32, rows as f32 / height as f32) }
    }

    /// Measures the sky of `pixels` (row-major, not finite = undefined) where `masked` is not
    /// above 0. `values` needs as many elements as the largest cell has pixels, `cells`
    /// [`mesh_cells`]. Cost: about twenty looks at each pixel.
    pub fn measure(
        pixels: &[f32],
        masked: &[f32],
        (width, height): (usize, usize),
        cells: &'m mut [Sky],
        values: &mut [f32],
    ) -> Mesh<'m> {
        let (columns, rows) = (cells_along(width), cells_along(height));
        let (cells, copy) = cells.split_at_mut_checked(columns * rows).unwrap_or((&mut [], &mut []));
        let mut mesh = Mesh::over(cells, (width, height));
        for row in 0..rows {
            for column in 0..columns {
                let (left, right) = (column * width / columns, (column + 1) * width / columns);
                let (bottom, top) = (row * height / rows, (row + 1) * height / rows);
                let mut count = 0;
                for y in bottom..top {
                    for at in y * width + left..y * width + right {
                        let value = pixels.get(at).copied().unwrap_or(f32::NAN);
                        let sky = masked.get(at).is_none_or(|&mask| mask <= 0.0);
                        if let (true, true, Some(out)) = (value.is_finite(), sky, values.get_mut(count)) {
                            *out = value;
                            count += 1;
                        }
                    }
                }
                let enough = count * 10 > (right - left) * (top - bottom);
                let sky = if enough { clipped(values.get_mut(..count).unwrap_or(&mut [])) } else { Sky::UNKNOWN };
                if let Some(cell) = mesh.cells.get_mut(row * columns + column) {
                    *cell = sky;
                }
            }
        }
        mesh.fill(copy);
        mesh.smooth(copy);
        mesh
    }

    fn cell(cells: &[Sky], index: usize) -> Sky {
        cells.get(index).copied().unwrap_or(Sky::UNKNOWN)
    }

    /// Unknown cells take the mean of their known neighbours, ring by ring.
    fn fill(&mut self, copy: &mut [Sky]) {
        for _ in 0..self.columns + self.rows {
            copy.iter_mut().zip(self.cells.iter()).for_each(|(copy, cell)| *copy = *cell);
            if copy.iter().take(self.cells.len()).all(|cell| cell.known()) {
                return;
            }
            for (index, cell) in self.cells.iter_mut().enumerate().filter(|(_, cell)| !cell.known()) {
                let (column, row) = (index % self.columns, index / self.columns);
                let (mut level, mut noise, mut count) = (0.0, 0.0, 0.0);
                for y in row.saturating_sub(1)..(row + 2).min(self.rows) {
                    for x in column.saturating_sub(1)..(column + 2).min(self.columns) {
                        let near = Self::cell(copy, y * self.columns + x);
                        if near.known() {
                            (level, noise, count) = (level + near.level, noise + near.noise, count + 1.0);
                        }
                    }
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
            let (column, row) = (index % self.columns, index / self.columns);
            let (mut levels, mut noises, mut count) = ([0.0; 9], [0.0; 9], 0);
            for y in row.saturating_sub(1)..(row + 2).min(self.rows) {
                for x in column.saturating_sub(1)..(column + 2).min(self.columns) {
                    let near = Self::cell(copy, y * self.columns + x);
                    if let (Some(level), Some(noise)) = (levels.get_mut(count), noises.get_mut(count)) {
                        (*level, *noise) = (near.level, near.noise);
                        count += 1;
                    }
                }
            }
            *cell = Sky { level: middle(&mut levels, count), noise: middle(&mut noises, count) };
        }
    }

    /// Background and noise at a pixel.
    pub fn at(&self, x: usize, y: usize) -> Sky {
        let place = |at: usize, cells: usize, scale: f32| {
            let place = (at as f32 + 0.5) * scale - 0.5;
            let place = if place > 0.0 { place } else { 0.0 };
            let first = (place as usize).min(cells.saturating_sub(2));
            let part = place - first as f32;
            (first, (first + 1).min(cells - 1), if part > 1.0 { 1.0 } else { part })
        };
        let (left, right, part_x) = place(x, self.columns, self.scale.0);
        let (below, above, part_y) = place(y, self.rows, self.scale.1);
        let blend = |value: fn(Sky) -> f32| {
            let row = |row: usize| {
                value(Self::cell(self.cells, row * self.columns + left)) * (1.0 - part_x)
                    + value(Self::cell(self.cells, row * self.columns + right)) * part_x
            };
            row(below) * (1.0 - part_y) + row(above) * part_y
        };
        Sky { level: blend(|sky| sky.level), noise: blend(|sky| sky.noise) }
    }
}

/// Median of the first `count` values; the mean of the middle two of an even number.
fn middle(values: &mut [f32; 9], count: usize) -> f32 {
    let values = values.get_mut(..count).unwrap_or(&mut []);
    values.sort_unstable_by(f32::total_cmp);
    let at = |index: usize| values.get(index).copied().unwrap_or(0.0);
    if count % 2 == 1 { at(count / 2) } else { 0.5 * (at((count / 2).saturating_sub(1)) + at(count / 2)) }
}
