//! The core and the f64 reference against the figures that an independent f64 program gave for the captions of the
//! paper's Test 1 on three simulated images: when the front stopped, and how many pixels it enclosed. The images lie
//! beside the repository: `cargo test -p skyfront-tests -- --ignored paper_table` asks for them. Without them
//! `agreement.rs` tries the captions on a sky of our own, where the reference has the word.

use skyfront::crosscheck::parameters;
use skyfront::pipeline::{Drive, Segmentation, segment};
use skyfront::read::Image;
use skyfront::reference::{Stages, run};
use skyfront_core::config::{Config, Edge, Rescale, Scheme, Tau};
use skyfront_tests::captions::{CAPTIONS, RESCALINGS, paper};
use skyfront_tests::scenes;

fn core(config: &Config, image: &Image) -> Segmentation {
    segment(config, &image.pixels, image.width, image.height, &mut Drive::default()).expect("a good image")
}

fn reference(config: &Config, image: &Image) -> Stages {
    let pixels: Vec<f64> = image.pixels.iter().map(|&pixel| pixel.into()).collect();
    run(&parameters(config), &pixels, image.width, image.height).expect("a good image")
}

fn mask_pixels(labels: &[u32]) -> u32 {
    labels.iter().filter(|&&label| label > 0).count() as u32
}

/// Otsu's threshold of r3 on the three images.
const TAU: [f64; 3] = [0.20703125, 0.26171875, 0.28515625];

/// Both programs are f64, but may sum in another order or place a node of the curvature threshold differently: first
/// order must agree exactly, curvature within two steps and two pixels, semi-Lagrangian within two steps and ten.
fn tolerance(scheme: Scheme) -> (u32, u32) {
    match scheme {
        Scheme::Fd | Scheme::FastMarching => (0, 0),
        Scheme::FdCurvature => (2, 2),
        Scheme::Sl | Scheme::SlCurvature => (2, 10),
        _ => unreachable!("no scheme of the paper"),
    }
}

fn check(index: usize) {
    let image = scenes::needed(&format!("f160_dev{index}"));
    for caption in &CAPTIONS {
        let (config, (steps, pixels)) = (caption.config(), caption.found[index]);
        let found = core(&config, &image).outcome;
        assert_eq!((found.steps, found.mask_pixels), (steps, pixels), "f160_dev{index}: {caption:?}");
        let stages = reference(&config, &image);
        let (most_steps, most_pixels) = tolerance(caption.scheme);
        let mask = mask_pixels(&stages.labels);
        assert!(
            stages.steps.abs_diff(steps) <= most_steps && mask.abs_diff(pixels) <= most_pixels,
            "the reference on f160_dev{index}: {} steps and {mask} pixels, {caption:?}",
            stages.steps
        );
        if let Some(tau) = stages.tau {
            assert_eq!(tau, TAU[index], "f160_dev{index}");
        }
    }
}

#[test]
#[ignore = "needs ../shared/scenes"]
fn the_captions_on_f160_dev0() {
    check(0);
}

#[test]
#[ignore = "needs ../shared/scenes"]
fn the_captions_on_f160_dev1() {
    check(1);
}

#[test]
#[ignore = "needs ../shared/scenes"]
fn the_captions_on_f160_dev2() {
    check(2);
}

#[test]
#[ignore = "needs ../shared/scenes"]
fn the_reference_on_deep_and_crowded_skies() {
    for (name, steps, pixels) in [("deep_dev0", 1247, 9821), ("crowded_dev0", 834, 4959)] {
        let image = scenes::needed(name);
        let stages = reference(&paper(RESCALINGS[0].1, Scheme::Fd), &image);
        assert_eq!((stages.steps, mask_pixels(&stages.labels)), (steps, pixels), "{name}");
    }
}

/// Four times as many directions of the semi-Lagrangian minimum: where the masks stay, 16 are enough.
#[test]
#[ignore = "needs ../shared/scenes"]
fn more_directions_do_not_change_the_masks() {
    for index in 0..3 {
        let image = scenes::needed(&format!("f160_dev{index}"));
        for caption in CAPTIONS.iter().filter(|caption| matches!(caption.scheme, Scheme::Sl | Scheme::SlCurvature)) {
            let config = caption.config();
            let (coarse, fine) = (core(&config, &image), core(&Config { directions: 64, ..config }, &image));
            let differ = coarse.labels.iter().zip(&fine.labels).filter(|(a, b)| (**a > 0) != (**b > 0)).count();
            assert_eq!(differ, 0, "f160_dev{index}: {caption:?}");
        }
    }
}

/// Given thresholds of r3: the mask is the reference's for each of the paper's schemes and edge detectors.
#[test]
#[ignore = "needs ../shared/scenes"]
fn given_thresholds_give_the_masks_of_the_reference() {
    for name in ["f160_dev0", "f160_dev1", "f160_dev2", "deep_dev0", "crowded_dev0"] {
        let image = scenes::needed(name);
        for tau in [0.05, 0.1, 0.2, 0.5] {
            let rescale = Rescale::R3 { beta: 8, tau: Tau::Value(tau) };
            for scheme in [Scheme::Fd, Scheme::Sl, Scheme::FdCurvature, Scheme::SlCurvature] {
                for edge in [Edge::G1 { p: 5000.0 }, Edge::G2Mod { c2: 0.8 }] {
                    let config = Config { rescale, edge, ..Config::PAPER_F160 }.with_scheme(scheme);
                    let (found, wanted) = (core(&config, &image), reference(&config, &image));
                    let differ =
                        found.labels.iter().zip(&wanted.labels).filter(|(a, b)| (**a > 0) != (**b > 0)).count();
                    println!(
                        "{name}, tau = {tau}, {scheme:?}, {edge:?}: {} pixels, {differ} differ",
                        found.outcome.mask_pixels
                    );
                    assert_eq!(differ, 0, "{name}, tau = {tau}, {scheme:?}, {edge:?}");
                }
            }
        }
    }
}
