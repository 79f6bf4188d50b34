//! A run on signal-to-noise: sky, noise, smoothing, a front, the tree of level sets, deblending and
//! the cut on significance, as the configuration has them.
//!
//! An [`Extractor`] goes through the steps of its [`Plan`], one per poll. The front of
//! [`Scheme::Region`](crate::config::Scheme::Region) is a step of its own; that of every other scheme the caller moves over
//! [`Extractor::image`], with a [`Segmenter`](crate::run::segmenter::Segmenter) of the same
//! configuration, and hands it over by [`Extractor::outline`].
//!
//! The run is deterministic, with at most a fixed number of passes over the planes and
//! one sort of the pixels in use. The sky is measured in the image's own single precision; from
//! signal-to-noise on, all there is for every pixel is in the [`Level`] of the caller's choice, and
//! single precision has no more to do than what there is once a frame or region: the cut, the
//! photon noise, the centres of wide regions.

use crate::arithmetic::{Level, Real};
use crate::config::{Config, Filter, Select};
use crate::error::Error;
use crate::front::outline::Front;
use crate::plane::crew::{Alone, Crew};
use crate::plane::field::Field;
use crate::plane::grid::Grid;
use crate::plane::mask::{Mask, MaskMut};
use crate::plane::part::{Question, Whole};
use crate::plane::sort::Keys;
use crate::run::plan::{Plan, ROUNDS};
use crate::run::stage::Stage;
use crate::run::workspace::Workspace;
use crate::sky::view::{Known, View};
use crate::sky::{LEAST_PIXELS, Sky, Survey, Values, photon, signal};
use crate::sources::selection::{self, Cut, Kept};
use crate::sources::separate;
use crate::sources::tree::{Count, Noise};

/// A source is masked when a pixel of it stands this high above the noise: noise peaks are not,
/// for without them the sky would be biased low.
const MASKED_PEAK: f32 = 3.5;

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
    /// A front is to move over [`Extractor::image`], and to be given to [`Extractor::outline`].
    Front,
    /// Nothing is left to do.
    Done(Found),
}

/// A run over a frame in the caller's memory.
#[derive(Debug)]
pub struct Extractor<'a, 'm, L: Level> {
    config: Config,
    pixels: &'a [f32],
    grid: Grid,
    view: View<'a>,
    work: Workspace<'m, L>,
    /// Steps of the plan that are done.
    done: usize,
    masked_from: L,
    noise: Noise<L>,
    count: Count,
    cut: Cut,
    kept: Kept,
    survey: Survey,
    unreached: u32,
}

impl<'a, 'm, L: Level> Extractor<'a, 'm, L> {
    /// Sets up a run over `pixels` (row-major, not finite = undefined).
    ///
    /// # Errors
    /// What [`Config::validate_values`] finds, [`Error::Together`] for a configuration without a sky,
    /// [`Error::Size`], [`Error::Length`] for memory or maps of another size, or [`Error::Arithmetic`]
    /// for a side longer than [`Level::LONGEST`].
    pub fn new(
        config: &Config,
        pixels: &'a [f32],
        width: usize,
        known: Known<'a>,
        work: Workspace<'m, L>,
    ) -> Result<Self, Error> {
        config.validate_values()?;
        if !config.sky.is_known() {
            return Err(moved_elsewhere(config));
        }
        let grid = work.check(pixels.len(), width, config.sky.cell(), known)?;
        Ok(Extractor {
            config: *config,
            pixels,
            grid,
            view: View { pixels, grid, known, values: Values::UNKNOWN },
            work,
            done: 0,
            masked_from: L::ZERO,
            noise: Noise { least: L::ONE, photon: 0.0 },
            count: Count::default(),
            cut: Cut::NONE,
            kept: Kept::default(),
            survey: Survey::default(),
            unreached: 0,
        })
    }

    /// How far the run is.
    pub fn progress(&self) -> Progress {
        match self.next() {
            Some(stage) if stage.is_of_front() => Progress::Front,
            Some(stage) => Progress::Next(stage),
            None => Progress::Done(self.found()),
        }
    }

    fn next(&self) -> Option<Stage> {
        Plan::of(&self.config).steps().nth(self.done).map(|step| step.stage)
    }

    /// Does the next step; where a front is awaited, or nothing is left to do, nothing.
    ///
    /// # Errors
    /// [`Error::NothingDefined`], or [`Error::NoSky`] and [`Error::NoNoise`] where the frame tells nothing
    /// of its sky or of its noise.
    pub fn poll(&mut self) -> Result<Progress, Error> {
        self.poll_by(&Alone)
    }

    /// The same by a crew, which has no part in the result.
    ///
    /// # Errors
    /// As [`Extractor::poll`].
    pub fn poll_by(&mut self, crew: &impl Crew) -> Result<Progress, Error> {
        if let Some(stage) = self.next().filter(|stage| !stage.is_of_front()) {
            self.step(stage, crew)?;
            if self.view.known.whole.is_some_and(Whole::is_waiting) {
                return Err(Error::Waiting);
            }
            self.done += 1;
        }
        Ok(self.progress())
    }

    fn step(&mut self, stage: Stage, crew: &impl Crew) -> Result<(), Error> {
        let (round, known) = (self.round(), self.view.known.whole);
        if let Some(whole) = known.filter(|whole| round < first_round(*whole)) {
            return self.pass_over(stage, round, whole);
        }
        let Extractor { config, grid, view, work, .. } = self;
        let (grid, has_signal) = (*grid, |view: &View<'_>, at: usize| view.has_signal(at));
        match stage {
            Stage::Values => return self.look(),
            Stage::Background => {
                let survey = signal::measure(view, config.sky.cell(), round, &mut work.sky(), crew);
                self.survey = survey.ok_or_else(|| self.no_noise())?;
            }
            Stage::Smooth => {
                let tail = signal::smooth(view, round, &mut work.sky(), crew);
                (self.noise.least, self.masked_from) = (tail.noise, tail.height(MASKED_PEAK));
            }
            Stage::Mask => {
                signal::mask_sources(view, L::of(config.outline.threshold), self.masked_from, &mut work.sky(), crew);
            }
            Stage::Photon => {
                let field = Field { values: &*work.signal, grid };
                self.noise.photon =
                    photon::slope(known, field, work.fine, Mask(work.masked), Keys(work.parents, work.order));
            }
            Stage::Outline => {
                let front = Front {
                    threshold: L::of(config.outline.threshold),
                    curvature: L::Weight::of(config.outline.curvature),
                    steps: config.outline.steps,
                };
                let start = smoothed(config.filter, [work.signal, work.fine, work.smooth]);
                front.outline([work.fine, start], work.labels, work.rows, grid, crew);
            }
            Stage::Tree => {
                let inside = |at: usize| has_signal(view, at);
                self.count = separate::tree(grid, inside, config, self.noise.photon, &mut work.separation(), crew);
            }
            Stage::Deblend => {
                let mut planes = work.separation();
                self.count = separate::deblend(known, grid, config, self.noise, self.count, &mut planes, crew);
                drop_undefined(view, work.labels);
            }
            Stage::Components => {
                let inside = |at: usize| has_signal(view, at);
                self.count = separate::components(grid, inside, config.connectivity, &mut work.separation());
                drop_undefined(view, work.labels);
            }
            Stage::Select => {
                let mut planes = work.selection(self.count.regions);
                self.cut = match config.select {
                    Select::Area => {
                        selection::measure(&mut planes);
                        Cut::NONE
                    }
                    Select::Significance => selection::cut(view, config, &mut planes, crew),
                };
                self.kept = selection::keep(config, self.cut, planes.labels, planes.regions);
            }
            _ => {}
        }
        Ok(())
    }

    /// How often the sky has been measured.
    fn round(&self) -> u32 {
        let done = Plan::of(&self.config).steps().take(self.done);
        done.filter(|step| step.stage == Stage::Mask).count() as u32
    }

    /// Passes over a step of a round of which the answers of all parts of the image are enough.
    fn pass_over(&mut self, stage: Stage, round: u32, whole: &dyn Whole) -> Result<(), Error> {
        match stage {
            Stage::Values => self.look(),
            Stage::Background => {
                signal::remember(&self.view, self.config.sky.cell(), round, whole, &mut self.work.sky());
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// What the values of the frame are.
    fn look(&mut self) -> Result<(), Error> {
        let Extractor { pixels, grid, work, view, .. } = self;
        *view = View::of(pixels, *grid, view.known, Keys(work.parents, work.order));
        if view.known.whole.is_some_and(Whole::is_waiting) {
            return Ok(());
        }
        if view.values.defined == 0 {
            return Err(Error::NothingDefined { pixels: pixels.len() });
        }
        work.masked.fill(0);
        signal::mask_undefined(view, &mut MaskMut(work.masked));
        work.mesh.fill(Sky::UNKNOWN);
        Ok(())
    }

    /// Why there is nothing to divide the signal by.
    fn no_noise(&self) -> Error {
        let (view, Values { defined, commonest, .. }) = (&self.view, self.view.values);
        if self.work.mesh.first().is_none_or(|sky| sky.level.is_nan()) {
            return Error::NoSky { defined, needed: LEAST_PIXELS };
        }
        let equal = (0..).zip(self.pixels).filter(|&(at, &pixel)| pixel == commonest && view.is_defined(at)).count();
        Error::NoNoise { value: commonest, equal: equal as u32, defined }
    }

    /// The image over which a front is to move: signal-to-noise, W x H, smoothed as the filter says.
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
            self.unreached += u32::from(unreached);
            *front = if inside && !unreached { L::ONE } else { -L::ONE }.bits();
        }
        while self.next().is_some_and(Stage::is_of_front) {
            self.done += 1;
        }
    }

    fn found(&self) -> Found {
        Found {
            sources: self.kept.sources,
            mask_pixels: self.kept.pixels,
            unlabelled: self.count.left_out,
            regions: self.count.regions,
            unreached: self.unreached,
            significance: self.cut.significance,
            photon: self.noise.photon,
            values: self.view.values,
            survey: self.survey,
        }
    }
}

/// The first round of the sky that a part must go through: of those before, the answers are enough, but that a round
/// needs the mask of the one before it.
fn first_round(whole: &dyn Whole) -> u32 {
    let last = ROUNDS - 1;
    if whole.knows(Question::Reaches) {
        return last;
    }
    let open = (0..last).find(|&round| !whole.knows(Question::Details(round)));
    open.unwrap_or(last).saturating_sub(1)
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
    Error::Front { scheme: config.scheme.name(), mover: "a segmenter" }
}

/// An undefined pixel between two of a source carries its light across, but is in no source.
fn drop_undefined(view: &View<'_>, labels: &mut [u32]) {
    if view.is_whole() {
        return;
    }
    for (_, label) in labels.iter_mut().enumerate().filter(|(at, _)| !view.is_defined(*at)) {
        *label = 0;
    }
}

/// A whole run with the front of [`Scheme::Region`](crate::config::Scheme::Region) into `work.labels`.
///
/// # Errors
/// Those of [`Extractor::new`] and [`Extractor::poll`], and [`Error::Front`] for another scheme.
pub fn extract<L: Level>(
    config: &Config,
    pixels: &[f32],
    width: usize,
    known: Known<'_>,
    work: Workspace<'_, L>,
) -> Result<Found, Error> {
    let mut run = Extractor::new(config, pixels, width, known, work)?;
    loop {
        match run.poll()? {
            Progress::Next(_) => {}
            Progress::Done(found) => return Ok(found),
            Progress::Front => return Err(moved_elsewhere(config)),
        }
    }
}
