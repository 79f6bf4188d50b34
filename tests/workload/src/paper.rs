//! The paper's size on a microcontroller: 300 x 300 pixels in 512 KiB of memory.

use crate::bits;
use crate::run::Planes;
use skyfront_core::arithmetic::{Arithmetic, Q11};
use skyfront_core::config::Config;
use skyfront_core::run::memory::{flags_len, ring_cells};
use skyfront_core::simulate::{Kind, Sky};

/// Columns and rows.
pub const SIDE: usize = 300;

/// All memory of the run.
pub type Room = Planes<Q11, SIDE, { SIDE * SIDE }, { ring_cells(SIDE, false) }, { flags_len(SIDE, SIDE) }>;

const _: () = assert!(size_of::<Room>() <= 384 * 1024, "the paper's image no longer fits the microcontroller");

/// Runs the paper's best setting, frame in to catalogue out, and gives `tell` each digest.
pub fn run(room: &mut Room, tell: impl FnMut(&str, u32)) {
    let config = Config { band: Q11::NEEDS_BAND, ..Config::PAPER_F160 };
    let mut sky = Sky::new(Kind::Bright, 1, SIDE, SIDE);
    bits::one(&config, (SIDE, SIDE), &mut sky, room.memory(), tell);
}
