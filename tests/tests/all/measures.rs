//! What sources measure, against photutils 3.0.0 and against numbers worked out by hand.

use skyfront::measure::{Extras, Flux, Level, Measured, Scene, measure};
use skyfront_core::catalog::Source;
use skyfront_core::flags;

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
