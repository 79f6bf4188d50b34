//! Active contours without edges: the energy, known answers, and the promises that every scheme keeps.

use skyfront::crosscheck::{crosscheck, table};
use skyfront::pipeline::{Drive, Segmentation, segment, segment_in};
use skyfront::planes::Room;
use skyfront_core::arithmetic::{F32, Q11, Q24};
use skyfront_core::config::{ChanVese, Config, Filter, Rescale, Scheme, Start};
use skyfront_core::error::Error;
use skyfront_core::run::frame::SliceFrame;
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::stage::Stage;
use skyfront_core::simulate::Kind;
use skyfront_tests::runs::sky;

const SIDE: usize = 96;

/// The image itself, without rescaling, between its extremes.
fn plain() -> Config {
    Config { rescale: Rescale::None, filter: Filter::None, ..Config::PAPER_F160.with_scheme(Scheme::ChanVese) }
}

fn mask(run: &Segmentation) -> Vec<bool> {
    run.labels.iter().map(|&label| label > 0).collect()
}

/// The length of a front's contours in pixels, in f64 by its definition.
pub fn length(config: &Config, front: &[f32], width: usize) -> f64 {
    let height = front.len() / width;
    let at = |x: usize, y: usize| f64::from(front[y.min(height - 1) * width + x.min(width - 1)]);
    let flat = f64::from(config.degenerate);
    let mut length = 0.0;
    // Every square of four pixels, those at the border with their outer half repeated.
    for y in 0..=height {
        for x in 0..=width {
            let (left, below) = (x.saturating_sub(1), y.saturating_sub(1));
            let (bl, br, al, ar) = (at(left, below), at(x, below), at(left, y), at(x, y));
            let squares = (br - bl).powi(2) + (ar - al).powi(2) + (al - bl).powi(2) + (ar - br).powi(2);
            let s = (squares / 2.0).sqrt();
            let inside = (1..width).contains(&x) && (1..height).contains(&y);
            let h = if s < flat { s * s / (2.0 * flat) + flat / 2.0 } else { s };
            length += h * if inside { 1.0 } else { 0.5 };
        }
    }
    length
}

/// The energy of a front in pixels with the means that are best for it.
fn energy(config: &Config, image: &[f32], front: &[f32], width: usize) -> f64 {
    let ChanVese { mu, lambda1, lambda2 } = config.chan_vese;
    let mut data = 0.0;
    for (sign, lambda) in [(1.0, lambda1), (-1.0, lambda2)] {
        let weighted = || image.iter().zip(front).map(|(&i, &v)| (f64::from(i), 1.0 + sign * f64::from(v)));
        let (light, weight) = weighted().fold((0.0, 0.0), |(light, all), (i, w)| (light + i * w, all + w));
        let mean = light / f64::max(weight, 1e-30);
        data += f64::from(lambda) * weighted().map(|(i, w)| w * (i - mean).powi(2)).sum::<f64>();
    }
    f64::from(mu / config.dx) * length(config, front, width) + data
}

/// A value of the front is rounded to 2^-24 in each of about ten operations and the energy changes by at most
/// `lambda1 + lambda2 + 6 mu/dx` per unit of it; the means are off by 2^-12 of their distance at most, which costs
/// `2^-24 lambda` per pixel because the best means are a minimum.
#[test]
fn the_energy_never_rises() {
    let (width, height) = (61, 47);
    let pixels = sky(Kind::Bright, 3, width, height);
    for (mu, lambda1, lambda2) in [(0.0, 1.0, 1.0), (0.005, 1.0, 1.0), (0.2, 0.5, 2.0), (2.0, 1.0, 1.0)] {
        for dt in [0.1, 8.0, 1000.0] {
            for start in [Start::Frame, Start::Threshold { margin: 1.0 }] {
                let chan_vese = ChanVese { mu, lambda1, lambda2 };
                let config = Config { chan_vese, dt, t_max: 60.0 * dt, start, eps: 1e-9, ..plain() };
                let mut room = Room::<F32>::new(&config, width, height, 10);
                let mut run = Segmenter::<F32>::new(&config, width, height, room.memory()).expect("good");
                let mut energies = Vec::new();
                while run.stage() <= Stage::Evolve {
                    if run.stage() == Stage::Evolve {
                        energies.push(energy(&config, run.image(), run.front(), width));
                    }
                    run.poll(usize::MAX, &mut SliceFrame(&pixels)).expect("a sky");
                }
                let steepest = f64::from(lambda1 + lambda2 + 6.0 * mu / config.dx);
                let slack = (width * height) as f64 * 0.5f64.powi(24) * (10.0 * steepest + 4.0);
                for (step, pair) in energies.windows(2).enumerate() {
                    assert!(pair[1] <= pair[0] + slack, "{chan_vese:?}, dt {dt}, step {step}: {pair:?}");
                }
                assert!(energies.len() > 1, "{chan_vese:?}, dt {dt}: it never moved");
            }
        }
    }
}

/// Discs of brightness 1 on a dark sky, beside a square that keeps the means apart.
fn discs(radii: &[(f64, f64, f64)]) -> Vec<f32> {
    let bright = |x: usize, y: usize| {
        let inside = |&(cx, cy, r): &(f64, f64, f64)| (x as f64 - cx).hypot(y as f64 - cy) <= r;
        (60..90).contains(&x) && (60..90).contains(&y) || radii.iter().any(inside)
    };
    (0..SIDE * SIDE).map(|at| f32::from(bright(at % SIDE, at / SIDE))).collect()
}

/// Two grey levels are two regions: without a weight of the length every pixel is told apart, in every arithmetic.
#[test]
fn two_levels_are_two_regions() {
    let pixels = discs(&[(20.0, 20.0, 6.0), (60.0, 25.0, 2.0), (30.0, 60.0, 0.5)]);
    let truth: Vec<bool> = pixels.iter().map(|&v| v > 0.5).collect();
    for start in [Start::Frame, Start::Threshold { margin: 3.0 }] {
        let chan_vese = ChanVese { mu: 0.0, ..plain().chan_vese };
        let config = Config { chan_vese, start, band: Some(8.0), ..plain() };
        let drive = || Drive::default();
        assert_eq!(mask(&segment(&config, &pixels, SIDE, SIDE, &mut drive()).expect("f32")), truth);
        assert_eq!(mask(&segment_in::<Q24>(&config, &pixels, SIDE, SIDE, &mut drive()).expect("q24")), truth);
        assert_eq!(mask(&segment_in::<Q11>(&config, &pixels, SIDE, SIDE, &mut drive()).expect("q11")), truth);
    }
}

/// A disc of contrast c costs 4 pi r mu/dx of length and saves 2 pi r^2 c^2: it goes where r < 2 mu / (dx c^2), here
/// 3.5 pixels.
#[test]
fn what_is_smaller_than_its_length_is_worth_goes() {
    let pixels = discs(&[(20.0, 20.0, 6.0), (60.0, 25.0, 2.0)]);
    let chan_vese = ChanVese { mu: 0.175, ..plain().chan_vese };
    // A heavy length makes steps short, and the usual tolerance ends the run before they add up.
    let config = Config { chan_vese, eps: 1e-7, t_max: 5000.0 * plain().dt, ..plain() };
    let run = segment(&config, &pixels, SIDE, SIDE, &mut Drive::default()).expect("f32");
    let mask = mask(&run);
    assert_eq!((mask[20 * SIDE + 20], mask[25 * SIDE + 60], mask[75 * SIDE + 75]), (true, false, true));
    assert_eq!(run.outcome.sources, 2);
}

#[test]
fn threads_slices_and_arithmetics_agree() {
    let pixels = sky(Kind::Bright, 8, SIDE, SIDE);
    let run = |threads, slice| {
        let mut drive = Drive { threads, slice, ..Drive::default() };
        segment(&Config::CHAN_VESE, &pixels, SIDE, SIDE, &mut drive).expect("a sky")
    };
    let whole = run(1, usize::MAX);
    assert!(whole.outcome.sources > 3, "{:?}", whole.outcome);
    let bits = |run: &Segmentation| run.front.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    for (threads, slice) in [(1, 1), (1, 13), (2, SIDE), (5, SIDE)] {
        let other = run(threads, slice);
        assert_eq!(other.outcome, whole.outcome, "{threads} threads, slices of {slice}");
        assert_eq!((&other.labels, bits(&other)), (&whole.labels, bits(&whole)), "{threads} threads");
    }
    let apart = |other: Segmentation| mask(&other).iter().zip(mask(&whole)).filter(|(a, b)| **a != *b).count();
    let banded = Config { band: Some(8.0), ..Config::CHAN_VESE };
    let q24 = segment_in::<Q24>(&banded, &pixels, SIDE, SIDE, &mut Drive::default()).expect("q24");
    let q11 = segment_in::<Q11>(&banded, &pixels, SIDE, SIDE, &mut Drive::default()).expect("q11");
    let (q24, q11) = (apart(q24), apart(q11));
    assert!(q24 <= 3 && q11 <= SIDE * SIDE / 500, "q24 {q24}, q11 {q11}");
}

#[test]
fn the_reference_agrees() {
    let pixels = sky(Kind::Bright, 8, SIDE, SIDE);
    for config in [Config::CHAN_VESE, plain(), Config { start: Start::Frame, ..Config::CHAN_VESE }] {
        let checks = crosscheck(&config, &pixels, SIDE, SIDE, |most| most).expect("a sky");
        assert_eq!(checks.len(), 3, "every arithmetic serves it");
        let f32 = &checks[..1];
        println!("{}", table("chan-vese", &checks));
        assert!(f32[0].failures().is_empty(), "{}", table("chan-vese", f32));
    }
}

#[test]
fn weights_out_of_range_are_refused_by_name() {
    let refused = |chan_vese, dt| {
        let config = Config { chan_vese, dt, t_max: 10.0 * dt, ..plain() };
        let Err(error) = config.validate::<Q24>() else { panic!("{chan_vese:?}, dt {dt}") };
        error
    };
    let weights = plain().chan_vese;
    assert!(matches!(refused(ChanVese { mu: -1.0, ..weights }, 1.0), Error::Parameter { name: "mu", .. }));
    assert!(matches!(refused(ChanVese { lambda1: 0.0, ..weights }, 1.0), Error::Parameter { name: "lambda1", .. }));
    assert!(matches!(refused(ChanVese { lambda2: 11.0, ..weights }, 1.0), Error::Parameter { name: "lambda2", .. }));
    assert!(matches!(refused(ChanVese { mu: 1.0, ..weights }, 8.0), Error::Arithmetic { name: "q24", .. }));
    assert!(matches!(refused(weights, 100.0), Error::Arithmetic { name: "q24", .. }));
}
