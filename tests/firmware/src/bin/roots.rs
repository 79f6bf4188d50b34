//! Prints a digest of square roots as the processor takes them, and whether it has an instruction for it.

#![no_std]
#![no_main]

use skyfront_firmware::entry;
use skyfront_firmware::machine::Console;
use skyfront_machine::{HARDWARE, Processor};
use skyfront_workload::{bits, report};

entry!(run);

fn run(mut line: Console) {
    report::resource(&mut line, &["hardware"], u32::from(HARDWARE), "instructions");
    report::digest(&mut line, &["roots"], bits::roots::<Processor>());
    report::done(&mut line);
}
