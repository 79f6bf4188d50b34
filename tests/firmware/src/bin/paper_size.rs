//! The paper's 300 x 300 pixels in 16-bit planes, frame in to catalogue out.

#![no_std]
#![no_main]

use skyfront_firmware::entry;
use skyfront_firmware::machine::{Console, Once};
use skyfront_workload::paper::{self, Room};
use skyfront_workload::report;

static ROOM: Once<Room> = Once::new(Room::ZERO);

entry!(run);

fn run(mut line: Console) {
    paper::run(ROOM.take(), |what, crc| report::digest(&mut line, &["paper", what], crc));
    report::done(&mut line);
}
