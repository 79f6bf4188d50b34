//! What sources measure, against photutils 3.0.0 and against numbers worked out by hand.

use skyfront::measure::{Extras, Flux, Level, Measured, Neighbours, Scene, Wanted, measure};
use skyfront_core::sources::catalog::Source;
use skyfront_core::sources::flags;
use std::time::Instant;

/// Segments with the labels given, measured.
fn measured(pixels: &[f32], labels: &[u32], width: usize, extras: &Extras<'_>) -> Vec<Measured> {
    let most = labels.iter().copied().max().unwrap_or(0);
    let mut sources: Vec<Source> = (1..=most).map(Source::empty).collect();
    for (index, &label) in labels.iter().enumerate().filter(|(_, label)| **label > 0) {
        sources[label as usize - 1].add((index % width) as u32, (index / width) as u32, pixels[index], 0.0);
    }
    let scene = Scene::new(pixels, labels, width, pixels.len() / width, extras);
    measure(&scene, &sources, extras, None)
}

fn known(background: f64, noise: f64) -> Extras<'static> {
    Extras { background: Some(Level::Constant(background)), noise: Some(Level::Constant(noise)), ..Extras::default() }
}

fn near(found: f64, expected: f64, what: &str) {
    assert!((found / expected - 1.0).abs() < 1e-6, "{what}: {found} is not {expected}");
}

/// A tilted galaxy on a level sky of 10, in units with 2 electrons each.
///
/// The numbers come from photutils 3.0.0 on the same pixels: `SourceCatalog(pixels - 10, labels,
/// error=4, apermask_method="mask", kron_params=(2.5, 1.4, 0))` and `CircularAperture`, errors
/// with flux / 2 added to the squares.
#[test]
fn a_galaxy_measures_what_photutils_says() {
    let (width, height) = (33, 31);
    let pixels: Vec<f32> = (0..width * height)
        .map(|index| {
            let (dx, dy) = ((index % width) as f64 - 15.3, (index / width) as f64 - 14.6);
            let q = dx * dx * 0.25 + dx * dy * 0.125 + dy * dy * 0.5;
            (3000.0 / ((1.0 + q) * (1.0 + q)) + 10.0) as f32
        })
        .collect();
    let labels: Vec<u32> = pixels.iter().map(|&pixel| u32::from(pixel > 60.0)).collect();
    let extras = Extras { gain: Some(2.0), apertures: vec![3.0, 5.5], ..known(10.0, 4.0) };
    let source = &measured(&pixels, &labels, width, &extras)[0];
    assert_eq!(source.source.area, 60);
    near(source.flux.value, 23515.728183746338, "flux");
    near(source.flux.error, 112.7735079345906, "flux error");
    near(source.shape.x, 15.311949069522427, "x");
    near(source.shape.y, 14.601877204050222, "y");
    near(source.shape.a, 1.6738360994503287, "a");
    near(source.shape.b, 1.1513388115195096, "b");
    near(source.shape.theta.to_degrees(), 345.114_202_166_981_56 - 360.0, "theta");
    near(source.kron.value, 24444.07297037559, "Kron flux");
    near(source.kron.error, 116.56806790163056, "Kron flux error");
    near(source.half_light, 1.6305067084378464, "half-light radius");
    let apertures = [(20091.41901680562, 102.46023058006331), (24537.822151088832, 117.4284544728486)];
    for (found, (flux, error)) in source.apertures.iter().zip(apertures) {
        near(found.value, flux, "aperture flux");
        near(found.error, error, "aperture flux error");
    }
    assert_eq!(source.flags, 0);
}

/// A star at column 20 and a fainter one `far` columns to the right, whose label reaches nearer to the
/// first than to itself.
fn pair(far: f64) -> (Vec<f32>, Vec<u32>, usize) {
    let side = 61;
    let bell = |x: f64, y: f64| 1000.0 * (-(x * x + y * y) / (2.0 * 2.5 * 2.5)).exp();
    let place = |at: usize| ((at % side) as f64 - 20.0, (at / side) as f64 - 30.0);
    let light = |at: usize| {
        let (x, y) = place(at);
        (bell(x, y) + 0.3 * bell(x - far, y)) as f32
    };
    let pixels: Vec<f32> = (0..side * side).map(light).collect();
    let labels = (0..side * side).map(|at| match place(at).0 < 0.35 * far {
        _ if pixels[at] < 20.0 => 0,
        true => 1,
        false => 2,
    });
    let labels = labels.collect();
    (pixels, labels, side)
}

#[test]
fn a_neighbour_is_replaced_by_the_light_opposite_to_it() {
    let (pixels, labels, side) = pair(12.0);
    let flux = |neighbours: Neighbours| {
        let extras = Extras { neighbours, apertures: vec![10.0], ..known(0.0, 1.0) };
        let source = measured(&pixels, &labels, side, &extras).remove(0);
        assert!(source.flags & flags::NEIGHBOUR != 0, "{neighbours:?}");
        (source.kron.value, source.apertures[0].value)
    };
    let alone = 1000.0 * 2.0 * std::f64::consts::PI * 2.5 * 2.5;
    let [correct, mask, keep] = [Neighbours::Correct, Neighbours::Mask, Neighbours::Keep].map(flux);
    assert!((correct.0 / alone - 1.0).abs() < 0.01 && (correct.1 / alone - 1.0).abs() < 0.01, "{correct:?} of {alone}");
    assert!(mask.1 < 0.97 * correct.1 && keep.1 > 1.02 * correct.1, "{mask:?} {correct:?} {keep:?}");
}

#[test]
fn an_aperture_without_a_pixel_to_measure_has_no_flux_and_a_flag() {
    // The second source lies around the first one's centroid.
    let labels: Vec<u32> = (0..81).map(|at| if (at % 9, at / 9) == (4, 4) { 1 } else { 2 }).collect();
    let mut pixels = vec![1.0; 81];
    pixels[40] = f32::NAN;
    for neighbours in [Neighbours::Correct, Neighbours::Mask] {
        let extras = Extras { neighbours, apertures: vec![1.5], ..known(0.0, 1.0) };
        let source = &measured(&pixels, &labels, 9, &extras)[0];
        assert!(source.apertures[0].value.is_nan() && source.apertures[0].error.is_nan(), "{neighbours:?}");
        assert!(source.kron.value.is_nan() && source.half_light.is_nan());
        assert!(source.flags & flags::NEIGHBOUR != 0);
    }
    let outside = Extras { apertures: vec![2.0], neighbours: Neighbours::Keep, ..known(0.0, 1.0) };
    assert!(measured(&pixels, &labels, 9, &outside)[0].apertures[0].value > 0.0);
}

#[test]
fn a_windowed_centroid_is_less_moved_by_a_neighbour() {
    let (pixels, labels, side) = pair(12.0);
    let wanted = Wanted { windowed: true, ..Wanted::default() };
    let source = &measured(&pixels, &labels, side, &Extras { wanted, ..known(0.0, 1.0) })[0];
    let (plain, windowed) = (source.shape.x - 20.0, source.windowed.x - 20.0);
    assert!(windowed.abs() < 0.3 * plain.abs() && (source.windowed.y - 30.0).abs() < 1e-6, "{plain} {windowed}");
    assert!(measured(&pixels, &labels, side, &known(0.0, 1.0))[0].windowed.x.is_nan(), "not wanted");
}

/// The errors of positions are those of many noisy images of one star.
#[test]
fn the_errors_of_positions_are_those_of_repeated_images() {
    let (side, trials, sigma) = (31, 400, 4.0);
    let labels: Vec<u32> = (0..side * side)
        .map(|at| u32::from(((at % side) as i32 - 15).pow(2) + ((at / side) as i32 - 15).pow(2) < 36))
        .collect();
    let mut state = 1u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1u64 << 24) as f64
    };
    let wanted = Wanted { windowed: true, ..Wanted::default() };
    let (mut plain, mut windowed) = (Vec::new(), Vec::new());
    let mut errors = (0.0, 0.0);
    for _ in 0..trials {
        let pixels: Vec<f32> = (0..side * side)
            .map(|at| {
                let (x, y) = ((at % side) as f64 - 15.2, (at / side) as f64 - 14.9);
                let noise = (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
                (300.0 * (-(x * x + y * y) / 8.0).exp() + sigma * noise) as f32
            })
            .collect();
        let source = measured(&pixels, &labels, side, &Extras { wanted, ..known(0.0, sigma) }).remove(0);
        plain.push(source.shape.x);
        windowed.push(source.windowed.x);
        errors = (errors.0 + source.shape.errors.0, errors.1 + source.windowed.errors.0);
    }
    let scatter = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
    };
    for (what, values, square) in [("centroid", &plain, errors.0), ("windowed", &windowed, errors.1)] {
        let (found, told) = (scatter(values), (square / f64::from(trials)).sqrt());
        assert!((0.8..1.25).contains(&(told / found)), "{what}: {told} told, {found} found");
    }
    assert!(scatter(&windowed) < scatter(&plain));
}

#[test]
fn the_sky_beside_a_source_is_its_own() {
    let (pixels, labels, side) = pair(12.0);
    let lifted: Vec<f32> = pixels.iter().map(|pixel| pixel + 50.0).collect();
    let wanted = Wanted { local: true, ..Wanted::default() };
    let source = &measured(&lifted, &labels, side, &Extras { wanted, ..known(0.0, 1.0) })[0];
    assert!((source.local.background - 50.0).abs() < 1.0, "{:?}", source.local);
    let light = source.flux.value - 50.0 * f64::from(source.source.area);
    assert!((source.local_flux.value / light - 1.0).abs() < 0.01, "{} {light}", source.local_flux.value);
    assert!(measured(&lifted, &labels, side, &known(0.0, 1.0))[0].local.background.is_nan(), "not wanted");
}

/// An exponential disc: its annulus has 0.2 of the mean light within where integrals
/// of r exp(-r) say so.
#[test]
fn a_disc_has_the_petrosian_radius_of_its_profile() {
    let (side, scale) = (161, 5.0);
    let place = |at: usize| ((at % side) as f64 - 80.2, (at / side) as f64 - 79.7);
    let pixels: Vec<f32> = (0..side * side)
        .map(|at| {
            let (x, y) = place(at);
            (1000.0 * (-x.hypot(y / 0.6) / scale).exp()) as f32
        })
        .collect();
    let labels: Vec<u32> = pixels.iter().map(|&pixel| u32::from(pixel > 20.0)).collect();
    let wanted = Wanted { petrosian: true, ..Wanted::NOTHING };
    let source = &measured(&pixels, &labels, side, &Extras { wanted, ..known(0.0, 1.0) })[0];
    // Light within r, in units of all, and the mean light of annulus and disc by it.
    let within = |r: f64| 1.0 - (1.0 + r) * (-r).exp();
    let ratio = |r: f64| (within(1.25 * r) - within(0.8 * r)) / (1.25f64.powi(2) - 0.8f64.powi(2)) / within(r);
    let radius = (0..100_000).map(|n| f64::from(n) * 1e-4 + 0.1).find(|&r| ratio(r) < 0.2).expect("a radius");
    assert!((source.petrosian.radius / (scale * radius) - 1.0).abs() < 0.01, "{:?} {radius}", source.petrosian);
    let light = 1000.0 * 2.0 * std::f64::consts::PI * scale * scale * 0.6;
    assert!(
        (source.petrosian.flux.value / (light * within(2.0 * radius)) - 1.0).abs() < 0.01,
        "{:?}",
        source.petrosian
    );
    assert!(measured(&pixels, &labels, side, &known(0.0, 1.0))[0].petrosian.radius.is_nan(), "not wanted");
}

#[test]
fn what_is_not_wanted_is_not_measured() {
    let (pixels, labels, side) = pair(12.0);
    let wanted = Wanted::NOTHING;
    let source = &measured(&pixels, &labels, side, &Extras { wanted, ..known(0.0, 1.0) })[0];
    assert!(source.kron.value.is_nan() && source.half_light.is_nan() && source.flux.value > 0.0);
}

/// Parallel lines, three pixels thick, along the rows or aslant: each as long as the image.
fn lines(side: usize, slope: usize) -> (Vec<f32>, Vec<u32>) {
    let phase = |at: usize| at / side + slope * (at % side);
    let labels = (0..side * side).map(|at| if phase(at) % 16 < 3 { phase(at) as u32 / 16 + 1 } else { 0 });
    let labels: Vec<u32> = labels.collect();
    (labels.iter().map(|&label| if label > 0 { 12.0 } else { 0.0 }).collect(), labels)
}

#[test]
fn threads_change_no_bit() {
    let (pixels, labels) = lines(300, 1);
    let of = |threads: usize| {
        let wanted = Wanted { windowed: true, local: true, petrosian: true, ..Wanted::default() };
        let extras = Extras { threads, wanted, apertures: vec![4.0], ..known(0.0, 1.0) };
        format!("{:?}", measured(&pixels, &labels, 300, &extras))
    };
    let one = of(1);
    assert!([2, 3, 16].into_iter().all(|threads| of(threads) == one));
}

/// Rings three pixels thick around the middle, one in another.
fn rings(side: usize) -> (Vec<f32>, Vec<u32>) {
    let middle = side as f64 / 2.0;
    let far = |at: usize| ((at % side) as f64 - middle).hypot((at / side) as f64 - middle) as u32;
    let labels = (0..side * side).map(far).map(|far| if far % 16 < 3 { far / 16 + 1 } else { 0 });
    let labels: Vec<u32> = labels.collect();
    (labels.iter().map(|&label| if label > 0 { 12.0 } else { 0.0 }).collect(), labels)
}

/// What apertures cost is the pixels in them: without a bound, those of rings would be as many as the
/// image has, for each.
#[test]
fn the_apertures_of_all_sources_are_a_bounded_part_of_the_image() {
    const MOST: f64 = 64.0;
    for name in ["rings", "lines", "lines aslant"] {
        let mut cut = 0;
        for side in [256, 512, 1024] {
            let (pixels, labels) = match name {
                "rings" => rings(side),
                _ => lines(side, usize::from(name == "lines aslant")),
            };
            let sources = measured(&pixels, &labels, side, &known(0.0, 1.0));
            for one in &sources {
                let (a, b) = one.shape.wide_axes();
                let area = std::f64::consts::PI * one.kron_radius * one.kron_radius * b / a;
                let most = MOST * f64::from(one.source.area) + 1024.0;
                assert!(area <= 1.000_001 * most, "{name}, {side}: {area} of {:?}", one.source);
                cut += usize::from(area > 0.999_999 * most);
                // All of a ring up to a hundred times as wide as thick, and a flag that says what is cut.
                let all = 12.0 * f64::from(one.source.area);
                let ring = name == "rings" && one.flags & flags::TRUNCATED == 0 && one.source.area < 5600;
                assert!(!ring || one.kron.value > 0.99 * all, "{side}: {:?}", one.source);
                assert!(area < 0.999_999 * most || one.flags & flags::APERTURE != 0, "{name}, {side}");
            }
        }
        assert_eq!(cut > 20, name == "rings", "{name}: {cut} cut");
    }
}

/// Long thin sources reach as far as round ones of a hundred times their area, and must not cost as
/// much: four times the pixels in twice as many lines of twice the length take four times as long.
#[test]
fn the_time_per_pixel_does_not_grow_with_the_length_of_lines() {
    for slope in [0, 1] {
        let [short, long] = [512, 2048].map(|side| (side, lines(side, slope)));
        let time = |(side, (pixels, labels)): &(usize, (Vec<f32>, Vec<u32>))| {
            let start = Instant::now();
            assert!(measured(pixels, labels, *side, &known(0.0, 1.0)).iter().any(|line| line.half_light > 0.0));
            start.elapsed().as_secs_f64() * 1e9 / (side * side) as f64
        };
        // In turn, so that both meet the same neighbours on the machine.
        let pairs: Vec<[f64; 2]> = (0..5).map(|_| [time(&short), time(&long)]).collect();
        let [short, long] = [0, 1].map(|of| pairs.iter().map(|pair| pair[of]).fold(f64::INFINITY, f64::min));
        println!("slope {slope}: {short:.1} and {long:.1} ns a pixel");
        // Sorting circles of pixels made it 5 times as long along the rows and 11 times aslant.
        assert!(long < 4.0 * short, "slope {slope}: {short:.1} and {long:.1} ns a pixel");
    }
}

/// Two sources side by side on a sky of 1 with noise 2, an undefined pixel, a saturated one.
#[test]
fn fluxes_errors_and_flags_by_hand() {
    let nan = f32::NAN;
    #[rustfmt::skip]
    let pixels = [
        1.0, 1.0, 1.0, 1.0, 1.0, 1.0,
        1.0, 3.0, 5.0, 9.0, 1.0, nan,
        1.0, 1.0, 1.0, 1.0, 1.0, 4.0,
    ];
    #[rustfmt::skip]
    let labels = [
        0, 0, 0, 0, 0, 0,
        0, 1, 1, 2, 0, 0,
        0, 0, 0, 0, 0, 3,
    ];
    let extras = Extras { gain: Some(0.5), saturation: Some(9.0), ..known(1.0, 2.0) };
    let sources = measured(&pixels, &labels, 6, &extras);
    // 2 + 4 above the sky; two pixels of variance 4, and 6 / 0.5.
    assert_eq!(sources[0].flux, Flux { value: 6.0, error: 20.0f64.sqrt() });
    // Weights 2 and 4 at columns 1 and 2.
    assert!((sources[0].shape.x - 10.0 / 6.0).abs() < 1e-15 && sources[0].shape.y == 1.0);
    assert!((sources[0].shape.moments.0 - 2.0 / 9.0).abs() < 1e-15);
    assert_eq!((sources[0].background, sources[0].noise, sources[0].threshold), (1.0, 2.0, 3.0));
    let pixel_flags =
        |source: &Measured| source.flags & (flags::TRUNCATED | flags::SATURATED | flags::MASKED | flags::BLENDED);
    assert_eq!(pixel_flags(&sources[0]), flags::BLENDED);
    assert_eq!(pixel_flags(&sources[1]), flags::BLENDED | flags::SATURATED);
    assert_eq!(pixel_flags(&sources[2]), flags::TRUNCATED | flags::MASKED);
    // The Kron aperture of the first reaches the second, that of the third the frame.
    assert!(sources[0].flags & flags::NEIGHBOUR != 0 && sources[2].flags & flags::APERTURE != 0);
}

#[test]
fn maps_count_pixel_by_pixel_and_bad_noise_leaves_a_pixel_out() {
    let pixels = [5.0, 5.0, 5.0, 5.0];
    let background = vec![1.0, 2.0, 3.0, 4.0];
    let noise = vec![1.0, 2.0, f32::INFINITY, 2.0];
    let extras = Extras {
        background: Some(Level::Map(background.into())),
        noise: Some(Level::Map(noise.into())),
        ..Extras::default()
    };
    let source = &measured(&pixels, &[1, 1, 1, 1], 4, &extras)[0];
    assert_eq!(source.flux, Flux { value: 4.0 + 3.0 + 1.0, error: 3.0 });
    assert!(source.flags & flags::MASKED != 0);
}

#[test]
fn a_source_below_its_background_says_so() {
    let source = &measured(&[0.0, -1.0, 0.0], &[0, 1, 0], 3, &known(0.0, 1.0))[0];
    assert!(source.flags & flags::NO_FLUX != 0);
    assert_eq!((source.shape.x, source.shape.y, source.flux.value), (1.0, 0.0, -1.0));
    assert!(source.half_light.is_nan() && source.flux.magnitude(25.0).0.is_nan());
}

#[test]
fn a_magnitude_by_hand() {
    let (magnitude, error) = Flux { value: 100.0, error: 1.0 }.magnitude(25.0);
    assert!((magnitude - 20.0).abs() < 1e-12 && (error - 0.010857362).abs() < 1e-9);
}

/// The curve of growth sums whole pixels once and cuts the others; the aperture visits them all.
#[test]
fn half_of_the_light_lies_within_the_half_light_radius() {
    let side = 41;
    let pixels: Vec<f32> = (0..side * side)
        .map(|at| {
            let (dx, dy) = ((at % side) as f32 - 19.7, (at / side) as f32 - 20.4);
            500.0 * (-(dx * dx + dy * dy) / 18.0).exp()
        })
        .collect();
    let labels: Vec<u32> = pixels.iter().map(|&pixel| u32::from(pixel > 5.0)).collect();
    let source = &measured(&pixels, &labels, side, &known(0.0, 1.0))[0];
    // A Gaussian of sigma 3 has half of its light within 3 sqrt(2 ln 2) = 3.53, of which the Kron aperture misses little.
    assert!((3.45..3.6).contains(&source.half_light), "{}", source.half_light);
    let radius = vec![source.half_light];
    let again = &measured(&pixels, &labels, side, &Extras { apertures: radius, ..known(0.0, 1.0) })[0];
    near(again.apertures[0].value, 0.5 * source.kron.value, "half of the light");
}
