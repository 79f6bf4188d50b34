//! Time of every row kernel, beside what the machine can do at best: criterion's throughput is in
//! pixels and steps a second.
//!
//! `cargo bench -p skyfront-benches [-- FILTER]`. Every group has the limits, measured in the same run on
//! planes of the same size: a pixel copied, two planes read and one written, as a step of the front
//! does, and a square root of every pixel.
//!
//! A sample is the shortest of its repetitions: what else runs on the machine only ever adds to a time, and more to that
//! of a kernel than to that of a limit.

use criterion::measurement::WallTime;
use criterion::{Bencher, BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use skyfront::machine::Native;
use skyfront_core::arithmetic::machine::{Machine, Task};
use skyfront_core::arithmetic::{Arithmetic, F32, Q11, Q24, Real};
use skyfront_core::config::{Config, Scheme};
use skyfront_core::front::edge::{EdgeDetector, GradientRange};
use skyfront_core::front::march::March;
use skyfront_core::front::region::Regions;
use skyfront_core::front::scheme::{AnyScheme, Evolve, Step};
use skyfront_core::front::settle::Settle;
use skyfront_core::front::stop::{Change, StopRule};
use skyfront_core::image::filter::Heat;
use skyfront_core::plane::sweep::{Band, Halo, Kernel, advance, ring_len};
use skyfront_core::plane::tiles::{Tiles, flags_len, rows_of_tile};
use std::hint::black_box;
use std::time::{Duration, Instant};

const SIDE: usize = 512;
const PIXELS: usize = SIDE * SIDE;
/// Half-width of the band, pixels.
const BAND: f32 = 8.0;

type Group<'a> = BenchmarkGroup<'a, WallTime>;

struct Roots<'a>(&'a [f32], &'a mut [f32]);

impl Task for Roots<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.iter().zip(self.1).for_each(|(x, root)| *root = Native::sqrt(*x));
    }
}

/// What costs no more than to read and write.
struct Sums<'a>(&'a [f32], &'a [f32], &'a mut [f32]);

impl Task for Sums<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.iter().zip(self.1).zip(self.2).for_each(|((x, y), sum)| *sum = x + y);
    }
}

/// Takes the shortest time of every sample's repetitions.
fn shortest(b: &mut Bencher<'_>, mut time: impl FnMut() -> Duration) {
    b.iter_custom(|repetitions| {
        let shortest = (0..repetitions).map(|_| time()).min().unwrap_or_default();
        shortest * u32::try_from(repetitions).expect("fewer than 2^32 repetitions")
    });
}

/// The time of one call.
fn timed(call: impl FnOnce()) -> Duration {
    let started = Instant::now();
    call();
    started.elapsed()
}

/// A group of benchmarks, which begins with the limits.
fn group<'a>(criterion: &'a mut Criterion, name: &str) -> Group<'a> {
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(PIXELS as u64));
    let (from, mut to) = (vec![2.0f32; PIXELS], vec![0.0f32; PIXELS]);
    group.bench_function("limit: copy", |b| shortest(b, || timed(|| to.copy_from_slice(black_box(&from)))));
    let speed = vec![1.0f32; PIXELS];
    group.bench_function("limit: two planes into one", |b| {
        let mut add = || {
            let rows = from.chunks(SIDE).zip(speed.chunks(SIDE)).zip(to.chunks_mut(SIDE));
            rows.for_each(|((front, speed), to)| Native::wide(Sums(black_box(front), speed, to)));
        };
        shortest(b, || timed(&mut add));
    });
    group.bench_function("limit: square root", |b| {
        let mut root = || {
            let rows = from.chunks(SIDE).zip(to.chunks_mut(SIDE));
            rows.for_each(|(from, to)| Native::wide(Roots(black_box(from), to)));
        };
        shortest(b, || timed(&mut root));
    });
    group
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

/// A step of a scheme over all tiles.
fn step<A: Arithmetic>(group: &mut Group<'_>, name: &str, scheme: Scheme, band: Option<f32>) {
    let config = Config { nu: 0.05, band, ..Config::PAPER_F160 }.with_scheme(scheme);
    let unit = if band.is_some() { (SIDE - 4) as f32 / 2.0 } else { 1.0 };
    let evolve = AnyScheme::<A>::new(&config, unit).expect("every scheme is there");
    let rule = StopRule::new(&config, unit);
    let (start, speed) = planes::<A>();
    let mut ring = vec![A::Cell::default(); ring_len(SIDE, evolve.window())];
    let mut flags = vec![0; flags_len(SIDE, SIDE)];
    let mut step = Step { settle: Settle::new(band), change: Change::none(&rule), means: Regions::NONE.means };
    let mut front = start.clone();
    let mut advance = |front: &mut [A::Cell]| {
        let mut tiles = Tiles::new(&mut flags, SIDE, rows_of_tile(SIDE));
        tiles.wake();
        let mut band = Band { plane: front, aux: &speed, ring: &mut ring, width: SIDE, halo: Halo::NONE };
        evolve.advance(&mut band, &mut tiles, 0..SIDE, &mut step);
    };
    // From the same front every time, and in the same memory: after thousands of steps it would be flat, and its
    // slopes subnormal numbers.
    group.bench_function(name, |b| {
        shortest(b, || {
            front.copy_from_slice(&start);
            timed(|| advance(&mut front))
        });
    });
}

fn schemes(criterion: &mut Criterion) {
    for (name, scheme) in [
        ("fd", Scheme::Fd),
        ("fd-filtered", Scheme::FdFiltered),
        ("fd-curvature", Scheme::FdCurvature),
        ("sl", Scheme::Sl),
        ("sl-curvature", Scheme::SlCurvature),
    ] {
        let mut group = group(criterion, name);
        step::<F32<Native>>(&mut group, "f32", scheme, None);
        step::<F32<Native>>(&mut group, "f32, band", scheme, Some(BAND));
        step::<Q24>(&mut group, "q24, band", scheme, Some(BAND));
        step::<Q11>(&mut group, "q11, band", scheme, Some(BAND));
    }
}

/// A sweep over the image plane.
fn sweep<K: Kernel<F32<Native>, 3>>(group: &mut Group<'_>, name: &str, mut kernel: K) {
    let (_, mut image) = planes::<F32<Native>>();
    let mut ring = vec![0.0; ring_len(SIDE, 3)];
    group.bench_function(name, |b| {
        let mut pass = || {
            let mut band = Band { plane: &mut image, aux: &[], ring: &mut ring, width: SIDE, halo: Halo::NONE };
            advance::<F32<Native>, K, 3>(&mut kernel, &mut band, 0..SIDE);
        };
        shortest(b, || timed(&mut pass));
    });
}

fn image(criterion: &mut Criterion) {
    let (config, range) = (Config::PAPER_F160, GradientRange { least: 0.0, greatest: 2.0 });
    let mut group = group(criterion, "image");
    sweep(&mut group, "heat filter", Heat::new(&config));
    sweep(&mut group, "gradient", GradientRange::none());
    sweep(&mut group, "edge detector", EdgeDetector::new(&config, &range));
}

/// Arrival times of a whole frame.
fn march(criterion: &mut Criterion) {
    type A = F32<Native>;
    let (_, mut speed) = planes::<A>();
    speed.iter_mut().for_each(|g| *g = 0.5 + 0.5 * *g);
    let mut front = vec![1.0f32; PIXELS];
    group(criterion, "fast-marching").bench_function("f32, all pixels", |b| {
        let mut march = || {
            for (index, cell) in front.iter_mut().enumerate() {
                let (x, y) = (index % SIDE, index / SIDE);
                *cell = if x.min(y).min(SIDE - 1 - x.max(y)) < 2 { -0.5 } else { 1.0 };
            }
            let mut march = March::new(4.0 * SIDE as f32);
            front.chunks_exact_mut(SIDE).for_each(March::seed_row::<A>);
            (0..SIDE).for_each(|y| march.sow_row::<A>(&mut front, &speed, SIDE, y));
            while march.advance::<A>(&mut front, &speed, SIDE, PIXELS) {}
        };
        shortest(b, || timed(&mut march));
    });
}

/// Some seconds for every group.
fn short() -> Criterion {
    let second = Duration::from_secs(1);
    Criterion::default().sample_size(20).warm_up_time(second / 4).measurement_time(second).without_plots()
}

criterion_group!(name = kernels; config = short(); targets = schemes, image, march);
criterion_main!(kernels);
