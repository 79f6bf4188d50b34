//! Skyfront on the emulated flight processors: `skyfront-on-target [PART...] [--store]`.
//!
//! Installs what it needs where it may (see `tests/firmware/setup`), builds, runs, compares:
//!
//! - `lint`: clippy over the firmware, which is no part of the workspace;
//! - `host`: the golden digests on this machine; with `--store`, writes them;
//! - `roots`: the square roots of every processor, of one more with the F extension, and whose they are;
//! - `digests`: the golden digests on every processor, and those of the examples in C and C++ on the Cortex-M7;
//! - `paper`: the paper's size on the Cortex-M7;
//! - `flight`: the example for flight computers;
//! - `track`: what twenty windows of a star tracker take, and no double precision on the Cortex-M7;
//! - `polls`: what the default takes on a star camera's frame on the Cortex-M7, and the costliest poll of every stage;
//! - `resources`: flash, stack and instructions against the stored table, and no double precision on the Cortex-M7; with `--store`, writes it.
//!
//! Without a part: all. Exit code 0 when all is well. A machine that is missing, hangs, or leaves
//! something out is a failure that says which.

mod build;
mod doubles;
mod elf;
mod emulator;
mod foreign;
mod machines;
mod report;
mod resources;
mod tables;

use anyhow::{Context, Result, bail};
use emulator::Run;
use machines::{MACHINES, MEASURED, Machine, RV32IMAFC};
use report::Report;
use skyfront_core::arithmetic::machine::Plain;
use skyfront_core::arithmetic::{Arithmetic, F32, Fixed14, Level, Q11, Q24};
use skyfront_workload::bits::{self, Planes};
use skyfront_workload::paper;
use skyfront_workload::polls;
use skyfront_workload::sources::Room;
use skyfront_workload::track;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::thread::ScopedJoinHandle;
use std::time::Duration;

const PARTS: [&str; 9] = ["host", "roots", "polls", "digests", "paper", "flight", "track", "resources", "lint"];

/// What the names of the digests begin with that only the examples in C and C++ print.
const FOREIGN: &str = "c/";

/// Twenty windows of 21 x 21 in single precision on the Cortex-M7: the most instructions, and bytes of stack.
const TRACK: (u64, u64) = (2_000_000, 4096);

/// The default on a star camera's frame on the Cortex-M7: the most instructions per pixel and per poll of one row, and
/// bytes of stack.
const POLLS: (u64, u64, u64) = (6_700, 2_120_000, 11_550);

/// How long a program may take: several times what it takes on two busy cores.
const LIMIT: Duration = Duration::from_secs(600);

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (options, names): (Vec<&str>, Vec<&str>) = words.iter().map(String::as_str).partition(|w| w.starts_with("--"));
    if options.iter().any(|&o| o != "--store") || names.iter().any(|n| !PARTS.contains(n)) {
        bail!("usage: skyfront-on-target [host|roots|polls|digests|paper|flight|track|resources|lint] [--store]");
    }
    let wanted = |name: &str| names.is_empty() || names.contains(&name);
    let store = options.contains(&"--store");
    let mut problems = 0;
    if wanted("host") {
        problems += host(store)?;
    }
    build(&wanted)?;
    if wanted("roots") {
        problems += roots();
    }
    if wanted("digests") {
        let (foreign, own) = golden()?.into_iter().partition(|(name, _)| name.starts_with(FOREIGN));
        problems += std::thread::scope(|scope| {
            // While the emulators run, the library for C is built.
            let of_c = scope.spawn(|| foreign::report(LIMIT));
            let problems = everywhere("digests", &MACHINES, &own);
            problems + differing("digests of C and C++", joined(of_c), &foreign)
        });
    }
    if wanted("paper") {
        problems += everywhere("paper_size", &MACHINES[..1], &paper_size());
    }
    if wanted("flight") {
        problems += flight();
    }
    if wanted("track") {
        doubles::none_in(&build::image(MACHINES[0].target, "track"))?;
        problems += windows();
    }
    if wanted("polls") {
        problems += polls();
    }
    if wanted("resources") {
        problems += needs(store)?;
    }
    if wanted("lint") {
        build::lint()?;
    }
    verdict(problems)
}

/// Builds the programs of all parts that are wanted at once: most of the time is linking, one program at a time.
fn build(wanted: &impl Fn(&str) -> bool) -> Result<()> {
    let of = |parts: &[(&str, &[&'static str])]| -> Vec<&'static str> {
        parts.iter().filter(|(part, _)| wanted(part)).flat_map(|(_, programs)| programs.iter().copied()).collect()
    };
    let everywhere = of(&[("digests", &["digests"]), ("flight", &["flight"])]);
    let measured = of(&[("paper", &["paper_size"]), ("track", &["track"]), ("resources", &resources::programs())]);
    build::programs(&everywhere, &MACHINES)?;
    build::programs(&measured, &MEASURED)?;
    build::programs(&of(&[("polls", &["polls"])]), &MACHINES[..1])?;
    build::programs(&of(&[("roots", &["roots"])]), &with_roots())
}

/// What a thread came to.
fn joined<T>(thread: ScopedJoinHandle<'_, Result<T>>) -> Result<T> {
    thread.join().unwrap_or_else(|_| bail!("it panicked"))
}

fn verdict(problems: usize) -> Result<()> {
    if problems > 0 {
        bail!("{problems} problems");
    }
    Ok(())
}

/// The file of golden digests, one `digest NAME 1a2b3c4d` a line.
fn golden_file() -> PathBuf {
    build::folder().join("../golden.txt")
}

fn golden() -> Result<BTreeMap<String, u32>> {
    let mut report = Report::default();
    let text = std::fs::read_to_string(golden_file()).with_context(|| golden_file().display().to_string())?;
    match text.lines().find(|line| !report.add(line)) {
        Some(line) => bail!("{}: no digest: {line:?}", golden_file().display()),
        None => Ok(report.digests),
    }
}

/// Compares this machine with the golden file, or stores what it computes there.
fn host(store: bool) -> Result<usize> {
    let report = here()?;
    if store {
        let mut digests = report.digests.clone();
        digests.extend(golden()?.into_iter().filter(|(name, _)| name.starts_with(FOREIGN)));
        let lines: String = digests.iter().map(|(name, crc)| format!("digest {name} {crc:08x}\n")).collect();
        std::fs::write(golden_file(), lines)?;
    }
    let own = golden()?.into_iter().filter(|(name, _)| !name.starts_with(FOREIGN)).collect();
    let problems = report.differences(&own);
    println!("digests on this machine: {} problems", problems.len());
    problems.iter().for_each(|problem| println!("  {problem}"));
    Ok(problems.len())
}

/// Runs a program on machines, compares its digests and says what is wrong; returns how much.
fn everywhere(program: &str, machines: &[Machine], expected: &BTreeMap<String, u32>) -> usize {
    let mut total = 0;
    for (machine, Run { report, seconds }) in machines.iter().zip(emulator::run_all(machines, program, LIMIT)) {
        let problems = problems_of(report, expected);
        println!(
            "{program} on {}: {} digests, {} problems, {seconds:.1} s",
            machine.name,
            expected.len(),
            problems.len()
        );
        problems.iter().for_each(|problem| println!("  {problem}"));
        total += problems.len();
    }
    total
}

fn problems_of(report: Result<Report>, expected: &BTreeMap<String, u32>) -> Vec<String> {
    match report {
        Ok(report) => report.differences(expected),
        Err(error) => vec![format!("{error:#}")],
    }
}

/// Says what is wrong with a report; returns how much.
fn differing(what: &str, report: Result<Report>, expected: &BTreeMap<String, u32>) -> usize {
    let problems = problems_of(report, expected);
    println!("{what}: {} digests, {} problems", expected.len(), problems.len());
    problems.iter().for_each(|problem| println!("  {problem}"));
    problems.len()
}

/// Counts what a star tracker's windows take, and holds the Cortex-M7 to its limits.
fn windows() -> usize {
    let mut problems = 0;
    for (machine, Run { report, .. }) in MEASURED.iter().zip(emulator::run_all(&MEASURED, "track", LIMIT)) {
        let value = |name: &str| report.as_ref().ok()?.resources.get(name).map(|&(value, _)| value);
        let [float, fixed, stack] =
            ["f32/instructions", "q24/instructions", "stack"].map(|name| value(name).unwrap_or(0));
        println!(
            "20 windows of 21 x 21 on {}: {float} instructions in f32, {fixed} in q24, {stack} bytes of stack",
            machine.name
        );
        let found = ["f32/stars", "q24/stars"].map(value) == [Some(track::STARS as u64); 2];
        let within = machine.name != MACHINES[0].name || (float <= TRACK.0 && stack <= TRACK.1);
        if !(found && within) {
            println!("  not every star, or more than {} instructions or {} bytes: {report:?}", TRACK.0, TRACK.1);
            problems += 1;
        }
    }
    problems
}

/// Counts the polls of the default on a star camera's frame, and holds the Cortex-M7 to its limits.
fn polls() -> usize {
    let (machine, report) = (&MACHINES[0], emulator::run(&MACHINES[0], "polls", LIMIT));
    let all = report.as_ref().map(|report| report.resources.clone()).unwrap_or_default();
    let value = |name: &str| all.get(name).map_or(0, |&(value, _)| value);
    let worst = all.iter().filter(|(name, _)| name.ends_with("/worst")).map(|(_, &(value, _))| value).max();
    for (name, (instructions, _)) in &all {
        if let Some(stage) = name.strip_suffix("/worst") {
            let mean = value(&format!("{stage}/mean"));
            println!("a poll of one row, {stage} on {}: {instructions} instructions, mean {mean}", machine.name);
        }
    }
    let [pixel, stack, sources] = ["pixel", "stack", "sources"].map(value);
    println!("the default on {}: {pixel} instructions per pixel, {stack} bytes of stack", machine.name);
    let is_within = pixel <= POLLS.0 && worst.is_some_and(|worst| worst <= POLLS.1) && stack <= POLLS.2;
    if sources == polls::STARS as u64 && is_within {
        return 0;
    }
    println!("  {sources} sources of {}, or more than {POLLS:?}: {:?}", polls::STARS, report.err());
    1
}

/// The digests that this machine computes.
fn here() -> Result<Report> {
    let mut report = Report::default();
    report.digest("powf".to_owned(), bits::powers());
    add::<F32>(&mut report);
    add::<Q24>(&mut report);
    add::<Q11>(&mut report);
    add_sources::<f32>(&mut report);
    add_sources::<Fixed14>(&mut report);
    add_stars::<F32>(&mut report);
    add_stars::<Q24>(&mut report);
    let failed: Vec<&String> = report.digests.keys().filter(|name| name.ends_with("/error")).collect();
    if !failed.is_empty() {
        bail!("these runs fail on this machine: {failed:?}");
    }
    Ok(report)
}

/// All machines whose square roots are compared.
fn with_roots() -> Vec<Machine> {
    MACHINES.iter().copied().chain([RV32IMAFC]).collect()
}

/// Compares square roots with those of software here, and holds every machine to its own instruction.
fn roots() -> usize {
    let (machines, expected) = (with_roots(), BTreeMap::from([("roots".to_owned(), bits::roots::<Plain>())]));
    let mut problems = 0;
    for (machine, Run { report, .. }) in machines.iter().zip(emulator::run_all(&machines, "roots", LIMIT)) {
        let hardware =
            report.as_ref().ok().and_then(|report| report.resources.get("hardware")).map(|&(value, _)| value);
        problems += differing(&format!("square roots on {}", machine.name), report, &expected);
        if hardware != Some(u64::from(machine.has_root)) {
            println!("  hardware: {hardware:?}, and not {}", machine.has_root);
            problems += 1;
        }
    }
    problems
}

/// The paper's size on this machine.
fn paper_size() -> BTreeMap<String, u32> {
    let mut digests = BTreeMap::new();
    paper::run(&mut Box::new(paper::Room::ZERO), |what, crc| {
        digests.insert(format!("paper/{what}"), crc);
    });
    digests
}

fn add<A: Arithmetic>(report: &mut Report) {
    let mut planes = Box::new(Planes::<A>::ZERO);
    bits::all(&mut planes, |name, crc| {
        report.digest(name.join("/"), crc);
    });
}

fn add_sources<L: Level>(report: &mut Report) {
    let mut room = Box::new(Room::<L>::BLANK);
    room.all(|name, crc| {
        report.digest(name.join("/"), crc);
    });
}

fn add_stars<A: Arithmetic>(report: &mut Report) {
    let mut room = track::Room::BLANK;
    room.all::<A>(|name, crc| {
        report.digest(name.join("/"), crc);
    });
}

/// The example: the first machine's catalogue is what the others must find.
fn flight() -> usize {
    match emulator::run(&MACHINES[0], "flight", LIMIT) {
        Ok(report) if report.resources.get("sources").is_some_and(|&(sources, _)| sources > 0) => {
            everywhere("flight", &MACHINES, &report.digests)
        }
        Ok(_) => {
            println!("flight on {}: no sources", MACHINES[0].name);
            1
        }
        Err(error) => {
            println!("{error:#}");
            1
        }
    }
}

/// Measures, and stores or compares.
fn needs(store: bool) -> Result<usize> {
    let table = resources::measure()?;
    print!("{}", tables::markdown(&table));
    if store {
        resources::store(&table)?;
        return Ok(0);
    }
    let growth = resources::growth(&table)?;
    growth.iter().for_each(|line| println!("  {line}"));
    Ok(growth.len())
}
