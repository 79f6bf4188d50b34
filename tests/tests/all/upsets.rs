//! Bits flip between polls: a run still ends within its bound, with a result or an `Err`.
//!
//! The bits of planes, ring, catalogue and state are flipped in a snapshot whose checksum is then
//! made right again, so that nothing but the core's own checks stands between them and the run.
//! The row of samples, which lies in no snapshot, is flipped as the frame source fills it. A panic
//! would end the test, and so would a poll beyond the bound.
//!
//! 20 000 flips by default; a million and more where the environment has SKYFRONT_LONG.

use skyfront::planes::{BandRoom, Room};
use skyfront_core::arithmetic::digest::Digest;
use skyfront_core::arithmetic::{Arithmetic, F32, Q11, Q24};
use skyfront_core::config::{Config, Rescale};
use skyfront_core::error::Error;
use skyfront_core::run::frame::Frame;
use skyfront_core::run::outcome::Progress;
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::snapshot::{self, SnapshotError};
use skyfront_core::run::stage::Stage;
use skyfront_core::simulate::Kind;
use skyfront_tests::runs::{every_kind, sky};
use std::collections::BTreeSet;
use std::convert::Infallible;

const WIDTH: usize = 17;
const HEIGHT: usize = 12;
const SOURCES: usize = 4;
/// Bytes of the header, which names the run and is checked word by word.
const HEADER: usize = 28;
/// Bytes of the state.
const STATE: usize = snapshot::bytes(0, 0, 0, 1, 0) - HEADER - 4;

/// A sequence of numbers that only the seed decides (xorshift).
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 >> 11
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }
}

/// A frame whose samples lose a bit now and then.
struct Flipping<'a> {
    pixels: &'a [f32],
    draw: &'a mut Draw,
    flips: &'a mut u64,
}

impl Frame for Flipping<'_> {
    type Error = Infallible;

    fn row(&mut self, y: usize, out: &mut [f32]) -> Result<(), Infallible> {
        out.copy_from_slice(&self.pixels[y * WIDTH..(y + 1) * WIDTH]);
        if self.draw.below(8) == 0 {
            let sample = &mut out[self.draw.below(WIDTH)];
            *sample = f32::from_bits(sample.to_bits() ^ 1 << self.draw.below(32));
            *self.flips += 1;
        }
        Ok(())
    }
}

/// What became of many runs.
#[derive(Debug, Default)]
struct Tally {
    flips: u64,
    finished: u64,
    refused_at_restore: u64,
    refused_at_poll: u64,
    stages: BTreeSet<Stage>,
}

/// Flips a bit of the state, or up to 16 of the planes, the ring and the catalogue, and makes the
/// checksum right again.
fn upset(snapshot: &mut [u8], draw: &mut Draw, tally: &mut Tally) {
    let body = snapshot.len() - 4;
    let (from, to, flips) = match draw.below(8) {
        // The counters at the head of the state, the state with its histograms, or the memory.
        0 => (HEADER, HEADER + 24, 1),
        1 => (HEADER, HEADER + STATE, 1),
        _ => (HEADER + STATE, body, 1 + draw.below(16)),
    };
    for _ in 0..flips {
        snapshot[from + draw.below(to - from)] ^= 1 << draw.below(8);
        tally.flips += 1;
    }
    let mut digest = Digest::default();
    digest.bytes(&snapshot[..body]);
    snapshot[body..].copy_from_slice(&digest.value().to_le_bytes());
}

/// One run that is upset at random, until it ends.
fn run<A: Arithmetic>(config: &Config, pixels: &[f32], draw: &mut Draw, tally: &mut Tally) {
    let mut room = Room::<A>::new(config, WIDTH, HEIGHT, SOURCES);
    let mut more = BandRoom::<A>::new(pixels.len() / (WIDTH * HEIGHT), WIDTH * HEIGHT);
    let segmenter = match pixels.len() / (WIDTH * HEIGHT) {
        1 => Segmenter::<A>::new(config, WIDTH, HEIGHT, room.memory()),
        _ => Segmenter::of_bands(config, WIDTH, HEIGHT, room.memory(), more.bands()),
    };
    let mut segmenter = segmenter.expect("a good configuration");
    let (_, bound) = segmenter.work();
    // An upset may set the run back; after the last one it must end within the bound.
    let mut upsets = 1 + draw.below(12);
    let mut polls_since = 0;
    let calm = 1 + draw.below(bound as usize / 8);
    loop {
        tally.stages.insert(segmenter.stage());
        let mut frame = Flipping { pixels, draw, flips: &mut tally.flips };
        match segmenter.poll(1 + polls_since % 4, &mut frame) {
            Ok(Progress::Working { .. }) => polls_since += 1,
            Ok(Progress::Done(_)) => return tally.finished += 1,
            Err(Error::Corrupted { .. } | Error::Constant { .. } | Error::NothingDefined { .. }) => {
                return tally.refused_at_poll += 1;
            }
            Err(error) => panic!("{}, {config:?}: {error}", A::NAME),
        }
        assert!(polls_since as u64 <= bound, "{}, {config:?}: longer than its bound", A::NAME);
        if upsets > 0 && polls_since.is_multiple_of(calm) {
            upsets -= 1;
            polls_since = 0;
            let mut snapshot = Vec::new();
            let saved: Result<(), Infallible> = segmenter.save(|chunk| {
                snapshot.extend_from_slice(chunk);
                Ok(())
            });
            let Ok(()) = saved;
            upset(&mut snapshot, draw, tally);
            let mut rest = &snapshot[..];
            let restored: Result<(), SnapshotError<Infallible>> = segmenter.restore(|chunk| {
                let (head, tail) = rest.split_at(chunk.len());
                chunk.copy_from_slice(head);
                rest = tail;
                Ok(())
            });
            if restored.is_err() {
                return tally.refused_at_restore += 1;
            }
        }
    }
}

#[test]
fn flipped_bits_never_panic_hang_or_overrun() {
    let wanted = if std::env::var_os("SKYFRONT_LONG").is_some() { 1_000_000 } else { 20_000 };
    let mut draw = Draw(0x5EED_0F5C_1ECE);
    let mut tally = Tally::default();
    let mut pixels = sky(Kind::Stars, 2, WIDTH, HEIGHT);
    pixels[50] = f32::NAN;
    let bands = [pixels.clone(), sky(Kind::Bright, 3, WIDTH, HEIGHT)].concat();
    let otsu = Config { rescale: Rescale::None, ..Config::CHAN_VESE };
    while tally.flips < wanted {
        every_kind::<F32>().iter().for_each(|config| run::<F32>(config, &pixels, &mut draw, &mut tally));
        every_kind::<Q24>().iter().for_each(|config| run::<Q24>(config, &pixels, &mut draw, &mut tally));
        every_kind::<Q11>().iter().for_each(|config| run::<Q11>(config, &pixels, &mut draw, &mut tally));
        run::<F32>(&otsu, &bands, &mut draw, &mut tally);
        run::<Q24>(&Config::CHAN_VESE, &bands, &mut draw, &mut tally);
    }
    println!("{tally:?}");
    // Every way out was taken, and every stage that a poll can be called in was upset.
    assert!(tally.finished > 0 && tally.refused_at_poll > 0 && tally.refused_at_restore > 0, "{tally:?}");
    let polled = Stage::ALL.iter().filter(|stage| stage.is_of_front());
    let missed: Vec<_> = polled.filter(|stage| !tally.stages.contains(stage)).collect();
    assert!(missed.is_empty(), "never upset: {missed:?}");
}
