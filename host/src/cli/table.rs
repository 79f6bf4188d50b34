//! The table of a run over many images: summary.csv, and on stderr.

use serde_json::Value;
use std::borrow::Cow;
use std::io::{self, Write};

/// What is told of each image beside its name, folder and failure: keys of its summary.
const COLUMNS: [&str; 8] = ["width", "height", "n_sources", "mask_pixels", "stop", "t", "iterations", "labels_crc32"];

/// One image of the run.
pub struct Row {
    /// The file as it was named.
    pub image: String,
    /// Its folder below the results.
    pub folder: String,
    /// What is told of it, or why there is nothing.
    pub result: Result<Facts, String>,
}

/// What is kept of an image's summary: as little as the table needs, for there may be thousands.
pub struct Facts {
    cells: [Box<str>; COLUMNS.len()],
    json: Option<Box<str>>,
}

impl Facts {
    /// The facts of a summary, with its JSON where that will be printed.
    pub fn of(summary: &Value, json: bool) -> Facts {
        let cell = |column| match &summary[column] {
            Value::Null => String::new(),
            Value::String(text) => text.clone(),
            Value::Number(number) if number.is_f64() => rounded(number.as_f64().unwrap_or(f64::NAN)),
            value => value.to_string(),
        };
        Facts { cells: COLUMNS.map(|column| cell(column).into()), json: json.then(|| summary.to_string().into()) }
    }
}

impl Row {
    fn value(&self, column: usize) -> &str {
        self.result.as_ref().map_or("", |facts| &facts.cells[column])
    }

    fn error(&self) -> &str {
        self.result.as_ref().err().map_or("", String::as_str)
    }

    /// As one line of JSON.
    pub fn json(&self) -> String {
        match &self.result {
            Ok(facts) => facts.json.as_deref().unwrap_or_default().to_owned(),
            Err(error) => serde_json::json!({ "input": { "file": self.image }, "error": error }).to_string(),
        }
    }
}

/// Writes the table as comma-separated values.
///
/// # Errors
/// What the writer reports.
pub fn write_csv(rows: &[Row], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "image,folder,{},error", COLUMNS.join(","))?;
    for row in rows {
        write!(out, "{},{}", quoted(&plain(&row.image)), quoted(&plain(&row.folder)))?;
        for column in 0..COLUMNS.len() {
            write!(out, ",{}", quoted(row.value(column)))?;
        }
        writeln!(out, ",{}", quoted(&plain(row.error())))?;
    }
    Ok(())
}

/// A text, of which the first word is a path, that no spreadsheet takes for a formula.
fn plain(path: &str) -> Cow<'_, str> {
    if path.starts_with(['=', '+', '-', '@', '\t', '\r']) { format!("./{path}").into() } else { path.into() }
}

/// A number without the rounding error of its last digits.
fn rounded(value: f64) -> String {
    ((value * 1e6).round() / 1e6).to_string()
}

/// A field of a CSV file (RFC 4180).
fn quoted(text: &str) -> String {
    if text.contains(['"', ',', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// The table as lines for a reader.
pub fn lines(rows: &[Row]) -> Vec<String> {
    // Places in `COLUMNS`.
    const SHOWN: [usize; 5] = [0, 1, 2, 4, 5];
    let header = ["image", "width", "height", "sources", "stop", "t"].map(str::to_owned).to_vec();
    let cells = rows.iter().map(|row| {
        let facts = SHOWN.map(|column| if row.value(column).is_empty() { "-" } else { row.value(column) });
        let mut cells = vec![row.image.clone()];
        let failed = ["-", "-", "-", "failed", "-"];
        cells.extend(if row.result.is_ok() { facts } else { failed }.map(str::to_owned));
        cells
    });
    let table: Vec<Vec<String>> = std::iter::once(header).chain(cells).collect();
    let width = |column: usize| table.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..=SHOWN.len()).map(width).collect();
    table
        .iter()
        .map(|line| {
            let padded = line.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| {
                if column == 0 { format!("{cell:width$}") } else { format!("{cell:>width$}") }
            });
            padded.collect::<Vec<_>>().join("  ")
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn rows() -> Vec<Row> {
        let summary = json!({ "width": 30, "height": 20, "n_sources": 5, "mask_pixels": 70, "stop": "rest", "t": 1.25,
            "iterations": 50, "labels_crc32": "0000abcd" });
        let row = |image: &str, result| Row { image: image.into(), folder: "f".into(), result };
        let summary = Facts::of(&summary, false);
        vec![row("a,\"b\".fits", Ok(summary)), row("c.fits", Err("no, never".into()))]
    }

    #[test]
    fn fields_with_commas_are_quoted() {
        let mut out = Vec::new();
        write_csv(&rows(), &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "\"a,\"\"b\"\".fits\",f,30,20,5,70,rest,1.25,50,0000abcd,");
        assert_eq!(lines[2], "c.fits,f,,,,,,,,,\"no, never\"");
        assert_eq!(lines[0].split(',').count(), lines[2].split(',').count() - 1);
    }

    #[test]
    fn names_are_no_formulas() {
        assert_eq!(["=1+1.fits", "-a", "a=b"].map(plain), ["./=1+1.fits", "./-a", "a=b"]);
    }

    #[test]
    fn the_table_for_readers_is_aligned() {
        assert_eq!(
            lines(&rows()),
            [
                "image       width  height  sources    stop     t",
                "a,\"b\".fits     30      20        5    rest  1.25",
                "c.fits          -       -        -  failed     -",
            ]
        );
    }
}
