//! The whole pipeline on skies made in the test: slices, undefined pixels, limits, errors.

use skyfront::cli::simulated;
use skyfront::pipeline::{Drive, Segmentation, segment};
use skyfront::planes::Room;
use skyfront_core::arithmetic::F32;
use skyfront_core::config::{Config, Edge, Filter, Normalize, Rescale, Scheme, Start, Stop, Tau};
use skyfront_core::error::Error;
use skyfront_core::run::frame::SliceFrame;
use skyfront_core::run::memory::Memory;
use skyfront_core::run::outcome::{Outcome, Progress};
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::simulate::Kind;
use skyfront_core::sources::catalog::Source;
use skyfront_workload::case::MOTIONS;

const WIDTH: usize = 61;
const HEIGHT: usize = 47;

fn sky() -> Vec<f32> {
    simulated(Kind::Stars, 3, WIDTH, HEIGHT).0.pixels
}

fn run(config: &Config, pixels: &[f32], slice: usize) -> Segmentation {
    let mut drive = Drive { slice, keep_stages: true, ..Drive::default() };
    segment(config, pixels, WIDTH, HEIGHT, &mut drive).expect("a good image")
}

fn configs() -> Vec<Config> {
    let mut configs: Vec<Config> = MOTIONS.iter().map(|motion| motion.of(Config::PAPER_F160)).collect();
    configs.push(Config::PAPER_REAL);
    configs.push(Config {
        normalize: Normalize::Percentile { low: 1.0, high: 99.0 },
        rescale: Rescale::R2 { alpha: 0.3 },
        edge: Edge::G1 { p: 2.0 },
        stop: Stop::Rate,
        band: Some(6.0),
        ..Config::PAPER_F160
    });
    configs
}

#[test]
fn slices_of_any_size_give_the_same_bits() {
    let mut pixels = sky();
    pixels[100] = f32::NAN;
    for config in configs() {
        let whole = run(&config, &pixels, usize::MAX);
        for slice in [1, 5, HEIGHT] {
            let sliced = run(&config, &pixels, slice);
            assert_eq!(sliced.labels, whole.labels, "{:?}, slices of {slice}", config.scheme);
            let bits = |plane: &[f32]| plane.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&sliced.front), bits(&whole.front));
            assert_eq!(sliced.stages, whole.stages);
            assert_eq!(sliced.sources, whole.sources);
            assert_eq!(sliced.outcome, whole.outcome);
        }
    }
}

#[test]
fn undefined_pixels_take_no_part() {
    let mut pixels = sky();
    let clean = run(&Config::PAPER_F160, &pixels, usize::MAX);
    let brightest = clean.sources.iter().max_by(|a, b| a.peak.total_cmp(&b.peak)).expect("a source");
    let (x, y) = brightest.peak_at;
    let at = y as usize * WIDTH + x as usize;
    for (index, value) in [(at, f32::NAN), (0, f32::INFINITY), (7 * WIDTH, f32::NEG_INFINITY)] {
        pixels[index] = value;
    }
    let holed = run(&Config::PAPER_F160, &pixels, usize::MAX);
    assert_eq!(holed.outcome.extremes.defined as usize, WIDTH * HEIGHT - 3);
    assert_eq!(holed.labels[at], 0, "an undefined pixel belongs to nothing");
    assert!(holed.outcome.extremes.greatest < brightest.peak, "an undefined pixel is no extreme");
    let stages = holed.stages.expect("stages were kept");
    for plane in [&stages.normalised, &stages.rescaled, &stages.filtered, &stages.edge, &holed.front] {
        assert!(plane.iter().all(|value| value.is_finite()), "the arithmetic never sees a NaN");
    }
}

/// A run in the caller's front plane, with room for so many sources.
fn core_run(
    config: &Config,
    pixels: &[f32],
    front: &mut [f32],
    sources: usize,
) -> Result<(Outcome, Vec<Source>), Error> {
    let mut room = Room::new(config, WIDTH, HEIGHT, sources);
    let memory = Memory { front, ..room.memory() };
    let mut segmenter = Segmenter::<F32>::new(config, WIDTH, HEIGHT, memory)?;
    loop {
        if let Progress::Done(outcome) = segmenter.poll(3, &mut SliceFrame(pixels))? {
            return Ok((outcome, segmenter.catalog().to_vec()));
        }
    }
}

#[test]
fn sources_beyond_the_catalogue_are_counted() {
    let pixels = sky();
    let mut front = vec![0.0; WIDTH * HEIGHT];
    let config = Config { normalize: Normalize::Percentile { low: 1.0, high: 97.0 }, ..Config::PAPER_F160 };
    let (full, all) = core_run(&config, &pixels, &mut front, 1000).expect("a good image");
    assert!(full.sources > 2 && full.catalogued == full.sources, "{full:?}");
    let (cut, two) = core_run(&config, &pixels, &mut front, 2).expect("a good image");
    assert_eq!((cut.sources, cut.catalogued), (full.sources, 2));
    assert_eq!(two[..], all[..2]);
}

#[test]
fn a_front_of_the_callers_own_shrinks_onto_what_it_encloses() {
    let pixels = sky();
    let frame = run(&Config::PAPER_F160, &pixels, usize::MAX);
    let largest = frame.sources.iter().max_by_key(|source| source.area).expect("a source");
    let (cx, cy) = largest.centroid();
    // A circle around the largest source, in the unit of u0.
    let mut front: Vec<f32> =
        (0..WIDTH * HEIGHT).map(|i| (9.0 - ((i % WIDTH) as f32 - cx).hypot((i / WIDTH) as f32 - cy)) * 0.05).collect();
    let config = Config { start: Start::Given, ..Config::PAPER_F160 };
    let (outcome, sources) = core_run(&config, &pixels, &mut front, 10).expect("a good image");
    assert!(outcome.sources >= 1);
    assert!(sources.iter().any(|source| source.label > 0 && source.area.abs_diff(largest.area) <= 2));
    let far = |source: &Source| (source.centroid().0 - cx).hypot(source.centroid().1 - cy);
    assert!(sources.iter().all(|source| far(source) < 10.0), "nothing outside the circle");
}

#[test]
fn what_a_caller_can_get_wrong_is_an_error_with_names_and_numbers() {
    let pixels = sky();
    let mut front = vec![0.0; WIDTH * HEIGHT];
    let mut error = |config: Config, pixels: &[f32]| {
        core_run(&config, pixels, &mut front, 5).expect_err("something is wrong").to_string()
    };
    let good = Config::PAPER_F160;
    assert_eq!(
        error(good, &vec![7.5; WIDTH * HEIGHT]),
        "all pixels in the range to normalise equal 7.5: nothing stands out"
    );
    assert_eq!(error(good, &vec![f32::NAN; WIDTH * HEIGHT]), "none of the 2867 pixels is a finite number");
    for (config, words) in [
        (Config { dt: 0.051, ..good }, "dt is 0.051; must be at most 0.05"),
        (Config { dt: 0.11, ..good.with_scheme(Scheme::Sl) }, "dt is 0.11; must be at most 0.1"),
        (Config { nu: 0.5, ..good.with_scheme(Scheme::FdCurvature) }, "dt is 0.010000001; must be at most 0.00833333"),
        (Config { nu: -0.1, ..good }, "nu is -0.1; must be at least 0"),
        (Config { filter_dt: 0.003, ..good }, "filter-dt is 0.003; must be at most 0.0025"),
        (Config { rescale: Rescale::R3 { beta: 0, tau: Tau::Otsu }, ..good }, "beta is 0; must be at least 1"),
        (Config { rescale: Rescale::R1 { alpha: f32::NAN }, ..good }, "alpha is NaN; must be above 0"),
        (Config { edge: Edge::G2Mod { c2: 1.0 }, ..good }, "c2 is 1; must be below 1"),
        (Config { filter: Filter::None, eps: 0.0, ..good }, "eps is 0; must be above 0"),
        (Config { directions: 12, ..good }, "directions is 12; must be 16 or 64"),
        (Config::NOISE_AWARE, "the front of the scheme region is moved by an extractor"),
    ] {
        let said = error(config, &pixels);
        assert!(said.starts_with(words), "'{said}' does not begin with '{words}'");
    }
}

#[test]
fn memory_that_is_too_short_is_named() {
    let mut room = Room::new(&Config::PAPER_F160, WIDTH, HEIGHT, 0);
    let memory = Memory { front: &mut [0.0; 9], ..room.memory() };
    let error = Segmenter::<F32>::new(&Config::PAPER_F160, WIDTH, HEIGHT, memory).expect_err("a short plane");
    assert_eq!(error, Error::Length { name: "the front plane", given: 9, needed: WIDTH * HEIGHT });
}

#[test]
fn frames_down_to_five_by_five() {
    for (width, height) in [(5, 5), (5, 9), (64, 5), (7, 6)] {
        let mut pixels = vec![0.0f32; width * height];
        pixels[height / 2 * width + width / 2] = 1.0;
        let run = segment(&Config::PAPER_F160, &pixels, width, height, &mut Drive::default());
        assert!(run.is_ok(), "{width} x {height}: {run:?}");
    }
    let small = segment(&Config::PAPER_F160, &[1.0; 16], 4, 4, &mut Drive::default());
    assert!(matches!(small, Err(Error::Size { width: 4, height: 4, least: 5, .. })), "{small:?}");
}
