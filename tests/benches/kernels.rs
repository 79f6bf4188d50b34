//! Nanoseconds per pixel and step of every row kernel, beside what the machine can do at best.
//!
//! `cargo bench -p skyfront-tests --bench kernels`. Times are processor time of this thread, the
//! least of several rounds, so that a busy machine disturbs them little. The limits are measured
//! in the same run: one square root a pixel, and one pixel copied.

use skyfront::machine::Native;
use skyfront_core::arithmetic::{Arithmetic, F32, Q11, Q24, Real};
use skyfront_core::config::{Config, Scheme};
use skyfront_core::edge::GradientRange;
use skyfront_core::filter::Heat;
use skyfront_core::machine::{Machine, Task};
use skyfront_core::march::March;
use skyfront_core::region::Regions;
use skyfront_core::scheme::{AnyScheme, Evolve, Step};
use skyfront_core::settle::Settle;
use skyfront_core::stop::{Change, StopRule};
use skyfront_core::sweep::{Band, Halo, advance, ring_len};
use skyfront_core::tiles::{Tiles, flags_len, rows_of_tile};
use std::hint::black_box;
use std::time::Instant;

const SIDE: usize = 512;
const PIXELS: usize = SIDE * SIDE;
const ROUNDS: usize = 9;

/// Processor time of this thread in nanoseconds; wall time where the system does not tell it.
fn now(start: Instant) -> f64 {
    let spent = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let spent = spent.and_then(|text| text.split(' ').next()?.parse().ok());
    spent.unwrap_or_else(|| start.elapsed().as_nanos() as f64)
}

/// The least time of a round of `steps` steps, in nanoseconds per pixel and step.
fn least(steps: usize, mut round: impl FnMut()) -> f64 {
    let start = Instant::now();
    (0..ROUNDS)
        .map(|_| {
            let before = now(start);
            (0..steps).for_each(|_| round());
            (now(start) - before) / (steps * PIXELS) as f64
        })
        .fold(f64::INFINITY, f64::min)
}

struct Roots<'a>(&'a [f32], &'a mut [f32]);

impl Task for Roots<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.iter().zip(self.1).for_each(|(x, root)| *root = Native::sqrt(*x));
    }
}

fn limits() -> (f64, f64) {
    let (from, mut to) = (vec![2.0f32; PIXELS], vec![0.0f32; PIXELS]);
    let roots = least(20, || {
        for (from, to) in from.chunks(SIDE).zip(to.chunks_mut(SIDE)) {
            Native::wide(Roots(black_box(from), to));
        }
    });
    let copy = least(20, || to.copy_from_slice(black_box(&from)));
    (roots, copy)
}

/// A front plane with slopes everywhere and a speed plane, both of cells.
fn planes<A: Arithmetic>() -> (Vec<A::Cell>, Vec<A::Cell>) {
    let mut seed = 7u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 24) as f32
    };
    let front = (0..PIXELS).map(|i| A::to_level(A::Real::of((i % SIDE) as f32 / 64.0 - 4.0 + random())));
    let front: Vec<_> = front.collect();
    (front, (0..PIXELS).map(|_| A::to_pixel(A::Real::of(random()))).collect())
}

fn scheme<A: Arithmetic>(scheme: Scheme, band: Option<f32>) -> f64 {
    let config = Config { nu: 0.05, band, ..Config::PAPER_F160 }.with_scheme(scheme);
    let unit = if band.is_some() { (SIDE - 4) as f32 / 2.0 } else { 1.0 };
    let evolve = AnyScheme::<A>::new(&config, unit).expect("every scheme is there");
    let rule = StopRule::new(&config, unit);
    let (mut front, speed) = planes::<A>();
    let mut ring = vec![A::Cell::default(); ring_len(SIDE, evolve.window())];
    let mut flags = vec![0; flags_len(SIDE, SIDE)];
    let mut step = Step { settle: Settle::new(band), change: Change::none(&rule), means: Regions::NONE.means };
    least(4, || {
        let mut tiles = Tiles::new(&mut flags, SIDE, rows_of_tile(SIDE));
        tiles.wake();
        let mut band = Band { plane: &mut front, aux: &speed, ring: &mut ring, width: SIDE, halo: Halo::NONE };
        evolve.advance(&mut band, &mut tiles, 0..SIDE, &mut step);
    })
}

fn image_kernels() -> [(&'static str, f64); 2] {
    type A = F32<Native>;
    let (mut image, _) = planes::<A>();
    let mut ring = vec![0.0; ring_len(SIDE, 3)];
    let mut heat = Heat::<A>::new(&Config::PAPER_F160);
    let mut gradient = GradientRange::<A>::none();
    let mut band = Band { plane: &mut image, aux: &[], ring: &mut ring, width: SIDE, halo: Halo::NONE };
    let heat = least(10, || advance::<A, _, 3>(&mut heat, &mut band, 0..SIDE));
    let gradient = least(10, || advance::<A, _, 3>(&mut gradient, &mut band, 0..SIDE));
    [("heat filter", heat), ("gradient", gradient)]
}

fn march() -> f64 {
    type A = F32<Native>;
    let (_, mut speed) = planes::<A>();
    speed.iter_mut().for_each(|g| *g = 0.5 + 0.5 * *g);
    let mut front = vec![1.0f32; PIXELS];
    least(1, || {
        for (index, cell) in front.iter_mut().enumerate() {
            let (x, y) = (index % SIDE, index / SIDE);
            *cell = if x.min(y).min(SIDE - 1 - x.max(y)) < 2 { -0.5 } else { 1.0 };
        }
        let mut march = March::new(4.0 * SIDE as f32);
        front.chunks_exact_mut(SIDE).for_each(March::seed_row::<A>);
        (0..SIDE).for_each(|y| march.sow_row::<A>(&mut front, &speed, SIDE, y));
        while march.advance::<A>(&mut front, &speed, SIDE, PIXELS) {}
    })
}

fn main() {
    let (roots, copy) = limits();
    println!("{SIDE} x {SIDE} pixels, ns per pixel and step");
    println!("{:24} {roots:8.3}\n{:24} {copy:8.3}", "limit: square root", "limit: copy");
    let limit = roots + copy;
    println!("{:24} {:>8} {:>16}", "kernel", "time", "limits together");
    let row = |name: &str, time: f64| println!("{name:24} {time:8.3} {:15.1}x", time / limit);
    for (name, which) in [
        ("fd", Scheme::Fd),
        ("fd-curvature", Scheme::FdCurvature),
        ("sl", Scheme::Sl),
        ("sl-curvature", Scheme::SlCurvature),
    ] {
        row(&format!("{name} f32"), scheme::<F32<Native>>(which, None));
        row(&format!("{name} f32, band"), scheme::<F32<Native>>(which, Some(8.0)));
        row(&format!("{name} q24, band"), scheme::<Q24>(which, Some(8.0)));
        row(&format!("{name} q11, band"), scheme::<Q11>(which, Some(8.0)));
    }
    image_kernels().into_iter().for_each(|(name, time)| row(name, time));
    row("fast marching, in all", march());
}
