//! One configuration of the core as a whole program: what it needs in flash, memory and stack.

use crate::machine::{self, Console};
use core::convert::Infallible;
use core::hint::black_box;
use skyfront_core::arithmetic::Arithmetic;
use skyfront_core::config::{Config, Scheme};
use skyfront_core::run::frame::Frame;
use skyfront_core::front::scheme::Evolve;
use skyfront_workload::bits::Planes;
use skyfront_workload::case::{HEIGHT, WIDTH};
use skyfront_workload::report;
use skyfront_workload::run::run;

/// A bright disc on an uneven background: a frame source that takes next to no flash.
struct Disc;

impl Frame for Disc {
    type Error = Infallible;

    fn row(&mut self, y: usize, out: &mut [f32]) -> Result<(), Infallible> {
        for (x, pixel) in out.iter_mut().enumerate() {
            let (dx, dy) = (x as i32 - 24, y as i32 - 13);
            *pixel = if dx * dx + dy * dy < 40 { 200.0 } else { (x * 7 % 5 + y * 3 % 4) as f32 };
        }
        Ok(())
    }
}

/// Runs the paper's best setting in arithmetic `A` with scheme `S`, which is `scheme`, and prints the
/// steps that the front took and the painted stack.
pub fn program<A: Arithmetic, S: Evolve<A>>(mut line: Console, scheme: Scheme, room: &mut Planes<A>) {
    // Not known to the compiler: it must not leave out what this one setting does not use.
    let config = black_box(Config { band: A::NEEDS_BAND, ..Config::PAPER_F160.with_scheme(scheme) });
    let size = black_box((WIDTH, HEIGHT));
    let outcome = run::<A, S, _>(&config, size, &mut Disc, room.memory(), HEIGHT, |_, _, _| {});
    report::resource(&mut line, &["steps"], outcome.map_or(0, |outcome| outcome.steps), "steps");
    report::resource(&mut line, &["stack"], machine::stack_used() as u32, "bytes");
    report::done(&mut line);
}

/// A program that is one configuration: an arithmetic, a type of scheme and the scheme's name.
#[macro_export]
macro_rules! sized {
    ($arithmetic:ty, $scheme:ty, $name:expr) => {
        static ROOM: $crate::machine::Once<skyfront_workload::bits::Planes<$arithmetic>> =
            $crate::machine::Once::new(skyfront_workload::bits::Planes::ZERO);

        $crate::entry!(measure);

        fn measure(line: $crate::machine::Console) {
            $crate::sized::program::<$arithmetic, $scheme>(line, $name, ROOM.take());
        }
    };
}
