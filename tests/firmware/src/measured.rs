//! One configuration of the core as a whole program: what it needs in flash, stack and instructions.

use crate::machine::{self, Console};
use core::hint::black_box;
use skyfront_core::arithmetic::Arithmetic;
use skyfront_core::scheme::Evolve;
use skyfront_core::stage::Stage;
use skyfront_workload::bits::Planes;
use skyfront_workload::case::{Case, HEIGHT, WIDTH};
use skyfront_workload::report;
use skyfront_workload::run::run;

/// Stages that are measured, and what they are called.
const STAGES: [(Stage, &str); 9] = [
    (Stage::Normalize, "normalize"),
    (Stage::Threshold, "threshold"),
    (Stage::Rescale, "rescale"),
    (Stage::Filter, "filter"),
    (Stage::Gradient, "gradient"),
    (Stage::Edge, "edge"),
    (Stage::Front, "front"),
    (Stage::Evolve, "evolve"),
    (Stage::Measure, "measure"),
];

/// The whole of a program that measures the paper's best setting in arithmetic `A` with scheme `S`.
///
/// Prints for each stage `resource STAGE N instructions` and `resource STAGE/pixels N pixel-steps`, where the
/// processor counts instructions, and the painted stack.
pub fn program<A: Arithmetic, S: Evolve<A>>(mut line: Console, case: &Case, room: &mut Planes<A>) {
    // Not known to the compiler: it must not leave out what this one setting does not use.
    let config = black_box(case.config::<A>());
    let mut counts = [(0u64, 0u64); STAGES.len()];
    let mut last = machine::ticks();
    let outcome = run::<A, S, _>(&config, (WIDTH, HEIGHT), &mut case.frame(), room.memory(), HEIGHT, |stage, _, _| {
        let now = machine::ticks();
        for (count, _) in counts.iter_mut().zip(STAGES).filter(|(_, (named, _))| *named == stage) {
            count.0 += machine::instructions(now.wrapping_sub(last));
            count.1 += (WIDTH * HEIGHT) as u64;
        }
        last = machine::ticks();
    });
    for ((instructions, pixels), (_, name)) in counts.into_iter().zip(STAGES).filter(|_| machine::COUNTS) {
        report::resource(&mut line, &[name], instructions, "instructions");
        report::resource(&mut line, &[name, "pixels"], pixels, "pixel-steps");
    }
    report::resource(&mut line, &["steps"], outcome.map_or(0, |outcome| u64::from(outcome.steps)), "steps");
    report::resource(&mut line, &["stack"], machine::stack_used() as u64, "bytes");
    report::done(&mut line);
}

/// A program that is one configuration: an arithmetic, a type of scheme and the case to run.
#[macro_export]
macro_rules! measured {
    ($arithmetic:ty, $scheme:ty, $case:expr) => {
        static ROOM: $crate::machine::Once<skyfront_workload::bits::Planes<$arithmetic>> =
            $crate::machine::Once::new(skyfront_workload::bits::Planes::ZERO);

        $crate::entry!(measure);

        fn measure(line: $crate::machine::Console) {
            $crate::measured::program::<$arithmetic, $scheme>(line, &$case, ROOM.take());
        }
    };
}
