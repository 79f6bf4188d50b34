//! Prints the digests of everything that has to be the same on every processor.

#![no_std]
#![no_main]

use skyfront_core::arithmetic::{Arithmetic, F32};
use skyfront_firmware::bits::{self, Planes};
use skyfront_firmware::machine::{Console, Processor};
use skyfront_firmware::{entry, report};
use static_cell::ConstStaticCell;

type Float = F32<Processor>;

static FLOAT: ConstStaticCell<Planes<Float>> = ConstStaticCell::new(Planes::filled(0.0));

entry!(run);

fn run(mut line: Console) {
    report::digest(&mut line, &["powf"], bits::powers());
    all(&mut line, FLOAT.take());
    report::done(&mut line);
}

fn all<A: Arithmetic>(line: &mut Console, planes: &mut Planes<A>) {
    bits::all(planes, |name, crc| report::digest(line, name, crc));
}
