//! The catalogue as a table: one registry of columns, from which every format is written.

use crate::write::WriteError;
use crate::write::fits::{Column as FitsColumn, ColumnData, Writer};
use crate::write::{Entry, fits};
use skyfront_core::catalog::Source;
use std::io::{self, Write};
use std::path::Path;

/// A column: its name, unit and meaning, and how a source fills it.
pub struct Column {
    /// Name, the same in every format.
    pub name: &'static str,
    /// Unit as FITS spells it; empty for none. `image` stands for the unit of the image.
    pub unit: &'static str,
    /// Meaning, one line.
    pub description: &'static str,
    /// The value.
    pub value: Value,
}

/// How a column's value follows from a source.
pub enum Value {
    /// A whole number.
    Integer(fn(&Source) -> i64),
    /// A real number.
    Real(fn(&Source) -> f64),
}

/// FITS coordinates count from 1.
fn fits_index(index: u32) -> i64 {
    i64::from(index) + 1
}

/// The columns, in order.
pub const COLUMNS: &[Column] = &[
    integer("label", "", "label in the segmentation map", |s| i64::from(s.label)),
    integer("area", "pixel", "number of pixels", |s| i64::from(s.area)),
    real("x", "pixel", "centroid, FITS convention: the first pixel's centre is 1", |s| {
        f64::from(s.x0) + f64::from(s.centroid_offset().0) + 1.0
    }),
    real("y", "pixel", "centroid, FITS convention: the first pixel's centre is 1", |s| {
        f64::from(s.y0) + f64::from(s.centroid_offset().1) + 1.0
    }),
    integer("xmin", "pixel", "first column of the bounding box, from 1", |s| fits_index(s.columns.0)),
    integer("xmax", "pixel", "last column of the bounding box", |s| fits_index(s.columns.1)),
    integer("ymin", "pixel", "first row of the bounding box, from 1", |s| fits_index(s.rows.0)),
    integer("ymax", "pixel", "last row of the bounding box", |s| fits_index(s.rows.1)),
    real("sum", "image", "sum of the pixel values", |s| f64::from(s.sum())),
    real("mean", "image", "mean of the pixel values", |s| f64::from(s.mean())),
    real("peak", "image", "greatest pixel value", |s| f64::from(s.peak)),
    integer("xpeak", "pixel", "column of the peak, from 1", |s| fits_index(s.peak_at.0)),
    integer("ypeak", "pixel", "row of the peak, from 1", |s| fits_index(s.peak_at.1)),
    real("a", "pixel", "root mean square along the major axis", |s| f64::from(s.ellipse().a)),
    real("b", "pixel", "root mean square along the minor axis", |s| f64::from(s.ellipse().b)),
    real("theta", "deg", "angle from the x axis to the major axis, towards y", |s| {
        f64::from(s.ellipse().theta).to_degrees()
    }),
];

const fn integer(
    name: &'static str,
    unit: &'static str,
    description: &'static str,
    value: fn(&Source) -> i64,
) -> Column {
    Column { name, unit, description, value: Value::Integer(value) }
}

const fn real(name: &'static str, unit: &'static str, description: &'static str, value: fn(&Source) -> f64) -> Column {
    Column { name, unit, description, value: Value::Real(value) }
}

/// Writes comma-separated values: one line of names, then one line a source.
///
/// # Errors
/// What the writer reports.
pub fn write_csv(sources: &[Source], out: &mut dyn Write) -> io::Result<()> {
    let names: Vec<&str> = COLUMNS.iter().map(|column| column.name).collect();
    writeln!(out, "{}", names.join(","))?;
    for source in sources {
        for (index, column) in COLUMNS.iter().enumerate() {
            let comma = if index == 0 { "" } else { "," };
            match column.value {
                Value::Integer(value) => write!(out, "{comma}{}", value(source))?,
                // As many digits as an f32 has.
                Value::Real(value) => write!(out, "{comma}{}", significant(value(source)))?,
            }
        }
        writeln!(out)?;
    }
    Ok(())
}

/// A number with nine significant digits, without trailing zeros.
fn significant(value: f64) -> String {
    format!("{value:.8e}").parse::<f64>().map_or_else(|_| value.to_string(), |rounded| rounded.to_string())
}

/// Writes a FITS binary table with units and descriptions.
///
/// # Errors
/// As [`Writer::table`].
pub fn write_fits(sources: &[Source], entries: &[Entry], path: &Path) -> Result<(), WriteError> {
    let integers: Vec<Vec<i64>> = COLUMNS
        .iter()
        .map(|column| match column.value {
            Value::Integer(value) => sources.iter().map(value).collect(),
            Value::Real(_) => Vec::new(),
        })
        .collect();
    let reals: Vec<Vec<f64>> = COLUMNS
        .iter()
        .map(|column| match column.value {
            Value::Real(value) => sources.iter().map(value).collect(),
            Value::Integer(_) => Vec::new(),
        })
        .collect();
    let columns: Vec<FitsColumn<'_>> = COLUMNS
        .iter()
        .zip(integers.iter().zip(&reals))
        .map(|(column, (integers, reals))| FitsColumn {
            name: column.name,
            unit: if column.unit == "image" { "" } else { column.unit },
            description: column.description,
            data: match column.value {
                Value::Integer(_) => ColumnData::I64(integers),
                Value::Real(_) => ColumnData::F64(reals),
            },
        })
        .collect();
    let mut writer = fits::Writer::create(path)?;
    Writer::table(&mut writer, "CATALOG", entries, &columns)?;
    writer.finish()
}
