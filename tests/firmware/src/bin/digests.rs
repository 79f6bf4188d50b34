//! Prints the digests of everything that has to be the same on every processor.

#![no_std]
#![no_main]

use skyfront_core::arithmetic::{Arithmetic, F32};
use skyfront_firmware::machine::{self, Console, Processor};
use skyfront_firmware::run::Planes;
use skyfront_firmware::{bits, entry, report};
use static_cell::StaticCell;

type Float = F32<Processor>;

static FLOAT: StaticCell<Planes<Float>> = StaticCell::new();

entry!(run);

fn run(mut line: Console) {
    report::digest(&mut line, "powf", bits::powers());
    all(&mut line, FLOAT.init_with(Planes::default));
    report::resource(&mut line, "stack", machine::stack_used() as u64, "bytes");
    report::done(&mut line);
}

fn all<A: Arithmetic>(line: &mut Console, planes: &mut Planes<A>) {
    bits::all(planes, |case, what, crc| report::digest(line, format_args!("{}/{case}/{what}", A::NAME), crc));
}
