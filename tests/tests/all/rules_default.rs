//! The default is what `default.md` says: every step of it is that of the reference, on skies of many kinds, and a
//! reference that is asked for anything else is found to differ.

use skyfront::crosscheck::{Difference, settings, walk_signal};
use skyfront::machine::Native;
use skyfront::pipeline::{Drive, segment};
use skyfront::reference::Connectivity as Touching;
use skyfront::reference::noise_aware::{Settings, Smoothing};
use skyfront_core::arithmetic::{F32, Fixed14, Q24};
use skyfront_core::config::{Background, Config, Connectivity, Deblending, Filter, Normalize, Select, Separate};
use skyfront_core::simulate::Kind;
use skyfront_tests::noise::{add_star, correlated, galaxy_with_knots, gaussian};
use skyfront_tests::runs::sky;

const WIDTH: usize = 140;
const HEIGHT: usize = 120;

/// Steps that differ, in both arithmetics.
fn differing(config: &Config, asked: &Settings, pixels: &[f32], width: usize) -> Vec<&'static str> {
    let size = (width, pixels.len() / width);
    let runs = [
        walk_signal::<F32<Native>, f32>(config, asked, pixels, size),
        walk_signal::<Q24, Fixed14>(config, asked, pixels, size),
    ];
    let wrong = |d: &Difference| d.beyond > if d.step == "u" || d.step == "u0" { 1e-6 } else { 3e-6 };
    runs.into_iter().flat_map(|run| run.expect("a sky")).filter(wrong).map(|d| d.step).collect()
}

/// Whole counts of photons with bright stars, one of them saturated, two close together, a hot pixel and pixels that were never seen.
fn counts() -> Vec<f32> {
    let mut light = vec![40.0; WIDTH * HEIGHT];
    for n in 0..40 {
        let (x, y) = ((n * 37 % WIDTH) as f32 + 0.3, (n * 53 % HEIGHT) as f32 + 0.1 * n as f32 % 1.0);
        add_star(&mut light, WIDTH, (x, y), 1.3, 30.0 * 1.25f32.powi(n as i32 % 16));
    }
    add_star(&mut light, WIDTH, (70.0, 60.0), 2.0, 60_000.0);
    add_star(&mut light, WIDTH, (116.0, 100.0), 1.5, 1200.0);
    add_star(&mut light, WIDTH, (122.0, 100.0), 1.5, 700.0);
    for (pixel, noise) in light.iter_mut().zip(gaussian(11, WIDTH * HEIGHT)) {
        *pixel = (*pixel + noise * pixel.sqrt()).round().min(4000.0);
    }
    light[20 * WIDTH + 90] = 900.0;
    light[30 * WIDTH..30 * WIDTH + 40].fill(f32::NAN);
    light[90 * WIDTH + 5] = f32::NAN;
    light
}

/// A sky that was cut off at its level.
fn cut_off() -> Vec<f32> {
    let mut light = vec![0.0; WIDTH * HEIGHT];
    (0..9).for_each(|n| add_star(&mut light, WIDTH, (15.5 * n as f32 + 6.0, 13.0 * n as f32 + 5.0), 1.4, 40.0));
    light
        .iter()
        .zip(gaussian(12, WIDTH * HEIGHT))
        .map(|(light, noise)| (light + 3.0 * noise).round().max(0.0))
        .collect()
}

/// Whole counts of noise below a step, of which neighbours share a part, with stars, some of them at the border.
fn coarse() -> Vec<f32> {
    let noise = correlated(13, WIDTH, 0.4);
    let mut light: Vec<f32> = noise[..WIDTH * HEIGHT].iter().map(|noise| 20.0 + 0.4 * noise).collect();
    (0..12).for_each(|n| add_star(&mut light, WIDTH, (12.4 * n as f32, 11.0 * n as f32 - 0.4), 1.4, 3.0 + n as f32));
    light.into_iter().map(f32::round).collect()
}

/// Sharp stars, barely found or not, in the two outermost rows and columns.
fn beside_the_border() -> Vec<f32> {
    let mut light = gaussian(14, WIDTH * HEIGHT);
    for n in 0..13 {
        let (x, y, off) = (10.3 * n as f32 + 6.0, 8.7 * n as f32 + 7.0, 0.3 * (n % 4) as f32);
        for place in [(x, off), (x, (HEIGHT - 1) as f32 - off), (off, y), ((WIDTH - 1) as f32 - off, y)] {
            add_star(&mut light, WIDTH, place, 0.7, 4.5 + 0.35 * n as f32);
        }
    }
    light
}

/// Pixels that stand alone or nearly so: around each have its four neighbours from an eighth of its light to half of it.
fn sharp() -> Vec<f32> {
    let mut light = gaussian(15, WIDTH * HEIGHT);
    for n in 0..99 {
        let (at, own) = ((n / 11 * 13 + 8) * WIDTH + n % 11 * 12 + 9, 11.0 + 0.3 * n as f32);
        light[at] += own;
        for (next, part) in [at - 1, at + 1, at - WIDTH, at + WIDTH].into_iter().zip([0.3, 0.25, 0.2, 0.25]) {
            light[next] += part * own * (0.125 + 0.375 * (n * 37 % 99) as f32 / 99.0);
        }
    }
    light
}

/// So many stars that no cell has enough sky, on noise of single pixels or of which neighbours share a part.
fn crowd(noise: &[f32]) -> Vec<f32> {
    let mut light: Vec<f32> = noise.iter().map(|noise| 200.0 + 3.0 * noise).collect();
    for star in gaussian(15, 3 * 1500).chunks_exact(3) {
        let place = |value: f32, length: usize| (0.5 + 0.29 * value).rem_euclid(1.0) * (length - 1) as f32;
        let place = (place(star[0], WIDTH), place(star[1], HEIGHT));
        add_star(&mut light, WIDTH, place, 1.3, 20.0 * (1.2 * star[2]).exp());
    }
    light
}

/// Half of the frame filled with zeros.
fn filled() -> Vec<f32> {
    let seen = |(at, pixel): (usize, f32)| if at % WIDTH < WIDTH / 2 { 0.0 } else { 500.0 + pixel };
    sky(Kind::Noisy, 9, WIDTH, HEIGHT).into_iter().enumerate().map(seen).collect()
}

/// Steep galaxies, each with eight knots that have from twice to five times the light of the galaxy below them.
fn knots(seed: u64) -> Vec<f32> {
    const SIDE: usize = 160;
    let mut pixels: Vec<f32> = gaussian(seed, SIDE * SIDE).into_iter().map(|noise| 100.0 + noise).collect();
    let draws = gaussian(seed + 1000, 4 * 8);
    for (galaxy, (cx, cy)) in [(45.3, 44.8), (115.3, 44.8), (45.3, 114.8), (115.3, 114.8)].into_iter().enumerate() {
        for (at, pixel) in pixels.iter_mut().enumerate() {
            let (x, y) = ((at % SIDE) as f32, (at / SIDE) as f32);
            *pixel += 600.0 * (-(x - cx).hypot(y - cy) / 4.0).exp();
            for knot in 0..8 {
                let (far, angle) = (10.0 + 1.2 * knot as f32, std::f32::consts::FRAC_PI_4 * knot as f32 + 0.3);
                let draw = (2.2 + 0.9 * draws[8 * galaxy + knot]).clamp(1.2, 4.2);
                let light = draw * 600.0 * (-far / 4.0).exp() + 2.0 + draw;
                let off = (x - cx - far * angle.cos()).hypot(y - cy - far * angle.sin());
                *pixel += light * (-off * off / (2.0 * 1.2 * 1.2)).exp();
            }
        }
    }
    pixels
}

/// Which pixels are opened, and which of them count, is told apart: knots on a slope fall between.
#[test]
fn knots_on_galaxies_are_opened_as_the_reference_opens_them() {
    let config = Config::NOISE_AWARE;
    for seed in 1..=12 {
        assert_eq!(differing(&config, &settings(&config), &knots(seed), 160), [""; 0], "seed {seed}");
    }
}

/// How many sources are found on these pixels.
fn sources(config: &Config, pixels: &[f32], width: usize) -> u32 {
    let height = pixels.len() / width;
    segment(config, pixels, width, height, &mut Drive::default()).expect("a sky").outcome.sources
}

/// Knots of all shares of a galaxy's light, in both arithmetics; the reference that keeps them is found to differ.
#[test]
fn knots_become_their_galaxy_s_as_the_reference_joins_them() {
    let config = Config::NOISE_AWARE;
    let keeping = Config { deblending: Deblending { knots: 0, ..config.deblending }, ..config };
    let shares = |first: f32| (0..8).map(|n| first * 1.15f32.powi(n)).collect::<Vec<f32>>();
    for (seed, first) in [(1, 0.0009), (2, 0.0012), (3, 0.0021), (4, 0.0030)] {
        let pixels = galaxy_with_knots(seed, &shares(first));
        assert_eq!(differing(&config, &settings(&config), &pixels, 140), [""; 0], "seed {seed}");
        let wrong = differing(&config, &settings(&keeping), &pixels, 140);
        assert!(wrong.contains(&"deblended"), "seed {seed}: {wrong:?}");
    }
}

#[test]
fn a_galaxy_with_three_knots_is_one_source() {
    let config = Config::NOISE_AWARE;
    let asked = |knots: u32| Config { deblending: Deblending { knots, ..config.deblending }, ..config };
    let found = |knots: u32, shares: &[f32]| sources(&asked(knots), &galaxy_with_knots(5, shares), 140);
    assert_eq!(found(3, &[0.003; 3]), 1);
    assert_eq!(found(3, &[0.003; 2]), 3);
    assert_eq!(found(4, &[0.003; 3]), 4);
    assert_eq!(found(0, &[0.003; 3]), 4);
    // Two of five are too bright to be the galaxy's.
    assert_eq!(found(3, &[0.003, 0.01, 0.003, 0.01, 0.003]), 3);
}

#[test]
fn every_choice_is_the_reference_s() {
    let skies = [
        sky(Kind::Bright, 1, WIDTH, HEIGHT),
        sky(Kind::Noisy, 2, WIDTH, HEIGHT),
        sky(Kind::Stars, 3, WIDTH, HEIGHT),
        counts(),
        cut_off(),
        coarse(),
        beside_the_border(),
        sharp(),
        filled(),
    ];
    let default = Config::NOISE_AWARE;
    let choices = [
        default,
        Config { sky: Background::Frame, filter: Filter::Gauss, ..default },
        Config { sky: Background::Mesh { size: 32 }, filter: Filter::None, separate: Separate::Components, ..default },
        Config { select: Select::Area, connectivity: Connectivity::Four, ..default },
        Config { separate: Separate::Components, select: Select::Area, connectivity: Connectivity::Four, ..default },
        Config::RSA,
    ];
    for (number, pixels) in skies.iter().enumerate() {
        for config in &choices {
            let wrong = differing(config, &settings(config), pixels, WIDTH);
            assert_eq!(wrong, [""; 0], "sky {number}, {config:?}");
        }
    }
}

/// What filters in steps leave of signal-to-noise, and a front that starts from it.
#[test]
fn every_filter_in_steps_is_the_reference_s() {
    let skies = [sky(Kind::Noisy, 2, WIDTH, HEIGHT), counts(), filled()];
    let stepped = Filter::ALL.iter().copied().filter(|filter| filter.is_stepped());
    let filters: Vec<Config> =
        stepped.map(|filter| Config { filter, filter_steps: 3, ..Config::NOISE_AWARE }).collect();
    let percentiles = Normalize::Percentile { low: 0.5, high: 99.9 };
    let others = [
        Config { normalize: percentiles, ..filters[0] },
        Config { normalize: Normalize::MinMax, separate: Separate::Components, ..filters[0] },
        Config { filter_steps: 0, ..filters[0] },
    ];
    for (number, pixels) in skies.iter().enumerate() {
        for config in filters.iter().chain(&others) {
            let wrong = differing(config, &settings(config), pixels, WIDTH);
            assert_eq!(wrong, [""; 0], "sky {number}, {config:?}");
        }
        let other = Settings { smoothing: Smoothing::ByNeed, ..settings(&filters[0]) };
        assert!(differing(&filters[0], &other, pixels, WIDTH).contains(&"u"), "sky {number}");
    }
}

/// The noise of a crowd is that of its darkest pixels, by their differences and by their tail; of its borders each
/// decision hangs on others.
#[test]
fn a_crowd_has_the_noise_of_the_reference() {
    let config = Config::NOISE_AWARE;
    for noise in [gaussian(16, WIDTH * HEIGHT), correlated(17, WIDTH, 0.6)[..WIDTH * HEIGHT].to_vec()] {
        assert_eq!(differing(&config, &settings(&config), &crowd(&noise), WIDTH), [""; 0]);
    }
}

/// A reference that is asked for another setting is found to differ, in the step that the setting belongs to.
#[test]
fn every_setting_is_noticed() {
    let config = Config::NOISE_AWARE;
    let asked = settings(&config);
    let photons = counts();
    let noisy = sky(Kind::Noisy, 2, WIDTH, HEIGHT);
    let clumpy = galaxy_with_knots(5, &[0.003; 3]);
    let others: [(Settings, &str); 19] = [
        (Settings { cell: 32, ..asked }, "sky"),
        (Settings { spike_height: 0.0, ..asked }, "signal"),
        (Settings { smoothing: Smoothing::Fine, ..asked }, "u"),
        (Settings { threshold: 1.05, ..asked }, "u0"),
        (Settings { steps: 4, ..asked }, "u"),
        (Settings { curvature: 0.55, ..asked }, "u"),
        (Settings { branch: 1e5, ..asked }, "tree"),
        (Settings { contrast: 0.9, ..asked }, "tree"),
        (Settings { excess: 50.0, ..asked }, "opened"),
        (Settings { reopened_area: 200, ..asked }, "opened"),
        (Settings { knots: 4, ..asked }, "deblended"),
        (Settings { sharpening: 0.45, ..asked }, "sharpened"),
        (Settings { connectivity: Touching::Four, ..asked }, "tree"),
        (Settings { by_significance: false, ..asked }, "cut"),
        (Settings { min_area: 12, ..asked }, "labels"),
        (Settings { peak: 4.0, ..asked }, "labels"),
        (Settings { false_sources: 5.0, ..asked }, "cut"),
        (Settings { false_share: 0.2, ..asked }, "cut"),
        (Settings { light: 60.0, ..asked }, "labels"),
    ];
    let mut missed = Vec::new();
    for (other, step) in others {
        let wrong = [&photons, &noisy, &clumpy].map(|pixels| differing(&config, &other, pixels, WIDTH)).concat();
        if !wrong.contains(&step) {
            missed.push(format!("{step}: {wrong:?}, {other:?}"));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}
