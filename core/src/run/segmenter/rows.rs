//! What each stage does to one row, or to a few of them.

use super::{Segmenter, corrupted};
use crate::arithmetic::{Arithmetic, Cell, Real};
use crate::config::{Motion, Normalize, Rescale, Start, Tau};
use crate::error::Error;
use crate::front::bands::{Bands, Pull};
use crate::front::march::March;
use crate::front::pair;
use crate::front::profile::turn_row;
use crate::front::scheme::{Evolve, Step};
use crate::front::start;
use crate::image::filter::{AnyFilter, Measured, Planes};
use crate::image::normalize;
use crate::image::rescale::Rescaler;
use crate::plane::rows::{row_of, row_of_mut};
use crate::plane::sweep::{Band, Halo, Kernel, advance};
use crate::plane::tiles::{Tiles, rows_of_tile};
use crate::run::frame::Frame;
use crate::run::plan::reads_frame;
use crate::run::stage::Stage;
use crate::sources::catalog::Source;
use crate::sources::label::{Damaged, Table, labelled_pieces};

impl<A: Arithmetic, S: Evolve<A>> Segmenter<'_, A, S> {
    /// One row of a stage that looks at no neighbours.
    pub(super) fn single_row<F: Frame>(&mut self, y: usize, frame: &mut F) -> Result<(), Error<F::Error>> {
        let width = self.width;
        let (has_bands, pixels) = (self.has_bands(), width.saturating_mul(self.height));
        let state = &mut self.state;
        let samples = self.memory.samples.get_mut(..width).unwrap_or(&mut []);
        let (mut image, mut first_row) = (&mut *self.memory.image, 0);
        if has_bands {
            // Levels are told in the same order as bands are made ready.
            let last = self.bands.each.len().saturating_sub(1);
            let levels = state.stage == Stage::StartLevel;
            let at = if levels { last.saturating_sub(state.pass as usize) } else { self.bands.under_way() };
            (image, first_row) = (self.bands.plane_mut(at, pixels), at.saturating_mul(self.height));
        }
        let image = row_of_mut(image, width, y);
        let counts = &mut *self.memory.counts;
        if reads_frame(state.stage) {
            frame.row(first_row.saturating_add(y), samples).map_err(Error::Frame)?;
        }
        match state.stage {
            Stage::Extremes => state.extremes.observe(samples),
            Stage::LowPercentile | Stage::HighPercentile | Stage::Median => {
                state.select.observe(counts, samples.iter().copied());
            }
            Stage::Sky => {
                if let Normalize::Noise { .. } = self.config.normalize {
                    state.noise.observe(&state.select, counts, samples.iter().copied());
                }
            }
            Stage::Normalize => normalize::row::<A>(state.range, state.fill, samples, image),
            Stage::Threshold => {
                let defined = image.iter().zip(samples).filter(|(_, pixel)| pixel.is_finite());
                let values = defined.map(|(cell, _)| A::pixel(*cell).to_f32());
                if let Rescale::R3 { tau: Tau::Noise { .. }, .. } = self.config.rescale {
                    state.noise.observe(&state.select, counts, values);
                } else {
                    values.for_each(|value| counts.add(value));
                }
            }
            Stage::Rescale => {
                if let Some(rescaler) = Rescaler::<A>::new(self.config.rescale, A::Real::of(state.tau)) {
                    rescaler.row(image);
                }
            }
            Stage::StartLevel => image.iter().for_each(|&cell| counts.add(A::pixel(cell).to_f32())),
            Stage::StartMark | Stage::StartUp | Stage::StartDown => self.start_row(y),
            Stage::Front => self.front_row(y).map_err(corrupted)?,
            Stage::Seed | Stage::Sow | Stage::March | Stage::Arrive => self.march_row(y),
            Stage::Turn => self.turn_row(y),
            _ => self.label_row(y).map_err(corrupted)?,
        }
        Ok(())
    }

    fn front_row(&mut self, y: usize) -> Result<(), &'static str> {
        let row = row_of_mut(self.memory.front, self.width, y);
        match self.config.start {
            _ if self.config.scheme.has_two_fronts() => {
                let image = row_of(self.memory.image, self.width, y);
                pair::start_row::<A>(self.state.regions.means.values::<A>(), image, row);
            }
            Start::Frame => self.profile.row::<A>(y, row),
            Start::Threshold { margin } => self.profile.outside_row::<A>(margin, row),
            Start::Given => {
                for cell in row {
                    let value = A::level(*cell).to_f32();
                    if !value.is_finite() {
                        return Err("the given front: a value is not finite");
                    }
                    // Schemes lower the front: one that grows is moved upside down.
                    let value = if self.config.motion == Motion::Outward { 0.0 - value } else { value };
                    *cell = A::to_level(A::Real::of(self.profile.saturate(value)));
                }
            }
        }
        if self.has_bands() {
            let pixels = self.width.saturating_mul(self.height);
            let front = self.memory.front.get(..pixels).unwrap_or(&[]);
            self.bands.add_rows(front, self.width, y..y.saturating_add(1));
        } else if self.config.scheme.is_by_regions() {
            let image = row_of(self.memory.image, self.width, y);
            self.state.regions.add_row::<A>(row_of(self.memory.front, self.width, y), image);
        }
        Ok(())
    }

    fn turn_row(&mut self, y: usize) {
        let row = row_of_mut(self.memory.front, self.width, y);
        match (self.config.scheme.has_two_fronts(), self.state.pass) {
            (true, 0) => {
                pair::decide_row::<A>(row);
                self.state.regions.add_row::<A>(row, row_of(self.memory.image, self.width, y));
            }
            (true, _) => pair::rank_row::<A>(self.state.regions.ranks(), row),
            (false, _) => turn_row::<A>(row),
        }
    }

    fn start_row(&mut self, y: usize) {
        let Start::Threshold { margin } = self.config.start else { return };
        let (width, last) = (self.width, self.height.saturating_sub(1));
        let (has_bands, pixels) = (self.has_bands(), width.saturating_mul(self.height));
        let front = &mut *self.memory.front;
        match self.state.stage {
            Stage::StartMark if has_bands => {
                let row = row_of_mut(front, width, y);
                for (at, (band, plane)) in self.bands.iter(pixels).enumerate() {
                    let image = row_of(plane, width, y);
                    if at == 0 {
                        start::mark_row::<A>(image, band.tau, margin, row);
                    } else {
                        start::mark_also::<A>(image, band.tau, row);
                    }
                }
            }
            Stage::StartMark => {
                let image = row_of(self.memory.image, width, y);
                start::mark_row::<A>(image, self.state.tau, margin, row_of_mut(front, width, y));
            }
            // The rows above y are not touched: the row before lies at a lower index.
            Stage::StartUp => {
                let (before, rest) = front.split_at_mut_checked(y.saturating_mul(width)).unwrap_or((&mut [], &mut []));
                start::spread_row::<A>(row_of(before, width, y.wrapping_sub(1)), row_of_mut(rest, width, 0));
            }
            _ => {
                let y_down = last.saturating_sub(y);
                let end = y_down.saturating_add(1).saturating_mul(width);
                let (rows, after) = front.split_at_mut_checked(end).unwrap_or((&mut [], &mut []));
                let before = if y == 0 { &[] } else { row_of(after, width, 0) };
                start::spread_row::<A>(before, row_of_mut(rows, width, y_down));
            }
        }
    }

    fn march_row(&mut self, y: usize) {
        if !S::MARCHES {
            return;
        }
        let (width, pixels) = (self.width, self.width.saturating_mul(self.height));
        let front = self.memory.front.get_mut(..pixels).unwrap_or(&mut []);
        let speed = self.memory.image.get(..pixels).unwrap_or(&[]);
        let state = &mut self.state;
        match state.stage {
            Stage::Seed => March::seed_row::<A>(row_of_mut(front, width, y)),
            Stage::Sow => state.march.sow_row::<A>(front, speed, width, y),
            Stage::March => state.marching = state.march.advance::<A>(front, speed, width, width),
            _ => March::level_row::<A>(row_of_mut(front, width, y), self.config.farthest()),
        }
    }

    fn label_row(&mut self, y: usize) -> Result<(), &'static str> {
        let (width, state) = (self.width, &mut self.state);
        let mut table = Table::new(self.memory.image);
        let start = y.saturating_mul(width);
        let (before, rest) = self.memory.front.split_at_mut_checked(start).unwrap_or((&mut [], &mut []));
        let row = row_of_mut(rest, width, 0);
        let before = row_of(before, width, y.wrapping_sub(1));
        // The columns that no front can have reached.
        let far = |margin: &usize| (*margin..self.height.saturating_sub(*margin)).contains(&y);
        let unreached =
            self.config.beyond_reach().filter(far).map_or(0..0, |margin| margin..width.saturating_sub(margin));
        // The table passes take as many labels a row as a row has pixels.
        let first_label = u32::try_from(start).unwrap_or(u32::MAX).saturating_add(1);
        let last_label = first_label.saturating_add(width as u32).saturating_sub(1).min(state.labels);
        match state.stage {
            Stage::Provisional => {
                let samples = self.memory.samples.get(..width).unwrap_or(&[]);
                let connectivity = self.config.connectivity;
                let in_mask = |(cell, pixel): (&A::Cell, &f32)| A::level(*cell) > A::Real::ZERO && pixel.is_finite();
                let count = |columns: core::ops::Range<usize>| {
                    let cells = row.get(columns.clone()).unwrap_or(&[]).iter();
                    cells.zip(samples.get(columns).unwrap_or(&[])).filter(|&pixel| in_mask(pixel)).count() as u32
                };
                state.mask_pixels = state.mask_pixels.saturating_add(count(0..width));
                state.unreached = state.unreached.saturating_add(count(unreached));
                let unlabelled = table
                    .provisional_row::<A>(row, before, samples, connectivity, &mut state.labels)
                    .map_err(LABELS)?;
                state.unlabelled = state.unlabelled.saturating_add(unlabelled);
            }
            Stage::Resolve => {
                for label in first_label..=last_label {
                    table.resolve(label).map_err(LABELS)?;
                }
            }
            Stage::Count => {
                table.count_row(row).map_err(LABELS)?;
                table.drop_row(row.get(unreached).unwrap_or(&[]));
            }
            Stage::Number => {
                for label in first_label..=last_label {
                    table.number(label, self.config.min_area, &mut state.numbered).map_err(LABELS)?;
                }
            }
            _ => {
                table.final_row(row).map_err(LABELS)?;
                measure_row(row, y, self.memory.samples, state.range.low, self.memory.sources);
            }
        }
        Ok(())
    }

    pub(super) fn sweep_image<K: Kernel<A, 3>>(&mut self, kernel: &mut K, end: usize) {
        let (rows, width, pixels) = (self.state.row..end, self.width, self.width.saturating_mul(self.height));
        let has_bands = self.has_bands();
        let Self { memory, bands, .. } = self;
        let plane = image_of(memory.image, bands, has_bands, pixels);
        let mut band = Band { plane, aux: &[], ring: memory.ring, width, halo: Halo::NONE };
        advance::<A, K, 3>(kernel, &mut band, rows);
    }

    pub(super) fn filter_rows(&mut self, end: usize) {
        let (rows, pixels) = (self.state.row..end, self.width.saturating_mul(self.height));
        let has_bands = self.has_bands();
        let mut planes = Planes {
            image: image_of(self.memory.image, &mut self.bands, has_bands, pixels),
            spare: self.memory.front.get_mut(..pixels).unwrap_or(&mut []),
            ring: &mut *self.memory.ring,
            width: self.width,
        };
        let (select, counts) = (&self.state.select, &mut *self.memory.counts);
        let measured = Measured { select, counts, value: self.state.noise.noise };
        let pass = (self.state.pass, self.config.filter_steps);
        AnyFilter::<A>::new(&self.config).rows(&mut planes, pass, measured, rows);
    }

    pub(super) fn evolve_rows(&mut self, end: usize) {
        let pixels = self.width.saturating_mul(self.height);
        let (has_bands, rows, width) = (self.has_bands(), self.state.row..end, self.width);
        if has_bands {
            let pull = Pull::new(&self.config, self.bands.each.len());
            let force = self.memory.image.get_mut(..pixels).unwrap_or(&mut []);
            self.bands.force_rows(&pull, force, width, rows.clone());
        }
        let front = self.memory.front.get_mut(..pixels).unwrap_or(&mut []);
        let speed = self.memory.image.get(..pixels).unwrap_or(&[]);
        let mut band = Band { plane: front, aux: speed, ring: self.memory.ring, width: self.width, halo: Halo::NONE };
        let mut tiles = Tiles::new(self.memory.tiles, self.width, rows_of_tile(self.height));
        let mut step = Step { settle: self.settle, change: self.state.change, means: self.state.regions.means };
        if has_bands {
            self.scheme.follow(&mut band, &mut tiles, rows.clone(), &mut step);
            self.bands.add_rows(self.memory.front.get(..pixels).unwrap_or(&[]), width, rows);
        } else {
            self.scheme.advance(&mut band, &mut tiles, rows, &mut step);
        }
        self.state.change = step.change;
        if end == self.height {
            tiles.turn(&[], &[]);
        }
    }
}

/// The plane in which the steps up to the filtered image work: that of the band under way, where there are several.
#[inline(always)]
fn image_of<'a, A: Arithmetic>(
    image: &'a mut [A::Cell],
    bands: &'a mut Bands<'_, A>,
    has_bands: bool,
    pixels: usize,
) -> &'a mut [A::Cell] {
    if has_bands { bands.plane_mut(bands.under_way(), pixels) } else { image.get_mut(..pixels).unwrap_or(&mut []) }
}

/// What a damaged label table is called.
const LABELS: fn(Damaged) -> &'static str = |_| "the label table";

/// Adds a row of labelled pixels to their sources; sources beyond the catalogue are left out.
fn measure_row<C: Cell>(labels: &[C], y: usize, pixels: &[f32], floor: f32, sources: &mut [Source]) {
    for (start, piece) in labelled_pieces(labels) {
        let cells = (start as u32..).zip(piece).zip(pixels.get(start..).unwrap_or(&[]));
        for ((x, cell), &pixel) in cells.filter(|((_, cell), _)| cell.bits() != C::BLANK.bits()) {
            if let Some(source) = (cell.label() as usize).checked_sub(1).and_then(|index| sources.get_mut(index)) {
                source.add(x, y as u32, pixel, floor);
            }
        }
    }
}
