//! The catalogue as a FITS binary table with units and descriptions.

use super::{Catalogue, Value};
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
            Value::Real(..) => {
                let real = |row| column.text(row).parse().unwrap_or(f64::NAN);
                Cells::Reals(catalogue.rows.iter().map(real).collect())
            }
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
    let mut writer = Writer::create(path)?;
    writer.table("CATALOG", entries, &columns)?;
    writer.finish()
}
