//! FITS files made byte by byte, so that they can be wrong in every way a file can.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;

const BLOCK: usize = 2880;

/// A header under construction.
#[derive(Clone, Default)]
pub struct Header(Vec<String>);

impl Header {
    /// The header of a primary HDU with these axes.
    pub fn primary(bitpix: i32, axes: &[u64]) -> Self {
        Self::default().card("SIMPLE", "T").axes(bitpix, axes)
    }

    /// The header of an image extension.
    pub fn image(bitpix: i32, axes: &[u64]) -> Self {
        Self::default().text("XTENSION", "IMAGE").axes(bitpix, axes).card("PCOUNT", 0).card("GCOUNT", 1)
    }

    /// The header of a binary table with these column formats, `rows` of `row_bytes`, and a heap.
    pub fn table(row_bytes: usize, rows: usize, heap: usize, formats: &[(&str, &str)]) -> Self {
        let table = Self::default().text("XTENSION", "BINTABLE").axes(8, &[row_bytes as u64, rows as u64]);
        let table = table.card("PCOUNT", heap).card("GCOUNT", 1).card("TFIELDS", formats.len());
        (1..).zip(formats).fold(table, |table, (n, (name, format))| {
            table.text(&format!("TTYPE{n}"), name).text(&format!("TFORM{n}"), format)
        })
    }

    fn axes(self, bitpix: i32, axes: &[u64]) -> Self {
        let header = self.card("BITPIX", bitpix).card("NAXIS", axes.len());
        (1..).zip(axes).fold(header, |header, (n, length)| header.card(&format!("NAXIS{n}"), length))
    }

    /// Appends a card with a bare value.
    pub fn card(self, keyword: &str, value: impl ToString) -> Self {
        self.line(&format!("{keyword:<8}= {:>20}", value.to_string()))
    }

    /// Appends a card with a string value.
    pub fn text(self, keyword: &str, value: &str) -> Self {
        self.line(&format!("{keyword:<8}= '{value:<8}'"))
    }

    /// Appends any line as a card.
    pub fn line(mut self, line: &str) -> Self {
        self.0.push(line.to_owned() + &" ".repeat(80 - line.len()));
        self
    }

    /// Leaves out the cards that begin with `keyword`.
    pub fn without(mut self, keyword: &str) -> Self {
        self.0.retain(|card| !card.starts_with(keyword));
        self
    }

    /// The bytes of the header block.
    pub fn bytes(self) -> Vec<u8> {
        padded(self.line("END").0.concat().into_bytes(), b' ')
    }

    /// The bytes of header and data, both padded to whole blocks.
    pub fn with(self, data: Vec<u8>) -> Vec<u8> {
        [self.bytes(), padded(data, 0)].concat()
    }
}

/// Fills up the last block.
pub fn padded(mut bytes: Vec<u8>, fill: u8) -> Vec<u8> {
    bytes.resize(bytes.len().div_ceil(BLOCK) * BLOCK, fill);
    bytes
}

/// Values as big-endian samples of a `BITPIX`.
pub fn samples(bitpix: i32, values: &[f64]) -> Vec<u8> {
    let bytes = |&value: &f64| match bitpix {
        8 => vec![value as u8],
        16 => (value as i16).to_be_bytes().to_vec(),
        32 => (value as i32).to_be_bytes().to_vec(),
        64 => (value as i64).to_be_bytes().to_vec(),
        -32 => (value as f32).to_be_bytes().to_vec(),
        _ => value.to_be_bytes().to_vec(),
    };
    values.iter().flat_map(bytes).collect()
}

/// A gzip member.
pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).expect("writing to memory");
    encoder.finish().expect("writing to memory")
}

/// A bzip2 stream.
pub fn bzip2(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::best());
    encoder.write_all(bytes).expect("writing to memory");
    encoder.finish().expect("writing to memory")
}

/// A tile-compressed image whose tiles are rows, behind an empty primary HDU: one piece of heap per tile.
pub fn tiled(
    bitpix: i32,
    (width, height): (u64, u64),
    coding: &str,
    column: &str,
    pieces: &[Vec<u8>],
    more: impl FnOnce(Header) -> Header,
) -> Vec<u8> {
    let mut rows = Vec::new();
    let mut heap = Vec::new();
    for piece in pieces {
        rows.extend((piece.len() as i32).to_be_bytes());
        rows.extend((heap.len() as i32).to_be_bytes());
        heap.extend_from_slice(piece);
    }
    let header = Header::table(8, pieces.len(), heap.len(), &[(column, "1PB")])
        .card("ZIMAGE", "T")
        .text("ZCMPTYPE", coding)
        .card("ZBITPIX", bitpix)
        .card("ZNAXIS", 2)
        .card("ZNAXIS1", width)
        .card("ZNAXIS2", height);
    [Header::primary(8, &[]).bytes(), more(header).with([rows, heap].concat())].concat()
}
