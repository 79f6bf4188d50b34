//! Prints the instructions of every stage in every arithmetic, where the processor counts them.

#![no_std]
#![no_main]

use core::fmt::Write;
use skyfront_core::arithmetic::{Arithmetic, F32, Q11, Q24};
use skyfront_firmware::entry;
use skyfront_firmware::machine::{self, Console, Once};
use skyfront_machine::Processor;
use skyfront_workload::cost::{self, Image, PIXELS, Planes};
use skyfront_workload::report;

static FLOAT: Once<Planes<F32<Processor>>> = Once::new(Planes::ZERO);
static WIDE: Once<Planes<Q24>> = Once::new(Planes::ZERO);
static IMAGE: Once<Image> = Once::new([0.0; PIXELS]);
static NARROW: Once<Planes<Q11>> = Once::new(Planes::ZERO);

entry!(run);

fn run(mut line: Console) {
    let image = IMAGE.take();
    cost::draw(image);
    all(&mut line, FLOAT.take(), image);
    all(&mut line, WIDE.take(), image);
    all(&mut line, NARROW.take(), image);
    report::done(&mut line);
}

fn all<A: Arithmetic>(line: &mut Console, planes: &mut Planes<A>, image: &Image) {
    let mut last = machine::ticks();
    let count = || {
        let before = core::mem::replace(&mut last, machine::ticks());
        machine::instructions(last.wrapping_sub(before))
    };
    cost::all(planes, image, count, |stage, variant, instructions| {
        // A line that cannot be written is missed by the reader.
        let _ = writeln!(line, "resource {}/{stage:?}/{variant} {instructions} instructions", A::NAME);
    });
}
