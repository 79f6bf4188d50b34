//! Four phases by two fronts: the energy, known answers, and the promises that every scheme keeps.

use crate::chan_vese::length;
use skyfront::crosscheck::{crosscheck, table};
use skyfront::outline::rings;
use skyfront::pipeline::{Drive, Segmentation, segment, segment_in};
use skyfront::planes::Room;
use skyfront::read::image;
use skyfront_core::arithmetic::{F32, Q11, Q24};
use skyfront_core::config::{ChanVese, Config, Connectivity, Filter, Normalize, Rescale, Scheme, Tau};
use skyfront_core::error::Error;
use skyfront_core::front::pair::{self, PHASES};
use skyfront_core::run::frame::SliceFrame;
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::stage::Stage;
use skyfront_core::simulate::Kind;
use skyfront_tests::command::{Folder, messages, skyfront};
use skyfront_tests::runs::sky;

const SIDE: usize = 96;

/// The image itself, without rescaling, between its extremes.
fn plain() -> Config {
    Config { rescale: Rescale::None, filter: Filter::None, ..Config::PAPER_F160.with_scheme(Scheme::Multiphase) }
}

/// Pixels in units of the noise, those above 3 of them lifted by r3.
fn on_a_sky() -> Config {
    Config { rescale: Rescale::R3 { beta: 8, tau: Tau::Noise { k: 3.0 } }, min_area: 5, ..with_noise(plain()) }
}

fn with_noise(config: Config) -> Config {
    Config { normalize: Normalize::Noise { below: 3.0, above: 30.0 }, ..config }
}

/// The energy of two fronts with the means that are best for them, in f64 by its definition; twice the authors', as the
/// H of both has a slope of 1/2.
fn energy(config: &Config, image: &[f32], fronts: &[Vec<f32>; 2], width: usize) -> f64 {
    let [first, second] = fronts;
    let mut data = 0.0;
    for (in_first, in_second) in PHASES.map(|[first, second]| (first, second)) {
        let share = |inside: bool, v: f32| 1.0 + if inside { f64::from(v) } else { -f64::from(v) };
        let weights = first.iter().zip(second).map(|(&v, &w)| share(in_first, v) * share(in_second, w));
        let weighted = || image.iter().map(|&i| f64::from(i)).zip(weights.clone());
        let (light, weight) = weighted().fold((0.0, 0.0), |(light, all), (i, w)| (light + i * w, all + w));
        let mean = light / f64::max(weight, 1e-30);
        data += 0.5 * weighted().map(|(i, w)| w * (i - mean).powi(2)).sum::<f64>();
    }
    let lengths = length(config, first, width) + length(config, second, width);
    f64::from(config.chan_vese.mu / config.dx) * lengths + data
}

/// A value of a front is rounded by half a step of 2^-14 at most, near the least of a parabola that bends by `1/dt + 8
/// mu / (dx degenerate)` at most, and by 2^-24 in each of about ten operations before. The means are off by 3 of 2^-12
/// of their distance at most, which costs its square per pixel because the best means are a minimum.
#[test]
fn the_energy_never_rises() {
    let (width, height) = (61, 47);
    for (kind, seed) in [(Kind::Bright, 3), (Kind::Noisy, 5)] {
        let pixels = sky(kind, seed, width, height);
        for (mu, dt) in [(0.0, 8.0), (0.005, 0.1), (0.005, 8.0), (0.005, 1000.0), (0.2, 8.0), (2.0, 8.0)] {
            let chan_vese = ChanVese { mu, ..plain().chan_vese };
            let config = Config { chan_vese, dt, t_max: 60.0 * dt, eps: 1e-9, ..with_noise(plain()) };
            let mut room = Room::<F32>::new(&config, width, height, 10);
            let mut run = Segmenter::<F32>::new(&config, width, height, room.memory()).expect("good");
            let mut energies = Vec::new();
            while run.stage() <= Stage::Evolve {
                if run.stage() == Stage::Evolve {
                    let front = |at: usize| run.front().iter().map(|&cell| pair::values::<f32>(cell)[at]).collect();
                    energies.push(energy(&config, run.image(), &[front(0), front(1)], width));
                }
                run.poll(usize::MAX, &mut SliceFrame(&pixels)).expect("a sky");
            }
            let (steepest, step) = (f64::from(2.0 + 6.0 * mu / config.dx), 0.5f64.powi(15));
            let bend = f64::from(1.0 / dt + 8.0 * mu / (config.dx * config.degenerate));
            let means = (3.0 * 0.5f64.powi(12)).powi(2);
            let slack = (width * height) as f64 * (0.5f64.powi(24) * 10.0 * steepest + bend * step * step + means);
            for (step, pair) in energies.windows(2).enumerate() {
                assert!(pair[1] <= pair[0] + slack, "{kind:?}, mu {mu}, dt {dt}, step {step}: {pair:?}, {slack}");
            }
            let (first, last) = (energies[0], energies[energies.len() - 1]);
            println!("{kind:?}, mu {mu}, dt {dt}: {first} to {last} in {} steps, slack {slack}", energies.len());
            assert!(energies.len() > 1 && (last < first || mu == 0.0), "{kind:?}, mu {mu}, dt {dt}: it never moved");
        }
    }
}

/// The phases of a front at its end, from dark to bright.
const RANKS: [f32; 4] = [-1.0, 1.0, 2.0, 3.0];

/// Nested discs of four levels beside a smaller one of two, with normal noise: the pixels, and the truth.
fn discs(seed: u32, noise: f32) -> (Vec<f32>, Vec<f32>) {
    let mut state = seed;
    let mut uniform = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    };
    let level = |x: usize, y: usize| {
        let off = |cx: f32, cy: f32| (x as f32 - cx).hypot(y as f32 - cy);
        let nested = [30.0, 20.0, 10.0].iter().filter(|&&radius| off(40.0, 40.0) <= radius).count();
        nested + 2 * usize::from(off(82.0, 82.0) <= 8.0)
    };
    let phases: Vec<usize> = (0..SIDE * SIDE).map(|at| level(at % SIDE, at / SIDE)).collect();
    let levels = [100.0, 250.0, 500.0, 800.0];
    let pixels = phases.iter().map(|&phase| levels[phase] + noise * (0..12).map(|_| uniform()).sum::<f32>());
    (pixels.collect(), phases.iter().map(|&phase| RANKS[phase]).collect())
}

fn wrong(run: &Segmentation, truth: &[f32]) -> usize {
    run.front.iter().zip(truth).filter(|(found, truth)| found != truth).count()
}

/// The noise puts the border of a level 1.5 to 3 standard deviations away: of single pixels one in 12 lies on the wrong
/// side. The length of the fronts leaves fewer than one in ten along the circles.
#[test]
fn nested_discs_of_four_levels_are_four_phases() {
    for seed in 1..=5 {
        let (pixels, truth) = discs(seed, 50.0);
        let run = |config: &Config| segment(config, &pixels, SIDE, SIDE, &mut Drive::default()).expect("discs");
        let smooth = Config { chan_vese: ChanVese { mu: 0.015, ..plain().chan_vese }, ..plain() };
        let found = run(&Config { min_area: 5, ..smooth });
        let alone = run(&Config { chan_vese: ChanVese { mu: 0.0, ..plain().chan_vese }, ..plain() });
        let (found_wrong, alone_wrong) = (wrong(&found, &truth), wrong(&alone, &truth));
        println!("seed {seed}: {found_wrong} pixels in another phase, without a length {alone_wrong}");
        let circles = 2.0 * std::f32::consts::PI * (30.0 + 20.0 + 10.0 + 8.0);
        assert!((found_wrong as f32) < 0.1 * circles && alone_wrong > SIDE * SIDE / 40, "{found_wrong}, {alone_wrong}");
        assert_eq!(found.outcome.sources, 2, "sources are what is brighter than the darkest phase");
        let inside = found.labels.iter().zip(&found.front).filter(|(label, phase)| (**label > 0) != (**phase > 0.0));
        assert!(inside.count() <= 20, "all but specks of it are in the sources");
    }
}

#[test]
fn fewer_levels_are_fewer_phases() {
    let two: Vec<f32> = discs(1, 0.0).1.iter().map(|&phase| if phase > 1.0 { 9.0 } else { 4.0 }).collect();
    // With a length, pixels that stand out of the circles are phases of their own.
    let config = Config { chan_vese: ChanVese { mu: 0.0, ..plain().chan_vese }, ..plain() };
    let run = segment(&config, &two, SIDE, SIDE, &mut Drive::default()).expect("discs");
    let ranks: Vec<f32> = two.iter().map(|&level| if level > 5.0 { RANKS[1] } else { RANKS[0] }).collect();
    assert_eq!((wrong(&run, &ranks), run.outcome.sources), (0, 2));
    // Outlines lie half way between the pixels of a source and those around it.
    let rings = rings(&run.labels, &run.front, SIDE, SIDE, Connectivity::Eight);
    let half = |at: f64| (at.fract() - 0.5).abs() < 1e-6;
    assert!(rings.iter().flat_map(|ring| &ring.points).all(|&(x, y)| half(x) != half(y)), "{rings:?}");
}

#[test]
fn threads_slices_and_arithmetics_agree() {
    let pixels = sky(Kind::Bright, 8, SIDE, SIDE);
    let config = with_noise(plain());
    let run = |threads, slice| {
        let mut drive = Drive { threads, slice, ..Drive::default() };
        segment(&config, &pixels, SIDE, SIDE, &mut drive).expect("a sky")
    };
    let whole = run(1, usize::MAX);
    assert!(whole.outcome.sources > 2 && whole.outcome.steps > 3, "{:?}", whole.outcome);
    let pixels_of = |phase: f32| whole.front.iter().filter(|&&other| other == phase).count();
    let phases = RANKS.map(pixels_of);
    assert!(phases.iter().all(|&pixels| pixels > 0), "{phases:?}");
    for (threads, slice) in [(1, 1), (1, 13), (2, SIDE), (5, SIDE)] {
        let other = run(threads, slice);
        assert_eq!(other.outcome, whole.outcome, "{threads} threads, slices of {slice}");
        assert_eq!((&other.labels, &other.front), (&whole.labels, &whole.front), "{threads} threads");
    }
    let q24 = segment_in::<Q24>(&config, &pixels, SIDE, SIDE, &mut Drive::default()).expect("q24");
    let apart = wrong(&q24, &whole.front);
    assert!(apart <= 3, "q24 {apart}");
}

#[test]
fn the_reference_agrees() {
    for (kind, seed) in [(Kind::Bright, 8), (Kind::Noisy, 2)] {
        let pixels = sky(kind, seed, SIDE, SIDE);
        let strong = Config { chan_vese: ChanVese { mu: 0.015, ..plain().chan_vese }, ..with_noise(plain()) };
        for config in [on_a_sky(), plain(), strong] {
            let checks = crosscheck(&config, &pixels, SIDE, SIDE, |most| most).expect("a sky");
            println!("{}", table("multiphase", &checks));
            assert_eq!(checks.len(), 2, "every arithmetic with cells of 32 bits serves it");
            for check in &checks {
                assert!(check.steps.iter().any(|step| step.step == "phases"));
                assert!(check.failures().is_empty(), "{}", table("multiphase", &checks));
            }
            let f32 = &checks[0].comparison;
            assert!(f32.mask_pixels <= 3 && f32.steps.0.abs_diff(f32.steps.1) <= 2, "{f32:?}");
        }
    }
}

#[test]
fn what_cannot_hold_two_fronts_is_refused_by_name() {
    let banded = Config { band: Some(8.0), ..plain() };
    let Err(Error::Arithmetic { name: "q11", reason }) = banded.validate::<Q11>() else { panic!("16 bits hold them") };
    assert!(reason.contains("32 bits"));
    let steep = Config { dt: 100.0, t_max: 1000.0, ..plain() };
    assert!(matches!(steep.validate::<Q24>(), Err(Error::Arithmetic { name: "q24", .. })));
    assert_eq!(steep.validate::<F32>(), Ok(()));
}

/// The command line: phases as the front, sources as labels, on the mesh's signal-to-noise too; options that say
/// nothing to it are refused.
#[test]
fn phases_are_the_front_that_is_written() {
    let folder = Folder::new("multiphase");
    let made = skyfront(["simulate", "--kind", "bright", "--seed", "4", "--side", "64", "--out", &folder.file("sky")]);
    assert!(made.status.success(), "{}", messages(&made));
    let run = |options: &[&str]| {
        let line = ["segment", &folder.file("sky/sky.fits"), "--out", &folder.file("out"), "--overwrite", "--quiet"];
        skyfront(line.into_iter().chain(["--scheme", "multiphase"]).chain(options.iter().copied()))
    };
    for options in [&["--preset", "rsa"][..], &["--preset", "paper-f160", "--tau", "noise:3"]] {
        let output = run(options);
        assert!(output.status.success(), "{}", messages(&output));
        let pixels = |name: &str| image(folder.file(name).as_ref(), None).expect("a plane").pixels;
        let (phases, labels) = (pixels("out/front.fits"), pixels("out/segmentation.fits"));
        assert!(phases.iter().all(|phase| RANKS.contains(phase)), "{options:?}");
        assert!(phases.contains(&3.0), "{options:?}");
        assert!(labels.iter().any(|&label| label > 1.0), "{options:?}");
    }
    for options in [["--start", "frame"], ["--margin", "2"], ["--lambda1", "2"], ["--edge", "g1"], ["--band", "8"]] {
        let output = run(&[&["--preset", "paper-f160"], &options[..]].concat());
        let expected = format!("skyfront: {} is not used by --scheme multiphase", options[0]);
        assert!(output.status.code() == Some(2) && messages(&output).starts_with(&expected), "{}", messages(&output));
    }
}
