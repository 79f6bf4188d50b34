//! The noise-aware default on noise alone, on spikes, stars, galaxies and odd frames.

use skyfront::background::SkyMaps;
use skyfront::extraction::segment;
use skyfront::pipeline::{Drive, Segmentation};
use skyfront_core::arithmetic::{F32, Fixed14};
use skyfront_core::config::{Background, Config, Deblending, Outline, Significance};
use skyfront_core::error::Error;
use skyfront_core::simulate::Kind;
use skyfront_tests::noise::{add_star, correlated, gaussian};
use skyfront_tests::runs::{apart, sky};

fn run(setting: &Config, pixels: &[f32], width: usize) -> Segmentation {
    segment::<F32, f32>(setting, pixels, width, &mut Drive::default()).expect("the frame can be segmented")
}

fn sources(pixels: &[f32], width: usize) -> u32 {
    run(&Config::NOISE_AWARE, pixels, width).outcome.sources
}

#[test]
fn pure_noise_has_at_most_two_sources() {
    for (seed, k) in [(1, 0.0), (2, 0.18), (3, 0.4)] {
        let pixels: Vec<f32> = correlated(seed, 1000, k).iter().map(|noise| 100.0 + 10.0 * noise).collect();
        let found = sources(&pixels, 1000);
        assert!(found <= 2, "{found} sources in noise with k = {k}");
    }
}

/// The default with every condition off but that on significance, with so many false sources per image.
fn with_noise(false_sources: f32) -> Config {
    let default = Config::NOISE_AWARE;
    Config {
        outline: Outline { threshold: 0.5, ..default.outline },
        significance: Significance { peak: 0.0, light: 0.0, false_share: 0.0, false_sources },
        min_area: 1,
        ..default
    }
}

/// With every other condition off, noise has as many sources as the setting allows: the tail of
/// the threshold, whether pixels are correlated or not.
#[test]
fn false_sources_are_as_many_as_expected() {
    let bare = with_noise(40.0);
    for (seed, k) in [(4, 0.0), (5, 0.18), (6, 0.4)] {
        let pixels = correlated(seed, 1000, k);
        let found = run(&bare, &pixels, 1000).outcome.sources;
        // Three standard deviations of a Poisson number.
        assert!((21..=59).contains(&found), "{found} false sources where 40 are expected, k = {k}");
    }
}

/// Planes are mirrored at the border of an image, where noise would be found again and again.
#[test]
fn false_sources_do_not_gather_at_the_border() {
    let bare = with_noise(4.0);
    // A third of the pixels are near the border.
    let (width, height) = (1000, 12);
    let mut found = 0;
    for seed in 7..17 {
        let pixels = &correlated(seed, width, 0.4)[..width * height];
        found += run(&bare, pixels, width).outcome.sources;
    }
    // Three standard deviations.
    assert!((21..=59).contains(&found), "{found} false sources where 40 are expected");
}

#[test]
fn sky_and_noise_of_pure_noise_are_unbiased() {
    let side = 512;
    for (seed, k) in [(7, 0.0), (8, 0.18), (9, 0.4)] {
        let pixels: Vec<f32> = correlated(seed, side, k).iter().map(|noise| 1000.0 + 5.0 * noise).collect();
        let sky = SkyMaps::measure(&pixels, &[], side);
        let [level, noise] = [&sky.level, &sky.noise].map(|map| map.iter().map(|&value| f64::from(value)).sum::<f64>());
        let count = (side * side) as f64;
        let (level, noise) = (level / count, noise / count);
        assert!((level - 1000.0).abs() < 0.1, "sky {level} where it is 1000, noise 5, k = {k}");
        assert!((noise - 5.0).abs() < 0.1, "noise {noise} where it is 5, k = {k}");
    }
}

#[test]
fn spikes_are_no_sources_and_stars_are() {
    let side = 200;
    let mut pixels = gaussian(10, side * side);
    for (index, height) in [30.0f32, 80.0, 300.0, 2000.0].into_iter().enumerate() {
        pixels[(30 + 40 * index) * side + 50] += height;
    }
    // A cosmic ray of two pixels beside each other is beyond this test: one pixel is certain.
    assert_eq!(sources(&pixels, side), 0, "hot pixels are taken for sources");
    for (index, peak) in [15.0f32, 60.0, 250.0, 4000.0].into_iter().enumerate() {
        add_star(&mut pixels, side, (140.3, 30.4 + 40.0 * index as f32), 1.1, peak);
    }
    let found = run(&Config::NOISE_AWARE, &pixels, side);
    assert_eq!(found.outcome.sources, 4);
    for index in 0..4 {
        assert!(found.labels[(30 + 40 * index) * side + 140] > 0, "star {index} is lost");
        assert_eq!(found.labels[(30 + 40 * index) * side + 50], 0, "hot pixel {index} is in a source");
    }
}

/// A large galaxy whose own photons make it uneven is one source; a star beside it is another.
#[test]
fn a_grainy_galaxy_stays_whole() {
    let side = 256;
    let mut light = vec![0.0; side * side];
    add_star(&mut light, side, (120.0, 128.0), 22.0, 60.0);
    let pixels: Vec<f32> = light
        .iter()
        .zip(gaussian(11, side * side))
        .map(|(&light, noise)| light + noise * (1.0 + 0.25 * light).sqrt())
        .collect();
    let alone = run(&Config::NOISE_AWARE, &pixels, side);
    assert_eq!((alone.outcome.sources, alone.blended), (1, Some(vec![false])));
    let mut both = pixels;
    add_star(&mut both, side, (160.0, 128.0), 1.3, 60.0);
    let found = run(&Config::NOISE_AWARE, &both, side);
    assert_eq!(found.outcome.sources, 2);
    assert_ne!(found.labels[128 * side + 160], found.labels[128 * side + 120]);
    assert_eq!(found.blended, Some(vec![true, true]));
}

/// Between two galaxies there is the light of both, which the mirror image of neither has. Taken
/// one by one, they left three to seven sources in each of these skies.
#[test]
fn no_source_is_where_two_galaxies_meet() {
    let side = 256;
    let disc = |x: f32, y: f32, at: usize| {
        let (dx, dy) = ((at % side) as f32 - x, (at / side) as f32 - y);
        250.0 * (-dx.hypot(dy) / 14.0).exp()
    };
    let mut found = Vec::new();
    for seed in 20..24 {
        let noise = gaussian(seed, side * side).into_iter().enumerate();
        let pixels: Vec<f32> = noise
            .map(|(at, noise)| {
                let light = disc(90.0, 120.0, at) + disc(165.0, 140.0, at);
                light + noise * (1.0 + 0.25 * light).sqrt()
            })
            .collect();
        found.push(sources(&pixels, side));
    }
    assert!(found.iter().all(|&count| count >= 2) && found.iter().sum::<u32>() <= 9, "{found:?} sources");
}

#[test]
fn touching_stars_are_apart() {
    let side = 96;
    let mut pixels = gaussian(12, side * side);
    add_star(&mut pixels, side, (45.0, 48.0), 1.3, 200.0);
    add_star(&mut pixels, side, (50.0, 48.0), 1.3, 30.0);
    add_star(&mut pixels, side, (70.0, 80.0), 1.3, 30.0);
    let found = run(&Config::NOISE_AWARE, &pixels, side);
    assert_eq!((found.outcome.sources, found.blended), (3, Some(vec![true, true, false])));
    assert_ne!(found.labels[48 * side + 45], found.labels[48 * side + 50]);
}

#[test]
fn undefined_pixels_are_in_no_source() {
    let side = 128;
    let mut pixels = gaussian(13, side * side);
    add_star(&mut pixels, side, (64.0, 64.0), 2.0, 100.0);
    for x in 50..90 {
        pixels[66 * side + x] = f32::NAN;
    }
    let found = run(&Config::NOISE_AWARE, &pixels, side);
    assert!(found.labels[64 * side + 64] > 0);
    assert!((50..90).all(|x| found.labels[66 * side + x] == 0));
}

/// Fixed point rounds, which must change next to nothing, and saturates, which only very bright stars see.
#[test]
fn fixed_point_finds_what_single_precision_finds() {
    let mut drive = Drive::default();
    for (kind, seed, noise) in [(Kind::Bright, 1, 8e-4), (Kind::Noisy, 2, 0.01), (Kind::Stars, 3, 10.0)] {
        let mut pixels = sky(kind, seed, 320, 240);
        for (star, most) in [(0.0, [0, 20]), (2e5, [2, 80])] {
            add_star(&mut pixels, 320, (250.0, 200.0), 1.5, star * noise);
            let runs = [
                segment::<F32, f32>(&Config::NOISE_AWARE, &pixels, 320, &mut drive),
                segment::<F32, Fixed14>(&Config::NOISE_AWARE, &pixels, 320, &mut drive),
            ]
            .map(|run| run.expect("the frame can be segmented"));
            let [sources, mask] = apart(&runs);
            println!("{kind:?}: {} sources, q24 differs in {sources}, and in {mask} pixels", runs[0].sources.len());
            assert!(runs[0].sources.len() > 5);
            let within = sources <= most[0] && mask <= most[1];
            assert!(within, "{kind:?}: {sources} sources and {mask} of 76800 pixels differ");
        }
    }
    let long = segment::<F32, Fixed14>(&Config::NOISE_AWARE, &vec![0.0; 65_537], 65_537, &mut drive).err();
    assert!(matches!(long, Some(Error::Arithmetic { name: "q24", .. })), "{long:?}");
}

#[test]
fn a_given_noise_map_says_which_pixels_are_noisier() {
    let side = 256;
    let scale = |at: usize| if at % side < 128 { 1.0 } else { 6.0 };
    let pixels: Vec<f32> = correlated(14, side, 0.0).iter().enumerate().map(|(at, noise)| noise * scale(at)).collect();
    let map: Vec<f32> = (0..side * side).map(|at| 0.01 * scale(at)).collect();
    let sky = vec![0.0; side * side];
    let mut drive = Drive { background: Some(&sky), noise: Some(&map), relative: true, ..Drive::default() };
    let mut with_stars = pixels.clone();
    add_star(&mut with_stars, side, (60.0, 128.0), 1.5, 12.0);
    let found =
        segment::<F32, f32>(&Config::NOISE_AWARE, &with_stars, side, &mut drive).expect("the frame can be segmented");
    assert_eq!(found.outcome.sources, 1);
    assert!(found.labels[128 * side + 60] > 0);
    let mut short = Drive { noise: Some(&map[1..]), ..Drive::default() };
    let refused = segment::<F32, f32>(&Config::NOISE_AWARE, &pixels, side, &mut short).err();
    assert!(matches!(refused, Some(Error::Length { .. })), "{refused:?}");
}

#[test]
fn small_and_constant_frames_are_taken() {
    for (width, height) in [(1, 1), (1, 9), (2, 2), (3, 7), (7, 3), (7, 7), (8, 8), (5, 40)] {
        let pixels = gaussian(15, width * height);
        match segment::<F32, f32>(&Config::NOISE_AWARE, &pixels, width, &mut Drive::default()) {
            Ok(found) => assert_eq!(found.labels.len(), width * height),
            Err(Error::NoSky { .. }) => assert!(width * height < 16, "{width} x {height} has a sky"),
            Err(other) => panic!("{width} x {height}: {other}"),
        }
    }
    let flat = segment::<F32, f32>(&Config::NOISE_AWARE, &[7.0; 64 * 64], 64, &mut Drive::default()).err();
    assert_eq!(flat, Some(Error::NoNoise { value: 7.0, equal: 4096, defined: 4096 }));
}

/// Bands are of 16 rows or more: here up to 19 of them, the last one lower.
#[test]
fn threads_change_no_bit() {
    let (width, height) = (333, 301);
    let mut pixels = sky(Kind::Bright, 160, width, height);
    pixels.iter_mut().step_by(97).for_each(|pixel| *pixel = f32::NAN);
    let by = |threads: usize| {
        let mut drive = Drive { threads, ..Drive::default() };
        segment::<F32, f32>(&Config::NOISE_AWARE, &pixels, width, &mut drive).expect("the frame can be segmented")
    };
    let bits = |plane: &[f32]| plane.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    let alone = by(1);
    assert!(alone.outcome.sources > 5);
    let alone_sky = alone.sky.as_ref().expect("it is measured");
    for threads in [2, 3, 40] {
        let run = by(threads);
        let sky = run.sky.as_ref().expect("it is measured");
        assert_eq!((&run.labels, &run.outcome), (&alone.labels, &alone.outcome), "{threads} threads");
        assert_eq!(bits(&run.front), bits(&alone.front), "{threads} threads");
        assert_eq!(bits(&sky.level), bits(&alone_sky.level), "{threads} threads");
        assert_eq!(bits(&sky.noise), bits(&alone_sky.noise), "{threads} threads");
    }
}

#[test]
fn settings_out_of_bounds_are_named() {
    let good = Config::NOISE_AWARE;
    let (outline, significance, deblending) = (good.outline, good.significance, good.deblending);
    let wrong = [
        ("threshold", Config { outline: Outline { threshold: 0.0, ..outline }, ..good }),
        ("min-peak", Config { significance: Significance { peak: f32::NAN, ..significance }, ..good }),
        ("false-share", Config { significance: Significance { false_share: 0.6, ..significance }, ..good }),
        ("min-area", Config { min_area: 0, ..good }),
        ("deblend-sharpening", Config { deblending: Deblending { sharpening: 5.0, ..deblending }, ..good }),
        ("sky", Config { sky: Background::Mesh { size: 15 }, ..good }),
    ];
    for (expected, setting) in wrong {
        match segment::<F32, f32>(&setting, &[0.0; 64], 8, &mut Drive::default()) {
            Err(Error::Parameter { name, .. }) => assert_eq!(name, expected),
            other => panic!("{expected} is accepted: {:?}", other.err()),
        }
    }
}
