//! No image, however hostile, makes a run longer than was said before.

use skyfront::planes::Room;
use skyfront_core::arithmetic::{Arithmetic, F32, Q11, Q24};
use skyfront_core::config::{Config, Scheme};
use skyfront_core::error::Error;
use skyfront_core::run::budget;
use skyfront_core::run::frame::SliceFrame;
use skyfront_core::run::outcome::Progress;
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::stage::Stage;
use skyfront_core::simulate::Kind;
use skyfront_tests::runs::{every_kind, sky};

const SIDE: usize = 33;

/// Distance from the outermost ring of the frame, along a square spiral's arms.
fn spiral(x: usize, y: usize) -> f32 {
    let ring = x.min(y).min(SIDE - 1 - x).min(SIDE - 1 - y);
    let seam = x == ring + 1 && y == ring + 1;
    f32::from(ring.is_multiple_of(2) != seam)
}

fn hostile() -> Vec<(&'static str, Vec<f32>)> {
    let draw = |value: &dyn Fn(usize, usize) -> f32| (0..SIDE * SIDE).map(|i| value(i % SIDE, i / SIDE)).collect();
    let noise = |x: usize, y: usize| ((x * 2_654_435_761 + y * 40_503) % 1009) as f32;
    vec![
        ("checkerboard", draw(&|x, y| ((x + y) % 2) as f32)),
        ("dots", draw(&|x, y| f32::from(x.is_multiple_of(2) && y.is_multiple_of(2)))),
        ("comb", draw(&|x, y| f32::from(x.is_multiple_of(2) || y == SIDE - 1))),
        ("teeth", draw(&|x, y| f32::from(y >= (x * 7) % 13 && x.is_multiple_of(2)))),
        ("spiral", draw(&spiral)),
        ("noise", draw(&noise)),
        ("one pixel", draw(&|x, y| f32::from(x == 9 && y == 20))),
        ("ramp", draw(&|x, y| (x * x + y) as f32)),
        ("mostly undefined", draw(&|x, y| if (x + y).is_multiple_of(5) { noise(x, y) } else { f32::NAN })),
        ("infinities", draw(&|x, y| [f32::INFINITY, f32::NEG_INFINITY, 1.0, 2.0][(x * 3 + y) % 4])),
        ("extremes", draw(&|x, y| [f32::MAX, f32::MIN, f32::MIN_POSITIVE, 1e-45, -0.0][(x + 2 * y) % 5])),
        ("nothing", vec![f32::NAN; SIDE * SIDE]),
        ("constant", vec![7.0; SIDE * SIDE]),
        ("sky", sky(Kind::Noisy, 1, SIDE, SIDE)),
    ]
}

fn assert_bound<A: Arithmetic>() {
    for config in every_kind::<A>() {
        let bound = budget::total_rows(&config, SIDE);
        for (name, pixels) in hostile() {
            for slice in [1, 7, usize::MAX] {
                let mut room = Room::<A>::new(&config, SIDE, SIDE, 3);
                let mut segmenter = Segmenter::<A>::new(&config, SIDE, SIDE, room.memory()).expect("enough memory");
                assert_eq!(segmenter.work(), (0, bound));
                let mut polls = 0u64;
                let done = loop {
                    polls += 1;
                    let before = segmenter.work().0;
                    match segmenter.poll(slice, &mut SliceFrame(&pixels)) {
                        Ok(Progress::Working { .. }) => {}
                        Ok(Progress::Done(outcome)) => break Some(outcome),
                        Err(Error::NothingDefined { .. } | Error::Constant { .. }) => break None,
                        Err(error) => panic!("{name}: {error}"),
                    }
                    let rows = segmenter.work().0 - before;
                    assert!((1..=slice as u64).contains(&rows), "{name}: {rows} rows in a poll of {slice}");
                };
                assert!(segmenter.work().0 <= bound && polls <= bound, "{}, {name}, {config:?}", A::NAME);
                // Between two percentiles a single pixel is nothing either.
                let may_fail = matches!(name, "nothing" | "constant" | "one pixel");
                match done {
                    Some(outcome) => assert_eq!(outcome.work, segmenter.work().0),
                    None => assert!(may_fail, "{}, {name}, {config:?}", A::NAME),
                }
            }
        }
    }
}

#[test]
fn hostile_images_stay_within_the_budget() {
    assert_bound::<F32>();
    assert_bound::<Q24>();
    assert_bound::<Q11>();
}

/// The figures of `skyfront budget --scheme fast-marching` for the paper's frame: bounds, and no 2^32 among them.
#[test]
fn a_march_has_a_bound_of_its_own() {
    let config = Config::PAPER_F160.with_scheme(Scheme::FastMarching);
    assert_eq!(budget::passes(&config, Stage::March), 96);
    assert_eq!(budget::rows(&config, 300, Stage::March), 28_800);
    assert!(Stage::ALL.iter().all(|&stage| budget::passes(&config, stage) <= 96));
}
