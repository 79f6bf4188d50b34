//! The core against the figures that an independent f64 program gave for the captions of the paper's
//! Test 1 on three simulated images: when the front stopped, and how many pixels it enclosed.

use skyfront::pipeline::{Drive, Segmentation, segment};
use skyfront::read;
use skyfront_core::config::{Config, Edge, Rescale, Scheme, Tau};
use skyfront_tests::command::workspace;
use std::io::Write;

const NONE: Rescale = Rescale::None;
const R1: Rescale = Rescale::R1 { alpha: 0.25 };
const R3: Rescale = Rescale::R3 { beta: 8, tau: Tau::Otsu };
const G1: Edge = Edge::G1 { p: 5000.0 };
const G2: Edge = Edge::G2Mod { c2: 0.8 };

/// Rescaling, edge detector, scheme, nu; then steps and pixels on f160_dev0, dev1, dev2.
type Row = (Rescale, Edge, Scheme, f32, [(u32, u32); 3]);

#[rustfmt::skip]
const TABLE: [Row; 12] = [
    (NONE, G2, Scheme::Fd, 0.0, [(631, 109), (631, 58), (633, 40)]),
    (NONE, G2, Scheme::Sl, 0.0, [(149, 109), (149, 58), (150, 40)]),
    (NONE, G1, Scheme::FdCurvature, 1e-4, [(1532, 179), (1532, 150), (1531, 138)]),
    (NONE, G1, Scheme::SlCurvature, 1e-4, [(149, 79), (149, 50), (149, 32)]),
    (R1, G2, Scheme::Fd, 0.0, [(746, 616), (735, 406), (729, 601)]),
    (R1, G2, Scheme::Sl, 0.0, [(183, 617), (180, 404), (181, 570)]),
    (R1, G1, Scheme::FdCurvature, 1e-6, [(1532, 249), (1532, 192), (1531, 177)]),
    (R1, G1, Scheme::SlCurvature, 1e-6, [(149, 149), (149, 92), (149, 57)]),
    (R3, G2, Scheme::Fd, 0.0, [(630, 94), (630, 47), (630, 30)]),
    (R3, G2, Scheme::Sl, 0.0, [(149, 94), (149, 47), (149, 30)]),
    (R3, G1, Scheme::FdCurvature, 1e-4, [(1532, 198), (1532, 149), (1532, 136)]),
    (R3, G1, Scheme::SlCurvature, 1e-4, [(149, 98), (149, 49), (149, 30)]),
];

/// One of the simulated images, or `None` with a word on stderr, past the test's capture.
fn scene(index: usize) -> Option<read::Image> {
    let path = workspace().join(format!("../shared/scenes/f160_dev{index}.fits"));
    if !path.exists() {
        let _ = writeln!(std::io::stderr(), "SKIPPED: {} is absent", path.display());
        return None;
    }
    Some(read::image(&path, None).expect("a good image"))
}

fn run(image: &read::Image, row: &Row, directions: u8) -> Segmentation {
    let &(rescale, edge, scheme, nu, _) = row;
    let config = Config { rescale, edge, nu, directions, ..Config::PAPER_F160 }.with_scheme(scheme);
    segment(&config, &image.pixels, image.width, image.height, &mut Drive::default()).expect("a good image")
}

fn check(index: usize) {
    let Some(image) = scene(index) else { return };
    for row in &TABLE {
        let found = run(&image, row, 16).outcome;
        assert_eq!((found.steps, found.mask_pixels), row.4[index], "f160_dev{index}: {row:?}");
    }
}

#[test]
fn the_captions_on_f160_dev0() {
    check(0);
}

#[test]
fn the_captions_on_f160_dev1() {
    check(1);
}

#[test]
fn the_captions_on_f160_dev2() {
    check(2);
}

/// Four times as many directions of the semi-Lagrangian minimum: where the masks stay, 16 are enough.
#[test]
fn more_directions_do_not_change_the_masks() {
    for index in 0..3 {
        let Some(image) = scene(index) else { return };
        for row in TABLE.iter().filter(|row| matches!(row.2, Scheme::Sl | Scheme::SlCurvature)) {
            let (coarse, fine) = (run(&image, row, 16), run(&image, row, 64));
            let differ = coarse.labels.iter().zip(&fine.labels).filter(|(a, b)| (**a > 0) != (**b > 0)).count();
            println!("f160_dev{index} {:?} {:?}: {differ} pixels", row.0, row.2);
            assert_eq!(differ, 0, "f160_dev{index}: {row:?}");
        }
    }
}
