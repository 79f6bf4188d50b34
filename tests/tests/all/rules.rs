//! Every rule of every step beside the f64 reference, each step from the core's own input; and that faults are seen.

use skyfront::crosscheck::{CheckError, Difference, crosscheck, parameters, walk};
use skyfront::pipeline::{Drive, segment};
use skyfront::reference::{self, Parameters};
use skyfront_core::arithmetic::digest::Digest;
use skyfront_core::arithmetic::{Arithmetic, Cell, F32};
use skyfront_core::config::{
    ChanVese, Config, Connectivity, CurvatureForm, Diffusivity, Edge, Filter, Normalize, Order, Rescale, Scheme, Start,
    Stop, Tau,
};
use skyfront_core::run::memory::{flags_len, ring_cells};
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::stage::Stage;
use skyfront_core::simulate::Kind;
use skyfront_tests::runs::sky;

const WIDTH: usize = 44;
const HEIGHT: usize = 36;
const PAPER: Config = Config::PAPER_F160;
const PAPERS_SCHEMES: [Scheme; 4] = [Scheme::Fd, Scheme::Sl, Scheme::FdCurvature, Scheme::SlCurvature];

/// The front goes half the way to the middle: the rules before it are what counts.
const SHORT: Config = Config { t_max: 1.0, ..PAPER };

fn with_tau(tau: Tau) -> Config {
    Config { rescale: Rescale::R3 { beta: 8, tau }, ..SHORT }
}

/// The rules of steps 1 and 2.
fn intensities() -> Vec<Config> {
    let rescales = [
        Rescale::None,
        Rescale::R1 { alpha: 0.25 },
        Rescale::R1 { alpha: 0.3 },
        Rescale::R2 { alpha: 0.25 },
        Rescale::R2 { alpha: 0.7 },
        Rescale::R3 { beta: 1, tau: Tau::Otsu },
        Rescale::R3 { beta: 3, tau: Tau::Otsu },
    ];
    let taus = [Tau::Kapur, Tau::Rosin, Tau::Noise { k: 3.0 }, Tau::Noise { k: 1.3 }];
    let values = [0.05, 0.1, 0.2, 0.5].map(Tau::Value);
    let noise = Normalize::Noise { below: 3.0, above: 30.0 };
    let normalize = [Normalize::MinMax, Normalize::Percentile { low: 0.5, high: 99.0 }, noise];
    let by_rescale = rescales.into_iter().map(|rescale| Config { rescale, ..SHORT });
    let by_tau = taus.into_iter().chain(values).map(with_tau);
    let all: Vec<Config> = by_rescale.chain(by_tau).collect();
    let orders = [Order::RescaleFirst, Order::FilterFirst];
    let each = |config: &Config| {
        let config = *config;
        normalize
            .into_iter()
            .flat_map(move |normalize| orders.into_iter().map(move |order| Config { normalize, order, ..config }))
    };
    all.iter().flat_map(each).collect()
}

/// The rules of steps 3 and 4.
fn filters_and_edges() -> Vec<Config> {
    let pm = |diffusivity, mu| Filter::PeronaMalik { diffusivity, mu };
    let of_paper = Filter::ALL.iter().copied().filter(|filter| *filter == Filter::None || filter.is_stepped());
    let filters: Vec<Filter> = of_paper.chain([pm(Diffusivity::F1, 2.0), pm(Diffusivity::F2, 2.0)]).collect();
    let edges = [
        Edge::G1 { p: 2.5 },
        Edge::G1 { p: 4.0 },
        Edge::G1 { p: 5000.0 },
        Edge::G2,
        Edge::G2Mod { c2: 0.0 },
        Edge::G2Mod { c2: 0.8 },
        Edge::G2Mod { c2: 0.97 },
    ];
    let filter_dt = 2e-3;
    let each = |filter| edges.map(|edge| Config { filter, filter_dt, edge, filter_steps: 7, ..SHORT });
    filters.into_iter().flat_map(each).collect()
}

/// The rules of steps 5 and 6.
fn fronts() -> Vec<Config> {
    let near = Start::Threshold { margin: 3.0 };
    let strong = ChanVese { mu: 0.02, lambda1: 1.5, lambda2: 0.5 };
    let each = |scheme| {
        let config = PAPER.with_scheme(scheme);
        let config = Config { t_max: 120.0 * config.dt, ..config };
        [
            config,
            Config { band: Some(8.0), ..config },
            Config { band: Some(3.5), stop: Stop::Rate, ..config },
            Config { directions: 64, nu: 0.02, min_area: 4, connectivity: Connectivity::Four, ..config },
            Config { start: near, rescale: Rescale::R1 { alpha: 0.25 }, nu: 0.05, chan_vese: strong, ..config },
            Config {
                start: near,
                band: Some(8.0),
                curvature_form: CurvatureForm::Printed,
                t_max: 20.0 * config.dt,
                ..config
            },
            Config { degenerate: 1.0, nu: 0.05, dx: 0.2, ..config },
        ]
    };
    let of_paper = Scheme::ALL.into_iter().filter(|scheme| *scheme != Scheme::Region);
    of_paper.flat_map(each).collect()
}

/// A sky with undefined pixels.
fn sky_with_holes(kind: Kind, seed: u32) -> Vec<f32> {
    let mut pixels = sky(kind, seed, WIDTH, HEIGHT);
    pixels.iter_mut().skip(seed as usize % 31).step_by(97).for_each(|pixel| *pixel = f32::NAN);
    pixels
}

/// What a check finds fault with, a line for each, and how many arithmetics it took in.
fn faults(config: &Config, pixels: &[f32], lines: &mut Vec<String>) -> usize {
    let checks =
        crosscheck(config, pixels, WIDTH, HEIGHT, |most| most).unwrap_or_else(|error| panic!("{error}: {config:?}"));
    for check in checks.iter().filter(|check| !check.failures().is_empty()) {
        let failures = check.failures();
        let steps: Vec<_> = check.steps.iter().filter(|d| failures.contains(&d.step)).collect();
        lines.push(format!("{}: {steps:?} of {config:?}", check.arithmetic));
    }
    checks.len()
}

fn assert_none(faults: &[String]) {
    faults.iter().for_each(|fault| println!("{}", &fault[..fault.len().min(260)]));
    assert!(faults.is_empty(), "{} faults, first and last:\n{}\n{}", faults.len(), faults[0], faults[faults.len() - 1]);
}

#[test]
fn every_rule_of_the_intensities() {
    let mut found = Vec::new();
    for (kind, seed) in [(Kind::Bright, 5), (Kind::Noisy, 6)] {
        for config in intensities() {
            assert_eq!(faults(&config, &sky_with_holes(kind, seed), &mut found), 3);
        }
    }
    assert_none(&found);
}

#[test]
fn every_filter_and_edge_detector() {
    let mut found = Vec::new();
    for (kind, seed) in [(Kind::Bright, 7), (Kind::Stars, 8)] {
        for config in filters_and_edges() {
            // Total variation has no room in cells of 16 bits.
            let arithmetics = if matches!(config.filter, Filter::TotalVariation { .. }) { 2 } else { 3 };
            assert_eq!(faults(&config, &sky_with_holes(kind, seed), &mut found), arithmetics);
        }
    }
    assert_none(&found);
}

#[test]
fn every_front() {
    let mut found = Vec::new();
    for (kind, seed) in [(Kind::Bright, 9), (Kind::Noisy, 10)] {
        for config in fronts().iter().filter(|config| config.validate::<F32>().is_ok()) {
            assert!(faults(config, &sky_with_holes(kind, seed), &mut found) > 0);
        }
    }
    assert_none(&found);
}

/// A front in pixels that is wider than the range of q24.
#[test]
fn a_march_over_a_frame_of_264_pixels() {
    const SIDE: usize = 264;
    let config = PAPER.with_scheme(Scheme::FastMarching);
    let checks = crosscheck(&config, &sky(Kind::Bright, 14, SIDE, SIDE), SIDE, SIDE, |most| most).expect("a sky");
    assert_eq!(checks.iter().map(|check| check.failures()).collect::<Vec<_>>(), [Vec::<&str>::new(), Vec::new()]);
}

/// Fifty skies, the paper's four schemes, its two rescalings and the two thresholds that lie in the flank of the sky.
#[test]
fn sound_runs_pass_on_fifty_skies() {
    let rescales = [
        Rescale::R1 { alpha: 0.25 },
        Rescale::R3 { beta: 8, tau: Tau::Otsu },
        Rescale::R3 { beta: 8, tau: Tau::Noise { k: 2.0 } },
        Rescale::R3 { beta: 8, tau: Tau::Value(0.1) },
    ];
    let mut found = Vec::new();
    for seed in 100..150 {
        let kind = [Kind::Bright, Kind::Noisy, Kind::Stars][seed as usize % 3];
        let pixels = sky(kind, seed, WIDTH, HEIGHT);
        for scheme in PAPERS_SCHEMES {
            let rescale = rescales[(seed as usize + scheme as usize) % rescales.len()];
            faults(&Config { rescale, t_max: 5.0, ..PAPER.with_scheme(scheme) }, &pixels, &mut found);
        }
    }
    assert_none(&found);
}

/// What the reference has no word on is no agreement.
#[test]
fn what_has_no_reference_is_refused() {
    let pixels = sky(Kind::Bright, 1, WIDTH, HEIGHT);
    let refused = crosscheck(&Config { start: Start::Given, ..PAPER }, &pixels, WIDTH, HEIGHT, |most| most);
    assert!(matches!(refused, Err(CheckError::NoReference(_))), "{refused:?}");
}

/// The steps that a check of `config` finds fault with where the reference follows other parameters.
fn blamed(config: &Config, wrong: impl Fn(&mut Parameters)) -> Vec<&'static str> {
    let mut other = parameters(config);
    wrong(&mut other);
    let pixels = sky_with_holes(Kind::Bright, 11);
    let checks = crosscheck(config, &pixels, WIDTH, HEIGHT, |most| most).expect("a sky");
    let tolerances = checks[0].tolerances;
    let steps = walk::<F32>(config, &other, &pixels, (WIDTH, HEIGHT), &mut |_, _| {}).expect("a sky");
    let check = skyfront::crosscheck::Check { steps, tolerances, ..checks[0].clone() };
    check.failures()
}

/// A core that did something else than it was asked for: a fault in each step is laid at that step's door.
#[test]
fn faults_are_seen_where_they_are_made() {
    let r1 = Config { rescale: Rescale::R1 { alpha: 0.25 }, ..PAPER };
    let pm = Config { filter: Filter::PeronaMalik { diffusivity: Diffusivity::F2, mu: 2.0 }, ..PAPER };
    let cv = PAPER.with_scheme(Scheme::ChanVese);
    let phases = PAPER.with_scheme(Scheme::Multiphase);
    let weighted = Config { chan_vese: ChanVese { mu: 0.005, lambda1: 1.5, lambda2: 0.5 }, ..cv };
    let bent = Config { nu: 0.05, ..PAPER.with_scheme(Scheme::FdCurvature) };
    let looking = Config { nu: 0.05, dt: 0.05, ..PAPER.with_scheme(Scheme::SlCurvature) };
    let noisy = Config { normalize: Normalize::Noise { below: 3.0, above: 30.0 }, ..PAPER };
    type Fault = fn(&mut Parameters);
    let filtered = |filter: Filter| Config { filter, filter_steps: 3, ..r1 };
    let bilateral = filtered(Filter::Bilateral { contrast: 0.1 });
    let flat = filtered(Filter::TotalVariation { weight: 0.1 });
    let starlet = filtered(Filter::Starlet { significance: 3.0 });
    let faults: [(&Config, Fault, &str); 33] = [
        (&PAPER, |p| p.normalize = reference::Normalize::Percentile(0.5, 99.9), "levels"),
        (&noisy, |p| p.normalize = reference::Normalize::Noise(3.0, 30.001), "levels"),
        (&noisy, |p| p.normalize = reference::Normalize::MinMax, "levels"),
        (&PAPER, |p| p.tau = reference::Tau::Kapur, "tau"),
        (&PAPER, |p| p.tau = reference::Tau::Value(0.2), "tau"),
        (&r1, |p| p.rescale = reference::Rescale::R2 { alpha: 0.25 }, "rescaled"),
        (&r1, |p| p.rescale = reference::Rescale::R1 { alpha: 0.250_01 }, "rescaled"),
        (&r1, |p| p.rescale = reference::Rescale::None, "rescaled"),
        (&PAPER, |p| p.rescale = reference::Rescale::R3 { beta: 7.0 }, "rescaled"),
        (&PAPER, |p| p.order = reference::Order::FilterFirst, "rescaled"),
        (&PAPER, |p| p.filter = reference::Filter::None, "filtered"),
        (&PAPER, |p| p.filter = reference::Filter::Heat { steps: 5, dt: 1.001e-4 }, "filtered"),
        (
            &pm,
            |p| {
                p.filter = reference::Filter::PeronaMalik { f: reference::Diffusivity::F1, mu: 2.0, steps: 5, dt: 1e-4 }
            },
            "filtered",
        ),
        (&bilateral, |p| p.filter = reference::Filter::Bilateral { contrast: 0.101, steps: 3 }, "filtered"),
        (&flat, |p| p.filter = reference::Filter::TotalVariation { weight: 0.101, steps: 3 }, "filtered"),
        (&starlet, |p| p.filter = reference::Filter::Starlet { significance: 3.01, scales: 3 }, "filtered"),
        (&starlet, |p| p.filter = reference::Filter::Starlet { significance: 3.0, scales: 2 }, "filtered"),
        (&PAPER, |p| p.edge = reference::Edge::G2, "g"),
        (&PAPER, |p| p.edge = reference::Edge::G2Mod { c2: 0.800_1 }, "g"),
        (&PAPER, |p| p.band = Some(8.0), "u0"),
        (&PAPER, |p| p.dt = 0.025_01, "u"),
        (&PAPER, |p| p.scheme = reference::Scheme::FdFiltered, "u"),
        (&phases, |p| p.mu = 0.005_2, "u"),
        (&phases, |p| p.dt = 8.1, "u"),
        (&phases, |p| p.scheme = reference::Scheme::ChanVese, "u0"),
        (&PAPER, |p| p.eps = 2e-3, "stop"),
        (&PAPER, |p| p.eps_front = 0.11, "change"),
        (&bent, |p| p.nu = 0.051, "u"),
        (&bent, |p| p.curvature_form = reference::CurvatureForm::Printed, "u"),
        (&looking, |p| p.nu = 0.051, "u"),
        (&weighted, |p| p.lambda = (p.lambda.1, p.lambda.0), "u"),
        (&cv, |p| p.mu = 0.02, "u"),
        (&PAPER, |p| p.min_area = 1000, "labels"),
    ];
    for (config, fault, step) in faults {
        assert_eq!(blamed(config, |_| {}), Vec::<&str>::new());
        let blamed = blamed(config, fault);
        assert!(blamed.contains(&step), "{step}: only {blamed:?} of {config:?}");
    }
}

/// Whole runs are held to limits only where there are some.
#[test]
fn whole_runs_can_be_held_to_limits() {
    let pixels = sky(Kind::Bright, 13, WIDTH, HEIGHT);
    let mut check = crosscheck(&PAPER, &pixels, WIDTH, HEIGHT, |most| most).expect("a sky").remove(0);
    (check.comparison.mask_pixels, check.comparison.steps) = (3, (10, 14));
    assert_eq!(check.failures(), Vec::<&str>::new());
    (check.tolerances.pixels, check.tolerances.steps) = (Some(3), Some(4));
    assert_eq!(check.failures(), Vec::<&str>::new());
    (check.tolerances.pixels, check.tolerances.steps) = (Some(2), Some(3));
    assert_eq!(check.failures(), ["steps", "mask"]);
}

/// `g2` is 1 where the gradient is least, on an image that is steep everywhere too.
#[test]
fn the_least_gradient_has_no_edge() {
    let pixels: Vec<f32> =
        (0..WIDTH * HEIGHT).map(|at| ((at % WIDTH) as f32).powi(2) + (at % WIDTH) as f32 * 9.0).collect();
    let config = Config { edge: Edge::G2, rescale: Rescale::None, filter: Filter::None, ..PAPER };
    let mut drive = Drive { keep_stages: true, ..Drive::default() };
    let run = segment(&config, &pixels, WIDTH, HEIGHT, &mut drive).expect("an image");
    assert!(run.outcome.gradient.0 > 0.01, "{:?}", run.outcome.gradient);
    let g = run.stages.expect("stages were kept").edge;
    assert_eq!(g.iter().copied().fold(0.0, f32::max), 1.0);
    let mut found = Vec::new();
    faults(&config, &pixels, &mut found);
    assert_none(&found);
}

/// A bit flips in a plane after a pass: what a beam of particles does, and what a wrong formula does to one pixel.
#[test]
fn a_single_bit_is_seen() {
    let config = Config { rescale: Rescale::R1 { alpha: 0.25 }, ..PAPER };
    let pixels = sky(Kind::Bright, 12, WIDTH, HEIGHT);
    let steps = |stage: Stage, plane: usize, bit: u32| {
        let mut left = 3;
        walk::<F32>(&config, &parameters(&config), &pixels, (WIDTH, HEIGHT), &mut |passed, run| {
            if passed == stage {
                left -= 1;
                if left == 0 || stage != Stage::Evolve && left == 2 {
                    flip(run, plane, WIDTH * HEIGHT / 2 + WIDTH / 2, bit);
                }
            }
        })
        .expect("a sky")
    };
    let tolerances = crosscheck(&config, &pixels, WIDTH, HEIGHT, |most| most).expect("a sky")[0].tolerances;
    let beyond = |found: &[Difference], step: &str| found.iter().find(|d| d.step == step).expect("a step").beyond;
    for bit in [8, 14, 20, 22] {
        for (stage, plane, step, most) in [
            (Stage::Normalize, 0, "normalised", tolerances.normalised),
            (Stage::Rescale, 0, "rescaled", tolerances.rescaled),
            (Stage::Edge, 0, "g", tolerances.edge),
            (Stage::Front, 1, "u0", tolerances.front),
            (Stage::Evolve, 1, "u", tolerances.front),
        ] {
            let found = beyond(&steps(stage, plane, bit), step);
            assert!(found > most, "bit {bit} after {stage:?}: {found:e}");
        }
    }
}

/// Flips a bit of a cell of the image (plane 0) or of the front (plane 1) through a snapshot.
fn flip<A: Arithmetic>(run: &mut Segmenter<'_, A>, plane: usize, pixel: usize, bit: u32) {
    let mut bytes = Vec::new();
    let Ok(()) = run.save(|piece| {
        bytes.extend_from_slice(piece);
        Ok::<(), std::convert::Infallible>(())
    });
    // From the end: the sum, the catalogue, the flags of the tiles, the ring and the two planes.
    let (cell, pixels) = (A::Cell::BYTES, WIDTH * HEIGHT);
    let sources = (pixels / 4).clamp(1, skyfront::pipeline::MOST_SOURCES);
    let behind = 4 + 4 * 25 * sources + 4 * flags_len(WIDTH, HEIGHT) + cell * ring_cells(WIDTH, false);
    let planes = bytes.len() - behind - 2 * cell * pixels;
    bytes[planes + cell * (plane * pixels + pixel) + bit as usize / 8] ^= 1 << (bit % 8);
    let end = bytes.len() - 4;
    let mut digest = Digest::default();
    digest.bytes(&bytes[..end]);
    bytes.splice(end.., digest.value().to_le_bytes());
    let mut rest = &bytes[..];
    let read = |piece: &mut [u8]| {
        let (head, tail) = rest.split_at(piece.len());
        piece.copy_from_slice(head);
        rest = tail;
        Ok::<(), std::convert::Infallible>(())
    };
    run.restore(read).expect("a sound snapshot");
}
