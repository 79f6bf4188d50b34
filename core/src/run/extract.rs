//! A run on signal-to-noise: sky, noise, smoothing, a front, the tree of level sets, deblending and
//! the cut on significance, as the configuration has them.
//!
//! An [`Extractor`] goes through the steps of its [`Plan`], one per poll. The front of
//! [`Scheme::Region`] is a step of its own; that of every other scheme the caller moves over
//! [`Extractor::image`], with a [`Segmenter`](crate::run::segmenter::Segmenter) of the same
//! configuration, and hands it over by [`Extractor::outline`]. Of a filter in steps before the region's own front
//! the same segmenter makes the filtered image alone, for [`Extractor::start_from`].
//!
//! The run is deterministic, with at most a fixed number of passes over the planes and
//! one sort of the pixels in use. The sky is measured in the image's own single precision; from
//! signal-to-noise on, all there is for every pixel is in the [`Level`] of the caller's choice, and
//! single precision has no more to do than what there is once a frame or region: the cut, the
//! photon noise, the centres of wide regions.

pub mod catalogue;
pub mod snapshot;
mod state;

use crate::arithmetic::{Fixed14, Level};
use crate::config::{Config, Filter, Scheme, Select};
use crate::error::Error;
use crate::front::outline::Front;
use crate::plane::crew::{Alone, Crew};
use crate::plane::field::Field;
use crate::plane::grid::Grid;
use crate::plane::mask::{Mask, MaskMut};
use crate::plane::part::{Question, Whole};
use crate::plane::raster::{Raster, Sample};
use crate::plane::rows::rows_of_mut;
use crate::plane::sort::Keys;
use crate::plane::walk::Walk;
use crate::run::budget;
use crate::run::plan::{Plan, ROUNDS};
use crate::run::stage::Stage;
use crate::run::workspace::Workspace;
use crate::sky::view::{Known, View};
use crate::sky::{LEAST_PIXELS, Sky, Survey, Values, photon, signal};
use crate::sources::selection;
use crate::sources::separate;
use state::State;

/// What a run found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Number of sources; labels run from 1 to this, in raster order of first pixels.
    pub sources: u32,
    /// Pixels of sources.
    pub mask_pixels: u32,
    /// Peaks for which the table of regions had no room: their pixels are in no source.
    pub unlabelled: u32,
    /// Regions in the table; what lies behind them is of no run.
    pub regions: usize,
    /// Pixels that no front can have reached: they are in no source.
    pub unreached: u32,
    /// The cut on the peak in the matched image, in its noise.
    pub significance: f32,
    /// The photon noise of the image (see [`crate::sky::photon`]).
    pub photon: f32,
    /// Pixels that stood alone as hot pixels do: see [`Config::spike_height`].
    pub spikes: u32,
    /// How the values of the frame came about.
    pub values: Values,
    /// How much of the sky could be measured, in the last round.
    pub survey: Survey,
}

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// This is to be done next.
    Next(Stage),
    /// A filter is to go over [`Extractor::image`], and what it leaves to be given to [`Extractor::start_from`].
    Filter,
    /// A front is to move over [`Extractor::image`], and to be given to [`Extractor::outline`].
    Front,
    /// Nothing is left to do.
    Done(Found),
}

/// A run over a frame in the caller's memory.
#[derive(Debug)]
pub struct Extractor<'a, 'm, L: Level, P = f32> {
    config: Config,
    grid: Grid,
    view: View<'a, P>,
    work: Workspace<'m, L>,
    state: State<L>,
    /// The most work.
    bound: u64,
    /// What ended the run before its end.
    ended: Option<Error>,
}

/// More than an [`Extractor`] itself takes, beside the [`Workspace`].
pub const EXTRACTOR_BYTES: usize = 2560;

const _: () = assert!(size_of::<Extractor<'_, '_, f32, u16>>() <= EXTRACTOR_BYTES);
const _: () = assert!(size_of::<Extractor<'_, '_, Fixed14, f32>>() <= EXTRACTOR_BYTES);

impl<'a, 'm, L: Level> Extractor<'a, 'm, L> {
    /// Sets up a run over `pixels` (row-major, not finite = undefined).
    ///
    /// # Errors
    /// Those of [`Extractor::over`].
    pub fn new(
        config: &Config,
        pixels: &'a [f32],
        width: usize,
        known: Known<'a>,
        work: Workspace<'m, L>,
    ) -> Result<Self, Error> {
        Extractor::set_up(config, (Raster::of(pixels, width), pixels.len(), width), known, work)
    }
}

impl<'a, 'm, L: Level, P: Sample> Extractor<'a, 'm, L, P> {
    /// Sets up a run over a frame as it lies in memory, in single precision or in a camera's counts. What comes out
    /// has the bits of a run over the same numbers in single precision.
    ///
    /// Each row is read seven times, and a sample of at most 65536 pixels once more; where pixels are undefined, some
    /// are looked at again. A frame that others may write to meanwhile ([`Sample::CHANGES`]) is summed up as it is
    /// read, and where pixels are undefined read once more at the end.
    ///
    /// # Errors
    /// What [`Config::validate_values`] finds, [`Error::Together`] for a configuration without a sky,
    /// [`Error::Size`], [`Error::Length`] for memory or maps of another size, [`Error::Arithmetic`]
    /// for a side longer than [`Level::LONGEST`], or [`Error::Parameter`] for a camera out of bounds or bad pixels that
    /// are not in order.
    pub fn over(
        config: &Config,
        frame: Raster<'a, P>,
        known: Known<'a>,
        work: Workspace<'m, L>,
    ) -> Result<Self, Error> {
        Extractor::set_up(config, (frame, frame.count(), frame.width), known, work)
    }

    fn set_up(
        config: &Config,
        (frame, count, width): (Raster<'a, P>, usize, usize),
        known: Known<'a>,
        work: Workspace<'m, L>,
    ) -> Result<Self, Error> {
        config.validate_values()?;
        if !config.sky.is_known() {
            return Err(moved_elsewhere(config));
        }
        let grid = work.check(count, width, config.sky.cell(), known)?;
        known.check()?;
        let bound = budget::cells(config, (grid.width.get(), grid.height), work.regions.len());
        Ok(Extractor {
            config: *config,
            grid,
            view: View { frame, grid, known, values: Values::UNKNOWN },
            work,
            state: State::NEW,
            bound,
            ended: None,
        })
    }

    /// Work done so far, and the most that the run can need ([`budget::cells`]), in cells.
    pub fn work_done(&self) -> (u64, u64) {
        (self.state.walk.spent(), self.bound)
    }

    /// How far the run is.
    pub fn progress(&self) -> Progress {
        match self.next() {
            Some(stage) if stage.is_of_front() && self.config.scheme == Scheme::Region => Progress::Filter,
            Some(stage) if stage.is_of_front() => Progress::Front,
            Some(stage) => Progress::Next(stage),
            None => Progress::Done(self.found()),
        }
    }

    fn next(&self) -> Option<Stage> {
        Plan::of(&self.config).steps().nth(self.state.done).map(|step| step.stage)
    }

    /// Does at most `rows` rows (at least one) of the step under way; where a filter or a front is awaited, or nothing is
    /// left to do, nothing. A row is as many pixels of a pass, keys of a sort or regions of the table as the frame has
    /// columns; where that is more, a cell of the mesh, and once each what the sample of the values tells.
    ///
    /// The same bits come out whatever the parts. A frame that is a part of an image is worked on in whole steps. After an
    /// error the run cannot go on, and every poll reports the same.
    ///
    /// # Errors
    /// [`Error::NothingDefined`], [`Error::NoSky`] and [`Error::NoNoise`] where the frame tells nothing
    /// of its sky or of its noise; [`Error::FrameChanged`] where others have written to it; [`Error::Waiting`] where
    /// other parts of an image have yet to answer.
    pub fn poll(&mut self, rows: usize) -> Result<Progress, Error> {
        self.resume(rows.saturating_mul(self.grid.width.get()));
        self.go_on(&Alone)
    }

    /// Does what is left of one pass of the step under way, for a look at what it leaves ([`Extractor::work`]) beside
    /// what it found. Of a frame that is a part of an image, the step.
    ///
    /// # Errors
    /// As [`Extractor::poll`].
    pub fn poll_pass(&mut self) -> Result<Progress, Error> {
        match self.view.known.whole {
            Some(_) => self.state.walk.resume(usize::MAX),
            None => self.state.walk.resume_pass(),
        }
        self.go_on(&Alone)
    }

    /// How many passes of the step under way are done. In a step with a loop the numbers of its passes come again in
    /// every round, and those behind it follow on them by a fixed distance.
    pub fn passes(&self) -> u32 {
        self.state.walk.done()
    }

    /// Does all that is left of the step under way by a crew, which has no part in the result.
    ///
    /// # Errors
    /// As [`Extractor::poll`].
    // Its instructions are counted by its name.
    #[inline(never)]
    pub fn poll_by(&mut self, crew: &impl Crew) -> Result<Progress, Error> {
        self.resume(usize::MAX);
        self.go_on(crew)
    }

    /// Lets so many cells be worked on; a part of an image goes in whole steps.
    fn resume(&mut self, cells: usize) {
        self.state.walk.resume(if self.view.known.whole.is_some() { usize::MAX } else { cells });
    }

    fn go_on(&mut self, crew: &impl Crew) -> Result<Progress, Error> {
        if let Some(ended) = self.ended {
            return Err(ended);
        }
        if let Some(stage) = self.next().filter(|stage| !stage.is_of_front()) {
            let whole = self.view.known.whole;
            let is_done = match self.step(stage, crew) {
                Ok(_) if whole.is_some_and(Whole::is_waiting) => Err(Error::Waiting),
                // A run that was left alone ends within its bound.
                Ok(None) if self.state.walk.spent() > self.bound => Err(Error::Corrupted { name: "the state" }),
                result => result,
            };
            if is_done.map_err(|error| *self.ended.insert(error))?.is_some() {
                self.end_step(stage);
            }
        }
        Ok(self.progress())
    }

    fn end_step(&mut self, stage: Stage) {
        if let Stage::Tree | Stage::Components = stage {
            self.state.dividing.opening.count = self.state.growing.count;
        }
        self.state.walk.end();
        self.state.done += 1;
    }

    /// Goes on with a step; nothing where there is more to do.
    fn step(&mut self, stage: Stage, crew: &impl Crew) -> Result<Option<()>, Error> {
        let (round, known) = (self.round(), self.view.known.whole);
        if let Some(whole) = known.filter(|whole| round < first_round(*whole, self.view.values)) {
            return self.pass_over(stage, round, whole);
        }
        let Extractor { config, grid, view, work, state, .. } = self;
        let (noise, masked_from, count) = (state.noise(), state.masked_from(), state.count());
        let State { walk, measured, smoothing, curve, growing, dividing, .. } = state;
        let (grid, is_whole) = (*grid, view.is_whole());
        let inside = |at: usize| is_whole || view.has_signal(at);
        Ok(match stage {
            Stage::Values => return self.look(),
            Stage::Background => {
                if signal::measure((walk, crew), measured, view, config, round, &mut work.sky()).is_none() {
                    return Ok(None);
                }
                return self.check_measured();
            }
            Stage::Smooth => signal::smooth((walk, crew), smoothing, view, round, &mut work.sky()),
            Stage::Mask => {
                let outline = L::of(config.outline.threshold);
                signal::mask_sources((walk, crew), view, outline, masked_from, &mut work.sky())
            }
            Stage::Photon => {
                let (field, keys) = (Field { values: &*work.signal, grid }, Keys(work.parents, work.order));
                photon::step(walk, (known, curve), field, work.fine, Mask(work.masked), (work.labels, keys))
            }
            Stage::Outline => {
                let start = smoothed(config.filter, [work.signal, work.fine, work.smooth]);
                let start = (!config.filter.is_stepped()).then_some(start);
                Front::new(config.outline).outline_in((walk, crew), (work.fine, start), work.labels, work.rows, grid)
            }
            Stage::Tree => {
                separate::tree((walk, crew), growing, grid, inside, (config, noise.photon), &mut work.separation())
            }
            Stage::Deblend => {
                let divided =
                    separate::deblend((walk, crew), dividing, known, grid, config, noise, &mut work.separation());
                divided.and_then(|()| drop_undefined(walk, view, work.labels))
            }
            Stage::Components => {
                let connectivity = config.connectivity;
                let found = separate::components(walk, growing, grid, inside, connectivity, &mut work.separation());
                found.and_then(|()| drop_undefined(walk, view, work.labels))
            }
            Stage::Select => {
                if self.select(count.regions, crew).is_none() {
                    return Ok(None);
                }
                return self.check_frame();
            }
            _ => Some(()),
        })
    }

    /// What the sky and the frame were like when they were measured.
    fn check_measured(&mut self) -> Result<Option<()>, Error> {
        let read = self.state.measured.read;
        if read.checksum != self.view.values.checksum {
            return Err(Error::FrameChanged);
        }
        if read.has_noise { Ok(Some(())) } else { self.no_noise() }
    }

    /// Measures the regions, and keeps those that are sources.
    fn select(&mut self, regions: usize, crew: &impl Crew) -> Option<()> {
        let Extractor { config, view, work, state, .. } = self;
        let State { walk, cutting, kept, .. } = state;
        let mut planes = work.selection(regions);
        match config.select {
            Select::Area => selection::measure((walk, crew), view, &mut planes)?,
            Select::Significance => selection::cut((walk, crew), cutting, view, config, &mut planes)?,
        }
        selection::keep(walk, kept, (config, cutting.cut), planes.labels, planes.regions)
    }

    /// Whether the frame is still what it was, where it has told up to here which pixels are undefined.
    fn check_frame(&mut self) -> Result<Option<()>, Error> {
        let Extractor { grid, view, state, .. } = self;
        if !P::CHANGES || view.is_whole() {
            return Ok(Some(()));
        }
        let (walk, read) = (&mut state.walk, &mut state.measured.read);
        let sum = walk.pass(grid.height, grid.width.get(), |part| {
            let before = if part.start == 0 { 0 } else { read.checksum };
            read.checksum = before.wrapping_add(view.frame.checksum(part));
        });
        if sum.is_some() && read.checksum != view.values.checksum {
            return Err(Error::FrameChanged);
        }
        Ok(sum)
    }

    /// How often the sky has been measured.
    fn round(&self) -> u32 {
        let done = Plan::of(&self.config).steps().take(self.state.done);
        done.filter(|step| step.stage == Stage::Mask).count() as u32
    }

    /// Passes over a step of a round of which the answers of all parts of the image are enough.
    fn pass_over(&mut self, stage: Stage, round: u32, whole: &dyn Whole) -> Result<Option<()>, Error> {
        match stage {
            Stage::Values => self.look(),
            Stage::Background => {
                signal::remember(&self.view, self.config.sky.cell(), round, whole, &mut self.work.sky());
                Ok(Some(()))
            }
            _ => Ok(Some(())),
        }
    }

    /// What the values of the frame are.
    fn look(&mut self) -> Result<Option<()>, Error> {
        let Extractor { grid, work, view, state, .. } = self;
        let State { walk, look, .. } = state;
        if view.look(walk, look, Keys(work.parents, work.order)).is_none() {
            return Ok(None);
        }
        if view.known.whole.is_some_and(Whole::is_waiting) {
            return Ok(Some(()));
        }
        if view.values.defined == 0 {
            return Err(Error::NothingDefined { pixels: grid.cells() });
        }
        let cleared = walk
            .pass(work.masked.len(), 1, |part| work.masked.get_mut(part).unwrap_or(&mut []).fill(0))
            .and_then(|()| signal::mask_undefined(walk, view, &mut MaskMut(work.masked)))
            .and_then(|()| {
                walk.pass(work.mesh.len(), 1, |part| work.mesh.get_mut(part).unwrap_or(&mut []).fill(Sky::UNKNOWN))
            });
        Ok(cleared)
    }

    /// Why there is nothing to divide the signal by.
    fn no_noise(&mut self) -> Result<Option<()>, Error> {
        let Extractor { view, work, grid, state, .. } = self;
        let (walk, Values { defined, commonest, .. }) = (&mut state.walk, view.values);
        if work.mesh.first().is_none_or(|sky| sky.level.is_nan()) {
            return Err(Error::NoSky { defined, needed: LEAST_PIXELS });
        }
        let is_equal = |&at: &usize| view.frame.value(at) == Some(commonest) && view.is_defined(at);
        let counted = walk.tally(grid.cells(), 1, |tally, part| {
            let before = if part.start == 0 { 0 } else { tally.count };
            tally.count = before + part.filter(is_equal).count();
        });
        match counted {
            Some(()) => Err(Error::NoNoise { value: commonest, equal: walk.tally.count as u32, defined }),
            None => Ok(None),
        }
    }

    /// The image over which a filter in steps is to go or a front to move: signal-to-noise, W x H, smoothed as the other
    /// filters say.
    pub fn image(&self) -> &[L] {
        let Workspace { signal, fine, smooth, .. } = &self.work;
        smoothed(self.config.filter, [signal, fine, smooth])
    }

    /// The front, above 0 inside, by its index, once it has moved and until its pixels have become regions.
    pub fn front(&self, at: usize) -> L {
        self.work.labels.get(at).map_or(L::ZERO, |&bits| L::from_bits(bits))
    }

    /// The planes, the mesh and the regions as the steps so far left them.
    pub fn work(&self) -> &Workspace<'m, L> {
        &self.work
    }

    /// Takes the filtered image that was awaited: signal-to-noise by its index, from which the region's front starts.
    pub fn start_from(&mut self, filtered: impl Fn(usize) -> f32) {
        if self.progress() != Progress::Filter {
            return;
        }
        let front = Front::<L>::new(self.config.outline);
        let labels = self.work.labels.iter_mut().enumerate();
        labels.for_each(|(at, u)| *u = front.at(L::signal(filtered(at))).bits());
        self.pass_over_front();
    }

    /// Takes the front that was awaited: whether a pixel is inside, by its index. What no front can have
    /// reached is counted, and is not.
    pub fn outline(&mut self, inside: impl Fn(usize) -> bool) {
        if self.progress() != Progress::Front {
            return;
        }
        let (Grid { width, height }, margin) = (self.grid, self.config.beyond_reach());
        for (at, front) in self.work.labels.iter_mut().enumerate() {
            let (inside, (x, y)) = (inside(at), self.grid.place(at));
            let far = |margin: usize| {
                let within = |at: usize, length: usize| (margin..length.saturating_sub(margin)).contains(&at);
                within(x, width.get()) && within(y, height)
            };
            let unreached = inside && margin.is_some_and(far);
            self.state.unreached += u32::from(unreached);
            *front = if inside && !unreached { L::ONE } else { -L::ONE }.bits();
        }
        self.pass_over_front();
    }

    /// Passes over the steps of a segmenter.
    fn pass_over_front(&mut self) {
        while self.next().is_some_and(Stage::is_of_front) {
            self.state.done += 1;
        }
    }

    fn found(&self) -> Found {
        let State { kept, unreached, measured, cutting, curve, .. } = &self.state;
        let count = self.state.count();
        Found {
            sources: kept.sources,
            mask_pixels: kept.pixels,
            unlabelled: count.left_out,
            regions: count.regions,
            unreached: *unreached,
            significance: cutting.cut.significance,
            photon: curve.slope(),
            spikes: measured.spikes,
            values: self.view.values,
            survey: measured.survey,
        }
    }
}

/// The first round of the sky that a part must go through: of those before, the answers are enough, but that a round
/// needs the mask of the one before it.
fn first_round(whole: &dyn Whole, values: Values) -> u32 {
    let last = ROUNDS - 1;
    if whole.knows(Question::Reaches) {
        return last;
    }
    let is_open = |round: u32| {
        let powers = [Question::FinePowers(round), Question::DetailPowers(round)];
        let is_skew = values.piled || values.coarse;
        !whole.knows(Question::Details(round)) || (is_skew && !powers.into_iter().all(|powers| whole.knows(powers)))
    };
    (0..last).find(|&round| is_open(round)).unwrap_or(last).saturating_sub(1)
}

/// Signal-to-noise as a filter leaves it: as it is, lightly smoothed or smoothed by need.
fn smoothed<L: Level>(filter: Filter, [signal, fine, smooth]: [&[L]; 3]) -> &[L] {
    match filter {
        Filter::Gauss => fine,
        Filter::Adaptive => smooth,
        _ => signal,
    }
}

fn moved_elsewhere(config: &Config) -> Error {
    let mover = match config.scheme {
        Scheme::Region => "an extractor, after a segmenter's filter",
        _ => "a segmenter",
    };
    Error::Front { scheme: config.scheme.name(), mover }
}

/// An undefined pixel between two of a source carries its light across, but is in no source.
fn drop_undefined<P: Sample>(walk: &mut Walk, view: &View<'_, P>, labels: &mut [u32]) -> Option<()> {
    let (rows, width) = (if view.is_whole() { 0 } else { view.grid.height }, view.grid.width.get());
    walk.pass(rows, width, |rows| {
        let labels = (rows.start * width..).zip(rows_of_mut(labels, &rows, width));
        labels.filter(|(at, _)| !view.is_defined(*at)).for_each(|(_, label)| *label = 0);
    })
}

/// A whole run with the front of [`Scheme::Region`] into `work.labels`.
///
/// # Errors
/// Those of [`Extractor::new`] and [`Extractor::poll`], and [`Error::Front`] for another scheme or a filter in steps.
pub fn extract<L: Level>(
    config: &Config,
    pixels: &[f32],
    width: usize,
    known: Known<'_>,
    work: Workspace<'_, L>,
) -> Result<Found, Error> {
    let mut run = Extractor::new(config, pixels, width, known, work)?;
    loop {
        match run.poll(usize::MAX)? {
            Progress::Next(_) => {}
            Progress::Done(found) => return Ok(found),
            Progress::Filter | Progress::Front => return Err(moved_elsewhere(config)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::{F32, Real};
    use crate::front::scheme::Still;
    use crate::plane::mask::mask_words;
    use crate::plane::raster::{BadPixel, sealed::Sealed};
    use crate::plane::smooth::ROOM_ROWS;
    use crate::plane::sweep::ring_len;
    use crate::run::frame::{Frame, SliceFrame};
    use crate::run::memory::{Memory, flags_len};
    use crate::run::outcome::Progress as Moved;
    use crate::run::segmenter::Segmenter;
    use crate::run::workspace::regions;
    use crate::simulate::{Kind, Sky as Simulated};
    use crate::sky::mesh_cells;
    use crate::sky::otsu::Histogram;
    use crate::sources::tree::Region;
    use core::sync::atomic::{AtomicU8, AtomicU16, AtomicU32, Ordering};

    extern crate std;
    use std::vec;
    use std::vec::Vec;

    pub(super) const WIDTH: usize = 40;
    pub(super) const HEIGHT: usize = 30;
    pub(super) const COUNT: usize = WIDTH * HEIGHT;

    /// The memory of a run over a frame of [`WIDTH`] x [`HEIGHT`].
    pub(super) struct Room<L: Level> {
        levels: [Vec<L>; 3],
        words: [Vec<u32>; 3],
        masked: Vec<u32>,
        rows: Vec<L>,
        mesh: Vec<Sky>,
        regions: Vec<Region<L>>,
    }

    impl<L: Level> Room<L> {
        fn new() -> Self {
            Room::full_of(0)
        }

        /// Full of something.
        pub(super) fn full_of(pattern: u32) -> Self {
            let level = L::from_bits(pattern.wrapping_mul(0x9E37_79B1));
            Room {
                levels: [(); 3].map(|()| vec![level; COUNT]),
                words: [(); 3].map(|()| vec![pattern; COUNT]),
                masked: vec![pattern; mask_words(COUNT)],
                rows: vec![level; ROOM_ROWS * WIDTH],
                mesh: vec![Sky::UNKNOWN; mesh_cells(WIDTH, HEIGHT, Config::NOISE_AWARE.sky.cell())],
                regions: vec![Region::BLANK; regions(WIDTH, HEIGHT)],
            }
        }

        /// All that a run with such an end leaves.
        pub(super) fn left(&self, end: std::string::String, regions: usize, polls: usize) -> Left {
            let bits = |levels: &Vec<L>| levels.iter().map(|level| level.bits()).collect::<Vec<u32>>();
            let sky = |sky: &Sky| [sky.level.to_bits(), sky.noise.to_bits()];
            let regions = self.regions.iter().take(regions);
            let regions = regions.flat_map(|region| [region.peak, region.area, region.label, region.value.bits()]);
            let planes = self.levels.iter().flat_map(bits).chain(self.words.iter().flatten().copied());
            let tables = self.masked.iter().copied().chain(self.mesh.iter().flat_map(sky)).chain(regions);
            Left { end, words: planes.chain(tables).collect(), polls }
        }

        pub(super) fn work(&mut self) -> Workspace<'_, L> {
            let ([signal, fine, smooth], [parents, order, labels]) = (&mut self.levels, &mut self.words);
            let Room { masked, rows, mesh, regions, .. } = self;
            Workspace { signal, fine, smooth, labels, parents, order, masked, rows, mesh, regions }
        }
    }

    /// Counts of a camera, with stars, in rows of `stride` of which the rest is no part of the frame.
    pub(super) fn counts(most: f32, stride: usize) -> Vec<u16> {
        let (mut sky, mut counts) = (Simulated::new(Kind::Bright, 7, WIDTH, HEIGHT), vec![999; stride * HEIGHT]);
        for (y, counts) in counts.chunks_exact_mut(stride).enumerate() {
            let mut row = [0.0; WIDTH];
            let Ok(()) = sky.row(y, &mut row);
            counts.iter_mut().zip(row).for_each(|(count, value)| *count = (most * (0.1 + 0.5 * value)) as u16);
        }
        counts
    }

    /// What a run finds, and its labels.
    #[derive(PartialEq)]
    struct Result {
        sources: u32,
        found: std::string::String,
        labels: Vec<u32>,
    }

    pub(super) fn told(found: Found) -> std::string::String {
        // Frames that can change have a checksum, and one NaN is as good as another.
        std::format!("{:?}", Found { values: Values { checksum: 0, ..found.values }, ..found })
    }

    fn found<L: Level, P: Sample>(frame: Raster<'_, P>, known: Known<'_>) -> Result {
        let mut room = Room::<L>::new();
        let mut run = Extractor::over(&Config::NOISE_AWARE, frame, known, room.work()).expect("room enough");
        let found = loop {
            if let Progress::Done(found) = run.poll(usize::MAX).expect("a sky with noise") {
                break found;
            }
        };
        let [_, _, labels] = room.words;
        Result { sources: found.sources, found: told(found), labels }
    }

    /// All that a run leaves.
    #[derive(PartialEq)]
    pub(super) struct Left {
        /// What was found, or why it ended.
        pub(super) end: std::string::String,
        pub(super) words: Vec<u32>,
        pub(super) polls: usize,
    }

    /// What a run leaves in parts of so many rows.
    pub(super) fn left<L: Level>(config: &Config, pixels: &[f32], known: Known<'_>, rows: usize) -> Left {
        let mut room = Room::<L>::new();
        let mut run = Extractor::new(config, pixels, WIDTH, known, room.work()).expect("room enough");
        for polls in 1.. {
            match run.poll(rows) {
                Ok(Progress::Done(found)) => return room.left(told(found), found.regions, polls),
                Ok(Progress::Filter) => filter(config, &mut run, rows),
                Ok(_) => {}
                Err(error) => return room.left(std::format!("{error}"), 0, polls),
            }
        }
        unreachable!("a run ends")
    }

    /// Filters the image of a run in parts of so many rows.
    pub(super) fn filter<L: Level>(config: &Config, run: &mut Extractor<'_, '_, L>, rows: usize) {
        let pixels: Vec<f32> = run.image().iter().map(|value| value.to_f32()).collect();
        let memory = Memory {
            image: &mut [0.0; COUNT],
            front: &mut [0.0; COUNT],
            ring: &mut [0.0; ring_len(WIDTH, 3)],
            tiles: &mut [0; flags_len(WIDTH, HEIGHT)],
            samples: &mut [0.0; WIDTH],
            counts: &mut Histogram::EMPTY.clone(),
            sources: &mut [],
        };
        let mut segmenter = Segmenter::<F32, Still>::new(config, WIDTH, HEIGHT, memory).expect("room enough");
        let range = loop {
            if let Moved::Done(outcome) = segmenter.poll(rows, &mut SliceFrame(&pixels)).expect("signal and noise") {
                break outcome.range;
            }
        };
        run.start_from(|at| range.pixel(segmenter.image()[at]));
    }

    #[track_caller]
    fn parts_make_the_whole<L: Level>(config: &Config, pixels: &[f32], known: Known<'_>) {
        let whole = left::<L>(config, pixels, known, usize::MAX);
        for rows in [1, 2, 7, HEIGHT] {
            let parts = left::<L>(config, pixels, known, rows);
            assert_eq!(parts.end, whole.end, "{}, parts of {rows} rows", L::NAME);
            let differing = parts.words.iter().zip(&whole.words).position(|(part, whole)| part != whole);
            assert_eq!(differing, None, "{}, parts of {rows} rows: {}", L::NAME, whole.end);
            let polls = parts.polls;
            assert!(polls > whole.polls && (rows > 1 || polls > 4 * HEIGHT), "{polls} polls of {rows} rows");
        }
    }

    #[test]
    fn parts_of_any_size_give_the_same_bits() {
        let default = Config::NOISE_AWARE;
        let components = Config { separate: crate::config::Separate::Components, ..default };
        let by_area = Config { select: Select::Area, filter: Filter::Gauss, ..default };
        let mut pixels: Vec<f32> = counts(4000.0, WIDTH).iter().map(|&count| f32::from(count)).collect();
        let filtered = Config { filter: Filter::TotalVariation { weight: 0.1 }, filter_steps: 3, ..default };
        for config in [default, components, by_area, filtered] {
            parts_make_the_whole::<f32>(&config, &pixels, Known::default());
        }
        parts_make_the_whole::<crate::arithmetic::Fixed14>(&default, &pixels, Known::default());
        // Undefined pixels, and a map of weights.
        let noise: Vec<f32> = (0..COUNT).map(|at| 1.0 + (at % 7) as f32).collect();
        let known = Known { noise: Some(&noise), relative: true, bad: &BAD, ..Known::default() };
        parts_make_the_whole::<f32>(&default, &pixels, known);
        // Cut off below.
        let cut: Vec<f32> = pixels.iter().map(|&pixel| (pixel - 400.0).positive()).collect();
        parts_make_the_whole::<f32>(&default, &cut, Known::default());
        // Filled on the left.
        (0..COUNT).filter(|at| at % WIDTH < 9).for_each(|at| pixels[at] = 0.0);
        parts_make_the_whole::<f32>(&default, &pixels, Known::default());
        parts_make_the_whole::<f32>(&default, &[3.0; COUNT], Known::default());
    }

    /// A run whose front starts from what `start_from` is given, in the place of the filter's image.
    fn started<L: Level>(pixels: &[f32], filtered: impl Fn(L) -> f32) -> Left {
        let (config, mut room) = (Config { filter: Filter::Median, ..Config::NOISE_AWARE }, Room::<L>::new());
        let mut run = Extractor::new(&config, pixels, WIDTH, Known::default(), room.work()).expect("room enough");
        run.start_from(|_| 1e6);
        for polls in 1.. {
            match run.poll(usize::MAX).expect("a sky with noise") {
                Progress::Done(found) => return room.left(told(found), found.regions, polls),
                Progress::Filter => {
                    run.outline(|_| true);
                    assert_eq!(run.poll(1), Ok(Progress::Filter), "no front is awaited");
                    let image = run.image().to_vec();
                    run.start_from(|at| filtered(image[at]));
                }
                _ => {}
            }
        }
        unreachable!("a run ends")
    }

    fn the_front_starts_where_the_filtered_image_says<L: Level>() {
        let pixels: Vec<f32> = counts(4000.0, WIDTH).iter().map(|&count| f32::from(count)).collect();
        let unfiltered = Config { filter: Filter::None, ..Config::NOISE_AWARE };
        let expected = left::<L>(&unfiltered, &pixels, Known::default(), usize::MAX);
        let same = started(&pixels, L::to_f32);
        assert!(same.end == expected.end && same.words == expected.words, "{}", same.end);
        let nowhere = started::<L>(&pixels, |_| 0.0);
        assert!(!expected.end.contains("sources: 0") && nowhere.end.contains("sources: 0"), "{}", nowhere.end);
    }

    #[test]
    fn a_filter_in_steps_tells_where_the_front_starts() {
        the_front_starts_where_the_filtered_image_says::<f32>();
        the_front_starts_where_the_filtered_image_says::<Fixed14>();
        let filtered = Config { filter: Filter::Median, ..Config::NOISE_AWARE };
        let (pixels, mut room) = (counts(4000.0, WIDTH), Room::<f32>::new());
        let pixels: Vec<f32> = pixels.iter().map(|&count| f32::from(count)).collect();
        let alone = extract(&filtered, &pixels, WIDTH, Known::default(), room.work());
        assert_eq!(alone, Err(moved_elsewhere(&filtered)));
    }

    /// A step that was begun in parts is ended as a whole, at every place where it may be.
    #[test]
    fn what_parts_began_is_ended_as_a_whole() {
        let pixels: Vec<f32> = counts(4000.0, WIDTH).iter().map(|&count| f32::from(count)).collect();
        let whole = left::<f32>(&Config::NOISE_AWARE, &pixels, Known::default(), usize::MAX);
        for parts in 1..12 {
            let mut room = Room::<f32>::new();
            let mut run = Extractor::new(&Config::NOISE_AWARE, &pixels, WIDTH, Known::default(), room.work()).unwrap();
            let found = loop {
                let progress = (0..parts).map(|_| run.poll(3)).last();
                if let Some(Ok(Progress::Done(found))) = progress {
                    break found;
                }
                run.poll_by(&Alone).unwrap();
            };
            let left = room.left(told(found), found.regions, 0);
            assert!(left.end == whole.end && left.words == whole.words, "after {parts} parts");
        }
    }

    fn counts_are_the_same_numbers<L: Level>() {
        for most in [200.0, 4000.0] {
            let padded = counts(most, WIDTH + 5);
            let pixels: Vec<f32> = counts(most, WIDTH).iter().map(|&count| f32::from(count)).collect();
            let expected = found::<L, f32>(Raster::of(&pixels, WIDTH), Known::default());
            assert!(expected.sources > 1 && expected.found.contains("step: 1.0"), "{}", expected.found);
            let words = Raster::new(&padded, WIDTH, HEIGHT, WIDTH + 5).expect("a frame");
            assert!(found::<L, u16>(words, Known::default()) == expected, "up to {most}");
            let bytes: Vec<u8> = padded.iter().map(|&count| count as u8).collect();
            let bytes = Raster::new(&bytes, WIDTH, HEIGHT, WIDTH + 5).expect("a frame");
            assert_eq!(found::<L, u8>(bytes, Known::default()) == expected, most < 256.0);
        }
    }

    #[test]
    fn counts_of_a_camera_give_the_bits_of_the_same_numbers_in_single_precision() {
        counts_are_the_same_numbers::<f32>();
        counts_are_the_same_numbers::<crate::arithmetic::Fixed14>();
    }

    pub(super) const BAD: [BadPixel; 4] =
        [BadPixel { x: 3, y: 0 }, BadPixel { x: 20, y: 7 }, BadPixel { x: 21, y: 7 }, BadPixel { x: 39, y: 29 }];

    #[test]
    fn bad_pixels_are_undefined_whatever_they_hold() {
        let counts = counts(4000.0, WIDTH);
        let mut pixels: Vec<f32> = counts.iter().map(|&count| f32::from(count)).collect();
        BAD.iter().for_each(|bad| pixels[usize::from(bad.y) * WIDTH + usize::from(bad.x)] = f32::NAN);
        let expected = found::<f32, f32>(Raster::of(&pixels, WIDTH), Known::default());
        assert!(expected.found.contains("defined: 1196"), "{}", expected.found);
        let known = Known { bad: &BAD, ..Known::default() };
        assert!(found::<f32, u16>(Raster::of(&counts, WIDTH), known) == expected);
    }

    #[test]
    fn bad_pixels_out_of_order_are_named() {
        let mut room = Room::<f32>::new();
        let [a, b, c, d] = BAD;
        for (bad, expected) in
            [([a, c, b, d], ("column of a bad pixel", 20.0, 21.0)), ([b, c, d, a], ("row of a bad pixel", 0.0, 29.0))]
        {
            let known = Known { bad: &bad, ..Known::default() };
            let refused = Extractor::over(&Config::NOISE_AWARE, Raster::of(&[1u16; COUNT], WIDTH), known, room.work());
            let Err(Error::Parameter { name, value, limit, .. }) = refused else { panic!("{refused:?}") };
            assert_eq!((name, value, limit), expected);
        }
    }

    /// Changes a pixel after every step in turn; the last step after which the run sees that.
    fn last_seen(known: Known<'_>) -> Option<Stage> {
        let counts = counts(4000.0, WIDTH);
        let expected = found::<f32, u16>(Raster::of(&counts, WIDTH), known);
        let steps: Vec<Stage> = Plan::of(&Config::NOISE_AWARE).steps().map(|step| step.stage).collect();
        let is_seen = |changed: usize| {
            let words: Vec<AtomicU16> = counts.iter().map(|&count| AtomicU16::new(count)).collect();
            let mut room = Room::<f32>::new();
            let frame = Raster::of(&words, WIDTH);
            let mut run = Extractor::over(&Config::NOISE_AWARE, frame, known, room.work()).expect("room enough");
            for poll in 0.. {
                match run.poll(usize::MAX) {
                    Ok(Progress::Done(found)) => {
                        assert_eq!(told(found), expected.found);
                        return false;
                    }
                    Ok(_) if poll == changed => {
                        words[500].fetch_xor(1, Ordering::Relaxed);
                    }
                    Ok(_) => {}
                    Err(error) => {
                        assert_eq!(error, Error::FrameChanged);
                        return true;
                    }
                }
            }
            false
        };
        let seen: Vec<bool> = (0..steps.len()).map(is_seen).collect();
        assert!(seen.is_sorted_by(|before, after| before >= after), "{seen:?}");
        seen.iter().rposition(|&seen| seen).map(|index| steps[index])
    }

    #[test]
    fn a_frame_that_others_write_to_is_told() {
        assert_eq!(
            last_seen(Known::default()),
            Some(Stage::Mask),
            "whoever reads it last is the last measurement of the sky"
        );
        assert_eq!(last_seen(Known { bad: &BAD, ..Known::default() }), Some(Stage::Deblend), "pixels may be undefined");
        let bytes: Vec<AtomicU8> = counts(200.0, WIDTH).iter().map(|&count| AtomicU8::new(count as u8)).collect();
        let whole = found::<f32, AtomicU8>(Raster::of(&bytes, WIDTH), Known::default());
        let plain: Vec<u8> = bytes.iter().map(|byte| byte.load(Ordering::Relaxed)).collect();
        assert!(whole == found::<f32, u8>(Raster::of(&plain, WIDTH), Known::default()));
    }

    /// A pixel that counts how often it is read.
    #[derive(Debug)]
    struct Counted(u16, AtomicU32);

    impl Sealed for Counted {}

    impl Sample for Counted {
        fn value(&self) -> f32 {
            self.1.fetch_add(1, Ordering::Relaxed);
            f32::from(self.0)
        }
    }

    #[test]
    fn a_row_is_read_seven_times_and_a_sample_once_more() {
        let pixels: Vec<Counted> =
            counts(4000.0, WIDTH).iter().map(|&count| Counted(count, AtomicU32::new(0))).collect();
        found::<f32, Counted>(Raster::of(&pixels, WIDTH), Known::default());
        // All of a small frame is its sample.
        let reads = |pixel: &Counted| pixel.1.load(Ordering::Relaxed);
        assert_eq!((pixels.iter().map(reads).min(), pixels.iter().map(reads).max()), (Some(8), Some(8)));
    }

    /// Frames that ask for work: peaks and borders everywhere, one winding source, holes, the ends of the numbers.
    fn hostile() -> [(&'static str, Vec<f32>); 9] {
        let draw = |value: &dyn Fn(usize, usize) -> f32| (0..COUNT).map(|at| value(at % WIDTH, at / WIDTH)).collect();
        let noise = |x: usize, y: usize| ((x * 2_654_435_761 + y * 40_503) % 1009) as f32;
        let bright = |is_bright: bool| if is_bright { 1e4 } else { 0.0 };
        [
            ("noise", draw(&noise)),
            ("checkerboard", draw(&|x, y| noise(x, y) + bright((x + y) % 2 == 0))),
            ("dots", draw(&|x, y| noise(x, y) + bright(x % 3 == 0 && y % 3 == 0))),
            ("comb", draw(&|x, y| noise(x, y) + bright(x % 4 == 0 || y + 1 == HEIGHT))),
            ("half", draw(&|x, y| noise(x, y) + bright(x > WIDTH / 2))),
            ("ramp", draw(&|x, y| (x * x + y) as f32)),
            ("holes", draw(&|x, y| if (x + y) % 3 == 0 { f32::NAN } else { noise(x, y) + bright(x % 5 == 0) })),
            ("ends", draw(&|x, y| [f32::MAX, f32::MIN, 1e-45, -0.0, 3.0][(x + 2 * y) % 5])),
            ("stars", counts(4000.0, WIDTH).iter().map(|&count| f32::from(count)).collect()),
        ]
    }

    #[test]
    fn no_frame_needs_more_work_or_polls_than_was_said() {
        let mut greatest = 0.0;
        for (name, pixels) in hostile() {
            for rows in [1, 5] {
                let mut room = Room::<f32>::new();
                let mut run = Extractor::new(&Config::NOISE_AWARE, &pixels, WIDTH, Known::default(), room.work())
                    .expect("room enough");
                let (mut polls, bound) = (0, run.work_done().1);
                assert_eq!(bound, budget::cells(&Config::NOISE_AWARE, (WIDTH, HEIGHT), regions(WIDTH, HEIGHT)));
                while let Ok(Progress::Next(_)) = run.poll(rows) {
                    polls += 1;
                }
                let (work, _) = run.work_done();
                assert!(work <= bound, "{name}: {work} cells where {bound} are the most");
                let most = budget::polls(bound, WIDTH, rows);
                assert!(polls <= most, "{name}: {polls} polls of {rows} rows where {most} are the most");
                greatest = f64::max(greatest, work as f64 / bound as f64);
                std::println!("{name}: {:.2} of the work, {polls} of {most} polls", work as f64 / bound as f64);
            }
        }
        assert!(greatest > 0.2, "{greatest} of the work that was allowed");
    }

    #[test]
    fn errors_end_a_run() {
        let nothing = |error: &Error| matches!(error, Error::NothingDefined { pixels: COUNT });
        let no_noise = |error: &Error| matches!(error, Error::NoNoise { value: 3.0, .. });
        for (pixel, is_expected) in [(f32::NAN, &nothing as &dyn Fn(&Error) -> bool), (3.0, &no_noise)] {
            let (mut room, pixels) = (Room::<f32>::new(), [pixel; COUNT]);
            let mut run = Extractor::new(&Config::NOISE_AWARE, &pixels, WIDTH, Known::default(), room.work())
                .expect("room enough");
            let errors = (0..9).filter_map(|_| run.poll(usize::MAX).err());
            let errors: Vec<Error> = errors.collect();
            assert!(errors.len() > 5 && errors.iter().all(is_expected), "{errors:?}");
        }
    }

    #[test]
    fn memory_may_be_longer_than_it_must_and_what_is_shorter_is_named() {
        let refused = |room: &mut Room<f32>| {
            Extractor::new(&Config::NOISE_AWARE, &[1.0; COUNT], WIDTH, Known::default(), room.work()).err()
        };
        let mut room = Room::new();
        room.mesh.push(Sky::UNKNOWN);
        room.masked.push(0);
        room.rows.push(0.0);
        assert_eq!(refused(&mut room), None);
        let (mesh, masked, rows) = (room.mesh.len() - 1, room.masked.len() - 1, room.rows.len() - 1);
        room.mesh.truncate(mesh - 1);
        assert_eq!(refused(&mut room), Some(Error::Length { name: "the mesh", given: mesh - 1, needed: mesh }));
        room.mesh.push(Sky::UNKNOWN);
        room.masked.truncate(masked - 1);
        assert_eq!(refused(&mut room), Some(Error::Length { name: "the mask", given: masked - 1, needed: masked }));
        room.masked.push(0);
        room.rows.truncate(rows - 1);
        assert_eq!(refused(&mut room), Some(Error::Length { name: "the rows", given: rows - 1, needed: rows }));
    }

    /// The bits of all planes.
    fn planes(work: &Workspace<'_, f32>) -> Vec<u32> {
        let Workspace { signal, fine, smooth, labels, parents, order, masked, .. } = work;
        let levels = [&**signal, fine, smooth].into_iter().flatten().map(|level| level.to_bits());
        levels.chain([&**labels, parents, order, masked].into_iter().flatten().copied()).collect()
    }

    /// A pass that does not say what it costs does all of its work in one poll.
    #[test]
    fn a_poll_of_one_row_writes_no_more_than_two() {
        let (mut room, counts) = (Room::<f32>::new(), counts(4000.0, WIDTH));
        let pixels: Vec<f32> = counts.iter().map(|&count| f32::from(count)).collect();
        let mut run =
            Extractor::new(&Config::NOISE_AWARE, &pixels, WIDTH, Known::default(), room.work()).expect("room");
        let mut before = planes(&run.work);
        while let Progress::Next(stage) = run.progress() {
            run.poll(1).expect("a sky");
            let after = planes(&run.work);
            let written = before.iter().zip(&after).filter(|(before, after)| before != after).count();
            // A cell of the mesh, here the whole frame, is measured at once.
            assert!(written <= 2 * WIDTH || stage == Stage::Background, "{written} cells in {stage:?}");
            before = after;
        }
    }
}
