//! One contour for several bands: the energy, known answers, and the promises that every scheme keeps.

use crate::chan_vese::length;
use skyfront::crosscheck::{Difference, parameters, walk_bands};
use skyfront::pipeline::{Drive, Segmentation, segment, segment_in};
use skyfront::planes::{BandRoom, Room};
use skyfront::reference::{self, Parameters, Plane, chan_vese, half_side, run_in};
use skyfront_core::arithmetic::{Arithmetic, Bits, F32, Q11, Q24, Real};
use skyfront_core::config::{ChanVese, Config, Filter, Normalize, Order, Rescale, Scheme, Start};
use skyfront_core::error::Error;
use skyfront_core::front::bands::{Bands, MOST_BANDS};
use skyfront_core::run::frame::{BandFrame, SliceFrame};
use skyfront_core::run::memory;
use skyfront_core::run::outcome::{Outcome, Progress};
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::snapshot::{self, SnapshotError};
use skyfront_core::run::stage::Stage;
use skyfront_core::simulate::Kind;
use skyfront_core::sources::catalog::Source;
use skyfront_tests::runs::sky;
use std::ops::Range;

const SIDE: usize = 96;

/// The image itself, without rescaling, between its extremes.
fn plain() -> Config {
    Config { rescale: Rescale::None, filter: Filter::None, ..Config::PAPER_F160.with_scheme(Scheme::ChanVese) }
}

/// With other weights inside than outside.
fn lopsided(config: Config) -> Config {
    Config { chan_vese: ChanVese { lambda1: 0.7, lambda2: 1.6, ..config.chan_vese }, ..config }
}

/// Three bands of different skies, a pixel of the second undefined.
fn bands(width: usize, height: usize) -> [Vec<f32>; 3] {
    let mut bands =
        [(Kind::Bright, 8), (Kind::Noisy, 5), (Kind::Bright, 3)].map(|(kind, seed)| sky(kind, seed, width, height));
    bands[1][40] = f32::NAN;
    bands
}

/// A run over bands from its start to its end; `look` sees it before every poll.
fn run<A: Arithmetic>(
    config: &Config,
    bands: &[&[f32]],
    (width, height): (usize, usize),
    slice: usize,
    mut look: impl FnMut(&mut Segmenter<'_, A>),
) -> Ended {
    let mut room = Room::<A>::full_of(0xA5A5, config, width, height, 50);
    let mut more = BandRoom::<A>::new(bands.len(), width * height);
    let mut run = Segmenter::<A>::of_bands(config, width, height, room.memory(), more.bands()).expect("enough memory");
    let mut convergence = Vec::new();
    loop {
        look(&mut run);
        match run.poll(slice, &mut BandFrame(bands)).expect("a sky") {
            Progress::Done(outcome) => return Ended::of(&run, outcome, convergence),
            Progress::Working { stage: Stage::Evolve, last_change, .. } => convergence.push(last_change),
            Progress::Working { .. } => {}
        }
    }
}

/// What a run leaves behind.
#[derive(Debug, PartialEq)]
struct Ended {
    outcome: Outcome,
    labels: Vec<u32>,
    sources: Vec<Source>,
    convergence: Vec<f32>,
}

impl Ended {
    fn of<A: Arithmetic>(run: &Segmenter<'_, A>, outcome: Outcome, mut convergence: Vec<f32>) -> Ended {
        let labels = run.front().iter().map(|cell| cell.bits()).collect();
        convergence.dedup();
        Ended { outcome, labels, sources: run.catalog().to_vec(), convergence }
    }
}

/// One band as one of several gives the bits of the two-phase scheme, step by step.
fn one_band_is_the_two_phase_scheme<A: Arithmetic>(config: &Config, pixels: &[f32]) {
    let fronts = |front: &[A::Cell]| front.iter().map(|cell| cell.bits()).collect::<Vec<_>>();
    let (mut alone, mut as_band) = (Vec::new(), Vec::new());
    let with_bands =
        run::<A>(config, &[pixels], (SIDE, SIDE), SIDE, |run| as_band.push((run.stage(), fronts(run.front()))));
    let mut room = Room::<A>::full_of(0xA5A5, config, SIDE, SIDE, 50);
    let mut two_phase = Segmenter::<A>::new(config, SIDE, SIDE, room.memory()).expect("enough memory");
    let mut convergence = Vec::new();
    let ended = loop {
        alone.push((two_phase.stage(), fronts(two_phase.front())));
        match two_phase.poll(SIDE, &mut SliceFrame(pixels)).expect("a sky") {
            Progress::Done(outcome) => break Ended::of(&two_phase, outcome, convergence),
            Progress::Working { stage: Stage::Evolve, last_change, .. } => convergence.push(last_change),
            Progress::Working { .. } => {}
        }
    };
    assert!(ended.outcome.sources > 0 && ended.outcome.steps > 1, "{:?}", ended.outcome);
    assert_eq!(with_bands, ended, "{}", A::NAME);
    assert!(alone == as_band, "{}: a front differs on the way", A::NAME);
}

#[test]
fn one_band_gives_the_bits_of_the_scheme_for_one_image() {
    for config in [Config::CHAN_VESE, lopsided(plain()), Config { start: Start::Frame, ..Config::CHAN_VESE }] {
        let pixels = sky(Kind::Bright, 8, SIDE, SIDE);
        one_band_is_the_two_phase_scheme::<F32>(&config, &pixels);
        one_band_is_the_two_phase_scheme::<Q24>(&config, &pixels);
    }
    let config = Config { start: Start::Frame, chan_vese: ChanVese { mu: 0.0, ..plain().chan_vese }, ..plain() };
    one_band_is_the_two_phase_scheme::<F32>(&config, &woken());
    one_band_is_the_two_phase_scheme::<Q24>(&config, &woken());
}

/// A block that is nearer to the first mean inside than to that outside, and rests, until another far away has left and
/// the means are others.
fn woken() -> Vec<f32> {
    let within = |at: usize, x: Range<usize>, y: Range<usize>| x.contains(&(at % SIDE)) && y.contains(&(at / SIDE));
    let level = |at: usize| match at {
        _ if !within(at, 3..SIDE - 3, 3..SIDE - 3) => 0.9,
        _ if within(at, 24..64, 28..68) => 0.57,
        _ if within(at, 70..86, 20..80) => 1.0,
        _ => 0.0,
    };
    (0..SIDE * SIDE).map(level).collect()
}

/// The energy of a front with the means that are best for it in each band, in f64 by its definition.
fn energy(config: &Config, bands: &[Vec<f32>], front: &[f32], width: usize) -> f64 {
    let ChanVese { mu, lambda1, lambda2 } = config.chan_vese;
    let mut data = 0.0;
    for image in bands {
        for (sign, lambda) in [(1.0, lambda1), (-1.0, lambda2)] {
            let weighted = || image.iter().zip(front).map(|(&i, &v)| (f64::from(i), 1.0 + sign * f64::from(v)));
            let (light, weight) = weighted().fold((0.0, 0.0), |(light, all), (i, w)| (light + i * w, all + w));
            let mean = light / f64::max(weight, 1e-30);
            data += f64::from(lambda) * weighted().map(|(i, w)| w * (i - mean).powi(2)).sum::<f64>();
        }
    }
    f64::from(mu / config.dx) * length(config, front, width) + data / bands.len() as f64
}

/// The slack is that of the two-phase scheme, with a rounding more for each band.
#[test]
fn the_energy_never_rises() {
    let (width, height) = (61, 47);
    let skies = bands(width, height);
    let skies: Vec<&[f32]> = skies.iter().map(Vec::as_slice).collect();
    for (mu, lambda1, lambda2) in [(0.0, 1.0, 1.0), (0.005, 1.0, 1.0), (0.2, 0.5, 2.0)] {
        for (dt, start) in [(0.1, Start::Threshold { margin: 1.0 }), (8.0, Start::Frame), (1000.0, Start::Frame)] {
            let chan_vese = ChanVese { mu, lambda1, lambda2 };
            let config = Config { chan_vese, dt, t_max: 60.0 * dt, start, eps: 1e-9, ..plain() };
            let mut energies = Vec::new();
            run::<F32>(&config, &skies, (width, height), height, |run| {
                if run.stage() == Stage::Evolve {
                    let images: Vec<_> = (0..skies.len()).map(|at| run.band(at).to_vec()).collect();
                    energies.push(energy(&config, &images, run.front(), width));
                }
            });
            let steepest = f64::from(lambda1 + lambda2 + 6.0 * mu / config.dx);
            let slack = (width * height) as f64 * 0.5f64.powi(24) * (13.0 * steepest + 4.0);
            for (step, pair) in energies.windows(2).enumerate() {
                assert!(pair[1] <= pair[0] + slack, "{chan_vese:?}, dt {dt}, step {step}: {pair:?}");
            }
            assert!(energies.len() > 2 && energies[energies.len() - 1] < energies[0], "{chan_vese:?}, dt {dt}");
        }
    }
}

/// A disc whose left half only the first band shows and its right half only the second, beside a disc in each alone;
/// normal noise of 1 on two levels, the second twice as strong in counts. The pixels of both, and the truth.
fn halves(seed: u32) -> ([Vec<f32>; 2], Vec<bool>) {
    let mut state = seed;
    let mut uniform = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    };
    let within =
        |at: usize, cx: f32, cy: f32, radius: f32| ((at % SIDE) as f32 - cx).hypot((at / SIDE) as f32 - cy) <= radius;
    let shown = |at: usize, second: bool| {
        within(at, 48.0, 48.0, 14.0) && (at % SIDE >= 48) == second
            || within(at, if second { 78.0 } else { 18.0 }, 20.0, 6.0)
    };
    let mut band = |second: bool, level: f32, scale: f32| -> Vec<f32> {
        let light = |at: usize| if shown(at, second) { 8.0 } else { 0.0 };
        (0..SIDE * SIDE).map(|at| level + scale * (light(at) + (0..12).map(|_| uniform()).sum::<f32>())).collect()
    };
    let pixels = [band(false, 100.0, 1.0), band(true, 40.0, 2.0)];
    (pixels, (0..SIDE * SIDE).map(|at| shown(at, false) || shown(at, true)).collect())
}

fn mask(run: &Segmentation) -> Vec<bool> {
    run.labels.iter().map(|&label| label > 0).collect()
}

fn apart(one: &[bool], two: &[bool]) -> usize {
    one.iter().zip(two).filter(|(a, b)| a != b).count()
}

/// The middle of each half of the disc, and of the discs that one band shows.
const PLACES: [usize; 4] = [48 * SIDE + 41, 48 * SIDE + 55, 20 * SIDE + 18, 20 * SIDE + 78];

#[test]
fn edges_that_one_band_shows_each_are_one_contour_in_both() {
    for seed in 1..=5 {
        let ([first, second], truth) = halves(seed);
        let found = |image: &[f32], bands: &[&[f32]]| {
            let mut drive = Drive { bands, ..Drive::default() };
            segment(&Config::CHAN_VESE, image, SIDE, SIDE, &mut drive).expect("discs")
        };
        let at = |run: &Segmentation| PLACES.map(|place| run.labels[place]);
        let (one, two) = (found(&first, &[]), found(&second, &[]));
        assert_eq!(at(&one).map(|label| label > 0), [true, false, true, false], "seed {seed}");
        assert_eq!(at(&two).map(|label| label > 0), [false, true, false, true], "seed {seed}");
        let both = found(&first, &[&second]);
        let [left, right, ..] = at(&both);
        assert!(left > 0 && left == right, "seed {seed}: the halves are one source");
        assert_eq!(both.outcome.sources, 3, "seed {seed}");
        let told = |run: &Segmentation| (run.outcome.extremes, run.outcome.range, run.outcome.tau);
        assert_eq!(told(&both), told(&one), "of the first band");
        let (wrong, all) = (apart(&mask(&both), &truth), truth.iter().filter(|&&inside| inside).count());
        println!("seed {seed}: {wrong} of {all} pixels wrong, of the bands alone {}", apart(&mask(&one), &truth));
        assert!(wrong * 20 < all, "seed {seed}: {wrong} of {all}");
    }
}

#[test]
fn threads_slices_and_arithmetics_agree() {
    let [one, two, three] = &bands(SIDE, SIDE);
    let config = lopsided(Config::CHAN_VESE);
    let run = |threads, slice| {
        let mut drive = Drive { threads, slice, bands: &[two, three], ..Drive::default() };
        segment(&config, one, SIDE, SIDE, &mut drive).expect("a sky")
    };
    let whole = run(1, usize::MAX);
    assert!(whole.outcome.sources > 3 && whole.outcome.steps > 3, "{:?}", whole.outcome);
    let bits = |run: &Segmentation| run.front.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    for (threads, slice) in [(1, 1), (1, 13), (2, SIDE), (5, SIDE)] {
        let other = run(threads, slice);
        assert_eq!(other.outcome, whole.outcome, "{threads} threads, slices of {slice}");
        assert_eq!((&other.labels, bits(&other)), (&whole.labels, bits(&whole)), "{threads} threads");
    }
    let mut drive = Drive { bands: &[two, three], ..Drive::default() };
    let q24 = segment_in::<Q24>(&config, one, SIDE, SIDE, &mut drive).expect("q24");
    assert!(apart(&mask(&q24), &mask(&whole)) <= 3, "{}", apart(&mask(&q24), &mask(&whole)));
}

/// Each step from the core's own front, the front at its start, and the whole run.
fn reference_agrees<A: Arithmetic>(config: &Config) {
    let skies = bands(SIDE, SIDE);
    let p = parameters(config);
    let wide: Vec<Vec<f64>> = skies.iter().map(|band| band.iter().map(|&pixel| pixel.into()).collect()).collect();
    let whole = run_in(&p, &wide, SIDE, SIDE).expect("a sky");
    let slices: Vec<&[f32]> = skies.iter().map(Vec::as_slice).collect();
    let (mut before, mut planes) = (None::<Plane>, Vec::new());
    let (mut worst, mut steps) = (0.0f64, 0);
    let ended = run::<A>(config, &slices, (SIDE, SIDE), SIDE, |run| {
        let plane = |value: &dyn Fn(usize) -> f32| {
            Plane::from_fn(SIDE, SIDE, |i, j| value(j as usize * SIDE + i as usize).into())
        };
        let over = |plane: &Plane| half_side(plane);
        if run.stage() == Stage::Evolve {
            let front = plane(&|at| A::level(run.front()[at]).to_f32());
            if planes.is_empty() {
                planes = (0..3).map(|band| plane(&|at| A::pixel(run.band(band)[at]).to_f32())).collect();
                let far = |one: &Plane, other: &Plane| {
                    one.values().iter().zip(other.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
                };
                for (core, reference) in planes.iter().zip(&whole.bands) {
                    assert!(far(core, reference) < 1e-3, "{}: an image is off by {}", A::NAME, far(core, reference));
                }
                let start = whole.u0.map(|u| u * over(&whole.u0));
                assert!(far(&front, &start) < 1e-3, "{}: the start is off by {}", A::NAME, far(&front, &start));
            }
            if let Some(before) = before.replace(front.clone()) {
                let half = over(&before);
                let next = chan_vese::step(&p, &planes, &before.map(|v| v / half));
                let off = next.values().iter().zip(front.values()).map(|(a, b)| (a * half - b).abs());
                worst = off.fold(worst, f64::max);
                steps += 1;
            }
        }
    });
    println!("{}: {steps} steps within {worst}; {} and {}", A::NAME, ended.outcome.steps, whole.evolution.steps);
    // The means are known to 3 of 2^-12 of their distance, and forces are at most dt times that, twice.
    let means = f64::from(config.dt) * 2.0 * 2.0 * 3.0 * 0.5f64.powi(12);
    assert!(steps > 3 && worst <= means, "{}: {worst} beyond {means}", A::NAME);
    let found: Vec<bool> = ended.labels.iter().map(|&label| label > 0).collect();
    let labels: Vec<bool> = whole.labels.iter().map(|&label| label > 0).collect();
    assert!(apart(&found, &labels) <= 3, "{}: {} pixels apart", A::NAME, apart(&found, &labels));
    assert!(ended.outcome.steps.abs_diff(whole.evolution.steps) <= 2);
}

#[test]
fn the_reference_agrees() {
    for config in [Config::CHAN_VESE, lopsided(Config::CHAN_VESE), Config { start: Start::Frame, ..Config::CHAN_VESE }]
    {
        reference_agrees::<F32>(&config);
        reference_agrees::<Q24>(&config);
    }
    let noise = Normalize::Noise { below: 3.0, above: 30.0 };
    reference_agrees::<F32>(&Config { normalize: noise, order: Order::FilterFirst, ..plain() });
}

/// Every step of a front in several bands is the reference's, and a reference that is asked for anything else is not.
#[test]
fn each_step_is_the_reference_s_and_others_are_noticed() {
    let skies = bands(SIDE, SIDE);
    let slices: Vec<&[f32]> = skies.iter().map(Vec::as_slice).collect();
    let config = Config::CHAN_VESE;
    let differing = |p: &Parameters| {
        let found = walk_bands::<F32>(&config, p, &slices, (SIDE, SIDE)).expect("a sky");
        let wrong = |note: &Difference| note.beyond > if note.step == "centroids" { 1e-3 } else { 1e-6 };
        found.into_iter().filter(wrong).map(|note| note.step).collect::<Vec<_>>()
    };
    let p = parameters(&config);
    assert_eq!(differing(&p), [""; 0]);
    let others: [(Parameters, &str); 5] = [
        (Parameters { mu: 1.1 * p.mu, ..p }, "u"),
        (Parameters { lambda: (1.01, 1.0), ..p }, "u"),
        (Parameters { start_margin: Some(2.0), ..p }, "u0"),
        (Parameters { normalize: reference::Normalize::Noise(3.0, 29.0), ..p }, "levels"),
        (Parameters { filter: reference::Filter::None, ..p }, "filtered"),
    ];
    for (other, step) in others {
        assert!(differing(&other).contains(&step), "{step}: {:?}", differing(&other));
    }
}

#[test]
fn what_cannot_hold_bands_is_refused_by_name() {
    let start = |config: &Config, bands: usize, planes: usize| {
        let mut room = Room::<F32>::new(config, SIDE, SIDE, 1);
        let mut planes = vec![0.0; planes];
        let mut each = vec![skyfront_core::front::bands::Band::NEW; bands];
        let bands = Bands { planes: &mut planes, each: &mut each };
        Segmenter::<F32>::of_bands(config, SIDE, SIDE, room.memory(), bands).err()
    };
    let pixels = SIDE * SIDE;
    assert_eq!(start(&Config::CHAN_VESE, MOST_BANDS, MOST_BANDS * pixels), None);
    let short = |name, given, needed| Some(Error::Length { name, given, needed });
    assert_eq!(start(&Config::CHAN_VESE, 0, 0), short("the bands", 0, 1));
    assert_eq!(
        start(&Config::CHAN_VESE, 2, 2 * pixels - 1),
        short("the planes of the bands", 2 * pixels - 1, 2 * pixels)
    );
    let Some(Error::Parameter { name: "bands", limit: 8.0, .. }) =
        start(&Config::CHAN_VESE, MOST_BANDS + 1, 9 * pixels)
    else {
        panic!("nine bands");
    };
    let told = |config: &Config| start(config, 2, 2 * pixels).map(|error| error.to_string()).unwrap_or_default();
    assert_eq!(told(&Config::PAPER_F160), "an image of several bands needs scheme chan-vese");
    assert_eq!(told(&plain().with_scheme(Scheme::Multiphase)), "an image of several bands needs scheme chan-vese");
    assert_eq!(told(&Config::RSA.with_scheme(Scheme::ChanVese)), "an image of several bands needs sky none");
    let banded = Config { band: Some(8.0), ..Config::CHAN_VESE };
    let mut room = Room::<Q11>::new(&banded, SIDE, SIDE, 1);
    let mut more = BandRoom::<Q11>::new(2, pixels);
    let refused = Segmenter::<Q11>::of_bands(&banded, SIDE, SIDE, room.memory(), more.bands());
    assert!(matches!(refused, Err(Error::Arithmetic { name: "q11", .. })));
}

const WIDTH: usize = 23;
const HEIGHT: usize = 14;

fn saved<A: Arithmetic>(run: &mut Segmenter<'_, A>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let write: Result<(), ()> = run.save(|chunk| {
        bytes.extend_from_slice(chunk);
        Ok(())
    });
    write.expect("memory does not fail");
    bytes
}

fn restored<A: Arithmetic>(run: &mut Segmenter<'_, A>, mut bytes: &[u8]) -> Result<(), SnapshotError<()>> {
    run.restore(|chunk| {
        let (head, rest) = bytes.split_at_checked(chunk.len()).ok_or(())?;
        chunk.copy_from_slice(head);
        bytes = rest;
        Ok(())
    })
}

/// A run that takes up what another wrote out before a poll, in memory full of something else, writes out the same after
/// it as the other did.
fn resumed_everywhere<A: Arithmetic>(config: &Config, slice: usize) {
    let skies = bands(WIDTH, HEIGHT);
    let skies: Vec<&[f32]> = skies.iter().map(Vec::as_slice).collect();
    let (size, cell, mut snapshots) = ((WIDTH, HEIGHT), size_of::<A::Cell>(), Vec::new());
    let stated = snapshot::bytes(WIDTH, HEIGHT, cell, 3, 50) + snapshot::band_bytes(WIDTH, HEIGHT, cell, 3);
    run::<A>(config, &skies, size, slice, |run| snapshots.push(saved(run)));
    for (poll, pair) in snapshots.windows(2).enumerate() {
        assert_eq!(pair[0].len(), stated, "as stated");
        let mut room = Room::<A>::full_of(0x2F13 + poll as u32, config, WIDTH, HEIGHT, 50);
        let mut more = BandRoom::<A>::new(3, WIDTH * HEIGHT);
        let other = Segmenter::<A>::of_bands(config, WIDTH, HEIGHT, room.memory(), more.bands());
        let mut other = other.expect("enough memory");
        let mut flipped = pair[0].clone();
        flipped[stated / 2] ^= 1;
        assert_eq!(restored(&mut other, &flipped), Err(SnapshotError::Damaged));
        assert_eq!(restored(&mut other, &pair[0]), Ok(()));
        other.poll(slice, &mut BandFrame(&skies)).expect("a sky");
        assert!(saved(&mut other) == pair[1], "{}, slices of {slice}, after poll {poll}", A::NAME);
    }
    assert!(snapshots.len() > 30, "{} polls", snapshots.len());
}

#[test]
fn resumed_runs_have_the_bits_of_undisturbed_ones() {
    let near = Config { start: Start::Threshold { margin: 2.0 }, ..plain() };
    for (config, slice) in [(Config::CHAN_VESE, HEIGHT), (near, 5), (near, 1)] {
        resumed_everywhere::<F32>(&config, slice);
        resumed_everywhere::<Q24>(&config, slice);
    }
}

#[test]
fn a_snapshot_of_other_bands_is_refused() {
    let config = &Config::CHAN_VESE;
    let start = |bands: usize, look: &mut dyn FnMut(&mut Segmenter<'_, F32>)| {
        let mut room = Room::<F32>::new(config, WIDTH, HEIGHT, 3);
        let mut more = BandRoom::<F32>::new(bands, WIDTH * HEIGHT);
        let run = Segmenter::<F32>::of_bands(config, WIDTH, HEIGHT, room.memory(), more.bands());
        look(&mut run.expect("enough memory"));
    };
    let mut bytes = Vec::new();
    start(2, &mut |run| bytes = saved(run));
    start(3, &mut |run| assert_eq!(restored(run, &bytes), Err(SnapshotError::Foreign { what: "height" })));
}

/// Allocated is what is stated, and a run stays within its budget of rows.
#[test]
fn memory_and_budget_are_as_stated() {
    let count = 3 * WIDTH * HEIGHT;
    let stated = memory::band_bytes(WIDTH, HEIGHT, 4, 3);
    assert_eq!(stated, 4 * count + 3 * size_of::<skyfront_core::front::bands::Band>());
    let skies = bands(WIDTH, HEIGHT);
    let skies: Vec<&[f32]> = skies.iter().map(Vec::as_slice).collect();
    let config = Config { eps: 1e-9, t_max: 24.0, ..plain() };
    let mut polls = 0u64;
    let mut bound = 0;
    let ended = run::<F32>(&config, &skies, (WIDTH, HEIGHT), 1, |run| (polls, bound) = (polls + 1, run.work().1));
    assert!(ended.outcome.work <= bound && polls <= bound, "{polls} polls, {} of {bound}", ended.outcome.work);
    // One band alone has fewer rows to prepare.
    let alone = skyfront_core::run::budget::total_rows(&config, HEIGHT);
    assert!(ended.outcome.work > alone && bound < 3 * alone, "{bound} of {alone}");
}
