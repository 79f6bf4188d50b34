//! What makes it fast changes nothing, or no more than is said: skipped tiles, wide vectors,
//! threads, the band, arrival times, and a start near the objects.

use skyfront::machine::Native;
use skyfront::pipeline::{Drive, Segmentation, segment_in};
use skyfront::planes::Room;
use skyfront_core::arithmetic::machine::Plain;
use skyfront_core::arithmetic::{Arithmetic, Bits, F32, Q11, Q24};
use skyfront_core::config::{Config, Rescale, Scheme, Start, Stop};
use skyfront_core::error::Error;
use skyfront_core::front::region::Regions;
use skyfront_core::front::scheme::{Evolve, Step};
use skyfront_core::front::stop::Change;
use skyfront_core::plane::sweep::{Band, Halo, ring_len};
use skyfront_core::plane::tiles::Tiles;
use skyfront_core::run::frame::{Frame, SliceFrame};
use skyfront_core::run::memory::flags_len;
use skyfront_core::run::segmenter::{Evolution, Segmenter};
use skyfront_core::simulate::{Kind, Sky};
use skyfront_workload::case::MOTIONS;

/// Every scheme that goes step by step.
fn schemes() -> impl Iterator<Item = Scheme> {
    let motions = MOTIONS.iter().filter(|motion| motion.start == Start::Frame);
    motions.map(|motion| motion.scheme).filter(|&scheme| scheme != Scheme::FastMarching)
}

/// No multiple of a tile in either direction.
const WIDTH: usize = 133;
const HEIGHT: usize = 75;

fn sky(kind: Kind, seed: u32, width: usize, height: usize) -> Vec<f32> {
    let mut sky = Sky::new(kind, seed, width, height);
    let mut pixels = vec![0.0; width * height];
    for (y, row) in pixels.chunks_exact_mut(width).enumerate() {
        let Ok(()) = sky.row(y, row);
    }
    pixels
}

fn faint(scheme: Scheme) -> Config {
    // With the paper's step SL with curvature bears a tenth of it.
    let nu = if scheme == Scheme::SlCurvature { 0.002 } else { 0.02 };
    Config { rescale: Rescale::R1 { alpha: 0.25 }, nu, ..Config::PAPER_F160 }.with_scheme(scheme)
}

fn banded(scheme: Scheme) -> Config {
    Config { band: Some(8.0), ..faint(scheme) }
}

fn run<A: Arithmetic>(config: &Config, pixels: &[f32], width: usize, threads: usize) -> Segmentation {
    let mut drive = Drive { threads, ..Drive::default() };
    segment_in::<A>(config, pixels, width, pixels.len() / width, &mut drive).expect("a good image")
}

fn differing(a: &Segmentation, b: &Segmentation) -> usize {
    a.labels.iter().zip(&b.labels).filter(|&(&a, &b)| (a > 0) != (b > 0)).count()
}

fn bits(run: &Segmentation) -> (u32, Vec<u32>, Vec<u32>, Vec<u32>) {
    let of = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect();
    (run.outcome.steps, of(&run.front), of(&run.convergence), run.labels.clone())
}

/// Moves a front to its end twice, with all tiles in every step and with active ones only, and
/// compares the planes and the sums of every step; the share of tiles that were skipped.
fn skipped<A: Arithmetic>(config: &Config, pixels: &[f32]) -> f64 {
    let mut room = Room::<A>::new(config, WIDTH, HEIGHT, 1);
    let mut segmenter = Segmenter::<A>::new(config, WIDTH, HEIGHT, room.memory()).expect("good parameters");
    while segmenter.evolution().is_none() {
        segmenter.poll(usize::MAX, &mut SliceFrame(pixels)).expect("a good image");
    }
    let evolution = segmenter.evolution().expect("the front is about to move");
    let Evolution { front, speed, tile_rows, scheme, rule, settle, max_steps, .. } = evolution;
    let mut all = front.to_vec();
    let mut rings = [vec![A::Cell::default(); ring_len(WIDTH, 11)], vec![A::Cell::default(); ring_len(WIDTH, 11)]];
    let mut all_flags = vec![0; flags_len(WIDTH, HEIGHT)];
    let mut some_flags = all_flags.clone();
    let (mut active, mut total) = (0, 0);
    for number in 0..max_steps {
        let step = Step { settle, change: Change::none(&rule), means: Regions::NONE.means };
        let (mut of_all, mut of_some) = (step, step);
        let [ring_all, ring_some] = &mut rings;
        let mut tiles = Tiles::new(&mut all_flags, WIDTH, tile_rows);
        tiles.wake();
        let mut band = Band { plane: &mut all, aux: speed, ring: ring_all, width: WIDTH, halo: Halo::NONE };
        scheme.advance(&mut band, &mut tiles, 0..HEIGHT, &mut of_all);
        let mut tiles = Tiles::new(&mut some_flags, WIDTH, tile_rows);
        if number == 0 {
            tiles.wake();
        }
        for row in 0..HEIGHT.div_ceil(tile_rows) {
            let columns = WIDTH.div_ceil(skyfront_core::arithmetic::vectors::COLUMNS);
            active += (0..columns).filter(|&column| tiles.is_active(row, column)).count();
            total += columns;
        }
        let mut band = Band { plane: front, aux: speed, ring: ring_some, width: WIDTH, halo: Halo::NONE };
        scheme.advance(&mut band, &mut tiles, 0..HEIGHT, &mut of_some);
        tiles.turn(&[], &[]);
        let same = all.iter().zip(front.iter()).all(|(a, b)| a.bits() == b.bits());
        let sums = [of_all, of_some].map(|step| (step.change.sum, step.change.crossings));
        assert!(same && sums[0] == sums[1], "{} {:?}, step {number}", A::NAME, config.scheme);
        if rule.at_rest(&of_all.change) {
            break;
        }
    }
    1.0 - f64::from(active as u32) / f64::from(total as u32)
}

#[test]
fn skipping_tiles_at_rest_changes_no_bit() {
    for (seed, kind) in [(1, Kind::Bright), (2, Kind::Stars)] {
        let pixels = sky(kind, seed, WIDTH, HEIGHT);
        for scheme in schemes() {
            skipped::<F32<Native>>(&faint(scheme), &pixels);
            let share = skipped::<F32<Native>>(&banded(scheme), &pixels);
            // How many is a matter of the benchmarks; here the comparison must not be empty.
            assert!(share > 0.0, "{scheme:?}, {kind:?}: no tile was skipped");
            skipped::<Q24>(&banded(scheme), &pixels);
            if !scheme.has_two_fronts() {
                skipped::<Q11>(&banded(scheme), &pixels);
            }
        }
    }
}

#[test]
fn threads_and_vectors_change_no_bit() {
    let pixels = sky(Kind::Bright, 3, WIDTH, HEIGHT);
    for scheme in schemes() {
        for config in [faint(scheme), banded(scheme), Config { stop: Stop::Rate, ..banded(scheme) }] {
            let one = bits(&run::<F32<Native>>(&config, &pixels, WIDTH, 1));
            assert!(one == bits(&run::<F32<Plain>>(&config, &pixels, WIDTH, 1)), "plain code, {scheme:?}");
            for threads in [2, 3, 64] {
                let many = bits(&run::<F32<Native>>(&config, &pixels, WIDTH, threads));
                assert!(one == many, "{threads} threads, {scheme:?}, band {:?}, {:?}", config.band, config.stop);
            }
        }
        // Sixteen bits hold one front.
        let q11 = |threads| bits(&run::<Q11>(&banded(scheme), &pixels, WIDTH, threads));
        assert!(scheme.has_two_fronts() || q11(1) == q11(4), "q11, {scheme:?}");
    }
}

#[test]
fn a_band_changes_few_pixels() {
    for kind in [Kind::Bright, Kind::Noisy, Kind::Stars] {
        let pixels = sky(kind, 4, 200, 160);
        for scheme in [Scheme::Fd, Scheme::Sl] {
            for rescale in [Rescale::R1 { alpha: 0.25 }, Config::PAPER_F160.rescale] {
                let paper = Config { rescale, ..Config::PAPER_F160 }.with_scheme(scheme);
                let narrow = Config { band: Some(8.0), ..paper };
                let (a, b) =
                    (run::<F32<Native>>(&paper, &pixels, 200, 1), run::<F32<Native>>(&narrow, &pixels, 200, 1));
                assert!(differing(&a, &b) <= pixels.len() / 500, "{kind:?} {scheme:?}: {}", differing(&a, &b));
            }
        }
    }
}

#[test]
fn the_longest_step_finds_the_same_objects_in_half_the_steps() {
    for kind in [Kind::Bright, Kind::Noisy, Kind::Stars] {
        let pixels = sky(kind, 4, 200, 160);
        for band in [None, Some(8.0)] {
            let paper = Config { band, ..Config::PAPER_F160 };
            let long = Config { dt: 0.5 * paper.dx, ..paper };
            let (a, b) = (run::<F32<Native>>(&paper, &pixels, 200, 1), run::<F32<Native>>(&long, &pixels, 200, 1));
            assert!(differing(&a, &b) <= pixels.len() / 1000, "{kind:?} {band:?}: {}", differing(&a, &b));
            let (a, b) = (a.outcome.steps, b.outcome.steps);
            assert!(b <= a / 2 + 10, "{kind:?} {band:?}: {b} steps, {a} of the paper's");
        }
    }
}

#[test]
fn arrival_times_give_the_front_of_the_time_steps() {
    for kind in [Kind::Bright, Kind::Noisy] {
        let pixels = sky(kind, 5, 200, 160);
        let steps = run::<F32<Native>>(&faint(Scheme::Fd), &pixels, 200, 1);
        // The front of the time steps when it came to rest is the one of that time.
        let t_max = steps.outcome.steps as f32 * 0.025;
        let config = Config { t_max, ..faint(Scheme::FastMarching) };
        let times = run::<F32<Native>>(&config, &pixels, 200, 1);
        assert!(differing(&steps, &times) <= pixels.len() / 250, "{kind:?}: {}", differing(&steps, &times));
        assert!(times.outcome.mask_pixels > 0);
        assert!(bits(&times) == bits(&run::<F32<Plain>>(&config, &pixels, 200, 1)), "plain code");
        let q24 = run::<Q24>(&config, &pixels, 200, 1);
        assert!(differing(&q24, &times) <= pixels.len() / 1000, "{kind:?}, q24: {}", differing(&q24, &times));
        let narrow = segment_in::<Q11>(&Config { band: Some(8.0), ..config }, &pixels, 200, 160, &mut Drive::default());
        assert!(matches!(narrow, Err(Error::Arithmetic { .. })), "16 bits hold no times");
    }
}

#[test]
fn a_start_near_the_objects_finds_the_same_objects() {
    let pixels = sky(Kind::Bright, 6, 200, 160);
    for scheme in [Scheme::Fd, Scheme::Sl, Scheme::FastMarching] {
        let frame = Config { band: Some(8.0), ..Config::PAPER_F160.with_scheme(scheme) };
        let near = Config { start: Start::Threshold { margin: 4.0 }, ..frame };
        let (a, b) = (run::<F32<Native>>(&frame, &pixels, 200, 1), run::<F32<Native>>(&near, &pixels, 200, 1));
        assert!(b.outcome.sources > 0 && b.outcome.steps < a.outcome.steps);
        assert!(differing(&a, &b) <= pixels.len() / 500, "{scheme:?}: {}", differing(&a, &b));
    }
}

/// The front from the frame cannot get into a closed ring; the front near the objects is inside
/// from the start. That is where the two differ.
#[test]
fn a_ring_shuts_out_the_front_from_the_frame_only() {
    let (side, middle) = (100usize, 50.0f32);
    let distance = |index: usize| ((index % side) as f32 + 0.5 - middle).hypot((index / side) as f32 + 0.5 - middle);
    let pixels: Vec<f32> = (0..side * side).map(|index| f32::from((distance(index) - 25.0).abs() < 3.0)).collect();
    let frame = Config { band: Some(8.0), ..Config::PAPER_F160 };
    let near = Config { start: Start::Threshold { margin: 4.0 }, ..frame };
    let (a, b) = (run::<F32<Native>>(&frame, &pixels, side, 1), run::<F32<Native>>(&near, &pixels, side, 1));
    // The ring lies between 22 and 28; its edges are left to the schemes.
    for index in 0..side * side {
        let (from_frame, from_near) = (a.labels[index] > 0, b.labels[index] > 0);
        match distance(index) {
            r if r < 18.0 => assert!(from_frame && !from_near, "pixel {index} is empty sky in the ring"),
            r if r > 32.0 => assert!(!from_frame && !from_near, "pixel {index} is empty sky outside"),
            r if (24.0..26.0).contains(&r) => assert!(from_frame && from_near, "pixel {index} is the ring"),
            _ => {}
        }
    }
}
