//! The table of resources, for people.

use crate::machines::MEASURED;
use crate::resources::{PROGRAMS, Table};
use std::fmt::Write;

/// The columns of the second table: title, stage and variant; with `-band` where the arithmetic needs one.
const COLUMNS: [(&str, &str, &str); 12] = [
    ("normalize", "normalize", "-"),
    ("r3", "rescale", "r3"),
    ("heat", "filter", "heat"),
    ("edge", "edge", "g2"),
    ("FD", "evolve", "fd"),
    ("FD, curvature", "evolve", "fd-curvature"),
    ("SL", "evolve", "sl"),
    ("SL, curvature", "evolve", "sl-curvature"),
    ("FD, filtered", "evolve", "fd-filtered"),
    ("Chan-Vese", "evolve", "chan-vese"),
    ("march, a look", "march", "-"),
    ("label", "provisional", "-"),
];

/// Both tables.
#[must_use]
pub fn markdown(table: &Table) -> String {
    let mut text = String::from(
        "| machine | program | flash | static RAM | stack by call graph | stack painted |\n|---|---|--:|--:|--:|--:|\n",
    );
    for (machine, (_, program)) in MEASURED.iter().flat_map(|machine| PROGRAMS.map(|program| (machine.name, program))) {
        let cell = |what: &str| number(table.get(&format!("size {machine} {program} {what}")));
        let bytes = ["flash", "memory", "stack", "painted"].map(cell).join(" | ");
        let _ = writeln!(text, "| {machine} | {program} | {bytes} |");
    }
    let titles = COLUMNS.map(|(title, ..)| title).join(" | ");
    let _ = writeln!(text, "\n| machine | arithmetic | {titles} |\n|---|---{}|", "|--:".repeat(COLUMNS.len()));
    for (machine, arithmetic) in
        MEASURED.iter().flat_map(|machine| ["f32", "q24", "q11"].map(|arithmetic| (machine.name, arithmetic)))
    {
        let cost = |stage: &str, variant: String| table.get(&format!("cost {machine} {arithmetic} {stage} {variant}"));
        let cell = |(_, stage, variant): (_, &str, &str)| {
            number(cost(stage, variant.into()).or_else(|| cost(stage, format!("{variant}-band"))))
        };
        let _ = writeln!(text, "| {machine} | {arithmetic} | {} |", COLUMNS.map(cell).join(" | "));
    }
    text
}

fn number(value: Option<&f64>) -> String {
    value.map_or("-".to_owned(), f64::to_string)
}
