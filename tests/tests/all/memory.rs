//! A run takes the memory that was stated, and nothing beyond.

use skyfront::planes::Room;
use skyfront_core::arithmetic::{Arithmetic, Cell, F32, Q11, Q24};
use skyfront_core::config::{Config, Scheme, Start};
use skyfront_core::error::Error;
use skyfront_core::run::frame::SliceFrame;
use skyfront_core::run::memory::{self, Memory, SEGMENTER_BYTES, catalogue_room};
use skyfront_core::run::outcome::Progress;
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::simulate::Kind;
use skyfront_core::sources::catalog::{Source, room_for};
use skyfront_tests::runs::{every_kind, sky};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell as Counter;

/// The system's memory, with a count of what this thread takes.
struct Counted;

thread_local! {
    static TAKEN: Counter<usize> = const { Counter::new(0) };
}

// SAFETY: every call is passed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        TAKEN.with(|taken| taken.set(taken.get() + layout.size()));
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the pointer came from `System.alloc` with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTED: Counted = Counted;

const SIDE: usize = 300;

/// Allocates what is stated for the paper's frame and runs in it; all bytes, the segmenter's included.
fn run_in_what_is_stated<A: Arithmetic>(config: &Config) -> usize {
    let pixels = sky(Kind::Bright, 160, SIDE, SIDE);
    let sources = catalogue_room(SIDE, SIDE, A::Cell::BYTES, false);
    let stated = memory::bytes(SIDE, SIDE, A::Cell::BYTES, false, sources);

    let before = TAKEN.with(Counter::get);
    let mut room = Room::<A>::full_of(0xA5A5, config, SIDE, SIDE, sources);
    assert_eq!(TAKEN.with(Counter::get) - before, stated, "what was allocated is what was stated");
    let mut segmenter = Segmenter::<A>::new(config, SIDE, SIDE, room.memory()).expect("it is enough");
    let outcome = loop {
        if let Progress::Done(outcome) = segmenter.poll(SIDE, &mut SliceFrame(&pixels)).expect("a sky") {
            break outcome;
        }
    };
    assert_eq!(TAKEN.with(Counter::get) - before, stated, "a run allocates nothing");
    println!("{}: {stated} bytes for {sources} sources, {} of state", A::NAME, size_of_val(&segmenter));
    assert!(outcome.sources > 0 && outcome.catalogued == outcome.sources, "{outcome:?}");
    stated + size_of_val(&segmenter)
}

const BANDED: Config = Config { band: Some(8.0), ..Config::PAPER_F160 };
const NEAR: Config = Config { start: Start::Threshold { margin: 4.0 }, ..BANDED };

/// 379 200 bytes at most, well below the 393 216 of 384 KiB.
#[test]
fn the_papers_frame_in_sixteen_bits_runs_in_384_kib() {
    for config in [BANDED, NEAR] {
        let all = run_in_what_is_stated::<Q11>(&config);
        assert!(all <= 4 * SIDE * SIDE + 64 * SIDE, "{all} bytes, {config:?}");
    }
}

#[test]
fn the_papers_frame_in_32_bits_marches_and_steps_in_twice_the_planes() {
    for config in [Config::PAPER_F160, BANDED, NEAR, BANDED.with_scheme(Scheme::FastMarching)] {
        for all in [run_in_what_is_stated::<F32>(&config), run_in_what_is_stated::<Q24>(&config)] {
            assert!(all <= 8 * SIDE * SIDE + 64 * SIDE, "{all} bytes, {config:?}");
        }
    }
}

fn assert_bounds<A: Arithmetic>() {
    for width in [300, 1000, 4096] {
        for sl_curvature in [false, true] {
            let cell = A::Cell::BYTES;
            let sources = catalogue_room(width, 300, cell, sl_curvature);
            let all = memory::bytes(width, 300, cell, sl_curvature, sources) + SEGMENTER_BYTES;
            assert!(all <= 2 * cell * width * 300 + 64 * width, "{}: {width} columns", A::NAME);
        }
    }
    assert!(size_of::<Segmenter<'_, A>>() <= SEGMENTER_BYTES, "{}: {}", A::NAME, size_of::<Segmenter<'_, A>>());
}

#[test]
fn two_cells_a_pixel_and_64_bytes_a_column_hold_everything() {
    assert_bounds::<F32>();
    assert_bounds::<Q24>();
    assert_bounds::<Q11>();
}

#[test]
fn one_element_less_is_refused_by_name() {
    for config in every_kind::<Q24>() {
        let mut room = Room::<Q24>::new(&config, 20, 10, 4);
        let Memory { image, front, ring, tiles, samples, counts, sources } = room.memory();
        let refused = |result: Result<Segmenter<'_, Q24>, Error>| match result {
            Err(Error::Length { name, given, needed }) => {
                assert_eq!(given + 1, needed);
                name
            }
            other => panic!("{other:?}"),
        };
        let (image_less, _) = image.split_at_mut(199);
        let memory = Memory { image: image_less, front, ring, tiles, samples, counts, sources };
        assert_eq!(refused(Segmenter::new(&config, 20, 10, memory)), "the image plane");
        let (front_less, _) = front.split_at_mut(199);
        let memory = Memory { image, front: front_less, ring, tiles, samples, counts, sources };
        assert_eq!(refused(Segmenter::new(&config, 20, 10, memory)), "the front plane");
        let less = ring.len() - 1;
        let (ring_less, _) = ring.split_at_mut(less);
        let memory = Memory { image, front, ring: ring_less, tiles, samples, counts, sources };
        assert_eq!(refused(Segmenter::new(&config, 20, 10, memory)), "the ring of old rows");
        let (samples_less, _) = samples.split_at_mut(19);
        let memory = Memory { image, front, ring, tiles, samples: samples_less, counts, sources };
        assert_eq!(refused(Segmenter::new(&config, 20, 10, memory)), "the sample row");
    }
}

#[test]
fn a_catalogue_may_be_a_heapless_vector() {
    const SIDE: usize = 64;
    let config = Config { t_max: 3.0, ..Config::PAPER_F160 }.with_scheme(Scheme::Sl);
    let pixels = sky(Kind::Stars, 1, SIDE, SIDE);
    let mut room = Room::<F32>::new(&config, SIDE, SIDE, 0);
    let mut catalogue: heapless::Vec<Source, 8> = room_for();
    let memory = Memory { sources: &mut catalogue, ..room.memory() };
    let mut segmenter = Segmenter::<F32>::new(&config, SIDE, SIDE, memory).expect("enough memory");
    let outcome = loop {
        if let Progress::Done(outcome) = segmenter.poll(SIDE, &mut SliceFrame(&pixels)).expect("a sky") {
            break outcome;
        }
    };
    catalogue.truncate(outcome.catalogued as usize);
    assert_eq!(catalogue.len(), (outcome.sources as usize).min(8));
    assert!(!catalogue.is_empty() && catalogue.iter().zip(1..).all(|(source, label)| source.label == label));
}
