//! A run that is written out and taken up again ends with the bits of one that was left alone.

use skyfront::planes::Room;
use skyfront_core::arithmetic::{Arithmetic, Bits, F32, Q11, Q24};
use skyfront_core::config::{Config, Scheme};
use skyfront_core::error::Error;
use skyfront_core::run::frame::SliceFrame;
use skyfront_core::run::outcome::{Outcome, Progress};
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::snapshot::{self, SnapshotError};
use skyfront_core::simulate::Kind;
use skyfront_core::sources::catalog::Source;
use skyfront_tests::runs::{every_kind, sky};

const WIDTH: usize = 23;
const HEIGHT: usize = 14;
const SOURCES: usize = 5;

/// What a run leaves behind, bit by bit.
#[derive(Debug, PartialEq)]
struct Result {
    outcome: Outcome,
    image: Vec<u32>,
    labels: Vec<u32>,
    sources: Vec<Source>,
}

fn result<A: Arithmetic>(segmenter: &Segmenter<'_, A>, outcome: Outcome) -> Result {
    let bits = |cells: &[A::Cell]| cells.iter().map(|cell| cell.bits()).collect();
    let (image, labels) = (bits(segmenter.image()), bits(segmenter.front()));
    Result { outcome, image, labels, sources: segmenter.catalog().to_vec() }
}

/// Runs in slices, with a snapshot before every poll whose number is in `stops`.
fn run<A: Arithmetic>(config: &Config, pixels: &[f32], slice: usize, stops: impl Fn(usize) -> bool) -> (Result, usize) {
    let mut rooms: Vec<Room<A>> = Vec::new();
    rooms.push(Room::new(config, WIDTH, HEIGHT, SOURCES));
    let mut bytes: Option<Vec<u8>> = None;
    let (mut polls, mut pattern) = (0, 0u32);
    loop {
        let mut room = rooms.pop().expect("a room");
        let mut segmenter = Segmenter::<A>::new(config, WIDTH, HEIGHT, room.memory()).expect("a good configuration");
        if let Some(bytes) = bytes.take() {
            restore(&mut segmenter, &bytes).expect("the snapshot that was just made");
        }
        loop {
            match segmenter.poll(slice, &mut SliceFrame(pixels)).expect("a sky") {
                Progress::Done(outcome) => return (result(&segmenter, outcome), polls),
                Progress::Working { .. } => polls += 1,
            }
            if stops(polls) {
                break;
            }
        }
        bytes = Some(save(&mut segmenter));
        // Fresh memory, full of something else.
        pattern = pattern.wrapping_mul(0x9E37_79B1).wrapping_add(0x2F13);
        rooms.push(Room::full_of(pattern, config, WIDTH, HEIGHT, SOURCES));
    }
}

fn save<A: Arithmetic>(segmenter: &mut Segmenter<'_, A>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let saved: std::result::Result<(), ()> = segmenter.save(|chunk| {
        assert!(chunk.len() <= 64);
        bytes.extend_from_slice(chunk);
        Ok(())
    });
    saved.expect("memory does not fail");
    bytes
}

#[derive(Debug, PartialEq)]
struct Ended;

fn restore<A: Arithmetic>(
    segmenter: &mut Segmenter<'_, A>,
    mut bytes: &[u8],
) -> std::result::Result<(), SnapshotError<Ended>> {
    segmenter.restore(|chunk| {
        let (head, rest) = bytes.split_at_checked(chunk.len()).ok_or(Ended)?;
        chunk.copy_from_slice(head);
        bytes = rest;
        Ok(())
    })
}

/// Every poll is a stop once: runs that stop at one poll, and one that stops at all of them.
fn assert_same_bits<A: Arithmetic>() {
    let pixels = {
        let mut pixels = sky(Kind::Bright, 3, WIDTH, HEIGHT);
        pixels[40] = f32::NAN;
        pixels
    };
    for config in every_kind::<A>() {
        for slice in [1, 5, HEIGHT] {
            let (undisturbed, polls) = run::<A>(&config, &pixels, slice, |_| false);
            let (restless, _) = run::<A>(&config, &pixels, slice, |_| true);
            assert_eq!(restless, undisturbed, "{}, {config:?}, slices of {slice}, every poll", A::NAME);
            let stride = if std::env::var_os("SKYFRONT_LONG").is_some() { 1 } else { polls / 5 + 1 };
            for stop in (1..=polls).step_by(stride) {
                let (resumed, _) = run::<A>(&config, &pixels, slice, |poll| poll == stop);
                assert_eq!(resumed, undisturbed, "{}, {config:?}, slices of {slice}, poll {stop}", A::NAME);
            }
        }
    }
}

#[test]
fn resumed_runs_have_the_bits_of_undisturbed_ones_in_f32() {
    assert_same_bits::<F32>();
}

#[test]
fn resumed_runs_have_the_bits_of_undisturbed_ones_in_q24() {
    assert_same_bits::<Q24>();
}

#[test]
fn resumed_runs_have_the_bits_of_undisturbed_ones_in_q11() {
    assert_same_bits::<Q11>();
}

/// A snapshot from the middle of a run.
fn halfway<A: Arithmetic>(config: &Config) -> Vec<u8> {
    let pixels = sky(Kind::Bright, 3, WIDTH, HEIGHT);
    let mut room = Room::<A>::new(config, WIDTH, HEIGHT, SOURCES);
    let mut segmenter = Segmenter::<A>::new(config, WIDTH, HEIGHT, room.memory()).expect("a good configuration");
    for _ in 0..100 {
        segmenter.poll(3, &mut SliceFrame(&pixels)).expect("a sky");
    }
    save(&mut segmenter)
}

/// What a fresh run of a configuration says to a snapshot.
fn offered<A: Arithmetic>(config: &Config, size: (usize, usize), bytes: &[u8]) -> SnapshotError<Ended> {
    let mut room = Room::<A>::new(config, size.0, size.1, SOURCES);
    let mut segmenter = Segmenter::<A>::new(config, size.0, size.1, room.memory()).expect("a good configuration");
    let error = restore(&mut segmenter, bytes).expect_err("not this run's snapshot");
    let pixels = vec![0.0; size.0 * size.1];
    for _ in 0..2 {
        assert_eq!(segmenter.poll(1, &mut SliceFrame(&pixels)), Err(Error::NotRestored));
    }
    error
}

/// The format has the number 7; the same words under another number are another format.
#[test]
fn another_format_is_refused_by_its_version() {
    let config = Config::PAPER_F160;
    let bytes = halfway::<F32>(&config);
    assert_eq!(bytes[4..8], 7u32.to_le_bytes());
    for version in [0, 6, 8, 1 << 24] {
        let mut other = bytes.clone();
        other[4..8].copy_from_slice(&u32::to_le_bytes(version));
        let error = offered::<F32>(&config, (WIDTH, HEIGHT), &other);
        assert_eq!(error, SnapshotError::Foreign { what: "format version" });
    }
}

#[test]
fn the_length_is_the_one_stated() {
    for config in every_kind::<Q11>() {
        let window = if config.scheme == Scheme::SlCurvature { 11 } else { 3 };
        assert_eq!(halfway::<F32>(&config).len(), snapshot::bytes(WIDTH, HEIGHT, 4, window, SOURCES));
        assert_eq!(halfway::<Q11>(&config).len(), snapshot::bytes(WIDTH, HEIGHT, 2, window, SOURCES));
    }
}

#[test]
fn a_row_beyond_the_frame_is_no_state_of_a_run() {
    let config = Config::PAPER_F160;
    let with_row = |row: usize| {
        let mut bytes = halfway::<F32>(&config);
        // Before it stand seven words of the header, the stage and the pass.
        bytes[36..40].copy_from_slice(&(row as u32).to_le_bytes());
        let checked = bytes.len() - 4;
        let sum = crc32fast::hash(&bytes[..checked]);
        bytes[checked..].copy_from_slice(&sum.to_le_bytes());
        bytes
    };
    let mut room = Room::<F32>::new(&config, WIDTH, HEIGHT, SOURCES);
    let mut segmenter = Segmenter::<F32>::new(&config, WIDTH, HEIGHT, room.memory()).expect("a good configuration");
    assert_eq!(restore(&mut segmenter, &with_row(HEIGHT - 1)), Ok(()));
    assert_eq!(offered::<F32>(&config, (WIDTH, HEIGHT), &with_row(HEIGHT)), SnapshotError::Damaged);
}

#[test]
fn any_single_damaged_byte_is_found() {
    let config = every_kind::<Q11>()[0];
    let bytes = halfway::<Q11>(&config);
    for index in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[index] ^= 1 << (index % 8);
        let error = offered::<Q11>(&config, (WIDTH, HEIGHT), &damaged);
        assert!(matches!(error, SnapshotError::Damaged | SnapshotError::Foreign { .. }), "byte {index}: {error:?}");
    }
}

#[test]
fn truncated_and_foreign_snapshots_are_refused() {
    let configs = every_kind::<Q24>();
    let bytes = halfway::<Q24>(&configs[0]);
    for length in (0..bytes.len()).step_by(97).chain([bytes.len() - 1]) {
        assert_eq!(offered::<Q24>(&configs[0], (WIDTH, HEIGHT), &bytes[..length]), SnapshotError::Read(Ended));
    }
    let foreign = |what| SnapshotError::Foreign { what };
    assert_eq!(offered::<F32>(&configs[0], (WIDTH, HEIGHT), &bytes), foreign("arithmetic"));
    assert_eq!(offered::<Q24>(&configs[0], (WIDTH + 1, HEIGHT), &bytes), foreign("width"));
    assert_eq!(offered::<Q24>(&configs[0], (WIDTH, HEIGHT - 1), &bytes), foreign("height"));
    assert_eq!(offered::<Q24>(&configs[1], (WIDTH, HEIGHT), &bytes), foreign("configuration"));
    assert_eq!(offered::<Q24>(&configs[0], (WIDTH, HEIGHT), &bytes[4..]), foreign("kind of contents"));
}
