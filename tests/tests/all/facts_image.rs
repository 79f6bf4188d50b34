//! The core against answers that are known without computing them: rescaling, threshold and filter.

use skyfront_core::arithmetic::F32;
use skyfront_core::config::{Config, Diffusivity, Rescale, Tau};
use skyfront_core::image::filter::{Heat, PeronaMalik};
use skyfront_core::image::rescale::Rescaler;
use skyfront_core::plane::sweep::{Band, Halo, advance, ring_len};
use skyfront_core::sky::otsu::{BINS, Histogram};
use std::f64::consts::PI;

/// A1 to A3, and A4 or A4_tau, on 4097 levels: f32 separates the values of neighbouring levels, whose smallest
/// relative difference, 2^-12 / 4 under x^(1/4), is 2^10 roundings wide. r3 with beta = 8 damps to (x/tau)^8, which
/// at 1/4096 of a tau of 1/4 is 2^-82, still far above the least f32.
#[test]
fn the_rescalings_have_the_papers_properties() {
    let tau = 0.25f32;
    let cases = [
        ("r1", Rescale::R1 { alpha: 0.25 }, None),
        ("r1 with another exponent", Rescale::R1 { alpha: 0.3 }, None),
        ("r2", Rescale::R2 { alpha: 0.25 }, None),
        ("r3", Rescale::R3 { beta: 8, tau: Tau::Otsu }, Some(tau)),
        ("r3 with another exponent", Rescale::R3 { beta: 3, tau: Tau::Otsu }, Some(tau)),
    ];
    for (name, rescale, threshold) in cases {
        let rescaler = Rescaler::<F32>::new(rescale, tau).expect("a rescaling");
        let r: Vec<f32> = (0..=4096u16).map(|k| rescaler.apply(f32::from(k) / 4096.0)).collect();
        assert_eq!((r[0], r[4096]), (0.0, 1.0), "{name}: A2");
        assert!(r.windows(2).all(|pair| pair[0] < pair[1]), "{name}: A3, and with A2 A1");
        for (k, &value) in r.iter().enumerate().take(4096).skip(1) {
            let x = k as f32 / 4096.0;
            match threshold {
                Some(tau) if x == tau => assert_eq!(value, tau, "{name}: A4_tau at tau"),
                Some(tau) if x < tau => assert!(value < x, "{name}: A4_tau below, at {x}"),
                _ => assert!(value > x, "{name}: A4 at {x}"),
            }
        }
    }
}

/// A linear congruential generator: the same histograms on every run.
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    *state >> 33
}

/// The variance between the classes of a split, times the square of the number of values, from the definition.
fn between(counts: &[u32; BINS], last: usize) -> f64 {
    let class = |bins: std::ops::Range<usize>| {
        let weight: f64 = counts[bins.clone()].iter().map(|&n| f64::from(n)).sum();
        let moment: f64 = bins.map(|bin| f64::from(counts[bin]) * bin as f64).sum();
        (weight, moment / weight)
    };
    let ((w0, m0), (w1, m1)) = (class(0..last + 1), class(last + 1..BINS));
    if w0 > 0.0 && w1 > 0.0 { w0 * w1 * (m0 - m1).powi(2) } else { 0.0 }
}

/// Otsu's split has the largest variance of all 255. The core rounds in f32, so a split may win whose variance is a
/// few 2^-24 smaller than the largest.
#[test]
fn otsu_is_the_best_of_all_splits() {
    let mut state = 1;
    for round in 0..300 {
        let mut counts = [0u32; BINS];
        for _ in 0..=round % 40 {
            counts[random(&mut state) as usize % BINS] += random(&mut state) as u32 % 10_000 + 1;
        }
        let tau = Histogram(counts).otsu();
        let largest = (0..BINS - 1).map(|last| between(&counts, last)).fold(0.0, f64::max);
        if largest == 0.0 {
            assert_eq!(tau, 0.0, "one bin has no split");
            continue;
        }
        let found = between(&counts, (tau * 256.0) as usize - 1);
        assert!(found >= largest * (1.0 - 1e-6), "round {round}: tau {tau} has {found}, not {largest}");
    }
}

/// cos(pi p (i + 1/2) / W) cos(pi q (j + 1/2) / H) is an eigenfunction of the 5-point Laplacian with replicated
/// edges: a heat step multiplies it by 1 - lambda (4 - 2 cos(pi p / W) - 2 cos(pi q / H)). Each of 20 steps rounds
/// values below 1 a few times by 2^-25: below 1e-5 in all.
#[test]
fn heat_damps_its_eigenfunctions() {
    let (width, height) = (24, 17);
    let config = Config { filter_dt: 2e-3, ..Config::PAPER_F160 };
    let lambda = 0.2;
    for (p, q) in [(0, 0), (1, 0), (0, 3), (5, 2), (23, 16)] {
        let wave = |mode: usize, i: usize, n: usize| (PI * mode as f64 * (i as f64 + 0.5) / n as f64).cos();
        let start: Vec<f64> =
            (0..width * height).map(|at| wave(p, at % width, width) * wave(q, at / width, height)).collect();
        let mut plane: Vec<f32> = start.iter().map(|&v| v as f32).collect();
        let mut ring = vec![0.0; ring_len(width, 3)];
        for _ in 0..20 {
            let mut kernel = Heat::<F32>::new(&config);
            let mut band = Band { plane: &mut plane, aux: &[], ring: &mut ring, width, halo: Halo::NONE };
            advance::<F32, _, 3>(&mut kernel, &mut band, 0..height);
        }
        let cosine = |mode: usize, n: usize| (PI * mode as f64 / n as f64).cos();
        let factor = 1.0 - lambda * (4.0 - 2.0 * cosine(p, width) - 2.0 * cosine(q, height));
        for (&found, &value) in plane.iter().zip(&start) {
            let expected = value * factor.powi(20);
            assert!((f64::from(found) - expected).abs() < 1e-5, "mode ({p}, {q}): {found}, not {expected}");
        }
    }
}

/// One step of Perona-Malik at a step of height d between two columns moves lambda f(|d| / dx) d from one to the other,
/// with lambda = dt / dx^2: f1 = 1 / (1 + s^2) and f2 = exp(-s^2) at s = |d| / (dx mu), and nothing elsewhere. f32 rounds
/// a few values below 1 by 2^-25.
#[test]
fn perona_malik_moves_what_its_coefficient_says() {
    let (width, lambda, mu) = (6, 0.2, 2.5);
    for (diffusivity, f) in [
        (Diffusivity::F1, (|s: f64| 1.0 / (1.0 + s * s)) as fn(f64) -> f64),
        (Diffusivity::F2, |s: f64| (-s * s).exp()),
    ] {
        for d in [0.05, 0.2, 0.7] {
            let config = Config { filter_dt: 2e-3, ..Config::PAPER_F160 };
            let (low, high) = (0.1, 0.1 + d);
            let mut plane: Vec<f32> = (0..width * 3).map(|at| if at % width < 3 { low } else { high } as f32).collect();
            let mut ring = vec![0.0; ring_len(width, 3)];
            let mut kernel = PeronaMalik::<F32>::new(&config, diffusivity, mu as f32);
            let mut band = Band { plane: &mut plane, aux: &[], ring: &mut ring, width, halo: Halo::NONE };
            advance::<F32, _, 3>(&mut kernel, &mut band, 0..3);
            let moved = lambda * f(d / (0.1 * mu)) * d;
            for (at, &found) in plane.iter().enumerate() {
                let expected = [low, low, low + moved, high - moved, high, high][at % width];
                assert!((f64::from(found) - expected).abs() < 1e-6, "{diffusivity:?}, {d}: {found}, not {expected}");
            }
        }
    }
}
