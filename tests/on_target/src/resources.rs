//! What the core needs on a processor with and one without an FPU, and the gate against growth.
//!
//! `host/src/cli/resources.txt` is the table: lines `size MACHINE PROGRAM WHAT BYTES` and
//! `cost MACHINE ARITHMETIC STAGE VARIANT INSTRUCTIONS`, the instructions those of a pixel in the costliest pass
//! (variants: [`skyfront_core::run::budget::variant`]). The tables of core/doc/on-board.md are made from it.

use crate::machines::{MEASURED, Machine};
use crate::report::Report;
use crate::tables;
use crate::{build, doubles, elf, emulator};
use anyhow::{Context, Result, bail};
use skyfront_workload::cost;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

/// The programs that are one configuration each, and what the table calls them.
pub const PROGRAMS: [(&str, &str); 5] = [
    ("size_f32_paper", "f32-paper"),
    ("size_f32_fd", "f32-fd"),
    ("size_f32_any", "f32-any"),
    ("size_q24_fd", "q24-fd"),
    ("size_q11_fd", "q11-fd"),
];

/// The program that counts instructions.
const COSTS: &str = "costs";

/// All programs that [`measure`] runs.
pub fn programs() -> Vec<&'static str> {
    PROGRAMS.iter().map(|&(program, _)| program).chain([COSTS]).collect()
}

/// How long a program may take.
const LIMIT: Duration = Duration::from_secs(600);

/// Growth beyond this fails, in percent.
const TOLERANCE: f64 = 5.0;

/// Values by the words before them.
pub type Table = BTreeMap<String, f64>;

/// Measures every program on every machine of the table.
///
/// # Errors
/// When an image cannot be read or run, uses more stack than its call graph has, or has double precision in it.
pub fn measure() -> Result<Table> {
    let tables = std::thread::scope(|scope| {
        let tables: Vec<_> = MEASURED.iter().map(|machine| scope.spawn(move || of_machine(machine))).collect();
        tables.into_iter().map(crate::joined).collect::<Result<Vec<Table>>>()
    })?;
    Ok(tables.into_iter().flatten().collect())
}

fn of_machine(machine: &Machine) -> Result<Table> {
    let mut table = Table::new();
    for (program, title) in PROGRAMS {
        sizes(machine, program, title, &mut table).with_context(|| format!("{program} on {}", machine.name))?;
    }
    let report = emulator::run(machine, COSTS, LIMIT)?;
    for (name, (instructions, _)) in &report.resources {
        let name = name.replace('/', " ").to_lowercase();
        let per_pixel = *instructions as f64 / cost::PIXELS as f64;
        table.insert(format!("cost {} {name}", machine.name), (per_pixel * 10.0).round() / 10.0);
    }
    println!("measured on {}", machine.name);
    Ok(table)
}

fn sizes(machine: &Machine, program: &str, title: &str, table: &mut Table) -> Result<()> {
    let image = build::image(machine.target, program);
    let needs = elf::needs(&image)?;
    if machine.name == MEASURED[0].name {
        doubles::none_in(&image)?;
    }
    let report = emulator::run(machine, program, LIMIT)?;
    let painted = painted(&report)?;
    if needs.stack.is_some_and(|stack| stack < painted) {
        bail!("{painted} bytes of stack were used, more than the call graph has");
    }
    let mut put = |what: &str, bytes: u64| table.insert(format!("size {} {title} {what}", machine.name), bytes as f64);
    put("flash", needs.flash);
    put("memory", needs.memory);
    if let Some(stack) = needs.stack {
        put("stack", stack);
    }
    put("painted", painted);
    Ok(())
}

/// The painted stack of a run that came to its end.
fn painted(report: &Report) -> Result<u64> {
    let value = |name: &str| report.resources.get(name).map(|&(value, _)| value);
    if value("steps").is_none_or(|steps| steps == 0) {
        bail!("the front took no step");
    }
    value("stack").context("no painted stack was told")
}

/// The stored table.
fn stored() -> PathBuf {
    build::folder().join("../../host/src/cli/resources.txt")
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

/// Stores the table and writes it into core/doc/on-board.md.
///
/// # Errors
/// When a file cannot be written, or the page has no place for it.
pub fn store(table: &Table) -> Result<()> {
    let mut text = format!(
        "# By `cargo run --release -p skyfront-on-target -- resources --store`; {}.\n\
         # size MACHINE PROGRAM WHAT BYTES; cost MACHINE ARITHMETIC STAGE VARIANT INSTRUCTIONS (of a pixel, costliest pass).\n",
        build::compiler()?
    );
    table.iter().for_each(|(name, value)| text += &format!("{name} {value}\n"));
    std::fs::write(stored(), text)?;
    let page = build::folder().join("../../core/doc/on-board.md");
    let old = std::fs::read_to_string(&page)?;
    let (begin, end) = ("<!-- resources: begin -->\n", "<!-- resources: end -->");
    let (before, rest) = old.split_once(begin).context("core/doc/on-board.md has no place for the table")?;
    let (_, after) = rest.split_once(end).context("the table in core/doc/on-board.md has no end")?;
    std::fs::write(&page, format!("{before}{begin}{}{end}{after}", tables::markdown(table)))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_beyond_five_percent_is_named() {
        let before = parse("# comment\nsize a flash 100\nsize a stack 100\nsize a gone 1\n").unwrap();
        let now = parse("size a flash 105\nsize a stack 106\nsize a new 1\n").unwrap();
        let told = compare(&before, &now);
        assert_eq!(
            told,
            ["size a gone: not measured", "size a stack: 106, was 100", "size a new: not in the stored table"]
        );
    }
}
