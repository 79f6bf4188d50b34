//! The binary table around a tile-compressed image: where each tile's bytes are (FITS standard 4.0, section 7.3).

use crate::read::error::Fault;
use crate::read::header::Header;

/// A table and its heap, in memory.
pub(super) struct Table<'a> {
    data: &'a [u8],
    row_bytes: usize,
    rows: usize,
    heap: usize,
    columns: Vec<Column>,
}

/// A column: its name, where it starts in a row, and its type letters.
struct Column {
    name: String,
    start: usize,
    letter: u8,
    /// Type of the elements in the heap, where the column holds descriptors (`P`, `Q`).
    element: u8,
}

/// A piece of the heap: elements of one type.
pub(super) struct Piece<'a> {
    pub(super) bytes: &'a [u8],
    /// FITS type letter of the elements: `B`, `I`, `J`, `K`, `E` or `D`.
    pub(super) element: u8,
}

impl<'a> Table<'a> {
    /// The table that a header describes, in the bytes of its data unit.
    pub(super) fn new(header: &Header, data: &'a [u8]) -> Result<Self, Fault> {
        let size = |keyword: &str| -> Result<usize, Fault> {
            header
                .integer(keyword)
                .and_then(|value| usize::try_from(value).ok())
                .ok_or_else(|| Fault::Header(format!("{keyword} is missing or negative")))
        };
        let (row_bytes, rows) = (size("NAXIS1")?, size("NAXIS2")?);
        let fixed = row_bytes.checked_mul(rows).filter(|&bytes| bytes <= data.len());
        let fixed = fixed.ok_or_else(|| Fault::Corrupt("the table is larger than its data".into()))?;
        let heap = if header.text("THEAP").is_some() { size("THEAP")? } else { fixed };
        let columns = columns(header, size("TFIELDS")?.min(999))?;
        Ok(Self { data, row_bytes, rows, heap, columns })
    }

    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name.eq_ignore_ascii_case(name))
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.column(name).is_some()
    }

    /// The bytes of one cell from its start to the end of its row.
    fn cell(&self, column: &Column, row: usize) -> Option<&'a [u8]> {
        self.data.get(row * self.row_bytes..(row + 1) * self.row_bytes)?.get(column.start..)
    }

    /// A number in a row; `None` without such a column.
    pub(super) fn number(&self, name: &str, row: usize) -> Option<f64> {
        let column = self.column(name)?;
        let cell = self.cell(column, row)?;
        match column.letter {
            b'B' => cell.first().map(|&b| b.into()),
            b'I' => cell.first_chunk().map(|b| i16::from_be_bytes(*b).into()),
            b'J' => cell.first_chunk().map(|b| i32::from_be_bytes(*b).into()),
            b'K' => cell.first_chunk().map(|b| i64::from_be_bytes(*b) as f64),
            b'E' => cell.first_chunk().map(|b| f32::from_be_bytes(*b).into()),
            b'D' => cell.first_chunk().map(|b| f64::from_be_bytes(*b)),
            _ => None,
        }
    }

    /// What a row's descriptor points to; `None` without such a column or if nothing is there.
    pub(super) fn piece(&self, name: &str, row: usize) -> Result<Option<Piece<'a>>, Fault> {
        let Some(column) = self.column(name) else { return Ok(None) };
        let descriptor = self.cell(column, row).and_then(|cell| descriptor(cell, column.letter));
        let outside = || Fault::Corrupt(format!("tile {row} lies outside the heap"));
        let (count, offset) = descriptor.ok_or_else(outside)?;
        if count == 0 {
            return Ok(None);
        }
        let start = self.heap.checked_add(offset).ok_or_else(outside)?;
        let length = count.checked_mul(element_bytes(column.element)).ok_or_else(outside)?;
        let end = start.checked_add(length).ok_or_else(outside)?;
        let bytes = self.data.get(start..end).ok_or_else(outside)?;
        Ok(Some(Piece { bytes, element: column.element }))
    }
}

/// Number of elements and offset in the heap.
fn descriptor(cell: &[u8], letter: u8) -> Option<(usize, usize)> {
    let (count, offset) = match letter {
        b'P' => {
            let (count, rest) = cell.split_first_chunk()?;
            (i64::from(i32::from_be_bytes(*count)), i64::from(i32::from_be_bytes(*rest.first_chunk()?)))
        }
        b'Q' => {
            let (count, rest) = cell.split_first_chunk()?;
            (i64::from_be_bytes(*count), i64::from_be_bytes(*rest.first_chunk()?))
        }
        _ => return None,
    };
    Some((count.try_into().ok()?, offset.try_into().ok()?))
}

fn columns(header: &Header, count: usize) -> Result<Vec<Column>, Fault> {
    let mut start = 0usize;
    let mut columns = Vec::new();
    for n in 1..=count {
        let form = header.text(&format!("TFORM{n}")).unwrap_or_default();
        let odd = || Fault::Header(format!("TFORM{n} = {form} is not a column format"));
        let letter_at = form.find(|c: char| !c.is_ascii_digit()).ok_or_else(odd)?;
        let (repeat, rest) = form.split_at(letter_at);
        let repeat: usize = if repeat.is_empty() { 1 } else { repeat.parse().map_err(|_| odd())? };
        let letter = rest.as_bytes()[0];
        let element = rest.as_bytes().get(1).copied().unwrap_or(b'B');
        let bytes = if letter == b'X' { repeat.div_ceil(8) } else { repeat.saturating_mul(element_bytes(letter)) };
        let name = header.text(&format!("TTYPE{n}")).unwrap_or_default().trim().to_owned();
        columns.push(Column { name, start, letter, element });
        start = start.saturating_add(bytes);
    }
    Ok(columns)
}

/// Bytes of one value of a FITS type.
fn element_bytes(letter: u8) -> usize {
    match letter {
        b'I' => 2,
        b'J' | b'E' => 4,
        b'K' | b'D' | b'C' | b'P' => 8,
        b'M' | b'Q' => 16,
        _ => 1,
    }
}
