//! FITS images and binary tables, with checksums, and with the same bytes on every run (FITS standard 4.0).

use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::checksum::Sum;
use super::entry::{self, Entry, Value};
use super::error::WriteError;
use crate::read::Card;

/// FITS files come in blocks of this many bytes.
const BLOCK: usize = 2880;

/// A FITS file that is being written: HDUs are appended, [`finish`](Self::finish) completes it.
pub struct Writer {
    out: BufWriter<File>,
    path: PathBuf,
    begun: bool,
}

/// A sample type of an image: `i32` (`BITPIX` 32) or `f32` (`BITPIX` -32, NaN = undefined).
pub trait Sample: Copy + Default {
    /// `BITPIX` in the file.
    const BITPIX: i64;
    /// The bytes in the file.
    fn bytes(self) -> [u8; 4];
}

impl Sample for i32 {
    const BITPIX: i64 = 32;
    fn bytes(self) -> [u8; 4] {
        self.to_be_bytes()
    }
}

impl Sample for f32 {
    const BITPIX: i64 = -32;
    fn bytes(self) -> [u8; 4] {
        self.to_be_bytes()
    }
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

    /// Bytes of a value.
    fn size(&self) -> usize {
        match self {
            Self::F32(_) | Self::I32(_) => 4,
            Self::F64(_) | Self::I64(_) => 8,
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

    /// Appends the value of a row.
    fn put(&self, row: usize, out: &mut Vec<u8>) {
        match self {
            Self::F32(values) => out.extend(values[row].to_be_bytes()),
            Self::F64(values) => out.extend(values[row].to_be_bytes()),
            Self::I32(values) => out.extend(values[row].to_be_bytes()),
            Self::I64(values) => out.extend(values[row].to_be_bytes()),
        }
    }
}

/// Bytes that are handed over together, in whole rows.
const PIECE: usize = 1 << 18;

impl Writer {
    /// Opens the file for writing and empties it; its name is taken literally.
    ///
    /// # Errors
    /// [`WriteError::Io`] if the system refuses.
    pub fn create(path: &Path) -> Result<Self, WriteError> {
        let file = File::create(path).map_err(|reason| WriteError::io(path, reason))?;
        Ok(Self { out: BufWriter::with_capacity(PIECE, file), path: path.to_owned(), begun: false })
    }

    /// Appends an image HDU (the first one is the primary) whose rows come one by one from `row(y, out)`, row 0 first.
    ///
    /// # Errors
    /// [`WriteError::Io`] if the system refuses, for instance on a full disk.
    pub fn image<T: Sample>(
        &mut self,
        (width, height): (usize, usize),
        entries: &[Entry],
        mut row: impl FnMut(usize, &mut [T]),
    ) -> Result<(), WriteError> {
        let mut cards = self.first_cards("IMAGE", T::BITPIX, &[width, height]);
        cards.extend(entries.iter().flat_map(cards_of));
        self.hdu(cards, |data| {
            let mut line = vec![T::default(); width];
            let mut bytes = Vec::with_capacity(PIECE);
            for y in 0..height {
                row(y, &mut line);
                let first = bytes.len();
                bytes.resize(first + line.len() * size_of::<[u8; 4]>(), 0);
                let places = bytes[first..].as_chunks_mut().0;
                places.iter_mut().zip(&line).for_each(|(place, sample)| *place = sample.bytes());
                data.flush_beyond(PIECE / 2, &mut bytes)?;
            }
            data.flush_beyond(0, &mut bytes)
        })
    }

    /// Appends a binary table (after an empty primary HDU if it is the first).
    ///
    /// # Errors
    /// [`WriteError::Io`] if the columns differ in length or the system refuses.
    pub fn table(&mut self, name: &str, entries: &[Entry], columns: &[Column<'_>]) -> Result<(), WriteError> {
        let rows = columns.first().map_or(0, |column| column.data.len());
        if let Some(odd) = columns.iter().find(|column| column.data.len() != rows) {
            let text = format!("column {} has {} rows, not {rows}", odd.name, odd.data.len());
            return Err(WriteError::io(&self.path, io::Error::new(ErrorKind::InvalidInput, text)));
        }
        if !self.begun {
            let cards = self.first_cards("", 8, &[]);
            self.hdu(cards, |_| Ok(()))?;
        }
        let row_bytes = columns.iter().map(|column| column.data.size()).sum();
        let mut cards = self.first_cards("BINTABLE", 8, &[row_bytes, rows]);
        cards.push(fixed("TFIELDS", columns.len() as i64));
        for (number, column) in (1..).zip(columns) {
            cards.extend(text_cards(&format!("TTYPE{number}"), column.name));
            cards.extend(text_cards(&format!("TFORM{number}"), column.data.format()));
            if !column.unit.is_empty() {
                cards.extend(text_cards(&format!("TUNIT{number}"), column.unit));
            }
            cards.extend(text_cards(&format!("TCOMM{number}"), column.description));
        }
        cards.extend(text_cards("EXTNAME", name));
        cards.extend(entries.iter().flat_map(cards_of));
        self.hdu(cards, |data| {
            let mut bytes = Vec::with_capacity(PIECE);
            for row in 0..rows {
                columns.iter().for_each(|column| column.data.put(row, &mut bytes));
                data.flush_beyond(PIECE / 2, &mut bytes)?;
            }
            data.flush_beyond(0, &mut bytes)
        })
    }

    /// Completes the file.
    ///
    /// # Errors
    /// [`WriteError::Io`] if the last bytes cannot be written.
    pub fn finish(mut self) -> Result<(), WriteError> {
        self.out.flush().map_err(|reason| WriteError::io(&self.path, reason))
    }

    /// The mandatory cards of the next HDU.
    fn first_cards(&self, extension: &str, bitpix: i64, axes: &[usize]) -> Vec<Card> {
        let mut cards = match self.begun {
            false => vec![fixed("SIMPLE", true)],
            true => text_cards("XTENSION", extension),
        };
        cards.extend([fixed("BITPIX", bitpix), fixed("NAXIS", axes.len() as i64)]);
        cards.extend((1..).zip(axes).map(|(n, &length)| fixed(&format!("NAXIS{n}"), length as i64)));
        match self.begun {
            false => cards.push(fixed("EXTEND", true)),
            true => cards.extend([fixed("PCOUNT", 0), fixed("GCOUNT", 1)]),
        }
        cards
    }

    /// Writes an HDU: the header with room for the sums, the data, and the header again with the sums.
    fn hdu(
        &mut self,
        mut cards: Vec<Card>,
        data: impl FnOnce(&mut Data<'_>) -> io::Result<()>,
    ) -> Result<(), WriteError> {
        self.begun = true;
        if cards.iter().any(|card| card.keyword() == "CONTINUE") {
            // Readers from before the standard took continued texts up want to be told.
            cards.extend(text_cards("LONGSTRN", "OGIP 1.0"));
        }
        let write = || -> io::Result<()> {
            let start = self.out.stream_position()?;
            self.out.write_all(&header(&cards, "0", ZEROS))?;
            let mut written = Data { out: &mut self.out, sum: Sum::default(), bytes: 0 };
            data(&mut written)?;
            written.pad()?;
            let mut sum = written.sum;
            let data_sum = sum.value().to_string();
            sum.add(&header(&cards, &data_sum, ZEROS));
            self.out.seek(SeekFrom::Start(start))?;
            self.out.write_all(&header(&cards, &data_sum, &sum.text()))?;
            self.out.seek(SeekFrom::End(0)).map(|_| ())
        };
        write().map_err(|reason| WriteError::io(&self.path, reason))
    }
}

/// The data unit that is being written.
struct Data<'a> {
    out: &'a mut BufWriter<File>,
    sum: Sum,
    bytes: usize,
}

impl Data<'_> {
    /// Writes what has gathered if it is more than `most` bytes; whole words of four.
    fn flush_beyond(&mut self, most: usize, gathered: &mut Vec<u8>) -> io::Result<()> {
        if gathered.len() > most {
            self.sum.add(gathered);
            self.bytes += gathered.len();
            self.out.write_all(gathered)?;
            gathered.clear();
        }
        Ok(())
    }

    fn pad(&mut self) -> io::Result<()> {
        let rest = self.bytes.next_multiple_of(BLOCK) - self.bytes;
        self.out.write_all(&vec![0; rest])
    }
}

/// What stands for `CHECKSUM` while it is computed.
const ZEROS: &str = "0000000000000000";

/// The bytes of a header with the two sums.
fn header(cards: &[Card], data_sum: &str, checksum: &str) -> Vec<u8> {
    let sums = [text_cards("CHECKSUM", checksum), text_cards("DATASUM", data_sum), vec![Card::new("END")]];
    let mut bytes: Vec<u8> = cards.iter().chain(sums.iter().flatten()).flat_map(|card| card.0).collect();
    bytes.resize(bytes.len().next_multiple_of(BLOCK), b' ');
    bytes
}

fn fixed(keyword: &str, value: impl Into<Value>) -> Card {
    entry::fixed_card(keyword, &value.into(), "").unwrap_or(Card::new(""))
}

fn text_cards(keyword: &str, text: &str) -> Vec<Card> {
    entry::text_cards(keyword, text, "")
}

fn cards_of(entry: &Entry) -> Vec<Card> {
    match entry {
        Entry::Copy(card) => vec![Card::new(&card.text())],
        Entry::Key(keyword, value, comment) => match entry::fixed_card(keyword, value, comment) {
            Some(card) => vec![card],
            None => entry::text_cards(keyword, &text_of(value), comment),
        },
    }
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

    #[test]
    fn columns_of_two_lengths_are_refused() {
        let path = std::env::temp_dir().join(format!("skyfront-columns-{}.fits", std::process::id()));
        let mut file = Writer::create(&path).unwrap();
        let column = |name, data| Column { name, unit: "", description: "", data };
        let columns = [column("id", ColumnData::I32(&[1, 2])), column("flux", ColumnData::F64(&[1.5]))];
        let error = file.table("SOURCES", &[], &columns).unwrap_err().to_string();
        assert!(error.contains("flux has 1 rows, not 2"), "{error}");
        std::fs::remove_file(path).unwrap();
    }
}
