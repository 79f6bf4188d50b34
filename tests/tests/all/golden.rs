//! The golden digests on this machine: every stage of every run, bit by bit. Those of the flight processors are compared
//! by `cargo run --release -p skyfront-on-target -- digests`, and stored by its `host --store`.

use skyfront::machine::Native;
use skyfront_core::arithmetic::{Arithmetic, F32, Fixed14, Level, Q11, Q24};
use skyfront_core::config::Config;
use skyfront_core::run::extract::{Extractor, Progress};
use skyfront_core::sky::view::Known;
use skyfront_workload::bits::{self, Planes};
use skyfront_workload::sources::{Room, WIDTH};
use skyfront_workload::track;
use std::collections::BTreeMap;

type Digests = BTreeMap<String, String>;

fn add(digests: &mut Digests, name: &str, crc: u32) {
    let before = digests.insert(name.to_owned(), format!("{crc:08x}"));
    assert_eq!(before, None, "{name} twice");
}

fn fronts<A: Arithmetic>(digests: &mut Digests) {
    bits::all(&mut Box::new(Planes::<A>::ZERO), |name, crc| add(digests, &name.join("/"), crc));
}

fn sources<L: Level>(digests: &mut Digests) {
    let mut room = Box::new(Room::<L>::BLANK);
    room.all(|name, crc| add(digests, &name.join("/"), crc));
}

fn stars<A: Arithmetic>(digests: &mut Digests) {
    let mut room = Box::new(track::Room::BLANK);
    room.all::<A>(|name, crc| add(digests, &name.join("/"), crc));
}

fn golden() -> Digests {
    let golden = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/golden.txt")).expect("tests/golden.txt");
    let golden = golden.lines().map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
        ["digest", name, crc] => (name.to_owned(), crc.to_owned()),
        _ => panic!("no digest: {line}"),
    });
    // Those of the examples in C and C++: see `c::`.
    golden.filter(|(name, _): &(String, _)| !name.starts_with("c/")).collect()
}

#[test]
fn every_digest_is_the_golden_one() {
    let golden = golden();
    let mut here = Digests::new();
    add(&mut here, "powf", bits::powers());
    fronts::<F32>(&mut here);
    fronts::<Q24>(&mut here);
    fronts::<Q11>(&mut here);
    sources::<f32>(&mut here);
    sources::<Fixed14>(&mut here);
    stars::<F32>(&mut here);
    stars::<Q24>(&mut here);
    let differ = |name: &&String| here.get(*name) != golden.get(*name);
    let names: Vec<_> = here.keys().chain(golden.keys()).filter(differ).collect();
    assert!(names.is_empty(), "{} digests are others, missing or new: {names:?}", names.len());
}

/// What the other machines lack: a front's rows on vector units, where this computer has them.
#[test]
fn vector_units_have_the_golden_digests() {
    let golden = golden();
    let mut here = Digests::new();
    fronts::<F32<Native>>(&mut here);
    stars::<F32<Native>>(&mut here);
    let differ: Vec<_> = here.iter().filter(|(name, crc)| golden.get(*name) != Some(*crc)).collect();
    assert!(here.len() > 100 && differ.is_empty(), "{} digests are others or new: {differ:?}", differ.len());
}

#[test]
fn the_crowd_has_too_little_sky() {
    let mut room = Box::new(Room::<f32>::BLANK);
    room.draw_crowd();
    let (pixels, _, work) = room.work();
    let run = Extractor::new(&Config::NOISE_AWARE, pixels, WIDTH, Known::default(), work);
    let mut run = run.expect("room enough");
    let found = loop {
        if let Progress::Done(found) = run.poll(usize::MAX).expect("noise") {
            break found;
        }
    };
    assert!(found.survey.is_crowded() && found.sources > 20, "{found:?}");
}
