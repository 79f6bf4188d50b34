//! Prints the instructions that twenty windows of 21 x 21 take, and the stack, where the processor counts.

#![no_std]
#![no_main]

use skyfront_core::arithmetic::{Arithmetic, F32, Q24};
use skyfront_firmware::entry;
use skyfront_firmware::machine::{self, Console, Once};
use skyfront_machine::Processor;
use skyfront_workload::report;
use skyfront_workload::track::Room;

static ROOM: Once<Room> = Once::new(Room::BLANK);

entry!(run);

fn run(mut line: Console) {
    let room = ROOM.take();
    room.draw();
    one::<F32<Processor>>(&mut line, room);
    report::resource(&mut line, &["stack"], machine::stack_used() as u32, "bytes");
    one::<Q24>(&mut line, room);
    report::done(&mut line);
}

fn one<A: Arithmetic>(line: &mut Console, room: &mut Room) {
    let before = machine::ticks();
    let found = room.find::<A>();
    let instructions = machine::instructions(machine::ticks().wrapping_sub(before));
    report::resource(line, &[A::NAME, "instructions"], instructions as u32, "instructions");
    report::resource(line, &[A::NAME, "stars"], found as u32, "stars");
}
