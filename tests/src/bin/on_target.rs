//! `on_target`: the same bits on the emulated flight processors as here.
//!
//! Installs what it needs where it may (see `tests/firmware/setup`), builds, runs, compares. Exit code 0
//! when every digest of every machine is right, 1 otherwise.

use anyhow::{Result, bail};
use skyfront_firmware::bits;
use skyfront_tests::on_target::{MACHINES, build, emulator};
use std::collections::BTreeMap;
use std::time::Duration;

fn main() -> Result<()> {
    build::all()?;
    digests()
}

/// Compares every machine with this one.
fn digests() -> Result<()> {
    let expected = BTreeMap::from([("powf".to_owned(), bits::powers())]);
    let mut failures = 0;
    for machine in &MACHINES {
        let problems = match emulator::run(machine, "digests", Duration::from_secs(300)) {
            Ok(report) => report.differences(&expected),
            Err(error) => vec![format!("{error:#}")],
        };
        println!("{}: {} digests, {} problems", machine.name, expected.len(), problems.len());
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
