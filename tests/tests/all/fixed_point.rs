//! Fixed point finds what f32 finds.

use skyfront::machine::Native;
use skyfront::pipeline::{Drive, Segmentation, segment_in};
use skyfront_core::arithmetic::{Arithmetic, F32, Q11, Q24};
use skyfront_core::config::{Config, Diffusivity, Edge, Filter, Order, Rescale, Scheme};
use skyfront_core::error::Error;
use skyfront_core::run::frame::Frame;
use skyfront_core::simulate::{Kind, Sky};

const SIDE: usize = 128;

fn sky(kind: Kind) -> Vec<f32> {
    let mut sky = Sky::new(kind, 4, SIDE, SIDE);
    let mut pixels = vec![0.0; SIDE * SIDE];
    for (y, row) in pixels.chunks_exact_mut(SIDE).enumerate() {
        let Ok(()) = sky.row(y, row);
    }
    pixels
}

fn run<A: Arithmetic>(config: &Config, pixels: &[f32]) -> Result<Segmentation, Error> {
    segment_in::<A>(config, pixels, SIDE, SIDE, &mut Drive::default())
}

fn differing(a: &Segmentation, b: &Segmentation) -> usize {
    a.labels.iter().zip(&b.labels).filter(|&(&a, &b)| (a > 0) != (b > 0)).count()
}

/// The bounds for 300 x 300 pixels, 3 for q24 and 0.2 % for q11, on skies of fewer pixels.
fn assert_agreement(config: &Config, kind: Kind) {
    let pixels = sky(kind);
    let reference = run::<F32<Native>>(config, &pixels).expect("f32");
    assert!(reference.outcome.mask_pixels > 0, "{kind:?}, {config:?}");
    let q24 = run::<Q24>(config, &pixels).expect("q24");
    assert!(differing(&q24, &reference) <= 3, "q24, {kind:?}, {config:?}: {}", differing(&q24, &reference));
    let banded = Config { band: Some(8.0), ..*config };
    let q11 = run::<Q11>(&banded, &pixels).expect("q11");
    let bound = SIDE * SIDE / 500;
    assert!(differing(&q11, &reference) <= bound, "q11, {kind:?}, {config:?}: {}", differing(&q11, &reference));
}

#[test]
fn first_order_schemes() {
    for rescale in [Rescale::R1 { alpha: 0.25 }, Config::PAPER_F160.rescale] {
        for scheme in [Scheme::Fd, Scheme::Sl] {
            for kind in [Kind::Bright, Kind::Stars] {
                assert_agreement(&Config { rescale, ..Config::PAPER_F160 }.with_scheme(scheme), kind);
            }
        }
    }
}

#[test]
fn curvature_that_sixteen_bits_can_resolve() {
    for scheme in [Scheme::FdCurvature, Scheme::SlCurvature] {
        let config = Config { nu: 0.02, rescale: Rescale::R1 { alpha: 0.25 }, ..Config::PAPER_F160 };
        // Half the paper's step of SL with curvature bears so strong a one.
        let config = config.with_scheme(scheme);
        let dt = if scheme == Scheme::SlCurvature { config.dt / 2.0 } else { config.dt };
        assert_agreement(&Config { dt, ..config }, Kind::Bright);
    }
}

#[test]
fn every_other_step_of_the_image() {
    let steps = [
        Config::PAPER_REAL,
        Config { rescale: Rescale::R2 { alpha: 0.3 }, ..Config::PAPER_F160 },
        Config { rescale: Rescale::None, edge: Edge::G2, ..Config::PAPER_F160 },
        Config { edge: Edge::G1 { p: 5000.0 }, ..Config::PAPER_F160 },
        Config {
            filter: Filter::PeronaMalik { diffusivity: Diffusivity::F1, mu: 2.0 },
            order: Order::FilterFirst,
            ..Config::PAPER_F160
        },
    ];
    for config in steps {
        assert_agreement(&config, Kind::Bright);
    }
}

#[test]
fn what_fixed_point_cannot_serve_is_refused() {
    let pixels = sky(Kind::Bright);
    let banded = Config { band: Some(8.0), ..Config::PAPER_F160 };
    let refused = |result: Result<Segmentation, Error>| matches!(result, Err(Error::Arithmetic { .. }));
    assert!(refused(run::<Q11>(&Config::PAPER_F160, &pixels)), "a front without a band");
    assert!(refused(run::<Q11>(&Config { band: Some(8.5), ..banded }, &pixels)), "a band too wide");
    assert!(refused(run::<Q11>(&banded.with_scheme(Scheme::FdCurvature), &pixels)), "a curvature too weak");
    assert!(refused(run::<Q24>(&Config { band: Some(200.0), ..banded }, &pixels)), "a band beyond the range");
    let steep = Filter::PeronaMalik { diffusivity: Diffusivity::F2, mu: 0.01 };
    assert!(refused(run::<Q24>(&Config { filter: steep, ..banded }, &pixels)), "a coefficient beyond the range");
}
