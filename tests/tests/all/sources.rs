//! What real optics and detectors make of a star stays one source, in every arithmetic.

use skyfront::detection::segment;
use skyfront::pipeline::{Drive, Segmentation};
use skyfront_core::arithmetic::{Fixed14, Level};
use skyfront_core::detection::Detection;
use skyfront_tests::noise::gaussian;

const SIDE: usize = 320;
/// Places of stars in a frame, not on pixel centres.
const PLACES: [(f32, f32); 16] = [
    (40.3, 41.2),
    (119.6, 38.9),
    (200.1, 42.5),
    (278.8, 39.7),
    (38.5, 120.0),
    (121.2, 121.7),
    (198.4, 118.3),
    (281.1, 122.9),
    (42.7, 199.4),
    (118.1, 201.8),
    (202.6, 200.5),
    (279.3, 198.2),
    (39.9, 280.6),
    (120.8, 278.4),
    (199.5, 281.3),
    (280.4, 279.1),
];

/// A star's light at a distance from its centre, with the wings of the atmosphere; 1 at the centre.
fn moffat(dx: f32, dy: f32, fwhm: f32) -> f32 {
    let beta = 2.8;
    let scale = 0.5 * fwhm / (2f32.powf(1.0 / beta) - 1.0).sqrt();
    (1.0 + (dx * dx + dy * dy) / (scale * scale)).powf(-beta)
}

/// Noise of 1, and a star of the shape at each place.
fn stars(seed: u64, shape: impl Fn(f32, f32) -> f32) -> Vec<f32> {
    let mut pixels = gaussian(seed, SIDE * SIDE);
    for (x, y) in PLACES {
        for (at, pixel) in pixels.iter_mut().enumerate() {
            let (dx, dy) = ((at % SIDE) as f32 - x, (at / SIDE) as f32 - y);
            if dx.abs() < 39.0 && dy.abs() < 39.0 {
                *pixel += shape(dx, dy);
            }
        }
    }
    pixels
}

fn run<L: Level>(pixels: &[f32]) -> Segmentation {
    segment::<L>(&Detection::DEFAULT, pixels, SIDE, &Drive::default()).expect("the frame can be segmented")
}

/// Every star is one source, and there is no other, in either arithmetic.
#[track_caller]
fn whole(pixels: &[f32]) -> Segmentation {
    let [found, fixed] = [run::<f32>(pixels), run::<Fixed14>(pixels)];
    assert_eq!([found.outcome.sources, fixed.outcome.sources], [PLACES.len() as u32; 2], "f32, q24");
    let mut labels: Vec<u32> = PLACES.iter().map(|&(x, y)| found.labels[y as usize * SIDE + x as usize]).collect();
    labels.sort_unstable();
    assert!(labels.iter().copied().eq(1..=PLACES.len() as u32), "{labels:?}");
    found
}

#[test]
fn a_star_out_of_focus_is_one_source() {
    let ring = |dx: f32, dy: f32| {
        let off = (dx.hypot(dy) - 3.6) / 1.2;
        (-0.5 * off * off).exp()
    };
    for (seed, peak) in [(1, 30.0), (2, 300.0)] {
        whole(&stars(seed, |dx, dy| {
            peak * (ring(dx, dy) * (1.0 + 0.1 * dx / (dx.hypot(dy) + 0.1)) + 0.45 * moffat(dx, dy, 4.0))
        }));
    }
}
