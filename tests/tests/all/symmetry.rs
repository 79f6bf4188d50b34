//! A mirrored or transposed image gives the mirrored or transposed front and mask, exactly, for every scheme.
//!
//! No step prefers a direction: opposite differences are added before others, the semi-Lagrangian directions map onto
//! themselves, and the look along the contour splits its offsets away from the centre. Two things do follow the
//! raster and are no part of the mask: the order of labels, and the rounding of the stopping rule's sum, which could
//! move the last step where the sum lies within one rounding of the tolerance; here it does not.

use skyfront::pipeline::{Drive, Segmentation, segment};
use skyfront_core::config::{Config, Diffusivity, Edge, Filter, Normalize, Rescale, Scheme};
use skyfront_core::run::frame::Frame;
use skyfront_core::simulate::{Kind, Sky};

const WIDTH: usize = 48;
const HEIGHT: usize = 37;

/// A row-major plane seen another way: the new plane's width, and for each of its pixels the old one's.
type View = (&'static str, usize, fn(usize, usize) -> usize);

const VIEWS: [View; 4] = [
    ("left-right", WIDTH, |x, y| y * WIDTH + (WIDTH - 1 - x)),
    ("upside down", WIDTH, |x, y| (HEIGHT - 1 - y) * WIDTH + x),
    ("transposed", HEIGHT, |x, y| x * WIDTH + y),
    ("turned", HEIGHT, |x, y| (HEIGHT - 1 - x) * WIDTH + y),
];

fn seen<T: Copy>(plane: &[T], (_, width, old): View) -> Vec<T> {
    (0..plane.len()).map(|at| plane[old(at % width, at / width)]).collect()
}

fn run(config: &Config, pixels: &[f32], width: usize) -> Segmentation {
    segment(config, pixels, width, pixels.len() / width, &mut Drive::default()).expect("a run")
}

fn check(config: &Config, kind: Kind, seed: u32) {
    let mut pixels = vec![0.0; WIDTH * HEIGHT];
    let mut sky = Sky::new(kind, seed, WIDTH, HEIGHT);
    for (y, row) in pixels.chunks_exact_mut(WIDTH).enumerate() {
        let Ok(()) = sky.row(y, row);
    }
    let plain = run(config, &pixels, WIDTH);
    assert!(plain.outcome.mask_pixels > 0, "{config:?}: an empty mask shows nothing");
    for view in VIEWS {
        let other = run(config, &seen(&pixels, view), view.1);
        let caption = format!("{} of {config:?}", view.0);
        assert_eq!(other.outcome.steps, plain.outcome.steps, "{caption}");
        let bits = |front: &[f32]| front.iter().map(|u| (u + 0.0).to_bits()).collect::<Vec<_>>();
        assert!(bits(&other.front) == bits(&seen(&plain.front, view)), "{caption}: the front");
        let mask = |labels: &[u32]| labels.iter().map(|&label| label != 0).collect::<Vec<_>>();
        assert!(mask(&other.labels) == seen(&mask(&plain.labels), view), "{caption}: the mask");
        assert_eq!(other.outcome.sources, plain.outcome.sources, "{caption}");
    }
}

#[test]
fn no_scheme_prefers_a_direction() {
    let strong = Config { rescale: Rescale::R1 { alpha: 0.25 }, nu: 0.3, ..Config::PAPER_F160 };
    for scheme in
        [Scheme::Fd, Scheme::Sl, Scheme::FdCurvature, Scheme::SlCurvature, Scheme::FdFiltered, Scheme::ChanVese]
    {
        let config = strong.with_scheme(scheme);
        // Half the paper's step of SL with curvature bears so strong a one.
        let dt = if scheme == Scheme::SlCurvature { config.dt / 2.0 } else { config.dt };
        for (kind, seed) in [(Kind::Bright, 5), (Kind::Stars, 6)] {
            check(&Config { dt, ..config }, kind, seed);
        }
    }
    check(&Config { directions: 64, ..strong.with_scheme(Scheme::Sl) }, Kind::Bright, 5);
}

#[test]
fn no_step_before_the_front_prefers_a_direction() {
    let robust = Config {
        normalize: Normalize::Percentile { low: 1.0, high: 99.0 },
        filter: Filter::PeronaMalik { diffusivity: Diffusivity::F2, mu: 2.0 },
        edge: Edge::G1 { p: 3.0 },
        ..Config::PAPER_F160
    };
    check(&robust, Kind::Bright, 5);
    check(&Config::PAPER_F160, Kind::Bright, 7);
}
