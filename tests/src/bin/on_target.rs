//! `on_target [digests|flight|resources] [--store]`: Skyfront on the emulated flight processors.
//!
//! Installs what it needs where it may (see `tests/firmware/setup`), builds, runs, compares. `digests`: the
//! same bits as here. `flight`: the example for flight computers. `resources`: flash, stack and
//! instructions against the stored table, or into it. Without a name: all. Exit code 0 when all is well.

use anyhow::{Result, bail};
use skyfront_core::arithmetic::{Arithmetic, F32};
use skyfront_firmware::bits::{self, Planes};
use skyfront_tests::on_target::{MACHINES, build, emulator, resources};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (options, names): (Vec<&str>, Vec<&str>) = words.iter().map(String::as_str).partition(|w| w.starts_with("--"));
    if options.iter().any(|&o| o != "--store") || names.iter().any(|n| !["digests", "flight", "resources"].contains(n))
    {
        bail!("usage: on_target [digests|flight|resources] [--store]");
    }
    let wanted = |name: &str| names.is_empty() || names.contains(&name);
    build::all()?;
    let mut problems = 0;
    if wanted("digests") {
        problems += everywhere("digests", &here()?);
    }
    if wanted("flight") {
        problems += flight();
    }
    if wanted("resources") {
        problems += needs(options.contains(&"--store"))?;
    }
    if problems > 0 {
        bail!("{problems} problems on the processors");
    }
    Ok(())
}

/// Runs a program on every machine, compares its digests and says what is wrong; returns how much.
fn everywhere(program: &str, expected: &BTreeMap<String, u32>) -> usize {
    let mut total = 0;
    for machine in &MACHINES {
        let began = Instant::now();
        let problems = match emulator::run(machine, program, Duration::from_secs(300)) {
            Ok(report) => report.differences(expected),
            Err(error) => vec![format!("{error:#}")],
        };
        let (count, seconds) = (expected.len(), began.elapsed().as_secs_f64());
        println!("{program} on {}: {count} digests, {} problems, {seconds:.1} s", machine.name, problems.len());
        problems.iter().for_each(|problem| println!("  {problem}"));
        total += problems.len();
    }
    total
}

/// The digests that this machine computes.
fn here() -> Result<BTreeMap<String, u32>> {
    let mut digests = BTreeMap::from([("powf".to_owned(), bits::powers())]);
    add::<F32>(&mut digests);
    let failed: Vec<&String> = digests.keys().filter(|name| name.ends_with("/error")).collect();
    if !failed.is_empty() {
        bail!("these runs fail on this machine: {failed:?}");
    }
    Ok(digests)
}

fn add<A: Arithmetic>(digests: &mut BTreeMap<String, u32>) {
    let mut planes = Box::new(Planes::<A>::filled(A::Cell::default()));
    bits::all(&mut planes, |name, crc| {
        digests.insert(name.join("/"), crc);
    });
}

/// The example: the first machine's catalogue is what the others must find.
fn flight() -> usize {
    match emulator::run(&MACHINES[0], "flight", Duration::from_secs(60)) {
        Ok(report) if report.resources.get("sources").is_some_and(|&(sources, _)| sources > 0) => {
            everywhere("flight", &report.digests)
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
    print!("{}", resources::markdown(&table));
    if store {
        resources::store(&table)?;
        return Ok(0);
    }
    let growth = resources::growth(&table)?;
    growth.iter().for_each(|line| println!("  {line}"));
    Ok(growth.len())
}
