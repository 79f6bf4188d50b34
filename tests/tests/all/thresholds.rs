//! Automatic thresholds: against exhaustive searches by their definitions, known answers, and skies.

use skyfront::crosscheck::parameters;
use skyfront::pipeline::{Drive, Segmentation, segment, segment_in};
use skyfront::reference;
use skyfront_core::arithmetic::{F32, Q11, Q24};
use skyfront_core::config::{Config, Normalize, Order, Rescale, Tau};
use skyfront_core::run::frame::Frame;
use skyfront_core::simulate::{Kind, Sky};
use skyfront_core::sky::otsu::{BINS, Histogram};
use skyfront_tests::runs::sky;

/// Histograms of every shape: dense, sparse, narrow, with one bin and none.
fn histograms() -> Vec<[u32; BINS]> {
    let mut state = 12_345u64;
    let mut draw = move |below: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    };
    let mut all = vec![[0; BINS], [0; BINS], [9; BINS]];
    all[1][77] = 40;
    for round in 0..300u64 {
        let (most, gaps, width) = (1 + draw(1 << (1 + round % 11)), draw(6), 2 + draw(255));
        let first = draw(BINS as u64 - width + 1) as usize;
        let mut bins = [0; BINS];
        for bin in &mut bins[first..first + width as usize] {
            *bin = if draw(6) < gaps { 0 } else { draw(most + 1) as u32 };
        }
        all.push(bins);
    }
    all
}

/// A level in the middle of its bin, as often as the bin says.
fn levels(bins: &[u32; BINS]) -> impl Iterator<Item = f64> + '_ {
    let level = |bin: usize| (bin as f64 + 0.5) / BINS as f64;
    bins.iter().enumerate().flat_map(move |(bin, &n)| std::iter::repeat_n(level(bin), n as usize))
}

#[test]
fn greatest_entropy_and_corner_are_those_of_an_exhaustive_search() {
    for bins in histograms() {
        let histogram = Histogram(bins);
        assert_eq!(f64::from(histogram.threshold(Tau::Kapur)), reference::kapur(levels(&bins)), "{bins:?}");
        assert_eq!(f64::from(histogram.threshold(Tau::Rosin)), reference::rosin(levels(&bins)), "{bins:?}");
    }
}

/// Two plateaus of equal entropy: the sum of entropies is greatest where each class is one of them. A peak with a long
/// tail of ones: the corner is at the foot of the peak.
#[test]
fn known_answers() {
    let mut plateaus = [0; BINS];
    plateaus[10..40].fill(50);
    plateaus[180..210].fill(50);
    let tau = Histogram(plateaus).threshold(Tau::Kapur);
    assert_eq!(tau, 40.0 / 256.0);
    let mut star_field = [0; BINS];
    star_field[20] = 90_000;
    star_field[21] = 30_000;
    star_field[22..250].fill(1);
    let tau = Histogram(star_field).threshold(Tau::Rosin);
    assert_eq!(tau, 23.0 / 256.0);
    // Otsu: every split between two peaks is as good as the next; the lowest edge counts.
    let mut peaks = [0; BINS];
    (peaks[10], peaks[90]) = (700, 300);
    assert_eq!(Histogram(peaks).threshold(Tau::Otsu), 11.0 / 256.0);
    let one = Histogram(std::array::from_fn(|bin| if bin == 5 { 3 } else { 0 }));
    assert_eq!([Tau::Otsu, Tau::Kapur, Tau::Rosin].map(|rule| one.threshold(rule)), [0.0; 3]);
}

const SIDE: usize = 128;

fn stars() -> (Vec<f32>, f32) {
    let mut sky = Sky::new(Kind::Stars, 4, SIDE, SIDE);
    let mut pixels = vec![0.0; SIDE * SIDE];
    for (y, row) in pixels.chunks_exact_mut(SIDE).enumerate() {
        let Ok(()) = sky.row(y, row);
    }
    (pixels, sky.sigma())
}

fn run(config: &Config, pixels: &[f32]) -> Segmentation {
    segment(config, pixels, SIDE, SIDE, &mut Drive::default()).expect("a sky")
}

/// The median of a plane, and its percentile one standard deviation below, sorted whole.
fn sorted_sky(pixels: &[f32]) -> (f64, f64) {
    let mut sorted: Vec<f64> = pixels.iter().map(|&v| v.into()).collect();
    sorted.sort_by(f64::total_cmp);
    for _ in 0..2 {
        let (level, noise) = ranks(&sorted);
        sorted.retain(|&v| v <= level + 3.0 * noise);
    }
    ranks(&sorted)
}

fn ranks(sorted: &[f64]) -> (f64, f64) {
    let last = (sorted.len() - 1) as f64;
    let level = sorted[(0.5 * last) as usize];
    (level, level - sorted[(0.158_655_25 * last) as usize])
}

#[test]
fn normalisation_by_sky_and_noise_is_not_moved_by_a_hot_pixel() {
    let (mut pixels, sigma) = stars();
    let config = Config { normalize: Normalize::Noise { below: 3.0, above: 30.0 }, ..Config::PAPER_F160 };
    let (level, noise) = sorted_sky(&pixels);
    // The wings of the stars are a tenth of the noise.
    assert!((noise / f64::from(sigma) - 1.0).abs() < 0.1, "{noise} measured, {sigma} simulated");
    let range = run(&config, &pixels).outcome.range;
    assert!((f64::from(range.low) - (level - 3.0 * noise)).abs() < 1e-5 * noise);
    assert!((f64::from(range.high) - (level + 30.0 * noise)).abs() < 1e-5 * noise);
    let calm = run(&config, &pixels);
    pixels[5 * SIDE + 5] = 1e30;
    let hot = run(&config, &pixels);
    let differing = calm.labels.iter().zip(&hot.labels).filter(|(a, b)| (**a > 0) != (**b > 0)).count();
    assert!(differing <= 9, "{differing} pixels far from the hot one");
    let flat = run(&Config::PAPER_F160, &pixels);
    assert!(flat.outcome.mask_pixels < 10, "by the extremes nothing is left but the hot pixel");
}

#[test]
fn a_frame_without_noise_is_normalised_by_its_extremes() {
    let pixels: Vec<f32> = (0..SIDE * SIDE).map(|i| if i % 7 == 0 { i as f32 } else { 2.0 }).collect();
    let config = Config { normalize: Normalize::Noise { below: 3.0, above: 30.0 }, ..Config::PAPER_F160 };
    let range = run(&config, &pixels).outcome.range;
    assert_eq!((range.low, range.high), (0.0, 16380.0));
}

/// On pure noise the share of pixels above sky + K sigma is the tail of the normal distribution, for a filtered image
/// as well: the noise is that of the image which is rescaled.
#[test]
fn a_threshold_in_noise_units_keeps_its_false_alarms() {
    let mut state = 99u32;
    let mut uniform = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / 16_777_216.0
    };
    const SIDE: usize = 500;
    // Sums of twelve uniform numbers are normal up to 2 standard deviations to better than 1 % of the tail.
    let pixels: Vec<f32> = (0..SIDE * SIDE).map(|_| ((0..12).map(|_| uniform()).sum::<f64>() - 6.0) as f32).collect();
    for (order, steps) in [(Order::RescaleFirst, 5), (Order::FilterFirst, 200)] {
        let k = 2.0;
        let rescale = Rescale::R3 { beta: 8, tau: Tau::Noise { k } };
        let config = Config { rescale, order, filter_steps: steps, t_max: 0.1, ..Config::PAPER_F160 };
        let mut drive = Drive { keep_stages: true, ..Drive::default() };
        let run = segment(&config, &pixels, SIDE, SIDE, &mut drive).expect("noise");
        let tau = run.outcome.tau;
        let stages = run.stages.expect("stages were kept");
        let image = if order == Order::FilterFirst { &stages.filtered } else { &stages.normalised };
        let share = image.iter().filter(|&&v| v > tau).count() as f64 / (SIDE * SIDE) as f64;
        let tail = 0.022_75;
        assert!((share / tail - 1.0).abs() < 0.06, "{order:?}: {share} of the pixels, not {tail}");
    }
}

/// A given threshold is the one that is used: each its own mask, and that of the f64 reference.
#[test]
fn a_given_threshold_is_used() {
    use skyfront_core::config::{Edge, Scheme};
    const SIDE: usize = 64;
    for (kind, seed) in [(Kind::Bright, 3), (Kind::Noisy, 4), (Kind::Stars, 5)] {
        let pixels = sky(kind, seed, SIDE, SIDE);
        let wide: Vec<f64> = pixels.iter().map(|&v| v.into()).collect();
        for scheme in [Scheme::Fd, Scheme::Sl, Scheme::FdCurvature, Scheme::SlCurvature] {
            for edge in [Edge::G1 { p: 5000.0 }, Edge::G2Mod { c2: 0.8 }] {
                let masks = [0.05, 0.1, 0.2, 0.5].map(|tau| {
                    let rescale = Rescale::R3 { beta: 8, tau: Tau::Value(tau) };
                    let config = Config { rescale, edge, ..Config::PAPER_F160 }.with_scheme(scheme);
                    let run = segment(&config, &pixels, SIDE, SIDE, &mut Drive::default()).expect("a sky");
                    assert_eq!(run.outcome.tau, tau);
                    let truth = reference::run(&parameters(&config), &wide, SIDE, SIDE).expect("a sky");
                    assert_eq!(run.labels, truth.labels, "{kind:?}, {scheme:?}, {edge:?}, tau = {tau}");
                    truth.mask
                });
                assert!(masks.windows(2).any(|pair| pair[0] != pair[1]), "{kind:?}, {scheme:?}, {edge:?}: one mask");
            }
        }
    }
}

#[test]
fn every_rule_finds_the_stars_in_every_arithmetic() {
    let (pixels, _) = stars();
    let robust = Normalize::Noise { below: 3.0, above: 30.0 };
    for tau in [Tau::Otsu, Tau::Kapur, Tau::Rosin, Tau::Noise { k: 5.0 }] {
        let rescale = Rescale::R3 { beta: 8, tau };
        let config = Config { normalize: robust, rescale, band: Some(8.0), ..Config::PAPER_F160 };
        let single = run(&config, &pixels);
        assert!(single.outcome.sources >= 3, "{tau:?}: {} sources", single.outcome.sources);
        let drive = || Drive::default();
        let q24 = segment_in::<Q24>(&config, &pixels, SIDE, SIDE, &mut drive()).expect("q24");
        let q11 = segment_in::<Q11>(&config, &pixels, SIDE, SIDE, &mut drive()).expect("q11");
        let plain = segment_in::<F32>(&config, &pixels, SIDE, SIDE, &mut drive()).expect("f32");
        assert_eq!(plain.labels, single.labels);
        let apart = |other: &Segmentation| {
            single.labels.iter().zip(&other.labels).filter(|(a, b)| (**a > 0) != (**b > 0)).count()
        };
        assert!(apart(&q24) <= 3, "{tau:?}: q24 {}", apart(&q24));
        assert!(apart(&q11) <= SIDE * SIDE / 500, "{tau:?}: q11 {}", apart(&q11));
        assert!((q11.outcome.tau - single.outcome.tau).abs() <= 1.0 / 256.0, "{tau:?}");
    }
}
