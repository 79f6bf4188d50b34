//! Prints every digest of the core on this machine, as `tests/golden.txt` has them; `tests/run coverage` counts the
//! branches that it takes.

use skyfront_core::arithmetic::{Arithmetic, F32, Fixed14, Level, Q11, Q24};
use skyfront_workload::bits::{self, Planes};
use skyfront_workload::{sources, track};

fn tell(name: &[&str], crc: u32) {
    println!("digest {} {crc:08x}", name.join("/"));
}

fn fronts<A: Arithmetic>() {
    bits::all(&mut Box::new(Planes::<A>::ZERO), tell);
}

fn default<L: Level>() {
    let mut room = Box::new(sources::Room::<L>::BLANK);
    room.all(tell);
}

fn stars<A: Arithmetic>() {
    let mut room = Box::new(track::Room::BLANK);
    room.all::<A>(tell);
}

fn main() {
    tell(&["powf"], bits::powers());
    fronts::<F32>();
    fronts::<Q24>();
    fronts::<Q11>();
    default::<f32>();
    default::<Fixed14>();
    stars::<F32>();
    stars::<Q24>();
}
