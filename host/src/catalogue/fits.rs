//! The catalogue as a FITS binary table with units and descriptions.

use super::{Catalogue, Value};
use crate::read::Card;
use crate::write::fits::{Column, ColumnData, Writer};
use crate::write::{Entry, WriteError};
use std::path::Path;

enum Cells {
    Integers(Vec<i64>),
    Reals(Vec<f64>),
}

/// Writes the table `CATALOG`; NaN where there is no value.
pub fn write(catalogue: &Catalogue, entries: &[Entry], path: &Path) -> Result<(), WriteError> {
    let cells: Vec<Cells> = catalogue
        .columns
        .iter()
        .map(|column| match &column.value {
            Value::Integer(value) => Cells::Integers(catalogue.rows.iter().map(value).collect()),
            Value::Real(..) => Cells::Reals(catalogue.rows.iter().map(|row| column.number(row)).collect()),
        })
        .collect();
    let columns: Vec<Column<'_>> = catalogue
        .columns
        .iter()
        .zip(&cells)
        .map(|(column, cells)| Column {
            name: &column.name,
            unit: &column.unit,
            description: &column.description,
            data: match cells {
                Cells::Integers(values) => ColumnData::I64(values),
                Cells::Reals(values) => ColumnData::F64(values),
            },
        })
        .collect();
    let mut entries = entries.to_vec();
    entries.extend(described(catalogue));
    let mut writer = Writer::create(path)?;
    writer.table("CATALOG", &entries, &columns)?;
    writer.finish()
}

/// Descriptions and content descriptors of the columns: by the keywords that VO tools use, and in the
/// comments from which astropy reads them.
fn described(catalogue: &Catalogue) -> Vec<Entry> {
    let mut entries = Vec::new();
    let mut lines = vec!["datatype:".to_owned()];
    for (number, column) in (1..).zip(&catalogue.columns) {
        entries.push(Entry::new(&format!("TUCD{number}"), column.ucd(), ""));
        entries.push(Entry::new(&format!("TDESC{number}"), column.description.as_str(), ""));
        lines.push(format!("- {}", super::text::described(column, "")));
    }
    lines.push("meta: {__serialized_columns__: {}}".to_owned());
    let lines = lines.iter().flat_map(|line| pieces(line));
    let marked = |end: &str| format!("--{end}-ASTROPY-SERIALIZED-COLUMNS--");
    let comments = [marked("BEGIN")].into_iter().chain(lines).chain([marked("END")]);
    entries.extend(comments.map(|line| Entry::Copy(Card::new(&format!("COMMENT {line}")))));
    entries
}

/// A line in pieces that fit into cards; all but the last end in a backslash.
fn pieces(line: &str) -> Vec<String> {
    const LENGTH: usize = 70;
    let bytes = line.as_bytes().chunks(LENGTH);
    let last = bytes.len();
    let text = |piece| String::from_utf8_lossy(piece).into_owned();
    (1..).zip(bytes).map(|(n, piece)| text(piece) + if n < last { "\\" } else { "" }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_pieces_of_a_line_but_the_last_go_on() {
        assert_eq!(pieces("short"), ["short"]);
        let (first, second) = ("a".repeat(70), "b".repeat(70));
        assert_eq!(pieces(&first), [first.as_str()]);
        let line = format!("{first}{second}c");
        assert_eq!(pieces(&line), [format!("{first}\\"), format!("{second}\\"), "c".to_owned()]);
    }
}
