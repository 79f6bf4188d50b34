//! What each configuration of the core needs on each machine, and the gate against growth.

use crate::machines::{MACHINES, Machine};
use crate::report::Report;
use crate::{build, elf, emulator};
use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Duration;

/// The programs that are one configuration each, and what the table calls them.
pub const PROGRAMS: [(&str, &str); 4] = [
    ("measure_f32_fd", "f32, FD"),
    ("measure_f32_any", "f32, all schemes"),
    ("measure_q24_fd", "q24, FD"),
    ("measure_q11_fd", "q11, FD"),
];

/// Stages whose instructions are in the table.
const STAGES: [&str; 9] = ["normalize", "otsu", "rescale", "filter", "gradient", "edge", "front", "evolve", "measure"];

/// Growth beyond this fails, in percent.
const TOLERANCE: f64 = 5.0;

/// Values by `MACHINE PROGRAM WHAT UNIT`.
pub type Table = BTreeMap<String, f64>;

/// Measures every program on every machine.
///
/// # Errors
/// When an image cannot be read or run, or uses more stack than its call graph has.
pub fn measure() -> Result<Table> {
    let mut table = Table::new();
    for machine in &MACHINES {
        for (program, _) in PROGRAMS {
            let needs = elf::needs(&build::image(machine.target, program))?;
            let report = emulator::run(machine, program, Duration::from_secs(600))?;
            let mut put = |what: &str, value: f64| table.insert(format!("{} {program} {what}", machine.name), value);
            put("flash bytes", needs.flash as f64);
            put("memory bytes", needs.memory as f64);
            put("stack bytes", needs.stack as f64);
            let painted = value(&report, "stack").context("no painted stack")?;
            put("painted-stack bytes", painted);
            for (stage, count) in STAGES.iter().filter_map(|stage| Some((stage, per_pixel(&report, stage)?))) {
                put(&format!("{stage} instructions/pixel/step"), count);
            }
        }
    }
    Ok(table)
}

fn value(report: &Report, name: &str) -> Option<f64> {
    report.resources.get(name).map(|&(value, _)| value as f64)
}

/// `None` where the machine does not count, or the stage had no step.
fn per_pixel(report: &Report, stage: &str) -> Option<f64> {
    let pixels = value(report, &format!("{stage}/pixels"))?;
    (pixels > 0.0).then_some((value(report, stage)? / pixels * 10.0).round() / 10.0)
}

/// The stored table.
fn stored() -> PathBuf {
    build::folder().join("resources.txt")
}

/// One line for everything that has grown by more than the tolerance, or is in one table only.
///
/// # Errors
/// When the stored table cannot be read.
pub fn growth(now: &Table) -> Result<Vec<String>> {
    let text = std::fs::read_to_string(stored()).with_context(|| stored().display().to_string())?;
    Ok(compare(&parse(&text)?, now))
}

fn compare(before: &Table, now: &Table) -> Vec<String> {
    let grown = before.iter().filter_map(|(name, &old)| match now.get(name) {
        None => Some(format!("{name}: not measured")),
        Some(&new) if new > old * (1.0 + TOLERANCE / 100.0) => Some(format!("{name}: {new}, was {old}")),
        Some(_) => None,
    });
    let new =
        now.keys().filter(|name| !before.contains_key(*name)).map(|name| format!("{name}: not in the stored table"));
    grown.chain(new).collect()
}

fn parse(text: &str) -> Result<Table> {
    text.lines()
        .filter(|line| !line.starts_with('#') && !line.is_empty())
        .map(|line| {
            let (name, value) = line.rsplit_once(' ').with_context(|| format!("no value in {line:?}"))?;
            Ok((name.to_owned(), value.parse().with_context(|| format!("no number in {line:?}"))?))
        })
        .collect()
}

/// Stores the table and writes it into the README.
///
/// # Errors
/// When a file cannot be written, or the README has no place for it.
pub fn store(table: &Table) -> Result<()> {
    let mut text = format!(
        "# MACHINE PROGRAM WHAT UNIT VALUE, by `skyfront-on-target resources --store`\n# {}\n",
        build::compiler()?
    );
    table.iter().for_each(|(name, value)| text += &format!("{name} {value}\n"));
    std::fs::write(stored(), text)?;
    let readme = build::folder().join("../../README.md");
    let old = std::fs::read_to_string(&readme)?;
    let (begin, end) = ("<!-- resources: begin -->\n", "<!-- resources: end -->");
    let (before, rest) = old.split_once(begin).context("the README has no place for the table")?;
    let (_, after) = rest.split_once(end).context("the README's table has no end")?;
    std::fs::write(&readme, format!("{before}{begin}{}{end}{after}", markdown(table)))?;
    Ok(())
}

/// The table for people.
#[must_use]
pub fn markdown(table: &Table) -> String {
    let mut text = String::from(
        "| machine | program | flash | stack | painted | normalize | rescale | filter | edge | front step |\n\
         |---|---|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for (Machine { name, .. }, (program, title)) in
        MACHINES.iter().flat_map(|machine| PROGRAMS.map(|program| (machine, program)))
    {
        let cell = |what: &str| table.get(&format!("{name} {program} {what}")).map_or("-".to_owned(), f64::to_string);
        let bytes = ["flash bytes", "stack bytes", "painted-stack bytes"].map(cell).join(" | ");
        let stages = ["normalize", "rescale", "filter", "edge", "evolve"]
            .map(|stage| cell(&format!("{stage} instructions/pixel/step")))
            .join(" | ");
        let _ = writeln!(text, "| {name} | {title} | {bytes} | {stages} |");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_beyond_five_percent_is_named() {
        let before = parse("# comment\na flash bytes 100\na stack bytes 100\na gone bytes 1\n").unwrap();
        let now = parse("a flash bytes 105\na stack bytes 106\na new bytes 1\n").unwrap();
        let told = compare(&before, &now);
        assert_eq!(
            told,
            ["a gone bytes: not measured", "a stack bytes: 106, was 100", "a new bytes: not in the stored table"]
        );
    }
}
