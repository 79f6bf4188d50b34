//! The filtered scheme of second order: what it promises of every step, its answers at kinks, and the reference.

use skyfront::crosscheck::{crosscheck, table};
use skyfront::pipeline::{Drive, segment};
use skyfront_core::arithmetic::{Arithmetic, Cell, F32, Q11, Q24, Real};
use skyfront_core::config::{Config, Rescale, Scheme};
use skyfront_core::error::Error;
use skyfront_core::front::region::Regions;
use skyfront_core::front::scheme::{Evolve, FdFiltered, Step};
use skyfront_core::front::settle::Settle;
use skyfront_core::front::stop::{Change, StopRule};
use skyfront_core::plane::sweep::{Band, Halo};
use skyfront_core::plane::tiles::{Tiles, flags_len, rows_of_tile};
use skyfront_core::run::memory::ring_cells;
use skyfront_core::simulate::Kind;
use skyfront_tests::evolve::Front;
use skyfront_tests::runs::sky;

const SIDE: usize = 96;

fn plain() -> Config {
    Config::PAPER_F160.with_scheme(Scheme::FdFiltered)
}

/// A step of arithmetic `A` on any front and speed.
fn step<A: Arithmetic>(config: &Config, front: &[f32], speed: &[f32], width: usize) -> Vec<f32> {
    let height = front.len() / width;
    let mut plane: Vec<_> = front.iter().map(|&v| A::to_level(A::Real::of(v))).collect();
    let speed: Vec<_> = speed.iter().map(|&g| A::to_pixel(A::Real::of(g))).collect();
    let rule = StopRule::<A>::new(config, 1.0);
    let mut step = Step { settle: Settle::new(None), change: Change::none(&rule), means: Regions::NONE.means };
    let scheme = <FdFiltered<A> as Evolve<A>>::new(config, 1.0).expect("its own scheme");
    let mut ring = vec![A::Cell::BLANK; ring_cells(width, false)];
    let mut flags = vec![0; flags_len(width, height)];
    let mut tiles = Tiles::new(&mut flags, width, rows_of_tile(height));
    tiles.wake();
    let mut band = Band { plane: &mut plane, aux: &speed, ring: &mut ring, width, halo: Halo::NONE };
    scheme.advance(&mut band, &mut tiles, 0..height, &mut step);
    plane.into_iter().map(|cell| A::level(cell).to_f32()).collect()
}

/// At the longest step allowed, on fronts and speeds without any smoothness: a new value lies between the old one and
/// the least of its neighbours, but for the rounding of a step of the arithmetic.
fn stays_within<A: Arithmetic>(rounding: f32) {
    let (width, height) = (37, 29);
    let config = Config { dt: plain().dx * 0.4, ..plain() };
    let mut seed = 11u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 24) as f32
    };
    let speed: Vec<f32> = (0..width * height).map(|_| random()).collect();
    let mut front: Vec<f32> = (0..width * height).map(|_| 4.0 * random() - 2.0).collect();
    let mut moved = 0;
    for number in 0..50 {
        let next = step::<A>(&config, &front, &speed, width);
        for (at, (&old, &new)) in front.iter().zip(&next).enumerate() {
            let (x, y) = (at % width, at / width);
            let near = [(x.saturating_sub(1), y), (x + 1, y), (x, y.saturating_sub(1)), (x, y + 1)];
            let value = |(x, y): (usize, usize)| front[y.min(height - 1) * width + x.min(width - 1)];
            let least = near.map(value).into_iter().fold(old, f32::min);
            assert!(new <= old + rounding && new >= least - rounding, "{} {least} {old} {new}, {number}", A::NAME);
            moved += usize::from(new < old);
        }
        front = next;
    }
    assert!(moved > 1000, "{}: hardly anything moved", A::NAME);
}

#[test]
fn no_step_moves_back_or_makes_a_new_extreme() {
    stays_within::<F32>(5e-7);
    stays_within::<Q24>(3e-7);
    stays_within::<Q11>(0.5 / 1024.0);
}

/// A plane is flat in every sense: the slopes of both schemes are the same there, and it travels at the speed of its
/// gradient, on axes and diagonals. Along a roof the neighbours lie lower on both sides, and the step is that of `fd`.
#[test]
fn planes_travel_exactly_and_ridges_as_in_fd() {
    let config = plain();
    for (a, b) in [(1.0, 0.0), (0.0, -1.0), (0.6, 0.8), (-0.8, 0.6)] {
        let mut plane = Front::new(config, 61, 61, |x, y| a * x + b * y);
        plane.until(1.0);
        // Far from the border, which repeats its pixels.
        for (x, y) in [(30, 30), (36, 28), (25, 33)] {
            let place = |i: usize| (f64::from(i as u32) - 30.0) * 0.1;
            let exact = a * place(x) + b * place(y) - 1.0;
            let found = f64::from(plane.values[y * 61 + x]);
            assert!((found - exact).abs() < 1e-5, "({a}, {b}) at ({x}, {y}): {found}, not {exact}");
        }
    }
    let roof = |scheme| {
        let mut roof = Front::new(config.with_scheme(scheme), 61, 61, |x, _| 1.0 - x.abs());
        roof.step();
        roof.values[30 * 61 + 30]
    };
    assert_eq!(roof(Scheme::FdFiltered), roof(Scheme::Fd));
    assert!(roof(Scheme::Fd) < 0.97);
}

/// Two discs 2 apart grow into each other: u = max(min(r1, r2) - t, 0) - 1, with a kink between them. On the whole the
/// filtered scheme is much nearer to it than `fd`; at the kink, where it must be of first order, it is as near.
#[test]
fn kinks_stay_where_they_belong() {
    let nearest = |x: f64, y: f64| (x - 2.0).hypot(y).min((x + 2.0).hypot(y));
    let errors = |scheme| {
        let (width, height) = (101, 61);
        let mut front = Front::new(plain().with_scheme(scheme), width, height, |x, y| nearest(x, y) - 1.0);
        front.until(1.5);
        let (mut all, mut kink) = (0.0, 0.0f64);
        for (at, &u) in front.values.iter().enumerate() {
            let place = |i: usize, n: usize| (i as f64 - (n as f64 - 1.0) / 2.0) * 0.1;
            let (x, y) = (place(at % width, width), place(at / width, height));
            // The least value is that of the middles, from where it spreads.
            let error = (f64::from(u) - ((nearest(x, y) - 1.5).max(0.0) - 1.0)).abs();
            // The border repeats its pixels, and that is felt up to 1.5 from it.
            all += if x.abs() < 3.5 && y.abs() < 1.5 { error } else { 0.0 };
            kink = if x.abs() < 0.05 && y.abs() < 1.5 { kink.max(error) } else { kink };
        }
        (all, kink)
    };
    let (filtered, first) = (errors(Scheme::FdFiltered), errors(Scheme::Fd));
    println!("{filtered:?} {first:?}");
    assert!(filtered.0 < 0.4 * first.0 && filtered.1 <= 1.1 * first.1, "{filtered:?}, fd {first:?}");
}

#[test]
fn the_reference_agrees() {
    // r1 lifts the noise to hundreds of sources of a pixel: one that 16 bits put elsewhere moves its centroid too far.
    let faint = Config { rescale: Rescale::R1 { alpha: 0.25 }, ..plain() };
    for (kind, seed) in [(Kind::Bright, 8), (Kind::Noisy, 9)] {
        let pixels = sky(kind, seed, SIDE, SIDE);
        for (config, judged) in [(plain(), 3), (faint, 2)] {
            let checks = crosscheck(&config, &pixels, SIDE, SIDE, |most| most).expect("a sky");
            assert_eq!(checks.len(), 3, "every arithmetic serves it");
            let checks = &checks[..judged];
            assert!(checks.iter().all(|check| check.failures().is_empty()), "{}", table("fd-filtered", checks));
        }
    }
}

/// The outlines are those of the first-order scheme: it is the same equation, and both rest at the same edges.
#[test]
fn it_finds_what_fd_finds() {
    let pixels = sky(Kind::Bright, 8, SIDE, SIDE);
    let run = |scheme| {
        let config = Config { rescale: Rescale::R1 { alpha: 0.25 }, ..plain().with_scheme(scheme) };
        segment(&config, &pixels, SIDE, SIDE, &mut Drive::default()).expect("a sky")
    };
    let (filtered, first) = (run(Scheme::FdFiltered), run(Scheme::Fd));
    let apart = filtered.labels.iter().zip(&first.labels).filter(|&(&a, &b)| (a > 0) != (b > 0)).count();
    println!("{} steps, fd {}, {apart} pixels apart", filtered.outcome.steps, first.outcome.steps);
    assert!(filtered.outcome.sources > 3 && apart <= SIDE * SIDE / 100, "{apart} pixels, {:?}", filtered.outcome);
}

#[test]
fn a_step_beyond_its_bound_is_refused() {
    let config = Config { dt: plain().dx * 0.41, ..plain() };
    assert!(matches!(config.validate::<F32>(), Err(Error::Parameter { name: "dt", .. })));
    assert_eq!(Config { dt: plain().dx * 0.4, ..plain() }.validate::<F32>(), Ok(()));
}
