//! `on_target`: the same bits on the emulated flight processors as here.
//!
//! Installs what it needs where it may (see `tests/firmware/setup`), builds, runs, compares. Exit code 0
//! when every digest of every machine is right, 1 otherwise.

use anyhow::{Result, bail};
use skyfront_core::arithmetic::{Arithmetic, F32};
use skyfront_firmware::bits;
use skyfront_firmware::run::Planes;
use skyfront_tests::on_target::{MACHINES, build, emulator};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

fn main() -> Result<()> {
    build::all()?;
    digests()
}

/// Compares every machine with this one.
fn digests() -> Result<()> {
    let expected = here()?;
    let mut failures = 0;
    for machine in &MACHINES {
        let began = Instant::now();
        let problems = match emulator::run(machine, "digests", Duration::from_secs(300)) {
            Ok(report) => report.differences(&expected),
            Err(error) => vec![format!("{error:#}")],
        };
        let (count, seconds) = (expected.len(), began.elapsed().as_secs_f64());
        println!("{:10} {count} digests, {} problems, {seconds:.1} s", machine.name, problems.len());
        for problem in &problems {
            println!("  {problem}");
        }
        failures += problems.len();
    }
    if failures > 0 {
        bail!("{failures} problems on the processors");
    }
    Ok(())
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
    let mut planes = Box::<Planes<A>>::default();
    bits::all(&mut planes, |case, what, crc| {
        digests.insert(format!("{}/{case}/{what}", A::NAME), crc);
    });
}
