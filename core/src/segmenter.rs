//! The state machine that takes a frame through all steps, in slices of bounded work.

use crate::arithmetic::{Arithmetic, Cell, Real};
use crate::budget;
use crate::catalog::Source;
use crate::config::{Config, Filter, Normalize, Rescale, Scheme, Start, Tau};
use crate::edge::EdgeDetector;
use crate::error::Error;
use crate::filter::{Heat, PeronaMalik};
use crate::frame::Frame;
use crate::front::{Front, LEAST_SIDE};
use crate::label::{Damaged, Table};
use crate::march::March;
use crate::memory::{Memory, flags_len};
use crate::normalize::{self, Range};
use crate::outcome::{Outcome, Progress, StopReason};
use crate::rescale::Rescaler;
use crate::scheme::{AnyScheme, Evolve, Step};
use crate::select::Select;
use crate::settle::Settle;
use crate::snapshot::{Parts, SnapshotError};
use crate::stage::Stage;
use crate::start;
use crate::state::State;
use crate::stop::{Change, StopRule};
use crate::sweep::{Band, Halo, Kernel, advance, row_of, row_of_mut};
use crate::tiles::{Tiles, rows_of_tile};

/// A run over one frame: immutable configuration, the caller's memory, and the state.
///
/// `S` is the scheme: [`AnyScheme`] takes it from the configuration; naming one of
/// [`crate::scheme`] leaves the others out of the program.
#[derive(Debug)]
pub struct Segmenter<'m, A: Arithmetic, S: Evolve<A> = AnyScheme<A>> {
    config: Config,
    width: usize,
    height: usize,
    bound: u64,
    front: Front,
    scheme: S,
    rule: StopRule<A>,
    settle: Settle<A>,
    memory: Memory<'m, A>,
    state: State<A>,
    /// The memory was found damaged, or holds half a snapshot.
    broken: bool,
}

/// A front about to move: see [`Segmenter::evolution`].
#[derive(Debug)]
pub struct Evolution<'a, A: Arithmetic, S> {
    /// The front, row-major.
    pub front: &'a mut [A::Cell],
    /// The edge detector.
    pub speed: &'a [A::Cell],
    /// Columns.
    pub width: usize,
    /// Rows of a tile.
    pub tile_rows: usize,
    /// The scheme.
    pub scheme: &'a S,
    /// When the front has stopped.
    pub rule: StopRule<A>,
    /// How new values are settled.
    pub settle: Settle<A>,
    /// The most steps it can take.
    pub max_steps: u32,
}

impl<'m, A: Arithmetic, S: Evolve<A>> Segmenter<'m, A, S> {
    /// Sets up a run; nothing can be wrong with the parameters or the memory afterwards.
    ///
    /// # Errors
    /// [`Error::Parameter`], [`Error::Arithmetic`], [`Error::Size`] or [`Error::Length`].
    pub fn new(config: &Config, width: usize, height: usize, memory: Memory<'m, A>) -> Result<Self, Error> {
        config.validate::<A>()?;
        let most_pixels = (A::Cell::MAX_LABEL as usize).saturating_mul(64);
        let pixels = width.saturating_mul(height);
        if width < LEAST_SIDE || height < LEAST_SIDE || width > 1 << 20 || pixels > most_pixels {
            return Err(Error::Size { width, height, least: LEAST_SIDE, most_pixels });
        }
        let front = Front::new(config, width, height);
        let scheme = S::new(config, front.unit).map_err(|_| Error::Arithmetic {
            name: A::NAME,
            reason: "the configuration names another scheme than this program was built for",
        })?;
        memory.check(width, height, scheme.window())?;
        let flags = flags_len(width, height);
        let memory = Memory { tiles: memory.tiles.get_mut(..flags).unwrap_or(&mut []), ..memory };
        let rule = StopRule::new(config, front.unit);
        let state = State::new(config, &rule);
        let bound = budget::total_rows(config, height);
        let settle = Settle::new(config.band);
        Ok(Segmenter {
            config: *config,
            width,
            height,
            bound,
            front,
            scheme,
            rule,
            settle,
            memory,
            state,
            broken: false,
        })
    }

    /// Does at most `rows` rows (at least one) of the pass under way.
    ///
    /// The same bits come out whatever the slices. After an error of the frame source the same
    /// poll can be tried again; after [`Error::Corrupted`] the run cannot go on.
    ///
    /// # Errors
    /// [`Error::Frame`], [`Error::NothingDefined`], [`Error::Constant`] or [`Error::Corrupted`].
    pub fn poll<F: Frame>(&mut self, rows: usize, frame: &mut F) -> Result<Progress, Error<F::Error>> {
        if self.broken {
            return Err(corrupted("an earlier poll or snapshot"));
        }
        let result = self.slice(rows, frame);
        self.broken = matches!(result, Err(Error::Corrupted { .. }));
        result
    }

    fn slice<F: Frame>(&mut self, rows: usize, frame: &mut F) -> Result<Progress, Error<F::Error>> {
        let height = self.height;
        // A run that was left alone has always some of its budget left here.
        if self.state.work >= self.bound && self.state.stage != Stage::Done {
            return Err(corrupted("the state"));
        }
        let end = self.state.row.saturating_add(rows.max(1)).min(height);
        match self.state.stage {
            Stage::Filter => self.filter_rows(end),
            Stage::Gradient => {
                let mut kernel = self.state.gradient;
                self.sweep_image(&mut kernel, end);
                self.state.gradient = kernel;
            }
            Stage::Edge => self.sweep_image(&mut EdgeDetector::<A>::new(&self.config, &self.state.gradient), end),
            Stage::Evolve => self.evolve_rows(end),
            Stage::Done => return Ok(Progress::Done(self.outcome())),
            _ => {
                for y in self.state.row..end {
                    self.single_row(y, frame)?;
                    self.state.row = y.saturating_add(1);
                    self.state.work = self.state.work.saturating_add(1);
                }
            }
        }
        let swept = end.saturating_sub(self.state.row) as u64;
        self.state.work = self.state.work.saturating_add(swept);
        self.state.row = end;
        if end == height {
            self.end_pass().map_err(|error| error.map_frame(|never| match never {}))?;
        }
        Ok(self.progress())
    }

    /// Writes the run out as a snapshot ([`crate::snapshot`]), in chunks of at most 64 bytes.
    ///
    /// # Errors
    /// The first error of `write`; the run goes on as if nothing had been asked.
    pub fn save<E>(&mut self, write: impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        self.parts().save(write)
    }

    /// Takes up the run of a snapshot in the place of this one, which must have the same
    /// configuration, size and length of the catalogue. `read` fills the whole slice or fails.
    ///
    /// # Errors
    /// [`SnapshotError`]; this run is then lost, and every poll reports [`Error::Corrupted`].
    pub fn restore<E>(&mut self, read: impl FnMut(&mut [u8]) -> Result<(), E>) -> Result<(), SnapshotError<E>> {
        let result = self.parts().restore(read);
        self.broken = result.is_err();
        result
    }

    fn parts(&mut self) -> Parts<'_, 'm, A> {
        Parts {
            config: &self.config,
            width: self.width,
            height: self.height,
            window: self.scheme.window(),
            bound: self.bound,
            memory: &mut self.memory,
            state: &mut self.state,
        }
    }

    /// One row of a stage that looks at no neighbours.
    fn single_row<F: Frame>(&mut self, y: usize, frame: &mut F) -> Result<(), Error<F::Error>> {
        let width = self.width;
        let state = &mut self.state;
        let samples = self.memory.samples.get_mut(..width).unwrap_or(&mut []);
        let image = row_of_mut(self.memory.image, width, y);
        if state.stage.reads_frame() {
            frame.row(y, samples).map_err(Error::Frame)?;
        }
        match state.stage {
            Stage::Extremes => state.extremes.observe(samples),
            Stage::LowPercentile | Stage::HighPercentile | Stage::Median => state.select.observe(samples),
            Stage::Normalize => normalize::row::<A>(state.range, state.fill, samples, image),
            Stage::Otsu => {
                for (cell, _) in image.iter().zip(samples).filter(|(_, pixel)| pixel.is_finite()) {
                    state.histogram.add(A::pixel(*cell).to_f32());
                }
            }
            Stage::Rescale => {
                if let Some(rescaler) = Rescaler::<A>::new(self.config.rescale, A::Real::of(state.tau)) {
                    rescaler.row(image);
                }
            }
            Stage::StartLevel => image.iter().for_each(|&cell| state.histogram.add(A::pixel(cell).to_f32())),
            Stage::StartMark | Stage::StartUp | Stage::StartDown => self.start_row(y),
            Stage::Front => self.front_row(y).map_err(corrupted)?,
            Stage::Seed | Stage::Sow | Stage::March | Stage::Arrive => self.march_row(y),
            _ => self.label_row(y).map_err(corrupted)?,
        }
        Ok(())
    }

    fn front_row(&mut self, y: usize) -> Result<(), &'static str> {
        let row = row_of_mut(self.memory.front, self.width, y);
        match self.config.start {
            Start::Frame => self.front.row::<A>(y, row),
            Start::Threshold { margin } => self.front.outside_row::<A>(margin, row),
            Start::Given => {
                for cell in row {
                    let value = A::level(*cell).to_f32();
                    if !value.is_finite() {
                        return Err("the given front: a value is not finite");
                    }
                    *cell = A::to_level(A::Real::of(self.front.saturate(value)));
                }
            }
        }
        Ok(())
    }

    fn start_row(&mut self, y: usize) {
        let Start::Threshold { margin } = self.config.start else { return };
        let (width, last) = (self.width, self.height.saturating_sub(1));
        let front = &mut *self.memory.front;
        match self.state.stage {
            Stage::StartMark => {
                let image = row_of(self.memory.image, width, y);
                start::mark_row::<A>(image, self.state.tau, margin, row_of_mut(front, width, y));
            }
            // The rows above y are not touched: the row before lies at a lower index.
            Stage::StartUp => {
                let (before, rest) = front.split_at_mut_checked(y * width).unwrap_or((&mut [], &mut []));
                start::spread_row::<A>(row_of(before, width, y.wrapping_sub(1)), row_of_mut(rest, width, 0));
            }
            _ => {
                let (rows, after) = front.split_at_mut_checked((last - y + 1) * width).unwrap_or((&mut [], &mut []));
                let before = if y == 0 { &[] } else { row_of(after, width, 0) };
                start::spread_row::<A>(before, row_of_mut(rows, width, last - y));
            }
        }
    }

    fn march_row(&mut self, y: usize) {
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
        // The table passes take as many labels a row as a row has pixels.
        let first_label = u32::try_from(start).unwrap_or(u32::MAX).saturating_add(1);
        let last_label = first_label.saturating_add(width as u32).saturating_sub(1).min(state.labels);
        match state.stage {
            Stage::Provisional => {
                let samples = self.memory.samples.get(..width).unwrap_or(&[]);
                let connectivity = self.config.connectivity;
                let in_mask = |(cell, pixel): (&A::Cell, &f32)| A::level(*cell) > A::Real::ZERO && pixel.is_finite();
                let mask = row.iter().zip(samples).map(in_mask).filter(|&inside| inside).count();
                state.mask_pixels = state.mask_pixels.saturating_add(mask as u32);
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
            Stage::Count => table.count_row(row).map_err(LABELS)?,
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

    fn sweep_image<K: Kernel<A, 3>>(&mut self, kernel: &mut K, end: usize) {
        let rows = self.state.row..end;
        let pixels = self.width.saturating_mul(self.height);
        let image = self.memory.image.get_mut(..pixels).unwrap_or(&mut []);
        let mut band = Band { plane: image, aux: &[], ring: self.memory.ring, width: self.width, halo: Halo::NONE };
        advance::<A, K, 3>(kernel, &mut band, rows);
    }

    fn filter_rows(&mut self, end: usize) {
        match self.config.filter {
            Filter::None => {}
            Filter::Heat => self.sweep_image(&mut Heat::<A>::new(&self.config), end),
            Filter::PeronaMalik { diffusivity, mu } => {
                self.sweep_image(&mut PeronaMalik::<A>::new(&self.config, diffusivity, mu), end);
            }
        }
    }

    fn evolve_rows(&mut self, end: usize) {
        let pixels = self.width.saturating_mul(self.height);
        let front = self.memory.front.get_mut(..pixels).unwrap_or(&mut []);
        let speed = self.memory.image.get(..pixels).unwrap_or(&[]);
        let rows = self.state.row..end;
        let mut band = Band { plane: front, aux: speed, ring: self.memory.ring, width: self.width, halo: Halo::NONE };
        let mut tiles = Tiles::new(self.memory.tiles, self.width, rows_of_tile(self.height));
        let mut step = Step { settle: self.settle, change: self.state.change };
        self.scheme.advance(&mut band, &mut tiles, rows, &mut step);
        self.state.change = step.change;
        if end == self.height {
            tiles.turn(&[], &[]);
        }
    }

    /// The last row of a pass is done: what follows from it, and the next pass.
    fn end_pass(&mut self) -> Result<(), Error> {
        let state = &mut self.state;
        state.row = 0;
        state.pass = state.pass.saturating_add(1);
        match state.stage {
            Stage::Extremes => {
                if state.extremes.defined == 0 {
                    return Err(Error::NothingDefined { pixels: self.width.saturating_mul(self.height) });
                }
                state.range = Range { low: state.extremes.least, high: state.extremes.greatest };
            }
            Stage::LowPercentile | Stage::HighPercentile | Stage::Median => {
                let Some(value) = state.select.end_pass() else { return Ok(()) };
                match state.stage {
                    Stage::LowPercentile => state.range.low = value,
                    Stage::HighPercentile => state.range.high = value,
                    _ => state.fill = value,
                }
            }
            Stage::Otsu | Stage::StartLevel => state.tau = state.histogram.otsu(),
            Stage::March if state.marching => return Ok(()),
            Stage::March => {
                // The time of the last arrival, in steps.
                state.steps = (state.march.latest() * self.config.dx / self.config.dt) as u32;
                state.reason = StopReason::Rest;
            }
            Stage::Filter if state.pass < u32::from(self.config.filter_steps) => return Ok(()),
            Stage::Evolve => {
                state.steps = state.pass;
                state.last_change = self.rule.norm(&state.change);
                let at_rest = self.rule.at_rest(&state.change);
                state.change = Change::none(&self.rule);
                if at_rest {
                    state.reason = StopReason::Rest;
                } else if state.steps < self.config.max_steps() {
                    return Ok(());
                }
            }
            _ => {}
        }
        self.begin_stage(self.stage_after(self.state.stage))
    }

    fn begin_stage(&mut self, stage: Stage) -> Result<(), Error> {
        let state = &mut self.state;
        (state.stage, state.pass) = (stage, 0);
        let defined = state.extremes.defined;
        match (stage, self.config.normalize) {
            (Stage::LowPercentile, Normalize::Percentile { low, .. }) => {
                state.select = Select::percentile(low, defined)
            }
            (Stage::HighPercentile, Normalize::Percentile { high, .. }) => {
                state.select = Select::percentile(high, defined);
            }
            (Stage::Median, _) => state.select = Select::percentile(50.0, defined),
            (Stage::Normalize, _) => {
                if state.range.low >= state.range.high {
                    return Err(Error::Constant { value: state.range.low });
                }
                state.fill = state.range.apply(state.fill, 0.0);
            }
            (Stage::Evolve, _) => Tiles::new(self.memory.tiles, self.width, rows_of_tile(self.height)).wake(),
            (Stage::Measure, _) => {
                for (label, source) in (1..=state.numbered).zip(self.memory.sources.iter_mut()) {
                    *source = Source::empty(label);
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// The stage after `stage`, without those that this configuration and image do not need.
    fn stage_after(&self, stage: Stage) -> Stage {
        let mut next = stage.following(self.config.order);
        // No more than seven optional stages can follow each other.
        for _ in 0..7 {
            if self.needed(next) {
                break;
            }
            next = next.following(self.config.order);
        }
        next
    }

    fn needed(&self, stage: Stage) -> bool {
        let starts_near = matches!(self.config.start, Start::Threshold { .. });
        let marches = self.config.scheme == Scheme::FastMarching;
        match stage {
            Stage::LowPercentile | Stage::HighPercentile => {
                matches!(self.config.normalize, Normalize::Percentile { .. })
            }
            Stage::Median => (self.state.extremes.defined as usize) < self.width.saturating_mul(self.height),
            Stage::Otsu => matches!(self.config.rescale, Rescale::R3 { tau: Tau::Otsu, .. }),
            Stage::Rescale => self.config.rescale != Rescale::None,
            Stage::StartLevel => starts_near && !matches!(self.config.rescale, Rescale::R3 { .. }),
            Stage::StartMark | Stage::StartUp | Stage::StartDown => starts_near,
            Stage::Evolve => !marches,
            Stage::Seed | Stage::Sow | Stage::March | Stage::Arrive => marches,
            Stage::Filter => self.config.filter != Filter::None && self.config.filter_steps > 0,
            _ => true,
        }
    }

    fn progress(&self) -> Progress {
        let state = &self.state;
        match state.stage {
            Stage::Done => Progress::Done(self.outcome()),
            stage => {
                Progress::Working { stage, pass: state.pass, row: state.row as u32, last_change: state.last_change }
            }
        }
    }

    fn outcome(&self) -> Outcome {
        let state = &self.state;
        let per_dx = 0.5 / self.config.dx;
        Outcome {
            reason: state.reason,
            steps: state.steps,
            last_change: state.last_change,
            extremes: state.extremes,
            range: state.range,
            tau: state.tau,
            gradient: (state.gradient.least.to_f32() * per_dx, state.gradient.greatest.to_f32() * per_dx),
            mask_pixels: state.mask_pixels,
            sources: state.numbered,
            catalogued: state.numbered.min(u32::try_from(self.memory.sources.len()).unwrap_or(u32::MAX)),
            unlabelled: state.unlabelled,
            work: state.work,
        }
    }

    /// The evolution, while it is at the start of a step: what a caller needs who moves the front
    /// by its own means, in bands on several processors, and then tells
    /// [`Self::finish_evolution`].
    pub fn evolution(&mut self) -> Option<Evolution<'_, A, S>> {
        let pixels = self.width.saturating_mul(self.height);
        let due = self.state.stage == Stage::Evolve && self.state.row == 0 && self.state.pass == 0;
        due.then_some(Evolution {
            front: self.memory.front.get_mut(..pixels)?,
            speed: self.memory.image.get(..pixels)?,
            width: self.width,
            tile_rows: rows_of_tile(self.height),
            scheme: &self.scheme,
            rule: self.rule,
            settle: self.settle,
            max_steps: self.config.max_steps(),
        })
    }

    /// Ends an evolution that was done elsewhere: the number of steps and the last one's change.
    ///
    /// # Errors
    /// Those of [`Self::poll`], without the frame's.
    pub fn finish_evolution(&mut self, steps: u32, change: Change<A>) -> Result<Progress, Error> {
        self.state.work = self.state.work.saturating_add(u64::from(steps).saturating_mul(self.height as u64));
        (self.state.pass, self.state.change) = (steps.saturating_sub(1), change);
        self.end_pass()?;
        Ok(self.progress())
    }

    /// The image plane: W x H cells that hold what the stage under way makes of them.
    pub fn image(&self) -> &[A::Cell] {
        self.memory.image.get(..self.width.saturating_mul(self.height)).unwrap_or(&[])
    }

    /// The front plane: the front until the evolution ends, then labels.
    pub fn front(&self) -> &[A::Cell] {
        self.memory.front.get(..self.width.saturating_mul(self.height)).unwrap_or(&[])
    }

    /// The catalogue of a finished run: label, area, moments and fluxes of each source.
    pub fn catalog(&self) -> &[Source] {
        let done = self.state.stage == Stage::Done;
        let count = if done { self.outcome().catalogued as usize } else { 0 };
        self.memory.sources.get(..count).unwrap_or(&[])
    }

    /// The stage under way.
    pub fn stage(&self) -> Stage {
        self.state.stage
    }

    /// Row operations done so far, and the most that the run can need ([`budget::total_rows`]).
    pub fn work(&self) -> (u64, u64) {
        (self.state.work, self.bound)
    }

    /// The front's unit: how many units of the front plane make 1 of the paper's `u0`.
    pub fn unit(&self) -> f32 {
        self.front.unit
    }
}

/// What a damaged label table is called.
const LABELS: fn(Damaged) -> &'static str = |_| "the label table";

fn corrupted<E>(name: &'static str) -> Error<E> {
    Error::Corrupted { name }
}

/// Adds a row of labelled pixels to their sources; sources beyond the catalogue are left out.
fn measure_row<C: Cell>(labels: &[C], y: usize, pixels: &[f32], floor: f32, sources: &mut [Source]) {
    for ((x, cell), &pixel) in (0u32..).zip(labels).zip(pixels) {
        if let Some(source) = (cell.label() as usize).checked_sub(1).and_then(|index| sources.get_mut(index)) {
            source.add(x, y as u32, pixel, floor);
        }
    }
}
