//! Prints what the default takes on a star camera's frame, where the processor counts: by stage, and the stack.

#![no_std]
#![no_main]

use core::fmt::Write;
use skyfront_firmware::entry;
use skyfront_firmware::machine::{self, Console, Once};
use skyfront_workload::polls::{PIXELS, Room};
use skyfront_workload::report;

static ROOM: Once<Room> = Once::new(Room::BLANK);

entry!(run);

fn run(mut line: Console) {
    let room = ROOM.take();
    room.draw();
    let mut last = machine::ticks();
    let count = || {
        let before = core::mem::replace(&mut last, machine::ticks());
        machine::instructions(last.wrapping_sub(before))
    };
    let mut all = 0;
    let sources = room.run(count, |polls| {
        all += polls.total;
        let mean = polls.total / u64::from(polls.count.max(1));
        // A line that cannot be written is missed by the reader.
        let _ = writeln!(Console, "resource {:?}/worst {} instructions", polls.stage, polls.worst);
        let _ = writeln!(Console, "resource {:?}/mean {mean} instructions", polls.stage);
    });
    report::resource(&mut line, &["pixel"], (all / PIXELS as u64) as u32, "instructions");
    report::resource(&mut line, &["stack"], machine::stack_used() as u32, "bytes");
    report::resource(&mut line, &["sources"], sources.unwrap_or(0), "sources");
    report::done(&mut line);
}
