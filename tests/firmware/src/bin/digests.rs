//! Prints the digests of everything that has to be the same on every processor.

#![no_std]
#![no_main]

use skyfront_core::arithmetic::{Arithmetic, F32, Fixed14, Q11, Q24};
use skyfront_firmware::entry;
use skyfront_firmware::machine::{Console, Once};
use skyfront_machine::Processor;
use skyfront_workload::bits::{self, Planes};
use skyfront_workload::report;
use skyfront_workload::sources::Room;
use skyfront_workload::track;

static FLOAT: Once<Planes<F32<Processor>>> = Once::new(Planes::ZERO);
static WIDE: Once<Planes<Q24>> = Once::new(Planes::ZERO);
static NARROW: Once<Planes<Q11>> = Once::new(Planes::ZERO);
static SOURCES: Once<Room<f32>> = Once::new(Room::BLANK);
static TRACK: Once<track::Room> = Once::new(track::Room::BLANK);
static WIDE_SOURCES: Once<Room<Fixed14>> = Once::new(Room::BLANK);

entry!(run);

fn run(mut line: Console) {
    report::digest(&mut line, &["powf"], bits::powers());
    all(&mut line, FLOAT.take());
    all(&mut line, WIDE.take());
    all(&mut line, NARROW.take());
    SOURCES.take().all(|name, crc| report::digest(&mut line, name, crc));
    WIDE_SOURCES.take().all(|name, crc| report::digest(&mut line, name, crc));
    let stars = TRACK.take();
    stars.all::<F32<Processor>>(|name, crc| report::digest(&mut line, name, crc));
    stars.all::<Q24>(|name, crc| report::digest(&mut line, name, crc));
    report::done(&mut line);
}

fn all<A: Arithmetic>(line: &mut Console, planes: &mut Planes<A>) {
    bits::all(planes, |name, crc| report::digest(line, name, crc));
}
