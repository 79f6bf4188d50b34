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
use crate::plane::raster::{Raster, Sample};
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
pub struct Extractor<'a, 'm, L: Level, P = f32> {
    config: Config,
    grid: Grid,
    view: View<'a, P>,
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
    /// What ended the run before its end.
    ended: Option<Error>,
}

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
    /// for a side longer than [`Level::LONGEST`], or [`Error::Parameter`] for bad pixels that are not in order.
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
        known.check_bad()?;
        Ok(Extractor {
            config: *config,
            grid,
            view: View { frame, grid, known, values: Values::UNKNOWN },
            work,
            done: 0,
            masked_from: L::ZERO,
            noise: Noise { least: L::ONE, photon: 0.0 },
            count: Count::default(),
            cut: Cut::NONE,
            kept: Kept::default(),
            survey: Survey::default(),
            unreached: 0,
            ended: None,
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

    /// Does the next step; where a front is awaited, or nothing is left to do, nothing. After an error the run
    /// cannot go on, and every poll reports the same.
    ///
    /// # Errors
    /// [`Error::NothingDefined`], [`Error::NoSky`] and [`Error::NoNoise`] where the frame tells nothing
    /// of its sky or of its noise; [`Error::FrameChanged`] where others have written to it; [`Error::Waiting`] where other parts of an image have yet to answer.
    pub fn poll(&mut self) -> Result<Progress, Error> {
        self.poll_by(&Alone)
    }

    /// The same by a crew, which has no part in the result.
    ///
    /// # Errors
    /// As [`Extractor::poll`].
    pub fn poll_by(&mut self, crew: &impl Crew) -> Result<Progress, Error> {
        if let Some(ended) = self.ended {
            return Err(ended);
        }
        if let Some(stage) = self.next().filter(|stage| !stage.is_of_front()) {
            self.whole_step(stage, crew).map_err(|error| *self.ended.insert(error))?;
            self.done += 1;
        }
        Ok(self.progress())
    }

    fn whole_step(&mut self, stage: Stage, crew: &impl Crew) -> Result<(), Error> {
        self.step(stage, crew)?;
        if self.view.known.whole.is_some_and(Whole::is_waiting) { Err(Error::Waiting) } else { Ok(()) }
    }

    fn step(&mut self, stage: Stage, crew: &impl Crew) -> Result<(), Error> {
        let (round, known) = (self.round(), self.view.known.whole);
        if let Some(whole) = known.filter(|whole| round < first_round(*whole)) {
            return self.pass_over(stage, round, whole);
        }
        let Extractor { config, grid, view, work, .. } = self;
        let (grid, is_whole) = (*grid, view.is_whole());
        let inside = |at: usize| is_whole || view.has_signal(at);
        match stage {
            Stage::Values => return self.look(),
            Stage::Background => {
                let measured = signal::measure(view, config.sky.cell(), round, &mut work.sky(), crew);
                self.survey = measured.survey;
                if measured.checksum != self.view.values.checksum {
                    return Err(Error::FrameChanged);
                }
                if !measured.has_noise {
                    return Err(self.no_noise());
                }
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
                self.count = separate::tree(grid, inside, config, self.noise.photon, &mut work.separation(), crew);
            }
            Stage::Deblend => {
                self.count = separate::deblend(known, grid, config, self.noise, self.count, &mut work.separation());
                drop_undefined(view, work.labels);
            }
            Stage::Components => {
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
                // Which pixels are undefined the frame has told up to here.
                if P::CHANGES && !view.is_whole() && view.frame.checksum() != view.values.checksum {
                    return Err(Error::FrameChanged);
                }
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
        let Extractor { grid, work, view, .. } = self;
        *view = View::of(view.frame, *grid, view.known, Keys(work.parents, work.order));
        if view.known.whole.is_some_and(Whole::is_waiting) {
            return Ok(());
        }
        if view.values.defined == 0 {
            return Err(Error::NothingDefined { pixels: grid.cells() });
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
        let is_equal = |&at: &usize| view.frame.value(at) == Some(commonest) && view.is_defined(at);
        let equal = (0..self.grid.cells()).filter(is_equal).count();
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
fn drop_undefined<P: Sample>(view: &View<'_, P>, labels: &mut [u32]) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::mask::mask_words;
    use crate::plane::raster::{BadPixel, sealed::Sealed};
    use crate::plane::smooth::ROOM_ROWS;
    use crate::run::frame::Frame;
    use crate::run::workspace::regions;
    use crate::simulate::{Kind, Sky as Simulated};
    use crate::sky::mesh_cells;
    use crate::sources::tree::Region;
    use core::sync::atomic::{AtomicU8, AtomicU16, AtomicU32, Ordering};

    extern crate std;
    use std::vec;
    use std::vec::Vec;

    const WIDTH: usize = 40;
    const HEIGHT: usize = 30;
    const COUNT: usize = WIDTH * HEIGHT;

    /// The memory of a run over a frame of [`WIDTH`] x [`HEIGHT`].
    struct Room<L: Level> {
        levels: [Vec<L>; 3],
        words: [Vec<u32>; 3],
        masked: Vec<u32>,
        rows: Vec<L>,
        mesh: Vec<Sky>,
        regions: Vec<Region<L>>,
    }

    impl<L: Level> Room<L> {
        fn new() -> Self {
            Room {
                levels: [(); 3].map(|()| vec![L::ZERO; COUNT]),
                words: [(); 3].map(|()| vec![0; COUNT]),
                masked: vec![0; mask_words(COUNT)],
                rows: vec![L::ZERO; ROOM_ROWS * WIDTH],
                mesh: vec![Sky::UNKNOWN; mesh_cells(WIDTH, HEIGHT, Config::NOISE_AWARE.sky.cell())],
                regions: vec![Region::BLANK; regions(WIDTH, HEIGHT)],
            }
        }

        fn work(&mut self) -> Workspace<'_, L> {
            let ([signal, fine, smooth], [parents, order, labels]) = (&mut self.levels, &mut self.words);
            let Room { masked, rows, mesh, regions, .. } = self;
            Workspace { signal, fine, smooth, labels, parents, order, masked, rows, mesh, regions }
        }
    }

    /// Counts of a camera, with stars, in rows of `stride` of which the rest is no part of the frame.
    fn counts(most: f32, stride: usize) -> Vec<u16> {
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

    fn told(found: Found) -> std::string::String {
        // Frames that can change have a checksum, and one NaN is as good as another.
        std::format!("{:?}", Found { values: Values { checksum: 0, ..found.values }, ..found })
    }

    fn found<L: Level, P: Sample>(frame: Raster<'_, P>, known: Known<'_>) -> Result {
        let mut room = Room::<L>::new();
        let mut run = Extractor::over(&Config::NOISE_AWARE, frame, known, room.work()).expect("room enough");
        let found = loop {
            if let Progress::Done(found) = run.poll().expect("a sky with noise") {
                break found;
            }
        };
        let [_, _, labels] = room.words;
        Result { sources: found.sources, found: told(found), labels }
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

    const BAD: [BadPixel; 4] =
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
                match run.poll() {
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

    #[test]
    fn errors_end_a_run() {
        let nothing = |error: &Error| matches!(error, Error::NothingDefined { pixels: COUNT });
        let no_noise = |error: &Error| matches!(error, Error::NoNoise { value: 3.0, .. });
        for (pixel, is_expected) in [(f32::NAN, &nothing as &dyn Fn(&Error) -> bool), (3.0, &no_noise)] {
            let (mut room, pixels) = (Room::<f32>::new(), [pixel; COUNT]);
            let mut run = Extractor::new(&Config::NOISE_AWARE, &pixels, WIDTH, Known::default(), room.work())
                .expect("room enough");
            let errors = (0..9).filter_map(|_| run.poll().err());
            let errors: Vec<Error> = errors.collect();
            assert!(errors.len() > 5 && errors.iter().all(is_expected), "{errors:?}");
        }
    }
}
