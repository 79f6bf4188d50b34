//! The state machine that takes a frame through all steps, in slices of bounded work.

mod order;
mod rows;

use crate::arithmetic::{Arithmetic, Cell, Real};
use crate::config::Config;
use crate::error::Error;
use crate::front::bands::{Band, Bands};
use crate::front::edge::EdgeDetector;
use crate::front::profile::{LEAST_SIDE, MOST_COLUMNS, Profile};
use crate::front::region::Regions;
use crate::front::scheme::{AnyScheme, Chosen, Evolve};
use crate::front::settle::Settle;
use crate::front::stop::{Change, StopRule};
use crate::plane::tiles::rows_of_tile;
use crate::run::frame::Frame;
use crate::run::memory::{Memory, flags_len};
use crate::run::outcome::{Outcome, Progress};
use crate::run::plan::Plan;
use crate::run::snapshot::{Parts, SnapshotError};
use crate::run::stage::Stage;
use crate::run::state::State;
use crate::sources::catalog::Source;

/// A run over one frame: immutable configuration, the caller's memory, and the state.
///
/// `S` is the scheme: [`AnyScheme`] takes it from the configuration; naming one of
/// [`crate::front::scheme`] leaves the others out of the program.
#[derive(Debug)]
pub struct Segmenter<'m, A: Arithmetic, S: Evolve<A> = AnyScheme<A>> {
    config: Chosen<A, S>,
    width: usize,
    height: usize,
    bound: u64,
    profile: Profile,
    scheme: S,
    rule: StopRule<A>,
    settle: Settle<A>,
    memory: Memory<'m, A>,
    bands: Bands<'m, A>,
    state: State<A>,
    /// What ended the run before its end.
    ended: Option<Error>,
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
    /// The two regions of Chan and Vese, before the first step.
    pub regions: Regions,
    /// The most steps it can take.
    pub max_steps: u32,
}

impl<'m, A: Arithmetic, S: Evolve<A>> Segmenter<'m, A, S> {
    /// Sets up a run; nothing can be wrong with the parameters or the memory afterwards.
    ///
    /// # Errors
    /// [`Error::Front`], [`Error::Parameter`], [`Error::Arithmetic`], [`Error::Size`] or [`Error::Length`].
    pub fn new(config: &Config, width: usize, height: usize, memory: Memory<'m, A>) -> Result<Self, Error> {
        Self::with(config, width, height, memory, Bands::none())
    }

    /// Sets up a run over several bands of one frame ([`crate::front::bands`]): the rows of the second follow those of
    /// the first, as the planes of a cube in FITS do, and so on: row `y` of band `i` is row `i height + y` of the
    /// frame. Sources, the outcome and what pixels are defined are told of the first. Cost beside that of one band: the
    /// steps up to the filtered image for each, and in each step of the front two looks at each pixel of each.
    ///
    /// # Errors
    /// Those of [`Self::new`]; [`Error::Length`] or [`Error::Parameter`] for too few or too many bands, and
    /// [`Error::Together`] or [`Error::Arithmetic`] where the front goes by one alone.
    pub fn of_bands(
        config: &Config,
        width: usize,
        height: usize,
        memory: Memory<'m, A>,
        bands: Bands<'m, A>,
    ) -> Result<Self, Error> {
        bands.check(config, width.saturating_mul(height))?;
        if !S::FOLLOWS {
            let reason = "the program was built for a scheme that goes by one band alone";
            return Err(Error::Arithmetic { name: A::NAME, reason });
        }
        bands.each.fill(Band::NEW);
        Self::with(config, width, height, memory, bands)
    }

    fn with(
        config: &Config,
        width: usize,
        height: usize,
        memory: Memory<'m, A>,
        bands: Bands<'m, A>,
    ) -> Result<Self, Error> {
        if !config.needs_segmenter() {
            return Err(Error::Front { scheme: config.scheme.name(), mover: "an extractor" });
        }
        let (given, chosen) = (config, Chosen::<A, S>::new(*config));
        let config = &*chosen;
        config.validate::<A>()?;
        let most_pixels = (A::Cell::MAX_LABEL as usize).saturating_mul(64);
        let pixels = width.saturating_mul(height);
        if width < LEAST_SIDE || height < LEAST_SIDE || width > MOST_COLUMNS || pixels > most_pixels {
            return Err(Error::Size { width, height, least: LEAST_SIDE, most_columns: MOST_COLUMNS, most_pixels });
        }
        let profile = Profile::new(config, width, height);
        let scheme = S::new(given, profile.unit).map_err(|_| Error::Arithmetic {
            name: A::NAME,
            reason: "the configuration names another scheme or setting than this program was built for",
        })?;
        memory.check(width, height, scheme.window())?;
        let flags = flags_len(width, height);
        let memory = Memory { tiles: memory.tiles.get_mut(..flags).unwrap_or(&mut []), ..memory };
        let rule = StopRule::new(config, profile.unit);
        let state = State::new(config, &rule);
        let bound = Plan::of_bands(config, bands.each.len()).total_rows(height);
        let settle = Settle::new(config.band);
        Ok(Segmenter {
            config: chosen,
            width,
            height,
            bound,
            profile,
            scheme,
            rule,
            settle,
            memory,
            bands,
            state,
            ended: None,
        })
    }

    /// Does at most `rows` rows (at least one) of the pass under way.
    ///
    /// The same bits come out whatever the slices. After an error of the frame source the same
    /// poll can be tried again; after any other the run cannot go on, and every poll reports the same.
    ///
    /// # Errors
    /// [`Error::Frame`], [`Error::NothingDefined`], [`Error::Constant`], [`Error::Corrupted`] or, after a
    /// failed [`Self::restore`], [`Error::NotRestored`].
    pub fn poll<F: Frame>(&mut self, rows: usize, frame: &mut F) -> Result<Progress, Error<F::Error>> {
        if let Some(ended) = self.ended {
            return Err(ended.map_frame(|never| match never {}));
        }
        self.slice(rows, frame).map_err(|error| match error.of_run() {
            Ok(ended) => self.end(ended).map_frame(|never| match never {}),
            Err(frame) => Error::Frame(frame),
        })
    }

    /// Ends the run with an error.
    fn end(&mut self, error: Error) -> Error {
        *self.ended.insert(error)
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

    /// Writes the run out as a snapshot ([`crate::run::snapshot`]), in chunks of at most 64 bytes.
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
    /// [`SnapshotError`]; this run is then lost, and every poll reports [`Error::NotRestored`], until
    /// a snapshot is taken up.
    pub fn restore<E>(&mut self, read: impl FnMut(&mut [u8]) -> Result<(), E>) -> Result<(), SnapshotError<E>> {
        let result = self.parts().restore(read);
        self.ended = result.as_ref().err().map(|_| Error::NotRestored);
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
            bands: &mut self.bands,
            state: &mut self.state,
        }
    }

    /// Whether several bands move the front.
    #[inline(always)]
    fn has_bands(&self) -> bool {
        S::FOLLOWS && !self.bands.each.is_empty()
    }

    fn plan(&self) -> Plan<'_> {
        Plan::of_bands(&self.config, if S::FOLLOWS { self.bands.each.len() } else { 1 })
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

    /// What the run has found so far; of several bands, of the one under way.
    pub fn outcome(&self) -> Outcome {
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
            unreached: state.unreached,
            work: state.work,
        }
    }

    /// The evolution, while it is at the start of a step: what a caller needs who moves the front
    /// by its own means, in bands on several processors, and then tells
    /// [`Self::finish_evolution`]. A front that several bands move is left to [`Self::poll`].
    pub fn evolution(&mut self) -> Option<Evolution<'_, A, S>> {
        let pixels = self.width.saturating_mul(self.height);
        let due = self.state.stage == Stage::Evolve && self.state.row == 0 && self.state.pass == 0 && !self.has_bands();
        due.then_some(Evolution {
            front: self.memory.front.get_mut(..pixels)?,
            speed: self.memory.image.get(..pixels)?,
            width: self.width,
            tile_rows: rows_of_tile(self.height),
            scheme: &self.scheme,
            rule: self.rule,
            settle: self.settle,
            regions: self.state.regions,
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
        self.end_pass().map_err(|error| self.end(error))?;
        Ok(self.progress())
    }

    /// The image plane: W x H cells that hold what the stage under way makes of them. Of several bands, the plane of
    /// the one under way, which are made from the last to the first.
    pub fn image(&self) -> &[A::Cell] {
        if self.has_bands() {
            return self.bands.plane(self.bands.under_way(), self.width.saturating_mul(self.height));
        }
        self.memory.image.get(..self.width.saturating_mul(self.height)).unwrap_or(&[])
    }

    /// What the front sees of a band of several, from the front's start on: W x H cells; none of a band that there is not.
    pub fn band(&self, at: usize) -> &[A::Cell] {
        self.bands.plane(at, self.width.saturating_mul(self.height))
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

    /// Columns and rows of the frame.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// The stage under way.
    pub fn stage(&self) -> Stage {
        self.state.stage
    }

    /// Row operations done so far, and the most that the run can need ([`Plan::total_rows`]).
    pub fn work(&self) -> (u64, u64) {
        (self.state.work, self.bound)
    }

    /// The front's unit: how many units of the front plane make 1 of the paper's `u0`.
    pub fn unit(&self) -> f32 {
        self.profile.unit
    }
}

fn corrupted<E>(name: &'static str) -> Error<E> {
    Error::Corrupted { name }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;
    use crate::plane::sweep::ring_len;
    use crate::run::frame::SliceFrame;
    use crate::sky::otsu::Histogram;

    const SIDE: usize = 16;

    /// What the last three of ten polls and more say of a frame of one value.
    fn last_polls(pixel: f32) -> [Result<Progress, Error>; 3] {
        let (mut image, mut front) = ([0.0; SIDE * SIDE], [0.0; SIDE * SIDE]);
        let (mut ring, mut samples, mut counts) = ([0.0; ring_len(SIDE, 3)], [0.0; SIDE], Histogram::EMPTY);
        let mut tiles = [0; flags_len(SIDE, SIDE)];
        let memory = Memory {
            image: &mut image,
            front: &mut front,
            ring: &mut ring,
            tiles: &mut tiles,
            samples: &mut samples,
            counts: &mut counts,
            sources: &mut [],
        };
        let mut run = Segmenter::<F32>::new(&Config::PAPER_F160, SIDE, SIDE, memory).expect("room enough");
        let pixels = [pixel; SIDE * SIDE];
        let mut poll = || run.poll(SIDE, &mut SliceFrame(&pixels));
        for _ in 0..10 {
            let _ = poll();
        }
        [poll(), poll(), poll()]
    }

    #[test]
    fn errors_end_a_run() {
        assert_eq!(last_polls(f32::NAN), [Err(Error::NothingDefined { pixels: SIDE * SIDE }); 3]);
        assert_eq!(last_polls(3.0), [Err(Error::Constant { value: 3.0 }); 3]);
    }
}
