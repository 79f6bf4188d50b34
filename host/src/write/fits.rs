//! FITS images and binary tables, written by cfitsio with the same bytes on every run.

use std::path::{Path, PathBuf};

use super::entry::{self, Entry, Value};
use super::error::WriteError;
use super::native::{Failure, Field, Handle, Native};

/// A FITS file that is being written: HDUs are appended, [`finish`](Self::finish) completes it.
pub struct Writer {
    handle: Handle,
    path: PathBuf,
}

/// A sample type of an image: `i32` (`BITPIX` 32) or `f32` (`BITPIX` -32, NaN = undefined).
#[allow(private_bounds)]
pub trait Sample: Native + Default {
    /// `BITPIX` in the file.
    const BITPIX: i32;
}

impl Sample for i32 {
    const BITPIX: i32 = 32;
}

impl Sample for f32 {
    const BITPIX: i32 = -32;
}

/// A column of a binary table: one number a row.
#[derive(Clone, Copy, Debug)]
pub struct Column<'a> {
    /// Name (`TTYPEn`).
    pub name: &'a str,
    /// Unit (`TUNITn`); empty for none.
    pub unit: &'a str,
    /// Description (`TCOMMn`).
    pub description: &'a str,
    /// The values, one a row.
    pub data: ColumnData<'a>,
}

/// The values of a column.
#[derive(Clone, Copy, Debug)]
pub enum ColumnData<'a> {
    /// Format `E`.
    F32(&'a [f32]),
    /// Format `D`.
    F64(&'a [f64]),
    /// Format `J`.
    I32(&'a [i32]),
    /// Format `K`.
    I64(&'a [i64]),
}

impl ColumnData<'_> {
    fn format(&self) -> &'static str {
        match self {
            Self::F32(_) => "1E",
            Self::F64(_) => "1D",
            Self::I32(_) => "1J",
            Self::I64(_) => "1K",
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::F32(values) => values.len(),
            Self::F64(values) => values.len(),
            Self::I32(values) => values.len(),
            Self::I64(values) => values.len(),
        }
    }
}

/// Samples that are handed over together, in whole rows: the library copies small pieces into
/// blocks of 2880 bytes and writes each of them by itself.
const PIECE: usize = 1 << 16;

impl Writer {
    /// Creates the file; its name is taken literally and must not exist.
    ///
    /// # Errors
    /// [`WriteError::Fits`] if it cannot be created.
    pub fn create(path: &Path) -> Result<Self, WriteError> {
        let handle = Handle::create(path).map_err(|reason| failure(path, reason))?;
        Ok(Self { handle, path: path.to_owned() })
    }

    /// Appends an image HDU (the first one is the primary) whose rows come one by one from `row(y, out)`, row 0 first.
    ///
    /// # Errors
    /// [`WriteError::Fits`] if the library refuses, for instance on a full disk.
    pub fn image<T: Sample>(
        &mut self,
        (width, height): (usize, usize),
        entries: &[Entry],
        mut row: impl FnMut(usize, &mut [T]),
    ) -> Result<(), WriteError> {
        self.try_do(|handle| {
            handle.image(T::BITPIX, width, height)?;
            write_entries(handle, entries)?;
            let rows = (PIECE / width.max(1)).clamp(1, height.max(1));
            let mut piece = vec![T::default(); rows * width];
            for first in (0..height).step_by(rows) {
                let piece = &mut piece[..rows.min(height - first) * width];
                (first..).zip(piece.chunks_exact_mut(width)).for_each(|(y, line)| row(y, line));
                handle.samples((first * width) as i64 + 1, piece)?;
            }
            Ok(())
        })
    }

    /// Appends a binary table (after an empty primary HDU if it is the first).
    ///
    /// # Errors
    /// [`WriteError::Fits`] if the columns differ in length or the library refuses.
    pub fn table(&mut self, name: &str, entries: &[Entry], columns: &[Column<'_>]) -> Result<(), WriteError> {
        self.try_do(|handle| {
            let rows = columns.first().map_or(0, |column| column.data.len());
            if let Some(odd) = columns.iter().find(|column| column.data.len() != rows) {
                return Err(Failure::Library(format!("column {} has {} rows, not {rows}", odd.name, odd.data.len())));
            }
            let fields: Vec<Field<'_>> = columns
                .iter()
                .map(|column| Field { name: column.name, format: column.data.format(), unit: column.unit })
                .collect();
            handle.table(name, rows, &fields)?;
            for (number, column) in (1..).zip(columns) {
                handle.text(&format!("TCOMM{number}"), &entry::ascii(column.description), "")?;
            }
            write_entries(handle, entries)?;
            (1..).zip(columns).try_for_each(|(number, column)| write_column(handle, number, column.data))
        })
    }

    /// Completes the file.
    ///
    /// # Errors
    /// [`WriteError::Fits`] if the last bytes cannot be written.
    pub fn finish(self) -> Result<(), WriteError> {
        let Self { handle, path } = self;
        handle.close().map_err(|reason| failure(&path, reason))
    }

    fn try_do(&mut self, work: impl FnOnce(&mut Handle) -> Result<(), Failure>) -> Result<(), WriteError> {
        work(&mut self.handle).map_err(|reason| failure(&self.path, reason))
    }
}

fn failure(path: &Path, reason: Failure) -> WriteError {
    match reason {
        Failure::System(reason) => WriteError::io(path, reason),
        Failure::Library(reason) => WriteError::Fits { file: path.to_owned(), reason },
    }
}

fn write_column(handle: &mut Handle, number: usize, data: ColumnData<'_>) -> Result<(), Failure> {
    if data.len() == 0 {
        return Ok(());
    }
    match data {
        ColumnData::F32(values) => handle.column(number, values),
        ColumnData::F64(values) => handle.column(number, values),
        ColumnData::I32(values) => handle.column(number, values),
        ColumnData::I64(values) => handle.column(number, values),
    }
}

fn write_entries(handle: &mut Handle, entries: &[Entry]) -> Result<(), Failure> {
    entries.iter().try_for_each(|entry| match entry {
        Entry::Copy(card) => handle.card(card.text().trim_end()),
        Entry::Key(keyword, value, comment) => match entry::fixed_card(keyword, value, comment) {
            Some(card) => handle.card(card.text().trim_end()),
            None => handle.text(keyword, &entry::ascii(&text_of(value)), &entry::ascii(comment)),
        },
    })
}

/// Values without a fixed format, as text: strings, and the numbers that FITS has no notation for.
fn text_of(value: &Value) -> String {
    match value {
        Value::Text(text) => text.clone(),
        other => format!("{other:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read;
    use crate::write::Products;

    #[test]
    fn an_image_reads_back_with_its_entries() {
        let folder = std::env::temp_dir().join(format!("skyfront-[fits]+1-{}", std::process::id()));
        let long = "a long text ".repeat(12);
        let entries = [
            Entry::new("CREATOR", long.trim_end(), "who"),
            Entry::new("TAU", 0.1, "threshold"),
            Entry::new("STEPS", 7, "count"),
            Entry::Copy(read::Card::new("CRVAL1  =   83.63308 / copied")),
        ];
        let write = |name: &str| {
            let mut products = Products::plan(&folder, &[name], false).unwrap();
            products
                .write_path(name, |path| {
                    let mut file = Writer::create(path)?;
                    file.image::<f32>((5, 3), &entries, |y, out| {
                        out.iter_mut().zip(0u8..).for_each(|(v, x)| *v = (y * 10) as f32 + f32::from(x))
                    })?;
                    file.finish()
                })
                .unwrap();
            products.publish().unwrap().remove(0)
        };
        let (one, two) = (write("a[1:2].fits"), write("b+1.fits"));
        assert_eq!(std::fs::read(&one).unwrap(), std::fs::read(&two).unwrap(), "the same bytes every time");
        let image = read::image(&one, None).unwrap();
        assert_eq!((image.width, image.height, image.bitpix), (5, 3, -32));
        assert_eq!(image.pixels[5..10], [10.0, 11.0, 12.0, 13.0, 14.0]);
        assert_eq!(image.header.text("CREATOR").as_deref(), Some(long.trim_end()));
        assert_eq!(image.header.real("TAU"), Some(0.1));
        assert_eq!(image.header.integer("STEPS"), Some(7));
        assert_eq!(image.header.real("CRVAL1"), Some(83.63308));
        assert!(image.header.text("DATE").is_none());
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_table_carries_units_and_descriptions() {
        let path = std::env::temp_dir().join(format!("skyfront-table-{}.fits", std::process::id()));
        let _ = std::fs::remove_file(&path);
        let mut file = Writer::create(&path).unwrap();
        let column = |name, unit, data| Column { name, unit, description: "a number", data };
        let columns = [
            column("id", "", ColumnData::I32(&[1, 2])),
            column("flux", "adu", ColumnData::F64(&[1.5, -2.5])),
            column("snr", "", ColumnData::F32(&[3.0, f32::NAN])),
            column("flags", "", ColumnData::I64(&[0, 1 << 40])),
        ];
        file.table("SOURCES", &[Entry::new("NSRC", 2, "sources")], &columns).unwrap();
        file.finish().unwrap();
        let mut back = fitsio::FitsFile::open(&path).unwrap();
        let table = back.hdu("SOURCES").unwrap();
        assert_eq!(table.read_col::<f64>(&mut back, "flux").unwrap(), [1.5, -2.5]);
        assert_eq!(table.read_col::<i32>(&mut back, "id").unwrap(), [1, 2]);
        assert_eq!(table.read_col::<i64>(&mut back, "flags").unwrap(), [0, 1 << 40]);
        assert_eq!(table.read_key::<String>(&mut back, "TUNIT2").unwrap(), "adu");
        assert_eq!(table.read_key::<String>(&mut back, "TCOMM4").unwrap(), "a number");
        assert_eq!(table.read_key::<i64>(&mut back, "NSRC").unwrap(), 2);
        std::fs::remove_file(path).unwrap();
    }
}
