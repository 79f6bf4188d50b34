//! Known answers for the f64 reference of the default: it has to be right before it can judge the core.

use skyfront::crosscheck::settings;
use skyfront::reference::Plane;
use skyfront::reference::noise_aware::{
    Facts, Judge, Mesh, Region, Regions, Seen, Settings, Tail, compete, connect, photon_noise, smoothed, start, step,
    straighten, tree, without_spikes,
};
use skyfront_core::config::Config;
use skyfront_tests::noise::gaussian;

const SIDE: usize = 192;

fn asked() -> Settings {
    settings(&Config::NOISE_AWARE)
}

fn sky(seed: u64, pixel: impl Fn(usize, usize, f64) -> f64) -> Vec<f64> {
    let noise = gaussian(seed, SIDE * SIDE);
    (0..SIDE * SIDE).map(|at| pixel(at % SIDE, at / SIDE, noise[at].into())).collect()
}

fn plane(size: usize, value: impl Fn(f64, f64) -> f64) -> Plane {
    Plane::from_fn(size, size, |i, j| value(i as f64, j as f64))
}

#[test]
fn a_slope_with_noise_is_measured_to_its_corners() {
    let slope = |x: usize, y: usize| 100.0 + 0.1 * x as f64 - 0.05 * y as f64;
    for step in [0.0, 1.0] {
        let rounded = |v: f64| if step > 0.0 { v.round() } else { v };
        let pixels = sky(1, |x, y, noise| rounded(slope(x, y) + 2.0 * noise));
        let facts = Facts::of(&pixels, SIDE);
        assert!(facts.fill.is_none() && !facts.cut_off && (facts.step == 1.0) == (step == 1.0), "{facts:?}");
        let mesh = Mesh::unknown((SIDE, SIDE), 64).measure(&pixels, &[Seen::Sky; SIDE * SIDE], &facts, 0.0);
        for (x, y) in [(0, 0), (SIDE - 1, 0), (SIDE / 2, SIDE / 2), (7, SIDE - 1)] {
            let found = mesh.at(x, y);
            assert!((found.level - slope(x, y)).abs() < 0.5, "{found:?} at {x}, {y}, not {}", slope(x, y));
            // The slope within a cell widens its values to the root of 4 + (0.1^2 + 0.05^2) 64^2 / 12.
            assert!((found.noise / 8.27f64.sqrt() - 1.0).abs() < 0.05, "{found:?} at {x}, {y}");
        }
    }
}

#[test]
fn zeros_that_lie_together_are_filling_and_a_cut_off_sky_is_told() {
    let holed = sky(2, |x, _, noise| if x < 40 { 0.0 } else { 100.0 + noise });
    assert_eq!(Facts::of(&holed, SIDE).fill, Some(0.0));
    let strewn = sky(3, |_, _, noise| noise.max(0.0).round());
    let facts = Facts::of(&strewn, SIDE);
    assert!(facts.fill.is_none() && facts.cut_off, "{facts:?}");
}

#[test]
fn a_lone_pixel_is_a_spike_and_a_star_is_none() {
    let spike = plane(9, |x, y| if (x, y) == (4.0, 4.0) { 50.0 } else { 0.0 });
    assert_eq!(without_spikes(&spike, 5.0, &Judge::exact()), plane(9, |_, _| 0.0));
    let star = plane(9, |x, y| 50.0 * (-((x - 4.0).powi(2) + (y - 4.0).powi(2)) / 1.3).exp());
    assert_eq!(without_spikes(&star, 5.0, &Judge::exact()), star);
}

/// Nothing is known of the values.
const EVEN: Facts = Facts { fill: None, step: 0.0, cut_off: false, coarse: false, resolution: 0.0 };

/// A Gaussian of standard deviation s makes white noise `1 / (2 sqrt(pi) s)` as large, up to the pixels.
#[test]
fn smoothing_keeps_light_and_takes_noise() {
    let point = smoothed(&plane(31, |x, y| f64::from(u8::from((x, y) == (15.0, 15.0)))), 1.7);
    assert!((point.values().iter().sum::<f64>() - 1.0).abs() < 1e-12);
    let pixels = sky(4, |_, _, noise| noise);
    let smooth = smoothed(&Plane::from_fn(SIDE, SIDE, |i, j| pixels[j as usize * SIDE + i as usize]), 1.7);
    let tail = Tail::of(smooth.values(), &[false; SIDE * SIDE], &EVEN);
    let expected = 1.0 / (2.0 * std::f64::consts::PI.sqrt() * 1.7);
    assert!((tail.noise / expected - 1.0).abs() < 0.05 && tail.skewness == 0.0, "{tail:?}, not {expected}");
}

/// An exponential distribution has the skewness 2, of which values up to 6 standard deviations show most.
#[test]
fn a_long_tail_raises_heights() {
    let values: Vec<f64> = (0..10_000).map(|n| -((f64::from(n) + 0.5) / 1e4).ln() - 1.0).collect();
    let tail = Tail::of(&values, &[false; 10_000], &Facts { cut_off: true, ..EVEN });
    assert!((tail.skewness - 1.7).abs() < 0.3 && (tail.raised(4.0) - 4.0 - 2.5 * tail.skewness).abs() < 1e-12);
}

/// One pixel in twenty each is a step of 3 noise units above and below a level plane.
#[test]
fn patches_of_coarse_noise_are_noise() {
    let value = |n| match n % 20 {
        0 => -3.0,
        1 => 3.0,
        _ => 0.0,
    };
    let values: Vec<f64> = (0..10_000).map(value).collect();
    let noise = |facts| Tail::of(&values, &[false; 10_000], facts).noise;
    assert_eq!(noise(&EVEN), 0.0);
    assert!((noise(&Facts { coarse: true, ..EVEN }) - 3.0 / 3.090232).abs() < 1e-9);
}

#[test]
fn photons_are_counted() {
    let level = |x: usize| if x < SIDE / 2 { 0.0 } else { 20.0 };
    for photon in [0.0, 0.4f64] {
        let of = |x: usize, noise: f64| level(x) + noise * (1.0 + photon * level(x)).sqrt();
        let pixels = sky(5, |x, _, noise| of(x, noise));
        let signal = Plane::from_fn(SIDE, SIDE, |i, j| pixels[j as usize * SIDE + i as usize]);
        let fine = Plane::from_fn(SIDE, SIDE, |i, _| level(i as usize));
        let masked: Vec<bool> = (0..SIDE * SIDE).map(|at| at % SIDE >= SIDE / 2).collect();
        let found = photon_noise(&signal, &fine, &masked);
        // The levels' middle is taken for 16 sqrt(2).
        assert!((found - photon * 20.0 / (16.0 * 2f64.sqrt())).abs() < 0.03, "{found}, not {photon}");
    }
}

fn radius(u: &Plane) -> f64 {
    (u.values().iter().filter(|&&u| u > 0.0).count() as f64 / std::f64::consts::PI).sqrt()
}

/// A force of 1/2 moves a disc by half the time; under curvature alone its radius is `sqrt(r^2 - 2 nu t)`.
#[test]
fn discs_grow_and_shrink_as_they_should() {
    let disc = plane(64, |x, y| 11.0 - (x - 31.5).hypot(y - 31.5));
    let moved = |light: f64, nu: f64, steps: u32| {
        let fine = plane(64, |_, _| light);
        radius(&(0..steps).fold(start(&disc, 1.0), |u, _| step(&u, &fine, 1.0, nu, 5e-4)))
    };
    for (radius, expected) in [
        (moved(1.5, 0.0, 30), 13.0),
        (moved(0.5, 0.0, 30), 7.0),
        (moved(9.0, 0.0, 30), 22.0),
        (moved(1.0, 0.6, 100), 76f64.sqrt()),
    ] {
        assert!((radius - expected).abs() < 0.5, "{radius}, not {expected}");
    }
}

/// Two Gaussian peaks a distance apart on a row, the fainter with a part of the brighter's light.
fn pair(apart: f64, part: f64) -> Plane {
    let star = |x: f64, y: f64| (-(x * x + y * y) / 8.0).exp();
    plane(48, |x, y| 100.0 * (star(x - 16.0, y - 20.0) + part * star(x - 16.0 - apart, y - 20.0)))
}

fn divided(image: &Plane, asked: &Settings) -> Regions {
    let inside: Vec<bool> = image.values().iter().map(|&v| v > 1.0).collect();
    tree(image, &inside, 0.0, asked, &Judge::exact())
}

#[test]
fn two_peaks_are_two_sources_where_the_fainter_stands_apart() {
    let count = |regions: &Regions| (1..=regions.table.len() as u32).filter(|n| regions.labels.contains(n)).count();
    let image = pair(10.0, 0.5);
    let regions = divided(&image, &asked());
    assert_eq!(count(&regions), 2);
    let parts: Vec<_> = regions.table.iter().map(|region| (region.peak, region.divided)).collect();
    let [bright, faint] = [20 * 48 + 16, 20 * 48 + 26];
    assert_eq!(parts, [(bright, Some(faint)), (faint, Some(bright))]);
    assert_eq!(count(&divided(&pair(4.0, 0.5), &asked())), 1, "one peak");
    assert_eq!(count(&divided(&image, &Settings { branch: 1e4, ..asked() })), 1);
    assert_eq!(count(&divided(&image, &Settings { contrast: 0.9, ..asked() })), 1);
    let noisy = tree(&image, &vec![true; 48 * 48], 1e4, &asked(), &Judge::exact());
    assert_eq!(count(&noisy), 1, "photon noise");
}

#[test]
fn borders_lie_where_the_brighter_has_half_the_light() {
    let image = pair(10.0, 0.5);
    let mut regions = divided(&image, &asked());
    regions.labels.iter_mut().enumerate().for_each(|(at, label)| {
        *label = if *label > 0 { 1 + u32::from(at % 48 > 24) } else { 0 };
    });
    compete(&image, &mut regions);
    // At x = 22 the brighter alone has 1.1, the fainter 6.8; at 21 they have 4.4 and 2.2.
    let row: Vec<u32> = (19..25).map(|x| regions.labels[20 * 48 + x]).collect();
    assert_eq!(row, [1, 1, 1, 2, 2, 2]);
}

fn labels(rows: &[&str]) -> (Vec<u32>, usize) {
    (rows.iter().flat_map(|row| row.bytes().map(|digit| u32::from(digit - b'0'))).collect(), rows[0].len())
}

#[test]
fn teeth_go_and_pieces_are_joined() {
    let (comb, width) = labels(&["111111", "000100", "000100", "000000"]);
    assert_eq!(straighten(&comb, width), labels(&["111111", "000100", "000000", "000000"]).0);
    let region = Region { peak: 31, value: 1.0, area: 0, sum: 1.0, centre: (0.0, 0.0), plateau: false, divided: None };
    let joined = |rows: &[&str], peak: usize| {
        let (pieces, width) = labels(rows);
        connect(&Regions { labels: pieces, table: vec![Region { peak, ..region.clone() }; 3] }, width)
    };
    let small = joined(&["11222001", "11222000", "11122110", "11122330"], 31);
    assert_eq!(small, labels(&["11222000", "11222000", "11122330", "11122330"]).0);
    // The piece with the peak stays, though another is twice as large.
    let with_peak = joined(&["11222001", "11222011", "11122110", "11122330"], 22);
    assert_eq!(with_peak, labels(&["22222001", "22222011", "22222110", "22222330"]).0);
}
