//! The catalogue as text: CSV, ECSV (astropy's APE 6) and JSON lines.

use super::{Catalogue, Column, Value};
use crate::write::{self, Entry};
use serde_json::json;
use std::io::{self, Write};

/// One line of names, then one line a source; empty where there is no value.
pub fn csv(catalogue: &Catalogue, out: &mut dyn Write) -> io::Result<()> {
    let names: Vec<&str> = catalogue.columns.iter().map(|column| column.name.as_str()).collect();
    writeln!(out, "{}", names.join(","))?;
    for source in &catalogue.rows {
        let cells: Vec<String> = catalogue.columns.iter().map(|column| column.text(source)).collect();
        writeln!(out, "{}", cells.join(","))?;
    }
    Ok(())
}

/// CSV after a header in YAML with types, units, descriptions and provenance.
pub fn ecsv(catalogue: &Catalogue, entries: &[Entry], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:")?;
    for column in &catalogue.columns {
        let unit = if column.unit.is_empty() { String::new() } else { format!("unit: {}, ", json!(column.unit)) };
        writeln!(out, "# - {}", described(column, &unit))?;
    }
    writeln!(out, "# meta:")?;
    for entry in entries {
        if let Entry::Key(keyword, value, _) = entry {
            writeln!(out, "#   {keyword}: {}", json_of(value))?;
        }
    }
    writeln!(out, "# schema: astropy-2.0")?;
    csv(catalogue, out)
}

/// A column in YAML, as astropy reads it, with `more` keys.
pub fn described(column: &Column, more: &str) -> String {
    let kind = if matches!(column.value, Value::Integer(_)) { "int64" } else { "float64" };
    // A JSON string is a YAML string too.
    let (name, description, ucd) = (&column.name, json!(column.description), json!(column.ucd()));
    format!("{{name: {name}, {more}datatype: {kind}, description: {description}, meta: {{ucd: {ucd}}}}}")
}

/// A header value as JSON, which is YAML too.
pub fn json_of(value: &write::Value) -> serde_json::Value {
    match value {
        write::Value::Text(text) => json!(text),
        write::Value::Integer(number) => json!(number),
        write::Value::Real(number) => json!(number),
        write::Value::Logical(flag) => json!(flag),
    }
}

/// One object a source; null where there is no value.
pub fn jsonl(catalogue: &Catalogue, out: &mut dyn Write) -> io::Result<()> {
    for source in &catalogue.rows {
        let cells: Vec<String> = catalogue
            .columns
            .iter()
            .map(|column| {
                let text = column.text(source);
                format!("\"{}\":{}", column.name, if text.is_empty() { "null" } else { &text })
            })
            .collect();
        writeln!(out, "{{{}}}", cells.join(","))?;
    }
    Ok(())
}
