//! The layout of one HDU, from its header alone; nothing is allocated from what a header claims.

use super::error::Fault;
use super::header::{CARD, Card, Header};
use super::source::Source;

/// FITS files come in blocks of this many bytes.
pub(super) const BLOCK: u64 = 2880;
/// A header longer than this (200 000 cards) is taken for a file that is not FITS.
const HEADER_LIMIT: usize = 16 << 20;
/// More axes than this are no image, whatever their lengths.
const MOST_AXES: i64 = 9;

/// One header-data unit: what it is, and how long its data are.
pub(super) struct Hdu {
    pub(super) number: usize,
    pub(super) header: Header,
    pub(super) kind: Kind,
    /// Bytes of the data unit without padding.
    pub(super) bytes: u128,
}

/// What an HDU holds.
pub(super) enum Kind {
    /// An array: bits per value (negative for floating point) and axis lengths, fastest first.
    Array(Shape),
    /// A binary table that holds a tile-compressed array of this shape.
    Tiles(Shape),
    /// Anything else, in words.
    Other(&'static str),
}

/// Sample type and axis lengths of an array.
pub(super) struct Shape {
    pub(super) bitpix: i64,
    pub(super) axes: Vec<u64>,
}

impl Shape {
    /// The two axes of a plane, from 1: the first two if all beyond them have length 1, else the only
    /// two that are longer.
    pub(super) fn plane_axes(&self) -> Option<[usize; 2]> {
        match self.axes.as_slice() {
            [_, _, rest @ ..] if rest.iter().all(|&n| n == 1) => Some([1, 2]),
            axes if axes.contains(&0) => None,
            axes => {
                let mut long = (1..).zip(axes).filter(|(_, n)| **n > 1).map(|(axis, _)| axis);
                let pair = [long.next()?, long.next()?];
                long.next().is_none().then_some(pair)
            }
        }
    }

    /// Columns and rows, if all other axes have length 1.
    pub(super) fn plane(&self) -> Option<(u64, u64)> {
        let [x, y] = self.plane_axes()?;
        let (width, height) = (self.axes[x - 1], self.axes[y - 1]);
        (width > 0 && height > 0).then_some((width, height))
    }

    /// The same for tile-compressed data, which were made as an image: a single axis is one row.
    pub(super) fn tiled_plane(&self) -> Option<(u64, u64)> {
        match self.axes.as_slice() {
            [width] if *width > 0 => Some((*width, 1)),
            _ => self.plane().filter(|_| self.plane_axes() == Some([1, 2])),
        }
    }

    /// Columns, rows and planes of a cube, or of an image, which has one.
    pub(super) fn cube(&self) -> Option<(u64, u64, u64)> {
        match self.axes.as_slice() {
            [width, height, rest @ ..] if *width > 0 && *height > 0 && rest.iter().skip(1).all(|&n| n == 1) => {
                Some((*width, *height, rest.first().copied().unwrap_or(1)))
            }
            _ => None,
        }
    }

    /// The shape in words, such as `a 3-D array of 96 x 64 x 3`.
    pub(super) fn words(&self) -> String {
        let lengths: Vec<String> = self.axes.iter().map(u64::to_string).collect();
        match lengths.len() {
            0 => "empty (no axes)".to_owned(),
            n => format!("a {n}-D array of {}", lengths.join(" x ")),
        }
    }
}

impl Hdu {
    /// Reads the header that starts here; `None` at the end of the file or where something else than an HDU follows.
    pub(super) fn next(source: &mut Source, number: usize) -> Result<Option<Self>, Fault> {
        let Some(header) = read_header(source, number)? else { return Ok(None) };
        let axes = axes(&header, "")?;
        let bytes = data_bytes(&header, &axes)?;
        let kind = kind(&header, number, axes)?;
        Ok(Some(Self { number, header, kind, bytes }))
    }

    /// `EXTNAME`, or its older spelling `HDUNAME`.
    pub(super) fn name(&self) -> Option<String> {
        self.header.text("EXTNAME").or_else(|| self.header.text("HDUNAME")).filter(|name| !name.is_empty())
    }

    /// What the HDU is, in words, for messages.
    pub(super) fn words(&self) -> String {
        match &self.kind {
            Kind::Array(shape) | Kind::Tiles(shape) => shape.words(),
            Kind::Other(what) => (*what).to_owned(),
        }
    }

    /// Number and name, for messages.
    pub(super) fn label(&self) -> String {
        self.name().map_or_else(|| self.number.to_string(), |name| format!("{} {name}", self.number))
    }
}

/// Reads blocks up to the `END` card.
fn read_header(source: &mut Source, number: usize) -> Result<Option<Header>, Fault> {
    let mut cards = Vec::new();
    let mut block = [0u8; BLOCK as usize];
    loop {
        let got = source.fill(&mut block)?;
        if cards.is_empty() && !starts_an_hdu(&block[..got], number)? {
            return Ok(None);
        }
        for card in block[..got].as_chunks::<CARD>().0 {
            if card.trim_ascii_end() == b"END" {
                return Ok(Some(Header::new(cards)));
            }
            if !card[..8].iter().all(|b| matches!(b, b' '..=b'~')) {
                return Err(Fault::Header(format!("no END card before binary data, after card {}", cards.len())));
            }
            cards.push(Card(*card));
        }
        if got < block.len() {
            return Err(Fault::Header("the file ends inside the header, before the END card".into()));
        }
        if cards.len() * CARD > HEADER_LIMIT {
            return Err(Fault::Header(format!("no END card within {} MB", HEADER_LIMIT >> 20)));
        }
    }
}

/// Whether a block begins an HDU. For the primary that is a must; later, anything else ends the file.
fn starts_an_hdu(block: &[u8], number: usize) -> Result<bool, Fault> {
    if number > 0 {
        return Ok(block.starts_with(b"XTENSION="));
    }
    let why = match block {
        [] => "it is empty",
        _ if block.starts_with(b"SIMPLE  =") => return Ok(true),
        _ if block.trim_ascii_start().starts_with(b"SIMPLE") || block.starts_with(b"\xef\xbb\xbf") => {
            "something stands before SIMPLE"
        }
        _ if block.trim_ascii_start().starts_with(b"<") => "it looks like a web page",
        _ => "it does not begin with SIMPLE",
    };
    Err(Fault::UnknownFormat(why))
}

/// `NAXIS` and `NAXISn`, with `prefix` `Z` for the array inside a compressed table.
fn axes(header: &Header, prefix: &str) -> Result<Vec<u64>, Fault> {
    let count = required(header, &format!("{prefix}NAXIS"))?;
    if !(0..=999).contains(&count) {
        return Err(Fault::Header(format!("{prefix}NAXIS = {count}")));
    }
    (1..=count)
        .map(|n| {
            let keyword = format!("{prefix}NAXIS{n}");
            let length = required(header, &keyword)?;
            u64::try_from(length).map_err(|_| Fault::Header(format!("{keyword} = {length} is negative")))
        })
        .collect()
}

/// A keyword without which the layout is unknown.
pub(super) fn required(header: &Header, keyword: &str) -> Result<i64, Fault> {
    let text = header.text(keyword).ok_or_else(|| Fault::Header(format!("{keyword} is missing")))?;
    let short: String = text.chars().take(32).collect();
    text.trim().parse().map_err(|_| Fault::Header(format!("{keyword} = {short} is not a 64-bit integer")))
}

fn bitpix(header: &Header, keyword: &str) -> Result<i64, Fault> {
    match required(header, keyword)? {
        value @ (8 | 16 | 32 | 64 | -32 | -64) => Ok(value),
        value => Err(Fault::Header(format!("{keyword} = {value} is not one of 8, 16, 32, 64, -32, -64"))),
    }
}

/// Bytes of the data unit: |BITPIX|/8 * GCOUNT * (PCOUNT + product of the axes).
fn data_bytes(header: &Header, axes: &[u64]) -> Result<u128, Fault> {
    let sample = bitpix(header, "BITPIX")?.unsigned_abs() / 8;
    let counts = |keyword: &str, default: i64| match header.text(keyword) {
        None => Ok(default as u64),
        Some(_) => required(header, keyword)?.try_into().map_err(|_| Fault::Header(format!("{keyword} is negative"))),
    };
    let (groups, parameters) = (counts("GCOUNT", 1)?, counts("PCOUNT", 0)?);
    // Random groups (FITS standard 4.0, section 6) have a first axis of 0 that does not count.
    let random_groups = axes.first() == Some(&0) && header.flag("GROUPS");
    let lengths = if random_groups { &axes[1..] } else { axes };
    let values = lengths.iter().try_fold(u128::from(!lengths.is_empty()), |product, &n| product.checked_mul(n.into()));
    values
        .and_then(|values| values.checked_add(parameters.into()))
        .and_then(|values| values.checked_mul(groups.into()))
        .and_then(|values| values.checked_mul(sample.into()))
        .ok_or_else(|| Fault::Header("the sizes in the header exceed any file".into()))
}

fn kind(header: &Header, number: usize, axes: Vec<u64>) -> Result<Kind, Fault> {
    let extension = header.text("XTENSION").unwrap_or_default();
    let extension = extension.trim_end();
    Ok(match (number, extension) {
        (0, _) if header.flag("GROUPS") && axes.first() == Some(&0) => Kind::Other("random groups"),
        (0, _) | (_, "IMAGE" | "IUEIMAGE") => array(bitpix(header, "BITPIX")?, axes),
        (_, "BINTABLE" | "A3DTABLE") if header.flag("ZIMAGE") => {
            match array(bitpix(header, "ZBITPIX")?, self::axes(header, "Z")?) {
                Kind::Array(shape) => Kind::Tiles(shape),
                other => other,
            }
        }
        (_, "BINTABLE" | "A3DTABLE") => Kind::Other("a binary table"),
        (_, "TABLE") => Kind::Other("an ASCII table"),
        _ => Kind::Other("an extension of unknown type"),
    })
}

fn array(bitpix: i64, axes: Vec<u64>) -> Kind {
    if axes.len() as i64 > MOST_AXES {
        return Kind::Other("an array with more than 9 axes");
    }
    Kind::Array(Shape { bitpix, axes })
}
