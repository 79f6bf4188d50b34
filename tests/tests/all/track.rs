//! Windows on made frames: centres at the bound, errors that are true, flags that say what is wrong.

use skyfront::extraction::segment;
use skyfront::pipeline::Drive;
use skyfront_core::arithmetic::{Arithmetic, F32, Q24};
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::run::memory::bytes;
use skyfront_core::run::workspace;
use skyfront_core::sources::catalog::Source;
use skyfront_core::sources::tree::Region;
use skyfront_core::track::{BLENDED, BadPixel, Camera, EDGE, HOT, LOST, Raster, SATURATED, Star, Window, track};
use skyfront_tests::frames::{Light, Random, bound, frame};

const CAMERA: Camera = Camera { black: 64.0, gain: 1.5, read_noise: 6.0, saturation: 60_000.0, psf_sigma: 1.0 };

fn window(x: f64, y: f64, side: u16) -> Window {
    Window { x: x as f32, y: y as f32, width: side, height: side }
}

/// The star of a window in the middle of a frame.
fn centred<A: Arithmetic>(pixels: &[u16], side: usize, camera: &Camera, window: Window, bad: &[BadPixel]) -> Star {
    let mut out = [Star::default()];
    let raster = Raster::new(pixels, side, side, side).expect("a frame");
    track::<A, u16>(&raster, &[window], camera, bad, &mut out).expect("a camera and a window within bounds");
    out[0]
}

/// Errors of many stars.
struct Errors {
    /// Root mean square over the root of the bound.
    of_bound: f64,
    /// Root mean square over what the record tells.
    pull: f64,
    /// Root mean square of the flux's relative error, times the signal-to-noise.
    of_flux: f64,
}

/// Centres stars of a width and flux in windows of `side`, the prediction up to 1.5 pixels beside them.
fn errors<A: Arithmetic>(camera: &Camera, sky: f64, flux: f64, side: usize, seed: u64) -> Errors {
    const STARS: usize = 600;
    let mut random = Random(seed);
    let mut sums = [0.0; 3];
    for _ in 0..STARS {
        let middle = (side as f64 - 1.0) / 2.0;
        let mut place = || middle + random.uniform() - 0.5;
        let star = Light { x: place(), y: place(), flux };
        let pixels = frame(side, camera, sky, &[star], &mut random);
        let found = centred::<A>(&pixels, side, camera, window(middle, middle, side as u16), &[]);
        assert_eq!(found.flags, 0, "{star:?} {found:?}");
        let (least_x, least_y) = bound(side, camera, sky, &star);
        let square = |found: f32, true_value: f64| (f64::from(found) - true_value).powi(2);
        let (x, y) = (square(found.x, star.x), square(found.y, star.y));
        sums[0] += x / least_x + y / least_y;
        sums[1] += x / f64::from(found.errx2) + y / f64::from(found.erry2);
        sums[2] += 2.0 * (square(found.flux, flux) / (flux * flux)) * f64::from(found.snr).powi(2);
    }
    let [of_bound, pull, of_flux] = sums.map(|sum| (sum / (2 * STARS) as f64).sqrt());
    Errors { of_bound, pull, of_flux }
}

/// Widths, skies, fluxes with signal-to-noise from 21 to 1000.
fn cases() -> impl Iterator<Item = (Camera, f64, f64)> {
    [0.7f32, 1.0, 1.5].into_iter().flat_map(|psf_sigma| {
        let faint = 21.0 * f64::from(psf_sigma) * 37.0;
        let camera = Camera { psf_sigma, ..CAMERA };
        [(40.0, faint), (40.0, 4.0 * faint), (400.0, 30_000.0), (5.0, 200_000.0)]
            .map(|(sky, flux)| (Camera { black: 64.0, gain: if flux > 1e5 { 5.0 } else { 1.5 }, ..camera }, sky, flux))
    })
}

fn at_the_bound<A: Arithmetic>(side: usize, seed: u64) {
    for (camera, sky, flux) in cases() {
        let Errors { of_bound, pull, of_flux } = errors::<A>(&camera, sky, flux, side, seed);
        let case = format!(
            "{} sigma {} sky {sky} flux {flux:.0} side {side}: {of_bound:.3} of the bound, pull {pull:.3}, flux {of_flux:.3}",
            A::NAME,
            camera.psf_sigma
        );
        println!("{case}");
        assert!(of_bound <= 1.15 && (0.9..=1.1).contains(&pull), "{case}");
        assert!((0.85..=1.15).contains(&of_flux), "{case}");
    }
}

#[test]
fn centres_are_at_the_bound_in_single_precision() {
    at_the_bound::<F32>(21, 1);
    at_the_bound::<F32>(15, 2);
}

#[test]
fn centres_are_at_the_bound_in_fixed_point() {
    at_the_bound::<Q24>(21, 3);
}

#[test]
fn centres_are_at_the_bound_in_the_least_window() {
    at_the_bound::<F32>(8, 4);
    at_the_bound::<Q24>(8, 5);
}

const SIDE: usize = 31;

/// A star at (14.3, 15.8) of a frame, and what else is there.
fn scene(others: &[Light], change: impl Fn(&mut [u16])) -> Vec<u16> {
    let mut stars = vec![Light { x: 14.3, y: 15.8, flux: 4000.0 }];
    stars.extend(others);
    let mut pixels = frame(SIDE, &CAMERA, 40.0, &stars, &mut Random(9));
    change(&mut pixels);
    pixels
}

fn in_scene(pixels: &[u16], window: Window, bad: &[BadPixel]) -> Star {
    let (float, fixed) =
        (centred::<F32>(pixels, SIDE, &CAMERA, window, bad), centred::<Q24>(pixels, SIDE, &CAMERA, window, bad));
    assert_eq!(float.flags, fixed.flags);
    // Within a hundredth of their errors.
    let apart = (float.x - fixed.x).hypot(float.y - fixed.y);
    assert!(float.flags & LOST != 0 || apart < 0.01 * float.errx2.sqrt(), "{float:?} {fixed:?}");
    float
}

/// The distance from the true place in units of its error.
fn off(star: &Star) -> f32 {
    (star.x - 14.3).hypot(star.y - 15.8) / star.errx2.sqrt()
}

#[test]
fn a_star_alone_has_no_flags_wherever_it_was_predicted() {
    let pixels = scene(&[], |_| {});
    for (x, y) in [(15.0, 15.0), (11.0, 19.0), (18.4, 12.1)] {
        let star = in_scene(&pixels, window(x, y, 15), &[]);
        assert_eq!(star.flags, 0);
        assert!(off(&star) < 3.0, "{star:?}");
    }
}

#[test]
fn a_hot_pixel_is_left_out_and_said() {
    let hot = scene(&[], |pixels| pixels[16 * SIDE + 17] = 20_000);
    let star = in_scene(&hot, window(15.0, 15.0, 15), &[]);
    assert_eq!(star.flags, HOT);
    assert!(off(&star) < 3.0, "{star:?}");
    // Far from the star it is of no account.
    let far = scene(&[], |pixels| pixels[10 * SIDE + 10] = 20_000);
    let star = in_scene(&far, window(15.0, 15.0, 15), &[]);
    assert_eq!(star.flags, 0);
    assert!(off(&star) < 3.0, "{star:?}");
}

#[test]
fn a_bad_pixel_is_left_out_and_said() {
    let dead = scene(&[], |pixels| pixels[16 * SIDE + 15] = 0);
    let without = in_scene(&dead, window(15.0, 15.0, 15), &[]);
    assert!(off(&without) > 5.0, "the pixel matters: {without:?}");
    let star = in_scene(&dead, window(15.0, 15.0, 15), &[BadPixel { x: 3, y: 3 }, BadPixel { x: 15, y: 16 }]);
    assert_eq!(star.flags, HOT);
    assert!(off(&star) < 3.0, "{star:?}");
    let clean = in_scene(&scene(&[], |_| {}), window(15.0, 15.0, 15), &[]);
    assert!(star.errx2 > 1.05 * clean.errx2, "fewer pixels tell less: {star:?} {clean:?}");
}

#[test]
fn saturated_pixels_are_left_out_and_said() {
    let full = scene(&[], |pixels| pixels.iter_mut().for_each(|pixel| *pixel = (*pixel).min(400)));
    let camera = Camera { saturation: 400.0, ..CAMERA };
    let star = centred::<F32>(&full, SIDE, &camera, window(15.0, 15.0, 15), &[]);
    assert_eq!(star.flags, SATURATED);
    assert!(off(&star) < 3.0 && (star.flux / 4000.0 - 1.0).abs() < 0.1, "{star:?}");
}

#[test]
fn a_second_star_is_said() {
    let neighbour = Light { x: 17.5, y: 15.0, flux: 2000.0 };
    assert_eq!(in_scene(&scene(&[neighbour], |_| {}), window(15.0, 15.0, 15), &[]).flags, BLENDED);
    let farther = Light { x: 20.5, y: 18.0, flux: 2000.0 };
    let star = in_scene(&scene(&[farther], |_| {}), window(15.0, 15.0, 15), &[]);
    assert_eq!(star.flags, 0);
    assert!(off(&star) < 3.0, "{star:?}");
}

#[test]
fn a_window_beyond_the_frame_is_said() {
    let pixels = frame(SIDE, &CAMERA, 40.0, &[Light { x: 2.3, y: 28.6, flux: 4000.0 }], &mut Random(3));
    let star = in_scene(&pixels, window(1.0, 29.0, 15), &[]);
    assert_eq!(star.flags, EDGE);
    assert!((star.x - 2.3).hypot(star.y - 28.6) < 3.0 * star.errx2.sqrt(), "{star:?}");
    let outside = in_scene(&pixels, window(-40.0, 29.0, 15), &[]);
    assert_eq!(outside.flags, EDGE | LOST);
}

#[test]
fn without_a_star_it_is_lost_and_weighs_nothing() {
    let mut random = Random(11);
    for _ in 0..500 {
        let pixels = frame(SIDE, &CAMERA, 40.0, &[], &mut random);
        let star = in_scene(&pixels, window(15.0, 15.0, 21), &[]);
        assert_eq!(star, Star { x: 15.0, y: 15.0, errx2: f32::INFINITY, erry2: f32::INFINITY, flags: LOST, ..star });
        assert_eq!((star.flux, star.snr), (0.0, 0.0));
    }
    let flat = vec![100; SIDE * SIDE];
    assert_eq!(in_scene(&flat, window(15.0, 15.0, 21), &[]).flags, LOST);
}

#[test]
fn bytes_and_longer_rows_give_the_same() {
    let pixels = scene(&[], |pixels| pixels.iter_mut().for_each(|pixel| *pixel /= 8));
    let bytes: Vec<u8> = pixels.iter().map(|&pixel| pixel as u8).collect();
    let stride = SIDE + 5;
    let long: Vec<u16> = pixels.chunks(SIDE).flat_map(|row| row.iter().copied().chain([9999; 5])).collect();
    let windows = [window(15.0, 15.0, 15), window(14.0, 16.0, 9)];
    let mut out = [[Star::default(); 3]; 3];
    let [of_words, of_bytes, of_long] = &mut out;
    track::<F32, _>(&Raster::new(&pixels, SIDE, SIDE, SIDE).unwrap(), &windows, &CAMERA, &[], of_words).unwrap();
    track::<F32, _>(&Raster::new(&bytes, SIDE, SIDE, SIDE).unwrap(), &windows, &CAMERA, &[], of_bytes).unwrap();
    let long = &long[..long.len() - 5];
    track::<F32, _>(&Raster::new(long, SIDE, SIDE, stride).unwrap(), &windows, &CAMERA, &[], of_long).unwrap();
    assert_eq!(out[0], out[1]);
    assert_eq!(out[0], out[2]);
    assert_eq!(out[0][2], Star::default(), "as many records as windows");
    assert!(out[0][0].snr > 10.0);
}

#[test]
fn the_page_for_flight_tells_the_memory_of_a_run() {
    let page = include_str!("../../../core/doc/on-board.md");
    for side in [512, 1024] {
        let [wide, narrow] = [4, 2].map(|cell| bytes(side, side, cell, false, 256));
        let spare = workspace::regions(side, side) - 2048;
        let most = workspace::bytes(side, side, Config::STAR_TRACKER.sky.cell());
        let whole = most - spare * size_of::<Region<f32>>();
        let row = format!("| {side} x {side} | {whole} | {wide} | {narrow} |");
        assert!(page.contains(&row), "{row}");
    }
}

/// Stars in a frame, each with a fainter one beside it: all are found, nothing else is, and their places are better
/// than the default's.
#[test]
fn the_preset_for_star_trackers_knows_better_where_stars_are() {
    const WIDE: usize = 320;
    let mut random = Random(5);
    let mut lights = Vec::new();
    for cell in 0..64 {
        let (x, y) = ((cell % 8 * 40 + 20) as f64 + random.uniform(), (cell / 8 * 40 + 20) as f64 + random.uniform());
        let angle = std::f64::consts::TAU * random.uniform();
        lights.push(Light { x, y, flux: 3000.0 + 20_000.0 * random.uniform() });
        lights.push(Light { x: x + 4.0 * angle.cos(), y: y + 4.0 * angle.sin(), flux: 250.0 });
    }
    let pixels: Vec<f32> = frame(WIDE, &CAMERA, 40.0, &lights, &mut random).into_iter().map(f32::from).collect();
    let [preset, default] = [Config::STAR_TRACKER, Config::NOISE_AWARE].map(|config| {
        let found = segment::<F32, f32>(&config, &pixels, WIDE, &mut Drive::default()).expect("a frame");
        let mut squares = Vec::new();
        for light in lights.iter().step_by(2) {
            let distance = |source: &Source| {
                let (x, y) = source.centroid();
                (f64::from(x) - light.x).hypot(f64::from(y) - light.y)
            };
            squares.push(found.sources.iter().map(distance).fold(f64::INFINITY, f64::min).powi(2));
        }
        let off = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        println!("{} sources, places {off:.3} pixels off", found.sources.len());
        (found.sources.len(), off)
    });
    assert_eq!(preset.0, 64, "the stars and nothing else");
    assert!(preset.1 < 0.75 * default.1, "{preset:?} {default:?}");
}

#[test]
fn what_is_out_of_bounds_is_named() {
    let pixels = [0u16; 400];
    let raster = Raster::new(&pixels, 20, 20, 20).unwrap();
    let tried = |camera: Camera, window: Window| {
        track::<F32, _>(&raster, &[window], &camera, &[], &mut [Star::default()]).unwrap_err().to_string()
    };
    let middle = window(10.0, 10.0, 9);
    for (camera, message) in [
        (Camera { black: -1.0, ..CAMERA }, "black is -1; must be at least 0"),
        (Camera { gain: 0.0, ..CAMERA }, "gain is 0; must be at least 0.001"),
        (Camera { read_noise: f32::NAN, ..CAMERA }, "read noise is NaN; must be at least 0"),
        (Camera { saturation: 1e9, ..CAMERA }, "saturation is 1000000000; must be at most 65536"),
        (Camera { psf_sigma: 0.4, ..CAMERA }, "PSF sigma is 0.4; must be at least 0.5"),
    ] {
        assert_eq!(tried(camera, middle), message);
    }
    for (window, message) in [
        (Window { width: 7, ..middle }, "window width is 7; must be at least 8"),
        (Window { height: 65, ..middle }, "window height is 65; must be at most 64"),
        (Window { x: f32::INFINITY, ..middle }, "predicted column is inf; must be within 10^6 of 0"),
        (Window { y: f32::NAN, ..middle }, "predicted row is NaN; must be within 10^6 of 0"),
    ] {
        assert_eq!(tried(CAMERA, window), message);
    }
    let short = track::<F32, _>(&raster, &[middle; 2], &CAMERA, &[], &mut [Star::default()]);
    assert_eq!(short, Err(Error::Length { name: "stars", given: 1, needed: 2 }));
    let size = Raster::new(&pixels, 7, 20, 7).unwrap_err();
    assert!(matches!(size, Error::Size { width: 7, height: 20, least: 8, .. }));
    let stride = Raster::new(&pixels, 20, 20, 19).unwrap_err();
    assert_eq!(stride, Error::Parameter { name: "stride", value: 19.0, bound: "at least", limit: 20.0 });
    let length = Raster::new(&pixels, 20, 20, 21).unwrap_err();
    assert_eq!(length, Error::Length { name: "frame", given: 400, needed: 419 });
}
