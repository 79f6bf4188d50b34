//! Runs an image under its emulator and reads its serial line, for a limited time.

use crate::build;
use crate::machines::Machine;
use crate::report::Report;
use anyhow::{Context, Result, anyhow, bail};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// An emulator that ends with its owner, however that ends.
struct Emulator(Child);

impl Drop for Emulator {
    fn drop(&mut self) {
        // It may have ended by itself; there is nothing to do about either then.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs the program `bin` on `machine` and returns what it reported.
///
/// # Errors
/// When the emulator does not start, the program prints something that is no report, ends before its last
/// line or is not there after `limit`. The message names machine, program and the last line seen.
pub fn run(machine: &Machine, bin: &str, limit: Duration) -> Result<Report> {
    let image = build::image(machine.target, bin);
    collect(machine, &image, limit).with_context(|| format!("{bin} on {}", machine.name))
}

/// What a program did on a machine, and how long it took.
pub struct Run {
    /// What it reported, or what was wrong.
    pub report: Result<Report>,
    /// Wall time.
    pub seconds: f64,
}

/// Runs the program `bin` on all `machines` at a time, each for `limit` at most; one run for each machine, in their order.
pub fn run_all(machines: &[Machine], bin: &str, limit: Duration) -> Vec<Run> {
    let timed = |machine: &Machine| {
        let began = Instant::now();
        let report = run(machine, bin, limit);
        Run { report, seconds: began.elapsed().as_secs_f64() }
    };
    thread::scope(|scope| {
        let runs: Vec<_> = machines.iter().map(|machine| scope.spawn(move || timed(machine))).collect();
        let panicked = || Run { report: Err(anyhow!("{bin}: its thread panicked")), seconds: 0.0 };
        runs.into_iter().map(|run| run.join().unwrap_or_else(|_| panicked())).collect()
    })
}

/// What an image that lies elsewhere reported.
///
/// # Errors
/// Those of [`run`].
pub fn run_image(machine: &Machine, image: &Path, limit: Duration) -> Result<Report> {
    collect(machine, image, limit).with_context(|| format!("on {}", machine.name))
}

fn collect(machine: &Machine, image: &Path, limit: Duration) -> Result<Report> {
    if !image.is_file() {
        bail!("no image {}", image.display());
    }
    let (program, arguments) = machine.emulator.split_first().context("no emulator is named")?;
    let mut child = Command::new(program)
        .args(arguments)
        .arg(image)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::inherit())
        .spawn()
        .with_context(|| format!("cannot start {program}"))?;
    let output = child.stdout.take().context("the emulator has no output")?;
    let _ends_with_this_function = Emulator(child);

    let (sender, lines) = channel();
    thread::spawn(move || {
        for line in BufReader::new(output).lines() {
            if line.is_err() || sender.send(line.unwrap_or_default()).is_err() {
                break;
            }
        }
    });
    read(&lines, Instant::now() + limit).map_err(|problem| match problem {
        Problem::Late(last) => anyhow!("hung: not done after {limit:?}; last line: {last:?}"),
        Problem::Short(last) => anyhow!("incomplete: ended before `done`; last line: {last:?}"),
        Problem::Foreign(line) => anyhow!("failed: {line}"),
    })
}

#[derive(Debug, PartialEq)]
enum Problem {
    Late(String),
    Short(String),
    Foreign(String),
}

fn read(lines: &Receiver<String>, end: Instant) -> Result<Report, Problem> {
    let mut report = Report::default();
    let mut last = String::new();
    loop {
        let line = match lines.recv_timeout(end.saturating_duration_since(Instant::now())) {
            Ok(line) => line,
            Err(RecvTimeoutError::Timeout) => return Err(Problem::Late(last)),
            Err(RecvTimeoutError::Disconnected) => return Err(Problem::Short(last)),
        };
        let line = line.trim_end();
        if line == "done" {
            return Ok(report);
        }
        if !report.add(line) {
            return Err(Problem::Foreign(line.to_owned()));
        }
        line.clone_into(&mut last);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is wrong with a machine whose emulator is a command of this one.
    fn wrong(emulator: &'static [&'static str], image: &str) -> String {
        let machine = Machine { name: "none", target: "none", emulator, has_root: false };
        format!("{:#}", collect(&machine, Path::new(image), Duration::from_millis(500)).unwrap_err())
    }

    #[test]
    fn a_machine_that_is_not_there_or_hangs_or_dies_says_which() {
        let here = concat!(env!("CARGO_MANIFEST_DIR"), "/src/emulator.rs");
        assert_eq!(wrong(&["true"], "no/such/image"), "no image no/such/image");
        assert!(wrong(&["no-such-emulator"], here).starts_with("cannot start no-such-emulator"));
        assert!(wrong(&["sh", "-c", "echo digest a 0000002a; exec sleep 60"], here).starts_with("hung"));
        assert!(wrong(&["sh", "-c", "echo digest a 0000002a"], here).starts_with("incomplete"));
        let unknown = Machine { name: "none", target: "none", emulator: &["true"], has_root: false };
        assert!(run(&unknown, "digests", Duration::ZERO).unwrap_err().to_string().contains("digests on none"));
    }

    fn told(lines: &[&str]) -> (Result<Report, Problem>, bool) {
        let (sender, receiver) = channel();
        for line in lines {
            sender.send((*line).to_owned()).unwrap();
        }
        let open = sender.clone();
        let hung = read(&receiver, Instant::now() + Duration::from_millis(20));
        let late = matches!(hung, Err(Problem::Late(_)));
        drop((sender, open));
        (hung, late)
    }

    #[test]
    fn a_complete_report_is_read() {
        let (report, _) = told(&["digest a 0000002a", "resource b 7 bytes", "done"]);
        let report = report.unwrap();
        assert_eq!(report.digests["a"], 42);
        assert_eq!(report.resources["b"], (7, "bytes".to_owned()));
    }

    #[test]
    fn a_machine_that_falls_silent_is_late() {
        assert!(told(&["digest a 0000002a"]).1);
    }

    #[test]
    fn a_machine_that_ends_early_is_short() {
        let (sender, receiver) = channel();
        sender.send("digest a 0000002a".to_owned()).unwrap();
        drop(sender);
        let problem = read(&receiver, Instant::now() + Duration::from_secs(5)).unwrap_err();
        assert_eq!(problem, Problem::Short("digest a 0000002a".to_owned()));
    }

    #[test]
    fn a_panic_is_told_as_it_was_printed() {
        let (report, _) = told(&["panicked at src/lib.rs:1:1", "done"]);
        assert_eq!(report.unwrap_err(), Problem::Foreign("panicked at src/lib.rs:1:1".to_owned()));
    }
}
