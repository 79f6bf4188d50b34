//! The mesh of cells over a frame.

use super::clipped::Clipped;
use super::quiet::{Pixels, quiet};
use super::{LEAST_PIXELS, Sky, Values, clipped};
use crate::arithmetic::Level;
use crate::plane::crew::{Alone, Crew};
use crate::plane::grid::Grid;
use crate::plane::mask::WORD;
use crate::plane::part::{CELL_WORDS, Question, Whole};
use crate::plane::raster::{Raster, Sample};
use crate::plane::sort::{self, Keys};
use crate::plane::walk::Walk;
use core::num::NonZero;
use core::ops::Range;

/// Side of a mesh cell in pixels where nothing else is wanted; a frame has a whole number of cells along
/// each axis.
pub const CELL: usize = 64;
/// The most cells along an axis; larger frames have larger cells.
pub const MOST_CELLS: usize = 64;

/// A cell is measured where more than this many percent of its defined pixels are sky.
const LEAST_SKY: usize = 30;
/// Groups of rows of cells for each hand: who is done early takes another.
const GROUPS: usize = 2;
/// Cells of a row whose pixels are read together, if there is room for their keys.
const TOGETHER: usize = 16;
/// A cell is measured where more than one in so many of its pixels is sky.
const LEAST_SHARE: usize = 64;

/// What a pixel is to the sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// Nothing is known of it.
    Undefined,
    /// The light of a source.
    Source,
    /// Sky.
    Sky,
}

/// What some pixels are, a bit for each, the lowest for the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Words {
    /// Those of which something is known.
    pub defined: u32,
    /// Those of sky.
    pub sky: u32,
}

impl Words {
    /// By the number of the bit.
    pub fn of(seen: impl Fn(usize) -> Seen) -> Words {
        (0..WORD).rev().map(seen).fold(Words { defined: 0, sky: 0 }, |Words { defined, sky }, seen| Words {
            defined: defined << 1 | u32::from(seen != Seen::Undefined),
            sky: sky << 1 | u32::from(seen == Seen::Sky),
        })
    }

    /// The first so many of them.
    fn first(self, count: usize) -> Words {
        let those = u32::MAX.checked_shl(count as u32).map_or(u32::MAX, |rest| !rest);
        Words { defined: self.defined & those, sky: self.sky & those }
    }
}

/// How a measurement went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Survey {
    /// Cells that have a defined pixel.
    pub cells: u32,
    /// Those of them that were measured in this round; the rest have too little sky, and take it from their
    /// neighbours or keep that of the round before.
    pub measured: u32,
}

impl Survey {
    /// Whether most cells have too little sky, and keep what was measured before sources were masked.
    pub fn is_crowded(&self) -> bool {
        2 * self.measured < self.cells
    }
}

/// The mesh over a frame, in the caller's memory.
#[derive(Debug)]
pub struct Mesh<'m> {
    cells: &'m mut [Sky],
    copy: &'m mut [Sky],
    grid: Grid,
    size: (usize, usize),
    /// Cells per pixel along each axis.
    scale: (f32, f32),
}

/// Cells of about `cell` pixels along an axis of `length` pixels; one for a `cell` of 0.
pub const fn cells_along(length: usize, cell: usize) -> NonZero<usize> {
    let cells = match length.saturating_add(cell / 2).checked_div(cell) {
        Some(cells) => cells,
        None => 1,
    };
    match NonZero::new(if cells > MOST_CELLS { MOST_CELLS } else { cells }) {
        Some(cells) => cells,
        None => NonZero::<usize>::MIN,
    }
}

/// Elements of the memory that [`Mesh::measure`] needs: the mesh, and a copy to filter it from.
///
/// ```
/// use skyfront_core::sky::{CELL, mesh_cells};
///
/// // A camera of 1024 x 768 pixels has 16 x 12 cells.
/// assert_eq!(mesh_cells(1024, 768, CELL), 2 * 16 * 12);
/// ```
pub const fn mesh_cells(width: usize, height: usize, cell: usize) -> usize {
    2 * cells_along(width, cell).get() * cells_along(height, cell).get()
}

/// The most pixels of a cell.
pub const fn cell_pixels(width: usize, height: usize, cell: usize) -> usize {
    width.div_ceil(cells_along(width, cell).get()) * height.div_ceil(cells_along(height, cell).get())
}

impl<'m> Mesh<'m> {
    /// The mesh of a frame, with cells of about `cell` pixels, that [`Mesh::measure`] left in `cells`, which
    /// has room for [`mesh_cells`].
    pub fn over(cells: &'m mut [Sky], size: (usize, usize), cell: usize) -> Mesh<'m> {
        let (columns, rows) = (cells_along(size.0, cell), cells_along(size.1, cell).get());
        let scale = (columns.get() as f32 / size.0 as f32, rows as f32 / size.1 as f32);
        let (cells, copy) = cells.split_at_mut_checked(columns.get() * rows).unwrap_or((&mut [], &mut []));
        Mesh { cells, copy, grid: Grid { width: columns, height: rows }, size, scale }
    }

    /// A mesh of which nothing is known yet.
    pub fn blank(cells: &'m mut [Sky], size: (usize, usize), cell: usize) -> Mesh<'m> {
        cells.fill(Sky::UNKNOWN);
        Mesh::over(cells, size, cell)
    }

    /// Measures the sky of `pixels`, row-major, where they are [`Seen::Sky`]. Cells that are mostly
    /// sources take what their neighbours have. Where most cells are such, they keep what was
    /// measured before the sources were masked: what is left between these is too little to be sky, and each round
    /// would mask more of it. `keys` needs room for [`cell_pixels`]. Cost: about
    /// twenty looks at each pixel.
    pub fn measure(
        &mut self,
        pixels: &[f32],
        seen: impl Fn(usize) -> Seen + Sync,
        values: &Values,
        keys: Keys<'_>,
    ) -> Survey {
        self.measure_by(&Alone, &Raster::of(pixels, self.size.0), seen, values, keys)
    }

    /// The same by a crew, of which as many work as `keys` has room for, [`cell_pixels`] each.
    pub fn measure_by<P: Sample>(
        &mut self,
        crew: &impl Crew,
        frame: &Raster<'_, P>,
        seen: impl Fn(usize) -> Seen + Sync,
        values: &Values,
        keys: Keys<'_>,
    ) -> Survey {
        let mut survey = Survey::default();
        let count = frame.count();
        let seen_within = |at: usize| if at < count { seen(at) } else { Seen::Undefined };
        let words = |first: usize| Words::of(|bit| seen_within(first.saturating_add(bit)));
        let _ = self.step((&mut Walk::whole(), crew), &mut survey, frame, words, values, keys);
        survey
    }

    /// The same in parts, a cell of the mesh at least in each: it has the work of twice its pixels.
    pub(crate) fn step<P: Sample>(
        &mut self,
        (walk, crew): (&mut Walk, &impl Crew),
        survey: &mut Survey,
        frame: &Raster<'_, P>,
        seen: impl Fn(usize) -> Words + Sync,
        values: &Values,
        mut keys: Keys<'_>,
    ) -> Option<()> {
        let (size, grid) = (self.size, self.grid);
        let cost = size.0.div_ceil(grid.width.get()) * size.1.div_ceil(grid.height.max(1)) * 2;
        walk.pass(grid.cells(), cost, |cells| {
            if cells.len() == grid.cells() {
                let told = self.measure_cells(crew, frame, &seen, values, keys.again());
                *survey = self.remember(&told);
                return;
            }
            if cells.start == 0 {
                *survey = Survey::default();
            }
            for index in cells {
                let (mut told, mut count) = (Told::default(), Count::default());
                let (room, counts) = (NonZero::<usize>::MAX, core::slice::from_mut(&mut count));
                keys_of_sky(frame, &[sides(size, grid, index)], &seen, (keys.0, room), counts);
                let is_enough = told.hears(0, &count);
                survey.cells += told.survey.cells;
                survey.measured += told.survey.measured;
                if let Some(cell) = self.cells.get_mut(index).filter(|_| is_enough) {
                    *cell = clipped(keys.sort(count.sky), values);
                }
                self.mark(index, is_enough);
            }
        })?;
        let columns = size.0;
        let pixels = Pixels {
            size,
            defined: |x: usize, y: usize| seen(y * columns + x).defined,
            value: |x: usize, y: usize| frame.value(y * columns + x),
        };
        // The mark of a cell that was not measured is one.
        let crowded = if survey.is_crowded() { grid.cells() } else { 0 };
        walk.pass(crowded, 2 * cost, |cells| {
            for index in cells {
                let Some(cell) = self.cells.get_mut(index).filter(|cell| cell.known()) else { continue };
                if !self.copy.get(index).is_some_and(|mark| mark.known()) {
                    let quiet = quiet(&pixels, sides(size, grid, index), cell.level, values, &mut keys);
                    cell.quieten(quiet);
                }
            }
        })?;
        self.settle(walk, *survey)
    }

    /// Measures all cells.
    fn measure_cells<P: Sample>(
        &mut self,
        crew: &impl Crew,
        frame: &Raster<'_, P>,
        seen: impl Fn(usize) -> Words + Sync,
        values: &Values,
        keys: Keys<'_>,
    ) -> [Told; MOST_CELLS] {
        let (size, grid) = (self.size, self.grid);
        let of_cell = size.0.div_ceil(grid.width.get()) * size.1.div_ceil(grid.height.max(1));
        let of_cell = NonZero::new(of_cell).unwrap_or(NonZero::<usize>::MIN);
        let row_of_cells = |row: usize, cells: &mut [Sky], Keys(keys, spare): &mut Keys<'_>| {
            let mut told = Told::default();
            // Of a clamped number the compiler does not know that it is one at least.
            let most = TOGETHER.min(keys.len() / of_cell);
            let most = most.max(1);
            for (first, cells) in (0..).step_by(most).zip(cells.chunks_mut(most)) {
                let place = row * grid.width.get() + first;
                let together: [_; TOGETHER] = core::array::from_fn(|column| sides(size, grid, place + column));
                let together = together.get(..cells.len()).unwrap_or(&[]);
                let mut counts = [Count::default(); TOGETHER];
                keys_of_sky(frame, together, &seen, (keys, of_cell), &mut counts);
                let rooms = keys.chunks_mut(of_cell.get()).zip(&counts);
                for (column, (cell, (keys, count))) in (first..).zip(cells.iter_mut().zip(rooms)) {
                    if told.hears(column, count) {
                        *cell = crew.wide(Clipped { sorted: Keys(keys, spare).sort(count.sky), values });
                    }
                }
            }
            told
        };
        // As many groups of rows as hands can work on, and as there is room to sort for.
        let groups = (GROUPS * crew.hands()).min(keys.room() / of_cell).max(1);
        let (rows, room) = (grid.height.div_ceil(groups).max(1), (keys.room() / groups).max(1));
        let mut told = [Told::default(); MOST_CELLS];
        let Keys(keys, spare) = keys;
        let groups = self.cells.chunks_mut((grid.width.get() * rows).max(1)).zip(told.chunks_mut(rows));
        let groups = (0..).step_by(rows).zip(groups).zip(keys.chunks_mut(room).zip(spare.chunks_mut(room)));
        crew.each(groups, |((first, (cells, told)), (keys, spare))| {
            let mut keys = Keys(keys, spare);
            for ((row, cells), told) in (first..).zip(cells.chunks_mut(grid.width.get())).zip(told) {
                *told = row_of_cells(row, cells, &mut keys);
            }
        });
        told
    }

    /// Remembers which cells were measured: in the copy, which is free until the mesh is filtered.
    fn remember(&mut self, told: &[Told]) -> Survey {
        let sum = |part: fn(&Survey) -> u32| told.iter().map(|told| part(&told.survey)).sum();
        let columns = self.grid.width.get();
        for (row, told) in told.iter().enumerate().take(self.grid.height) {
            (0..columns).for_each(|column| self.mark(row * columns + column, told.enough >> column & 1 == 1));
        }
        Survey { cells: sum(|survey| survey.cells), measured: sum(|survey| survey.measured) }
    }

    fn mark(&mut self, index: usize, is_measured: bool) {
        if let Some(mark) = self.copy.get_mut(index) {
            *mark = if is_measured { Sky { level: 0.0, noise: 0.0 } } else { Sky::UNKNOWN };
        }
    }

    /// The same where `frame` is a part of the mesh's, which all its parts measure
    /// together; `seen` goes by the part's indices. `None` while others have yet to answer.
    pub(crate) fn asked<P: Sample>(
        &mut self,
        (whole, round): (&dyn Whole, u32),
        frame: &Raster<'_, P>,
        seen: impl Fn(usize) -> Seen,
        values: &Values,
        mut keys: Keys<'_>,
    ) -> Option<Survey> {
        let (part, size, grid) = (whole.part(), self.size, self.grid);
        let columns = NonZero::new(size.0)?;
        let local = |at: usize| {
            let (x, y) = ((at % columns).checked_sub(part.origin.0)?, (at / columns).checked_sub(part.origin.1)?);
            (x < frame.width).then_some(y * frame.width + x)
        };
        let places = |index: usize| cell_of(size, grid, index).filter_map(local);
        let is_own = |index: &usize| {
            let middle = middle_of(size, grid, *index);
            let (x, y) = (middle.0.checked_sub(part.origin.0), middle.1.checked_sub(part.origin.1));
            x.zip(y).is_some_and(|place| part.owns(place))
        };
        let value = |x: usize, y: usize| local(y * size.0 + x).and_then(|at| frame.value(at));
        let is_defined = |at: usize| local(at).is_some_and(|at| seen(at) != Seen::Undefined);
        let defined = |x: usize, y: usize| {
            (0..WORD).rev().fold(0, |word, bit| word << 1 | u32::from(is_defined(y * size.0 + x + bit)))
        };
        let pixels = Pixels { size, defined, value };
        let cells = &*self.cells;
        let words = |index: usize| {
            let mut count = Count::default();
            let of_sky = places(index).filter(|&at| count.sees(seen(at)) == Seen::Sky);
            let sorted = keys.sorted(of_sky.filter_map(|at| frame.value(at).map(|pixel| pixel + 0.0)));
            let (Sky { level, noise }, is_enough) = (clipped(sorted, values), count.is_enough());
            let Count { all, defined, sky } = count;
            let before = cells.get(index).filter(|cell| cell.known() && !is_enough);
            let quiet = before.and_then(|sky| quiet(&pixels, sides(size, grid, index), sky.level, values, &mut keys));
            let quiet = quiet.unwrap_or(f32::NAN);
            [index as u32, all as u32, defined as u32, sky as u32, level.to_bits(), noise.to_bits(), quiet.to_bits()]
        };
        let answer = whole.words(Question::Cells(round), &mut (0..grid.cells()).filter(is_own).flat_map(words))?;
        let cell = |index: usize| answer.get(index * CELL_WORDS..).and_then(|words| words.first_chunk::<CELL_WORDS>());
        let mut told = [Told::default(); MOST_CELLS];
        for (index, own) in self.cells.iter_mut().enumerate() {
            let Some(&[_, all, defined, sky, level, noise, _]) = cell(index) else { continue };
            let count = Count { all: all as usize, defined: defined as usize, sky: sky as usize };
            let (column, row) = grid.place(index);
            if told.get_mut(row).is_some_and(|told| told.hears(column, &count)) {
                *own = Sky { level: f32::from_bits(level), noise: f32::from_bits(noise) };
            }
        }
        let survey = self.remember(&told);
        if survey.is_crowded() {
            for (index, own) in self.cells.iter_mut().enumerate() {
                let quiet = cell(index).map(|&[.., quiet]| f32::from_bits(quiet)).filter(|quiet| quiet.is_finite());
                own.quieten(quiet.filter(|_| !self.copy.get(index).is_some_and(|mark| mark.known())));
            }
        }
        self.settle(&mut Walk::whole(), survey)?;
        Some(survey)
    }

    /// Settles what cells have that were not measured, and filters the mesh.
    fn settle(&mut self, walk: &mut Walk, survey: Survey) -> Option<()> {
        let (cells, columns, rows) = (self.grid.cells(), self.grid.width.get(), self.grid.height);
        walk.once(cells, || {
            if !survey.is_crowded() {
                let unmeasured = self.cells.iter_mut().zip(self.copy.iter()).filter(|(_, mark)| !mark.known());
                unmeasured.for_each(|(cell, _)| *cell = Sky::UNKNOWN);
            }
        })?;
        walk.pass(columns + rows, 8 * cells, |rings| {
            let _ = { rings }.try_for_each(|_| self.fill());
        })?;
        walk.once(cells, || self.copy())?;
        walk.pass(rows, 8 * columns, |rows| self.smooth(rows))
    }

    fn cell(cells: &[Sky], index: usize) -> Sky {
        cells.get(index).copied().unwrap_or(Sky::UNKNOWN)
    }

    fn copy(&mut self) {
        self.copy.iter_mut().zip(self.cells.iter()).for_each(|(copy, cell)| *copy = *cell);
    }

    /// Unknown cells take the mean of their known neighbours, one ring of them; `None` where there are no more.
    fn fill(&mut self) -> Option<()> {
        if self.cells.iter().all(|cell| cell.known()) {
            return None;
        }
        self.copy();
        for (index, cell) in self.cells.iter_mut().enumerate().filter(|(_, cell)| !cell.known()) {
            let (mut level, mut noise, mut count) = (0.0, 0.0, 0.0);
            let near = self.grid.neighbours(index).map(|near| Self::cell(self.copy, near));
            for near in near.filter(|near| near.known()) {
                (level, noise, count) = (level + near.level, noise + near.noise, count + 1.0);
            }
            if count > 0.0 {
                *cell = Sky { level: level / count, noise: noise / count };
            }
        }
        Some(())
    }

    /// Each cell of some rows becomes the median of the 3 x 3 cells around it; beyond the border the levels go on
    /// straight, so that there a slope is kept too, and the noise stays. The copy has them as they were.
    fn smooth(&mut self, part: Range<usize>) {
        let (columns, rows) = (self.grid.width.get(), self.grid.height);
        for (index, cell) in self.cells.iter_mut().enumerate().take(part.end * columns).skip(part.start * columns) {
            let (column, row) = self.grid.place(index);
            let near = |value: fn(Sky) -> f32, slope: f32| {
                let at = |column: usize, row: usize| value(Self::cell(self.copy, row * columns + column));
                let along = |x: Step, row: usize| x.beyond(|column| at(column, row), slope);
                let places = (0..9).map(|n| (Step::new(column, n % 3, columns), Step::new(row, n / 3, rows)));
                middle(places.map(|(x, y)| y.beyond(|row| along(x, row), slope)))
            };
            *cell = Sky { level: near(|sky| sky.level, 1.0), noise: near(|sky| sky.noise, 0.0) };
        }
    }

    /// Background and noise at a pixel: bilinear between the centres of cells; beyond the outer ones
    /// the level goes on straight, the noise stays.
    pub fn at(&self, x: usize, y: usize) -> Sky {
        let (mut level, mut noise) = ([0.0], [0.0]);
        self.along(x, y, &mut level, &mut noise);
        let ([level], [noise]) = (level, noise);
        Sky { level, noise }
    }

    /// The same for the pixels of row `y` from column `x` on, as many as there is room for.
    #[inline(always)]
    pub fn along(&self, x: usize, y: usize, level: &mut [f32], noise: &mut [f32]) {
        let (columns, up) = (self.grid.width.get(), Between::new(y, self.grid.height, self.scale.1));
        let cell = |row: usize, column: usize| Self::cell(self.cells, row * columns + column);
        let until = x + level.len().min(noise.len());
        let (mut x, mut level, mut noise) = (x, level, noise);
        while x < until {
            // Columns that lie between the same two cells.
            let Between { first, next, .. } = Between::new(x, columns, self.scale.0);
            let end = Between::end(x, until, columns, self.scale.0);
            let (below, below_next) = (cell(up.first, first), cell(up.first, next));
            let (above, above_next) = (cell(up.next, first), cell(up.next, next));
            let levels = [[below.level, above.level], [below_next.level, above_next.level]];
            let noises = [[below.noise, above.noise], [below_next.noise, above_next.noise]];
            let (level_here, level_rest) = level.split_at_mut_checked(end - x).unwrap_or_default();
            let (noise_here, noise_rest) = noise.split_at_mut_checked(end - x).unwrap_or_default();
            for ((level, noise), x) in level_here.iter_mut().zip(noise_here).zip(x as u32..) {
                let across = Between::after(first, x, self.scale.0);
                *level = blend(levels, across.part, up.part);
                *noise = blend(noises, across.inside(), up.inside());
            }
            (x, level, noise) = (end, level_rest, noise_rest);
        }
    }
}

/// Bilinear between two columns of two values each.
#[inline(always)]
fn blend([before, after]: [[f32; 2]; 2], across: f32, up: f32) -> f32 {
    let row = |before: f32, after: f32| before * (1.0 - across) + after * across;
    let ([first, next], [first_after, next_after]) = (before, after);
    row(first, first_after) * (1.0 - up) + row(next, next_after) * up
}

/// First and last column, first and last row of a cell, the last not included.
fn sides((width, height): (usize, usize), grid: Grid, index: usize) -> [usize; 4] {
    let (column, row) = grid.place(index);
    let (columns, rows) = (grid.width, NonZero::new(grid.height).unwrap_or(NonZero::<usize>::MIN));
    [column * width / columns, (column + 1) * width / columns, row * height / rows, (row + 1) * height / rows]
}

/// Lays the keys of the sky's pixels between the sides of some cells of a row, those of each in its own room of `of_cell`,
/// and counts them: row by row of the frame, for pixels that follow each other in memory are read faster.
fn keys_of_sky<P: Sample>(
    frame: &Raster<'_, P>,
    cells: &[[usize; 4]],
    seen: &impl Fn(usize) -> Words,
    (keys, of_cell): (&mut [u32], NonZero<usize>),
    counts: &mut [Count],
) {
    // Adding 0 gives both zeros one key.
    let key = |pixel: &P| (pixel.value() + 0.0).key();
    let (bottom, top) = cells.first().map_or((0, 0), |&[.., bottom, top]| (bottom, top));
    for y in bottom..top {
        let rooms = keys.chunks_mut(of_cell.get()).zip(&mut *counts);
        for (&[left, right, ..], (keys, count)) in cells.iter().zip(rooms) {
            count.all += right - left;
            let pieces = frame.part(y, left..right).chunks(WORD);
            for (first, pixels) in (y * frame.width + left..).step_by(WORD).zip(pieces) {
                let Words { defined, sky } = seen(first).first(pixels.len());
                let free = keys.get_mut(count.sky..).unwrap_or(&mut []);
                if sky.count_ones() as usize == pixels.len() {
                    free.iter_mut().zip(pixels).for_each(|(free, pixel)| *free = key(pixel));
                } else {
                    lay(pixels.iter().map(key), sky, free);
                }
                count.defined += defined.count_ones() as usize;
                count.sky += sky.count_ones() as usize;
            }
        }
    }
}

/// Lays the keys that have their bit, without asking for each.
fn lay(keys: impl Iterator<Item = u32>, mut bits: u32, free: &mut [u32]) {
    let mut next = 0;
    for key in keys {
        if let Some(free) = free.get_mut(next) {
            *free = key;
        }
        next += (bits & 1) as usize;
        bits >>= 1;
    }
}

/// The pixels of a cell, row by row.
fn cell_of(size: (usize, usize), grid: Grid, index: usize) -> impl Iterator<Item = usize> + use<> {
    let [left, right, bottom, top] = sides(size, grid, index);
    (bottom..top).flat_map(move |y| y * size.0 + left..y * size.0 + right)
}

/// Column and row in the middle of a cell: the part that has it measures the cell.
fn middle_of(size: (usize, usize), grid: Grid, index: usize) -> (usize, usize) {
    let [left, right, bottom, top] = sides(size, grid, index);
    (usize::midpoint(left, right), usize::midpoint(bottom, top))
}

/// What is told of a row of cells.
#[derive(Clone, Copy, Default)]
struct Told {
    survey: Survey,
    /// A bit for each cell that has enough sky.
    enough: u64,
}

impl Told {
    /// Hears of the pixels of a cell; whether it has enough sky to be measured.
    fn hears(&mut self, column: usize, count: &Count) -> bool {
        let is_enough = count.is_enough();
        self.survey.cells += u32::from(count.defined > 0);
        self.survey.measured += u32::from(is_enough);
        self.enough |= u64::from(is_enough) << column;
        is_enough
    }
}

/// What the pixels of a cell are.
#[derive(Clone, Copy, Default)]
struct Count {
    all: usize,
    defined: usize,
    sky: usize,
}

impl Count {
    #[inline]
    fn sees(&mut self, seen: Seen) -> Seen {
        self.all += 1;
        self.defined += usize::from(seen != Seen::Undefined);
        self.sky += usize::from(seen == Seen::Sky);
        seen
    }

    fn is_enough(&self) -> bool {
        let sky = self.sky;
        sky >= LEAST_PIXELS && sky * 100 >= self.defined * LEAST_SKY && sky * LEAST_SHARE >= self.all
    }
}

/// A cell beside another along an axis: within the mesh the cell itself; beyond it the border's, and
/// the one before that.
#[derive(Clone, Copy)]
struct Step {
    near: usize,
    far: usize,
}

impl Step {
    /// `offset` 0 is the cell before, 1 the same, 2 the one after.
    fn new(at: usize, offset: usize, cells: usize) -> Step {
        let last = cells.saturating_sub(1);
        let one = |near: usize| Step { near, far: near };
        match offset {
            0 => at.checked_sub(1).map_or(Step { near: 0, far: last.min(1) }, one),
            2 if at >= last => Step { near: last, far: last.saturating_sub(1) },
            2 => one(at + 1),
            _ => one(at),
        }
    }

    fn beyond(self, value: impl Fn(usize) -> f32, slope: f32) -> f32 {
        let (near, far) = (value(self.near), value(self.far));
        let beyond = near + slope * (near - far);
        if beyond.is_finite() { beyond } else { near }
    }
}

/// A place between the centres of two cells, or beyond the outer ones.
#[derive(Clone, Copy)]
struct Between {
    first: usize,
    next: usize,
    /// How far it is from the first towards the next, -1/2 to 3/2.
    part: f32,
}

impl Between {
    fn new(at: usize, cells: usize, scale: f32) -> Between {
        let first = Self::first(at, cells, scale);
        Between { next: (first + 1).min(cells.saturating_sub(1)), ..Self::after(first, at as u32, scale) }
    }

    fn first(at: usize, cells: usize, scale: f32) -> usize {
        (((at as f32 + 0.5) * scale - 0.5) as usize).min(cells.saturating_sub(2))
    }

    /// A place between the cell `first` and the one after it.
    #[inline(always)]
    fn after(first: usize, at: u32, scale: f32) -> Between {
        // No axis has 2^31 pixels, and what has a sign is converted by vector units.
        let at = at as i32 as f32;
        Between { first, next: first + 1, part: ((at + 0.5) * scale - 0.5) - first as f32 }
    }

    /// The first place after `at`, at most `until`, that lies after another cell.
    fn end(at: usize, until: usize, cells: usize, scale: f32) -> usize {
        let first = Self::first(at, cells, scale);
        let (mut inside, mut end) = (at, until);
        while end - inside > 1 {
            let middle = inside.midpoint(end);
            let after = Self::first(middle, cells, scale) == first;
            (inside, end) = if after { (middle, end) } else { (inside, middle) };
        }
        end
    }

    #[inline(always)]
    fn inside(self) -> f32 {
        let part = if self.part > 0.0 { self.part } else { 0.0 };
        if part < 1.0 { part } else { 1.0 }
    }
}

/// The median of nine values.
fn middle(of: impl Iterator<Item = f32>) -> f32 {
    let mut values = [0.0; 9];
    values.iter_mut().zip(of).for_each(|(out, value)| *out = value);
    sort::few(&mut values, |a, b| a.key() < b.key());
    let [.., middle, _, _, _, _] = values;
    middle
}

#[cfg(test)]
mod tests {
    use super::super::{CELL, cell_pixels};
    use super::*;
    use crate::plane::part::Part;
    use crate::sky::noise::tests::normal;

    extern crate std;
    use std::sync::Mutex;
    use std::vec::Vec;

    const SIDE: usize = 320;

    /// Noise of 1 on a level that differs from pixel to pixel.
    fn frame(level: impl Fn(usize, usize) -> f32) -> Vec<f32> {
        let noise = normal(SIDE * SIDE, 0.0, 1.0);
        (0..noise.len()).map(|at| noise[at * 7919 % noise.len()] + level(at % SIDE, at / SIDE)).collect()
    }

    fn measure(mesh: &mut Mesh<'_>, pixels: &[f32], seen: impl Fn(usize, usize) -> Seen + Sync) -> Survey {
        let room = cell_pixels(SIDE, SIDE, CELL);
        let (mut keys, mut spare) = (std::vec![0; room], std::vec![0; room]);
        let seen = |at: usize| seen(at % SIDE, at / SIDE);
        mesh.measure(pixels, seen, &Values::UNKNOWN, Keys(&mut keys, &mut spare))
    }

    fn cells() -> [Sky; mesh_cells(SIDE, SIDE, CELL)] {
        [Sky::UNKNOWN; mesh_cells(SIDE, SIDE, CELL)]
    }

    /// Rows are looked at 32 pixels at a time, of which the last may lie beyond the frame.
    #[test]
    fn no_pixel_beyond_the_frame_is_asked_for() {
        let pixels = normal(60 * 60, 0.0, 1.0);
        let (mut cells, mut room) = ([Sky::UNKNOWN; mesh_cells(60, 60, CELL)], [[0; 3600]; 2]);
        let [keys, spare] = &mut room;
        let seen = |at: usize| if pixels[at].is_finite() { Seen::Sky } else { Seen::Undefined };
        let survey =
            Mesh::blank(&mut cells, (60, 60), CELL).measure(&pixels, seen, &Values::UNKNOWN, Keys(keys, spare));
        assert_eq!(survey, Survey { cells: 1, measured: 1 });
    }

    #[test]
    fn a_slope_is_followed_into_the_corners() {
        let slope = |x: usize, y: usize| 0.05 * x as f32 - 0.03 * y as f32;
        let (pixels, mut cells) = (frame(slope), cells());
        let mut mesh = Mesh::blank(&mut cells, (SIDE, SIDE), CELL);
        let survey = measure(&mut mesh, &pixels, |_, _| Seen::Sky);
        assert_eq!(survey, Survey { cells: 25, measured: 25 });
        for (x, y) in [(0, 0), (319, 0), (0, 319), (319, 319), (160, 0), (0, 160), (31, 200), (100, 290)] {
            let sky = mesh.at(x, y);
            assert!((sky.level - slope(x, y)).abs() < 0.2, "{} beside {} at {x}, {y}", sky.level, slope(x, y));
            // A cell of 64 pixels spans 3.2 and 1.9 of the slope.
            assert!((1.0..1.6).contains(&sky.noise), "{} at {x}, {y}", sky.noise);
        }
    }

    #[test]
    fn along_a_row_there_is_what_there_is_at_each_pixel() {
        for side in [1, 63, 100, 130, SIDE] {
            let mut cells: Vec<Sky> = (0..mesh_cells(side, side, CELL))
                .map(|n| Sky { level: (n * 7919 % 101) as f32 - 0.3, noise: 1.0 + (n * 31 % 17) as f32 })
                .collect();
            let mesh = Mesh::over(&mut cells, (side, side), CELL);
            let (mut level, mut noise) = (std::vec![0.0; side], std::vec![0.0; side]);
            for (first, y) in [(0, 0), (side / 3, side / 2), (side - 1, side - 1)] {
                mesh.along(first, y, &mut level[first..], &mut noise[first..]);
                for x in first..side {
                    let sky = mesh.at(x, y);
                    assert_eq!([level[x], noise[x]].map(f32::to_bits), [sky.level, sky.noise].map(f32::to_bits));
                }
            }
        }
    }

    /// Levels and noise bend, so that each place tells the cells it lies between.
    #[test]
    fn between_cells_there_is_what_lies_on_the_line_and_beyond_them_noise_stays() {
        let (mut cells, square) = (cells(), |n: usize| (n * n) as f32);
        cells.iter_mut().enumerate().for_each(|(n, cell)| {
            *cell = Sky { level: square(n % 5), noise: 1.0 + square(n / 5) };
        });
        let mesh = Mesh::over(&mut cells, (SIDE, SIDE), CELL);
        // Centres lie at 31.5 and so on, 64 pixels apart.
        for (at, first, part) in [(0, 0, -63.0), (40, 0, 17.0), (130, 1, 69.0), (200, 2, 81.0), (319, 3, 191.0)] {
            let (near, next, part) = (square(first), square(first + 1), part / 128.0);
            let line = |part: f32| near + part * (next - near);
            let (level, noise) = (mesh.at(at, 100).level, mesh.at(100, at).noise);
            assert!((level - line(part)).abs() < 1e-5, "{level} at {at}, not {}", line(part));
            assert!((noise - 1.0 - line(part.clamp(0.0, 1.0))).abs() < 1e-5, "{noise} at {at}");
        }
    }

    #[test]
    fn pixels_are_counted_as_what_they_are() {
        let mut count = Count::default();
        for seen in [Seen::Sky, Seen::Source, Seen::Undefined, Seen::Sky] {
            assert!(count.sees(seen) == seen);
        }
        assert_eq!((count.all, count.defined, count.sky), (4, 3, 2));
    }

    #[test]
    fn a_cell_without_sky_has_that_of_its_neighbours() {
        let source = |x: usize, y: usize| (64..128).contains(&x) && (64..128).contains(&y);
        let pixels = frame(|x, y| if source(x, y) { 500.0 } else { 100.0 });
        let mut cells = cells();
        let mut mesh = Mesh::blank(&mut cells, (SIDE, SIDE), CELL);
        let seen = |x: usize, y: usize| match source(x, y) {
            // A tenth of the cell is left, all of it wings.
            true if !x.is_multiple_of(10) => Seen::Source,
            _ => Seen::Sky,
        };
        assert_eq!(measure(&mut mesh, &pixels, seen), Survey { cells: 25, measured: 24 });
        let sky = mesh.at(95, 95);
        assert!((sky.level - 100.0).abs() < 0.1 && (sky.noise - 1.0).abs() < 0.05, "{sky:?}");
    }

    /// What is left where sources are everywhere is darker and quieter round by round.
    #[test]
    fn a_crowded_mesh_keeps_what_was_measured_first() {
        let (pixels, mut cells) = (frame(|_, _| 100.0), cells());
        let mut mesh = Mesh::blank(&mut cells, (SIDE, SIDE), CELL);
        measure(&mut mesh, &pixels, |_, _| Seen::Sky);
        let first = mesh.at(160, 160);
        let dark = |x: usize, y: usize| if pixels[y * SIDE + x] < 99.0 { Seen::Sky } else { Seen::Source };
        for _ in 0..5 {
            let survey = measure(&mut mesh, &pixels, dark);
            assert_eq!(survey, Survey { cells: 25, measured: 0 });
            assert!(survey.is_crowded());
        }
        let last = mesh.at(160, 160);
        assert!((last.level - first.level).abs() < 0.05 && (last.noise / first.noise - 1.0).abs() < 0.03, "{last:?}");
    }

    #[test]
    fn nothing_is_known_of_a_mesh_without_sky() {
        let (pixels, mut cells) = (frame(|_, _| 100.0), cells());
        let mut mesh = Mesh::blank(&mut cells, (SIDE, SIDE), CELL);
        let survey = measure(&mut mesh, &pixels, |x, _| if x < 10 { Seen::Source } else { Seen::Undefined });
        assert_eq!(survey, Survey { cells: 5, measured: 0 });
        assert!(mesh.at(5, 5).level.is_nan());
        let survey = measure(&mut mesh, &pixels, |x, y| if x < 4 && y < 4 { Seen::Sky } else { Seen::Undefined });
        assert_eq!(survey, Survey { cells: 1, measured: 0 }, "16 pixels of 4096 are too few");
    }

    #[test]
    fn a_window_is_one_cell() {
        let pixels: Vec<f32> = normal(64, 7.0, 1.0);
        let mut cells = [Sky::UNKNOWN; mesh_cells(8, 8, CELL)];
        let (mut keys, mut spare) = ([0; 64], [0; 64]);
        let mut mesh = Mesh::blank(&mut cells, (8, 8), CELL);
        mesh.measure(&pixels, |_| Seen::Sky, &Values::UNKNOWN, Keys(&mut keys, &mut spare));
        assert_eq!(mesh.at(0, 0), mesh.at(7, 7));
        assert!((mesh.at(3, 4).level - 7.0).abs() < 0.1);
    }

    /// A part that tells what it is asked for, and has no answer.
    #[derive(Debug)]
    struct Telling(Part, Mutex<Vec<u32>>);

    impl Whole for Telling {
        fn part(&self) -> Part {
            self.0.clone()
        }

        fn words(&self, _: Question, own: &mut dyn Iterator<Item = u32>) -> Option<&[u32]> {
            self.1.lock().expect("one thread").extend(own);
            None
        }

        fn sums(&self, _: Question, _: &mut dyn FnMut() -> [f64; 4]) -> Option<[f64; 4]> {
            None
        }

        fn knows(&self, _: Question) -> bool {
            false
        }

        fn is_waiting(&self) -> bool {
            true
        }
    }

    /// The first of two cells ends beyond the one part, and the second begins before the other.
    #[test]
    fn a_part_counts_the_pixels_of_a_cell_that_it_has() {
        const COLUMNS: usize = 40;
        let (size, pixels) = ((2 * CELL, CELL), std::vec![1.0; COLUMNS * CELL]);
        for (index, left) in [(0, 0), (1, 2 * CELL - COLUMNS)] {
            let mut cells = [Sky::UNKNOWN; mesh_cells(2 * CELL, CELL, CELL)];
            let (mut keys, mut spare) = (std::vec![0; CELL * CELL], std::vec![0; CELL * CELL]);
            let part = Part { image: size, origin: (left, 0), columns: 0..COLUMNS, rows: 0..CELL };
            let (telling, frame) = (Telling(part, Mutex::default()), Raster::of(&pixels, COLUMNS));
            let keys = Keys(&mut keys, &mut spare);
            let mut mesh = Mesh::blank(&mut cells, size, CELL);
            assert_eq!(mesh.asked((&telling, 0), &frame, |_| Seen::Sky, &Values::UNKNOWN, keys), None);
            let (words, count) = (telling.1.into_inner().expect("one thread"), (COLUMNS * CELL) as u32);
            assert_eq!((words.len(), &words[..4]), (CELL_WORDS, &[index, count, count, count][..]));
        }
    }
}
