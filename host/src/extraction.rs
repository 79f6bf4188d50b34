//! A run on signal-to-noise on the host: memory, the steps, the catalogue.

use crate::background::SkyMaps;
use crate::evolution::{Filtered, filter_in, segment_in};
use crate::nothing::without_front;
use crate::planes::{SignalRoom, most_room_rows, room_for};
use crate::remarks;
use crate::segmentation::{Drive, Segmentation, StagePlanes};
use crate::workers::{Threads, in_groups};
use skyfront_core::arithmetic::machine::Task;
use skyfront_core::arithmetic::{Arithmetic, Level};
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::front::bands;
use skyfront_core::image::normalize::Extremes;
use skyfront_core::plane::crew::Crew;
use skyfront_core::plane::mask::{Mask, mask_words};
use skyfront_core::plane::part::Whole;
use skyfront_core::plane::rows::runs;
use skyfront_core::run::extract::{Extractor, Found, Progress};
use skyfront_core::run::outcome::{Outcome, Progress::Working};
use skyfront_core::run::stage::Stage;
use skyfront_core::run::workspace::regions;
use skyfront_core::sky::view::Known;
use skyfront_core::sky::{Mesh, Sky, mesh_cells};
use skyfront_core::sources::catalog::Source;
use skyfront_core::sources::tree::Region;
use std::ops::Range;
use std::time::Instant;

/// Bytes that an image and [`segment`] without pictures take together, by what they hold.
pub fn memory(config: &Config, width: usize, height: usize) -> [(usize, &'static str); 5] {
    let plane = width * height * size_of::<f32>();
    [
        (plane, "the image"),
        (4 * plane, "four planes to work in"),
        (2 * plane, "two lists of the pixels of sources; of each as much is used as there are"),
        (
            regions(width, height) * size_of::<Region<f32>>(),
            "table of regions; a fifth of it is enough but for images full of specks",
        ),
        (
            mesh_cells(width, height, config.sky.cell()) * size_of::<Sky>()
                + mask_words(width * height) * size_of::<u32>()
                + most_room_rows(height) * width * size_of::<f32>(),
            "mesh of the sky, mask, and rows to smooth in",
        ),
    ]
}

/// The signal-to-noise that the histogram shows.
pub mod shown {
    /// Its first bin begins here.
    pub const LEAST: f32 = -5.0;
    /// Its last one ends here.
    pub const GREATEST: f32 = 20.0;

    /// A signal-to-noise on the scale from the one, 0, to the other, 1.
    pub fn unit(value: &f32) -> f32 {
        (value - LEAST) / (GREATEST - LEAST)
    }
}

/// Of so many pixels one is a region's peak, at most, but for images full of specks.
const PIXELS_OF_REGION: usize = 16;
/// A table of so few regions is not worth sparing.
const LEAST_REGIONS: usize = 1 << 16;

/// The regions of a table that is enough for most images.
fn few_regions(pixels: usize) -> usize {
    (pixels / PIXELS_OF_REGION).max(LEAST_REGIONS)
}

/// As [`memory`], together and but for images full of specks.
pub fn usual_memory(config: &Config, width: usize, height: usize) -> usize {
    let all: usize = memory(config, width, height).iter().map(|(bytes, _)| bytes).sum();
    let spared = regions(width, height).saturating_sub(few_regions(width * height));
    all - spared * size_of::<Region<f32>>()
}

/// Segments an image, row-major, NaN = undefined, in `L`; a front that is not the region's own moves in `A`.
///
/// # Errors
/// What the core finds wrong with the configuration or the image.
pub fn segment<A: Arithmetic, L: Level>(
    config: &Config,
    pixels: &[f32],
    width: usize,
    drive: &mut Drive<'_>,
) -> Result<Segmentation, Error> {
    if !drive.bands.is_empty() {
        bands::serve::<A>(config, drive.bands.len() + 1)?;
    }
    with_few_regions::<A, L>(config, pixels, width, drive, few_regions(pixels.len()))
}

/// The same in a table of a few regions or, where the image has more, again in one that has room for all.
fn with_few_regions<A: Arithmetic, L: Level>(
    config: &Config,
    pixels: &[f32],
    width: usize,
    drive: &mut Drive<'_>,
    few: usize,
) -> Result<Segmentation, Error> {
    let all = regions(width, pixels.len() / width.max(1));
    let run = in_room::<A, L>(config, pixels, width, drive, few.min(all))?;
    if run.outcome.unlabelled == 0 || few >= all {
        return Ok(run);
    }
    drop(run);
    in_room::<A, L>(config, pixels, width, drive, all)
}

fn in_room<A: Arithmetic, L: Level>(
    config: &Config,
    pixels: &[f32],
    width: usize,
    drive: &mut Drive<'_>,
    regions: usize,
) -> Result<Segmentation, Error> {
    let count = pixels.len();
    let height = count / width.max(1);
    let (image, origin) =
        drive.whole.map(Whole::part).map_or(((width, height), (0, 0)), |part| (part.image, part.origin));
    let mut room = SignalRoom::<L>::new(config, (count, width), image, regions, drive.threads);
    let (background, noise) = (drive.background, drive.noise);
    let known = Known { background, noise, relative: drive.relative, whole: drive.whole, ..Known::default() };
    let mut run = Extractor::new(config, pixels, width, known, room.workspace())?;
    let (crew, mut seconds) = (Threads(drive.threads), Vec::new());
    let (mut smoothed, mut moved, mut front, mut stages) = (None, None, Vec::new(), None);
    let found = loop {
        let started = Instant::now();
        match run.progress() {
            Progress::Done(found) => break found,
            Progress::Next(stage) => {
                if let Some(watch) = &mut drive.watch {
                    watch(&Working { stage, pass: 0, row: 0, last_change: 0.0 });
                }
                run.poll_by(&crew)?;
                seconds.push((stage, started.elapsed()));
                if stage == Stage::Outline {
                    front = give_front(&run, drive);
                    stages = drive.keep_stages.then(|| stages_of(&run, smoothed.as_ref()));
                }
            }
            Progress::Filter => {
                let image = in_f32(run.image());
                let filtered = filter_in::<A>(config, &image, width, drive)?;
                run.start_from(|at| filtered.image[at]);
                seconds.extend(filtered.seconds.iter().copied());
                smoothed = Some(filtered);
            }
            Progress::Front => {
                let evolved = move_front::<A, L>(config, &run, width, drive)?;
                run.outline(|at| evolved.front[at] > 0.0);
                seconds.extend(evolved.seconds.iter().copied());
                moved = Some(evolved);
            }
        }
    };
    let SignalRoom { levels: [signal, fine, smooth], labels, mut mesh, regions, .. } = room;
    drop(signal);
    let mesh = Mesh::over(&mut mesh, image, config.sky.cell());
    let mut sky = SkyMaps::of(&mesh, width, origin, [fine, smooth].map(into_f32), &crew);
    // Nothing is measured in what was never observed.
    if found.values.filled > 0 {
        let unseen = sky.noise.iter_mut().zip(pixels).filter(|(_, pixel)| **pixel == found.values.fill);
        unseen.for_each(|(noise, _)| *noise = f32::NAN);
    }
    // What parts have in common counts in one of them.
    let own = drive.whole.map(Whole::part).map_or((0..width, 0..height), |part| (part.columns, part.rows));
    let extremes = extremes_of((pixels, width), own, &found, &crew);
    let mut sources: Vec<Source> = (1..=found.sources).map(Source::empty).collect();
    in_groups(&mut sources, drive.threads, |first, sources| {
        for (y, (labels, pixels)) in (0..).zip(labels.chunks_exact(width).zip(pixels.chunks_exact(width))) {
            for (start, end, label) in runs(labels) {
                let index = (label as usize).checked_sub(first);
                let Some(source) = index.and_then(|index| sources.get_mut(index)) else { continue };
                for (x, &pixel) in (start as u32..).zip(&pixels[start..end]) {
                    if drive.keep_sums {
                        source.add(x, y, pixel, extremes.least);
                    } else {
                        source.extend(x, y);
                    }
                }
            }
        }
    });
    let [mut blended, mut plateaus] = [(); 2].map(|()| vec![false; sources.len()]);
    let mark = |of: &mut [bool], label: u32| {
        (label as usize).checked_sub(1).and_then(|index| of.get_mut(index)).into_iter().for_each(|of| *of = true);
    };
    for region in &regions[..found.regions] {
        if let Some(other) = region.divided_from(&labels) {
            // The other may remember a part that was dropped.
            mark(&mut blended, region.label);
            mark(&mut blended, other);
        }
        if region.plateau > 0.0 {
            mark(&mut plateaus, region.label);
        }
    }
    let run = Segmentation {
        arithmetic: L::NAME,
        width,
        height,
        labels,
        front,
        stages,
        convergence: Vec::new(),
        sources,
        blended: Some(blended),
        plateaus,
        outcome: without_front(extremes),
        sky: Some(sky),
        seconds,
        remarks: remarks::on(&found, image.0 * image.1),
    };
    Ok(with_front(run, &found, moved))
}

/// The extremes of the pixels that are observations.
fn extremes_of(
    (pixels, width): (&[f32], usize),
    (columns, rows): (Range<usize>, Range<usize>),
    found: &Found,
    crew: &Threads,
) -> Extremes {
    /// Rows that a thread takes at a time.
    const ROWS: usize = 64;
    let band = (ROWS * width).max(1);
    let pixels = pixels.get(rows.start * width..rows.end * width).unwrap_or(&[]);
    let mut bands = vec![Extremes::NONE; pixels.len().div_ceil(band)];
    crew.each(bands.iter_mut().zip(pixels.chunks(band)), |(extremes, pixels)| {
        let mut observed = vec![0.0; columns.len()];
        for row in pixels.chunks_exact(width) {
            let mut row = row.get(columns.clone()).unwrap_or(&[]);
            if found.values.filled > 0 {
                let observe = |pixel: f32| if found.values.holds(pixel) { pixel } else { f32::NAN };
                observed.iter_mut().zip(row).for_each(|(out, &pixel)| *out = observe(pixel));
                row = &observed;
            }
            crew.wide(Observe { extremes, row });
        }
    });
    bands.into_iter().fold(Extremes::NONE, |all, band| Extremes {
        least: all.least.min(band.least),
        greatest: all.greatest.max(band.greatest),
        defined: all.defined + band.defined,
    })
}

/// A row whose extremes are looked for.
struct Observe<'a> {
    extremes: &'a mut Extremes,
    row: &'a [f32],
}

impl Task for Observe<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.extremes.observe(self.row);
    }
}

/// The front of a run, unless somebody takes it.
fn give_front<L: Level>(run: &Extractor<'_, '_, L>, drive: &mut Drive<'_>) -> Vec<f32> {
    match &mut drive.take_front {
        Some(take) => {
            take(&|first, out| (first..).zip(out).for_each(|(at, out)| *out = run.front(at).to_f32()));
            Vec::new()
        }
        None => {
            let mut front = room_for(run.image().len());
            front.extend((0..run.image().len()).map(|at| run.front(at).to_f32()));
            front
        }
    }
}

/// What the steps up to the front have left, with what a filter in steps did.
fn stages_of<L: Level>(run: &Extractor<'_, '_, L>, filtered: Option<&Filtered>) -> StagePlanes {
    let (work, unit) = (run.work(), |value: &L| shown::unit(&value.to_f32()));
    let by_need = || work.smooth.iter().map(unit).collect();
    StagePlanes {
        normalised: work.signal.iter().map(unit).collect(),
        rescaled: Vec::new(),
        filtered: filtered.map_or_else(by_need, |filtered| filtered.image.iter().map(shown::unit).collect()),
        edge: (0..work.signal.len()).map(|at| f32::from(u8::from(Mask(work.masked).has(at)))).collect(),
    }
}

/// Moves the front of a configuration over the image that a run has made.
fn move_front<A: Arithmetic, L: Level>(
    config: &Config,
    run: &Extractor<'_, '_, L>,
    width: usize,
    drive: &mut Drive<'_>,
) -> Result<Segmentation, Error> {
    let image = in_f32(run.image());
    // The run needs the front itself before anyone else may have it.
    let take_front = drive.take_front.take();
    let evolved = segment_in::<A>(config, &image, width, image.len() / width.max(1), drive);
    drive.take_front = take_front;
    evolved
}

/// A run with what its front found, if one was moved for it, and the sources.
fn with_front(run: Segmentation, found: &Found, moved: Option<Segmentation>) -> Segmentation {
    let run = match moved {
        None => run,
        Some(moved) => Segmentation {
            front: moved.front,
            stages: moved.stages,
            convergence: moved.convergence,
            outcome: Outcome { extremes: run.outcome.extremes, ..moved.outcome },
            ..run
        },
    };
    let outcome = Outcome {
        mask_pixels: found.mask_pixels,
        sources: found.sources,
        catalogued: found.sources,
        unlabelled: found.unlabelled,
        unreached: found.unreached,
        ..run.outcome
    };
    Segmentation { outcome, ..run }
}

/// A plane in single precision, in its own memory.
fn into_f32<L: Level>(plane: Vec<L>) -> Vec<f32> {
    plane.into_iter().map(L::to_f32).collect()
}

/// A copy of a plane in single precision.
fn in_f32<L: Level>(plane: &[L]) -> Vec<f32> {
    plane.iter().map(|value| value.to_f32()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use skyfront_core::arithmetic::F32;
    use skyfront_core::config::Filter;
    use skyfront_core::run::frame::Frame;
    use skyfront_core::simulate::{Kind, Sky as Simulated};

    fn bright(side: usize) -> Vec<f32> {
        let (mut sky, mut pixels) = (Simulated::new(Kind::Bright, 7, side, side), vec![0.0; side * side]);
        for (y, row) in pixels.chunks_exact_mut(side).enumerate() {
            let Ok(()) = sky.row(y, row);
        }
        pixels
    }

    #[test]
    fn a_filter_in_steps_has_its_image_and_its_time_and_the_same_bits_however_it_is_driven() {
        const SIDE: usize = 90;
        let (pixels, filter) = (bright(SIDE), Filter::Starlet { significance: 3.0 });
        let config = &Config { filter, filter_steps: 3, ..Config::NOISE_AWARE };
        let run = |threads: usize, slice: usize| {
            let mut drive = Drive { threads, slice, keep_stages: true, ..Drive::default() };
            segment::<F32, f32>(config, &pixels, SIDE, &mut drive).expect("there is a sky")
        };
        let once = run(1, usize::MAX);
        for (threads, slice) in [(3, usize::MAX), (1, 1), (2, 7)] {
            let other = run(threads, slice);
            assert_eq!((&other.labels, &other.front, &other.stages), (&once.labels, &once.front, &once.stages));
        }
        let stages = [Stage::Photon, Stage::Extremes, Stage::Normalize, Stage::Filter, Stage::Outline];
        let timed: Vec<Stage> =
            once.seconds.iter().map(|(stage, _)| *stage).filter(|stage| stages.contains(stage)).collect();
        assert_eq!(timed, stages);
        let mut by_need = Drive { keep_stages: true, ..Drive::default() };
        let by_need = segment::<F32, f32>(&Config::NOISE_AWARE, &pixels, SIDE, &mut by_need).expect("there is a sky");
        let [own, other] = [once, by_need].map(|run| run.stages.expect("they were kept"));
        assert!(own.normalised == other.normalised && own.filtered != other.filtered);
        assert!(own.filtered.iter().all(|value| value.is_finite()));
    }

    #[test]
    fn sources_without_sums_have_their_areas_and_places() {
        const SIDE: usize = 120;
        let pixels = bright(SIDE);
        let run = |keep_sums| {
            let mut drive = Drive { keep_sums, threads: 2, ..Drive::default() };
            segment::<F32, f32>(&Config::NOISE_AWARE, &pixels, SIDE, &mut drive).expect("there is a sky").sources
        };
        let (with, without) = (run(true), run(false));
        let seen = |source: &Source| (source.label, source.area, source.x0, source.y0, source.columns, source.rows);
        assert!(with.len() > 1 && with.iter().map(seen).eq(without.iter().map(seen)));
        assert!(with.iter().all(|source| source.sum() > 0.0) && without.iter().all(|source| source.sum() == 0.0));
    }

    #[test]
    fn a_table_that_is_too_small_is_replaced() {
        const SIDE: usize = 120;
        let (pixels, config) = (bright(SIDE), &Config::NOISE_AWARE);
        let in_one = in_room::<F32, f32>(config, &pixels, SIDE, &mut Drive::default(), 1).expect("there is a sky");
        assert!(in_one.outcome.unlabelled > 0, "one region is too few");
        let run = segment::<F32, f32>(config, &pixels, SIDE, &mut Drive::default()).expect("there is a sky");
        let again = with_few_regions::<F32, f32>(config, &pixels, SIDE, &mut Drive::default(), 1);
        let again = again.expect("there is a sky");
        assert!(run.outcome.unlabelled == 0 && run.outcome.sources > 1);
        assert_eq!((again.labels, again.outcome), (run.labels, run.outcome));
    }
}
