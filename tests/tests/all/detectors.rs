//! The default on skies as detectors deliver them: in steps, cut off, counted, filled, in windows, in crowds.

use skyfront::extraction::segment;
use skyfront::pipeline::{Drive, Segmentation};
use skyfront_core::arithmetic::{F32, Fixed14, Level};
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_tests::noise::{add_star, correlated, gaussian};

const SIDE: usize = 200;

fn run<L: Level>(pixels: &[f32], width: usize) -> Segmentation {
    segment::<F32, L>(&Config::NOISE_AWARE, pixels, width, &mut Drive::default()).expect("the frame can be segmented")
}

/// Sixteen stars of 12 to 120 noise units, none near another.
fn stars(seed: u64) -> [(f32, f32, f32); 16] {
    let jitter = gaussian(seed, 48);
    std::array::from_fn(|n| {
        let off = |k: usize| jitter[3 * n + k].clamp(-2.0, 2.0);
        let place = |cell: usize, k: usize| 30.0 + 46.0 * cell as f32 + 4.0 * off(k);
        (place(n % 4, 0), place(n / 4, 1), 38.0 * (0.57 * off(2)).exp())
    })
}

/// The light of stars of 3 pixels FWHM.
fn light(stars: &[(f32, f32, f32)], side: usize) -> Vec<f32> {
    let mut light = vec![0.0; side * side];
    stars.iter().for_each(|&(x, y, peak)| add_star(&mut light, side, (x, y), 1.274, peak));
    light
}

/// The sky of [`stars`] with noise of 1.
fn sky(seed: u64) -> Vec<f32> {
    light(&stars(seed), SIDE)
        .iter()
        .zip(gaussian(seed + 100, SIDE * SIDE))
        .map(|(light, noise)| light + noise)
        .collect()
}

/// Every star is found, each as one source, and at most `most_false` more, in both arithmetics.
fn check(name: &str, seed: u64, pixels: &[f32], most_false: usize) {
    check_in::<f32>(name, seed, pixels, most_false);
    check_in::<Fixed14>(name, seed, pixels, most_false);
}

fn check_in<L: Level>(name: &str, seed: u64, pixels: &[f32], most_false: usize) {
    let found = run::<L>(pixels, SIDE);
    let stars = stars(seed);
    let at = |x: f32, y: f32| y.round() as usize * SIDE + x.round() as usize;
    // A star on an undefined pixel is seen on the next one.
    let label = |x, y| [found.labels[at(x, y)], found.labels[at(x, y) + 1]].into_iter().max().filter(|&l| l > 0);
    let mut labels: Vec<u32> = stars.iter().filter_map(|&(x, y, _)| label(x, y)).collect();
    labels.sort_unstable();
    labels.dedup();
    let (arithmetic, sources) = (found.arithmetic, found.sources.len());
    println!("{name}, {arithmetic}: {} of {} stars, {sources} sources", labels.len(), stars.len());
    assert_eq!(labels.len(), stars.len(), "{name}, {arithmetic}: stars are lost, of {sources} sources");
    assert!(sources <= stars.len() + most_false, "{name}, {arithmetic}: {sources} sources");
}

#[test]
fn stars_are_found_in_whole_counts() {
    for (seed, noise) in [(1, 0.3), (2, 0.5), (3, 0.7), (4, 1.0), (5, 2.5)] {
        for part in [0.0, 0.25, 0.5] {
            let counts: Vec<f32> = sky(seed).iter().map(|value| (100.0 + part + noise * value).round()).collect();
            check(&format!("noise {noise}, sky 100 + {part}"), seed, &counts, 2);
        }
    }
}

/// Also where rounding gives a zero of either sign, and where a flat field hides the steps.
#[test]
fn stars_are_found_in_counts_that_software_has_changed() {
    let subtracted: Vec<f32> = sky(6).iter().map(|value| value.round()).collect();
    check("sky subtracted", 6, &subtracted, 2);
    let scaled: Vec<f32> = sky(7).iter().map(|value| 1000.0 + 0.37 * (100.0 + value).round()).collect();
    check("scaled", 7, &scaled, 2);
    let factors: Vec<f32> = gaussian(9, 997).iter().map(|value| 1.0 + 0.01 * value).collect();
    let flattened: Vec<f32> =
        sky(8).iter().enumerate().map(|(at, value)| (10.0 + value).round() * factors[at % 997]).collect();
    check("flat field", 8, &flattened, 2);
}

#[test]
fn stars_are_found_above_a_black_level() {
    for (seed, level, noise) in [(10, 0.0, 1.0), (11, 0.0, 3.0), (12, 0.5, 2.0)] {
        let cut: Vec<f32> = sky(seed).iter().map(|value| (level + noise * value).round().clamp(0.0, 255.0)).collect();
        check(&format!("cut at 0, sky {level}, noise {noise}"), seed, &cut, 3);
    }
    let below: Vec<f32> = sky(13).iter().map(|value| (value - 0.5).max(0.0)).collect();
    check("sky below the cut", 13, &below, 3);
}

#[test]
fn stars_are_found_beside_filling_and_between_undefined_pixels() {
    for (seed, level, whole) in [(14, 0.0, false), (15, 100.0, false), (16, 1000.0, true)] {
        let round = |value: f32| if whole { value.round() } else { value };
        let mut pixels: Vec<f32> = sky(seed).iter().map(|value| round(level + 5.0 * value)).collect();
        let filled = |at: usize| at % SIDE < 12 || at % SIDE > 188 || at / SIDE < 12;
        pixels.iter_mut().enumerate().filter(|(at, _)| filled(*at)).for_each(|(_, pixel)| *pixel = 0.0);
        check(&format!("filled with 0 at a sky of {level}"), seed, &pixels, 2);
        let found = run::<f32>(&pixels, SIDE);
        let remark = found.remarks.first().expect("the filling is told");
        assert!(remark.contains("exactly 0: taken for filling"), "{remark}");
        assert_eq!(found.outcome.extremes.defined, 177 * 188, "filled pixels are undefined");
    }
    let mut pixels: Vec<f32> = sky(17).iter().map(|value| 100.0 + 5.0 * value).collect();
    pixels.iter_mut().step_by(2).for_each(|pixel| *pixel = f32::NAN);
    check("every second column undefined", 17, &pixels, 2);
    let found = run::<f32>(&pixels, SIDE);
    assert!(found.labels.iter().step_by(2).all(|&label| label == 0), "no undefined pixel is in a source");
}

#[test]
fn stars_are_found_without_noise() {
    // Where nothing else is noise, stars are brighter than fixed point can hold, and flat.
    check_in::<f32>("model", 18, &light(&stars(18), SIDE), 0);
    let counts: Vec<f32> = light(&stars(19), SIDE).iter().map(|value| (100.0 + 5.0 * value).round()).collect();
    check("model in whole counts", 19, &counts, 0);
    let mut one = vec![50.0; 64 * 64];
    add_star(&mut one, 64, (30.3, 33.8), 1.5, 10.0);
    assert_eq!(run::<f32>(&one, 64).sources.len(), 1);
}

#[test]
fn a_star_is_found_in_a_tracking_window() {
    for (side, sigma) in [(8, 1.0), (12, 1.2), (16, 1.7), (24, 2.1), (24, 3.4)] {
        for (seed, step) in [(20, 0.0), (21, 1.0), (22, 2.0)] {
            let centre = side as f32 / 2.0 - 0.3;
            let mut pixels = gaussian(seed, side * side);
            add_star(&mut pixels, side, (centre, centre), sigma, 100.0);
            let stepped = |value: f32| if step > 0.0 { step * (value / step).round() } else { value };
            let pixels: Vec<f32> = pixels.into_iter().map(|value| 100.0 + stepped(value)).collect();
            let found = run::<f32>(&pixels, side);
            assert_eq!(found.sources.len(), 1, "{side} x {side}, sigma {sigma}, steps of {step}");
            assert!(found.labels[side / 2 * side + side / 2] > 0);
        }
    }
}

#[test]
fn noise_in_whole_counts_has_at_most_two_sources() {
    let white = [(30, 0.3, 0.0), (31, 0.5, 0.0), (32, 1.0, 0.0), (33, 3.0, 0.0)];
    let correlated_ones = [(34, 1.0, 0.4), (35, 0.3, 0.4), (36, 0.5, 0.4), (37, 0.3, 0.8)];
    for (seed, noise, k) in white.into_iter().chain(correlated_ones) {
        for part in [0.0, 0.25, 0.5] {
            let counts: Vec<f32> =
                correlated(seed, 1000, k).iter().map(|value| (100.0 + part + noise * value).round()).collect();
            let found = run::<f32>(&counts, 1000).sources.len();
            assert!(found <= 2, "{found} sources in noise of {noise} at 100 + {part}, k = {k}");
        }
    }
}

/// Photons of a sky of so many a pixel, by inversion.
fn photons(seed: u64, side: usize, mean: f64) -> Vec<f32> {
    let chance = |value: f32| 0.5 * (1.0 + erf(f64::from(value) / std::f64::consts::SQRT_2));
    let count = |value: f32| {
        let (mut count, mut p) = (0.0, (-mean).exp());
        let (mut sum, wanted) = (p, chance(value));
        while sum < wanted && count < 1e3 {
            count += 1.0;
            p *= mean / count;
            sum += p;
        }
        count as f32
    };
    gaussian(seed, side * side).into_iter().map(count).collect()
}

/// Abramowitz and Stegun 7.1.26, to 1.5e-7.
fn erf(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs());
    let poly =
        t * (0.254_829_592 + t * (-0.284_496_736 + t * (1.421_413_741 + t * (-1.453_152_027 + t * 1.061_405_429))));
    (1.0 - poly * (-x * x).exp()).copysign(x)
}

#[test]
fn photons_of_the_sky_are_no_sources() {
    for (seed, mean) in [(40, 0.01), (41, 0.1), (42, 0.5), (43, 2.0)] {
        let found = run::<f32>(&photons(seed, 400, mean), 400).sources.len();
        assert!(found <= 2, "{found} sources in {mean} photons a pixel");
        let mut pixels = photons(seed, SIDE, mean);
        for (pixel, light) in pixels.iter_mut().zip(light(&stars(seed), SIDE)) {
            *pixel += light.round();
        }
        check(&format!("{mean} photons a pixel"), seed, &pixels, 2);
    }
}

#[test]
fn a_ramp_has_no_source() {
    let side = 512;
    for slope in [1.0, 3.0, 5.0] {
        let ramp = |at: usize| slope * ((at % side) as f32 + 0.5 * (at / side) as f32) / 100.0;
        let pixels: Vec<f32> =
            gaussian(50, side * side).iter().enumerate().map(|(at, noise)| noise + ramp(at)).collect();
        assert!(run::<f32>(&pixels, side).sources.len() <= 1, "a ramp of {slope} noise units per 100 pixels");
    }
}

/// Noise of 5 under stars of S/N 4 to 1000, until such a share of the pixels has light of one noise unit; the measured noise
/// in units of the true one.
fn noise_under_stars(seed: u64, cover: f32) -> Vec<f32> {
    let side = 512;
    let mut light = vec![0.0; side * side];
    let mut random = gaussian(seed, 90_000).into_iter().map(|value| (erf(f64::from(value) / 1.415) * 0.5 + 0.5) as f32);
    let mut next = move || random.next().expect("enough of them");
    while light.iter().filter(|&&light| light > 1.0).count() < (cover * (side * side) as f32) as usize {
        for _ in 0..50 {
            let (x, y, peak) = (next() * side as f32, next() * side as f32, (4.0 / (next() + 1e-3)).min(1000.0));
            add_near(&mut light, side, (x, y), peak);
        }
    }
    let pixels: Vec<f32> = light
        .iter()
        .zip(gaussian(seed + 10, side * side))
        .map(|(light, noise)| 100.0 + 5.0 * (light + noise))
        .collect();
    let sky = run::<f32>(&pixels, side).sky.expect("it is measured");
    sky.noise.iter().map(|noise| noise / 5.0).collect()
}

#[test]
fn the_noise_is_unbiased_up_to_three_tenths_covered() {
    for (seed, cover) in [(60, 0.1), (61, 0.2), (62, 0.3)] {
        let noise = noise_under_stars(seed, cover);
        let mean = noise.iter().map(|&noise| f64::from(noise)).sum::<f64>() / noise.len() as f64;
        println!("covered {cover}: noise {mean:.4} of the true one");
        assert!((mean - 1.0).abs() < 0.02, "covered {cover}: {mean}");
        // The median of nine cells of 4096 pixels, of which a third is sky, is known to one percent.
        assert!(noise.iter().all(|noise| (noise - 1.0).abs() < 0.05), "covered {cover}");
    }
}

/// A quarter of the pixels, and then a tenth, know the sky.
#[test]
fn the_noise_of_each_cell_is_known_where_nine_tenths_are_covered() {
    for (seed, cover) in [(63, 0.75), (64, 0.9)] {
        let noise = noise_under_stars(seed, cover);
        let [least, most] = [f32::min, f32::max].map(|of| noise.iter().copied().reduce(of).expect("there are pixels"));
        println!("covered {cover}: noise {least:.3} to {most:.3} of the true one");
        assert!(least > 0.9 && most < 1.1, "covered {cover}: {least} to {most}");
    }
}

/// [`add_star`] in the pixels around it only.
fn add_near(pixels: &mut [f32], side: usize, (x, y): (f32, f32), peak: f32) {
    let around = |centre: f32| (centre as usize).saturating_sub(8)..(centre as usize + 9).min(side);
    for row in around(y) {
        for column in around(x) {
            let (dx, dy) = (column as f32 - x, row as f32 - y);
            pixels[row * side + column] += peak * (-0.5 * (dx * dx + dy * dy) / 1.62).exp();
        }
    }
}

/// Each round of masking finds less sky than the one before where stars are everywhere.
#[test]
fn a_crowd_does_not_run_away() {
    let side = 256;
    let mut light = vec![0.0; side * side];
    let random = gaussian(70, 12_000);
    for star in random.chunks_exact(3) {
        let place = |value: f32| (erf(f64::from(value) / 1.415) * 0.5 + 0.5) as f32 * (side - 1) as f32;
        add_near(&mut light, side, (place(star[0]), place(star[1])), 8.0 * (1.2 * star[2]).exp());
    }
    let crowd: Vec<f32> = light.iter().zip(gaussian(71, side * side)).map(|(light, noise)| light + noise).collect();
    let found = run::<f32>(&crowd, side);
    let covered = found.labels.iter().filter(|&&label| label > 0).count() as f32 / (side * side) as f32;
    println!("{} sources on {covered} of the frame", found.sources.len());
    assert!(found.sources.len() > 400 && covered < 0.8, "{} sources on {covered}", found.sources.len());
    assert!(found.remarks.iter().any(|remark| remark.contains("cells of the sky")), "{:?}", found.remarks);
}

#[test]
fn a_frame_without_a_sky_says_why() {
    let refused = |pixels: &[f32], width: usize, drive: &mut Drive<'_>| {
        segment::<F32, f32>(&Config::NOISE_AWARE, pixels, width, drive).err()
    };
    let mut hot = vec![7.0; 64 * 64];
    hot[0] = f32::NAN;
    let mut plain = Drive::default();
    assert_eq!(refused(&hot, 64, &mut plain), Some(Error::NoNoise { value: 7.0, equal: 4095, defined: 4095 }));
    let few: Vec<f32> = (0..64 * 64).map(|at| if at < 15 { at as f32 } else { f32::NAN }).collect();
    assert_eq!(refused(&few, 64, &mut plain), Some(Error::NoSky { defined: 15, needed: 16 }));
    assert_eq!(refused(&[f32::NAN; 64], 8, &mut plain), Some(Error::NothingDefined { pixels: 64 }));
    // Given sky and noise make up for it.
    let (level, noise) = (vec![7.0; 64 * 64], vec![1.0; 64 * 64]);
    let mut given = Drive { background: Some(&level), noise: Some(&noise), ..Drive::default() };
    assert_eq!(refused(&hot, 64, &mut given), None);
    assert_eq!(refused(&few, 64, &mut given), None);
}

/// A noise that is given is believed, however wrong; only weights are scaled to the image.
#[test]
fn a_given_noise_is_absolute_and_a_weight_is_relative() {
    let pixels: Vec<f32> = sky(80).iter().map(|value| 100.0 + 5.0 * value).collect();
    let found = |noise: f32, relative: bool| {
        let map = vec![noise; pixels.len()];
        let mut drive = Drive { noise: Some(&map), relative, ..Drive::default() };
        segment::<F32, f32>(&Config::NOISE_AWARE, &pixels, SIDE, &mut drive)
            .expect("the frame can be segmented")
            .sources
            .len()
    };
    assert_eq!([found(5.0, false), found(50.0, true), found(0.05, true)], [16; 3]);
    let brighter = stars(80).iter().filter(|(_, _, peak)| *peak > 20.0).count();
    assert!((1..=brighter).contains(&found(50.0, false)), "{} of {brighter} bright stars", found(50.0, false));
    assert_eq!(found(500.0, false), 0);
}

/// In a frame that shows nearly none of it, a source must stand out from the noise that is given.
#[test]
fn a_given_noise_that_the_frame_does_not_show_is_believed() {
    let peaks = [2.2, 2.4, 2.6, 2.7, 3.8, 4.5, 6.0, 9.0];
    let stars: Vec<_> = (0..8).map(|n| (25.3 + 50.0 * (n % 4) as f32, 50.6 + 100.0 * (n / 4) as f32)).collect();
    let mut pixels: Vec<f32> = gaussian(91, SIDE * SIDE).iter().map(|noise| 7.0 + 0.01 * noise).collect();
    stars.iter().zip(peaks).for_each(|(&place, peak)| add_star(&mut pixels, SIDE, place, 1.274, peak));
    let map = vec![1.0; pixels.len()];
    for noise in [None, Some(&map[..])] {
        let mut drive = Drive { noise, ..Drive::default() };
        let found = segment::<F32, f32>(&Config::NOISE_AWARE, &pixels, SIDE, &mut drive).expect("it can be segmented");
        assert_eq!(found.sources.len(), if noise.is_some() { 4 } else { 8 }, "{:?}", found.sources);
    }
}
