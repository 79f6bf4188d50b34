//! Why a file could not be read, in one line that names the file, the HDU, the reason and the way out.

use std::path::{Path, PathBuf};

/// A file that was refused: which one, where in it, and why.
#[derive(Debug, thiserror::Error)]
#[error("{}{}: {}", one_line(&file.display().to_string()), place(*hdu), one_line(&fault.to_string()))]
pub struct ReadError {
    /// The file as the caller named it.
    pub file: PathBuf,
    /// Number of the HDU (0 = primary) where the fault was found, if it concerns one.
    pub hdu: Option<usize>,
    /// The reason. It is part of the line and therefore not given as a source as well.
    pub fault: Fault,
}

/// The reason why a file was refused.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// The operating system refused to open or read the file.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// A directory was named.
    #[error("is a directory; name a file inside it")]
    Directory,
    /// The first bytes are those of no known format.
    #[error("is not a FITS, PGM or PNG file ({0})")]
    UnknownFormat(&'static str),
    /// The compressed stream around the file is broken or not supported.
    #[error("{0}; decompress it with the tool that made it and try again")]
    Wrapping(String),
    /// A header that breaks the FITS standard in a way that leaves the layout unknown.
    #[error("broken header: {0}")]
    Header(String),
    /// No HDU of the file holds a two-dimensional image.
    #[error("no 2-D image in this file ({0}); FILE[*,*,1] is the first plane of a cube")]
    NoImage(String),
    /// The wanted HDU does not exist.
    #[error("no HDU {wanted}; the file has {present}")]
    NoSuchHdu {
        /// What was asked for.
        wanted: String,
        /// The HDUs of the file, number and name.
        present: String,
    },
    /// The wanted HDU is not a two-dimensional image.
    #[error("{0}, not a 2-D image; choose another HDU with --hdu, or a plane of a cube with FILE[*,*,1]")]
    NotTwoDimensional(String),
    /// The file ends before the data its header promises.
    #[error(
        "truncated: the header promises {promised} bytes of data, the file holds {present}; copy or download it again"
    )]
    Truncated {
        /// Bytes of the data unit according to the header.
        promised: u128,
        /// Bytes of it that can be there at most.
        present: u64,
    },
    /// The image does not fit in memory.
    #[error(
        "an image of {width} x {height} pixels needs {megabytes} MB of memory, which are not available; cut it into pieces"
    )]
    Memory {
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
        /// Memory for its pixels, in 10^6 bytes.
        megabytes: u64,
    },
    /// The caller does not want an image of this size.
    #[error("{0}")]
    Refused(String),
    /// Data that contradict their own description.
    #[error("corrupt data: {0}; copy or download the file again")]
    Corrupt(String),
    /// A legal variety that this program does not read.
    #[error("not supported: {0}")]
    Unsupported(String),
    /// A section that the image does not have.
    #[error("{0}")]
    Section(String),
    /// Every pixel is NaN, BLANK or infinite.
    #[error("every pixel is undefined or infinite; nothing can be measured")]
    NothingDefined,
}

impl Fault {
    /// The error for `file`, without a place in it.
    pub(super) fn in_file(self, file: &Path) -> ReadError {
        ReadError { file: file.to_owned(), hdu: None, fault: self }
    }
}

/// Text as one line: control characters, which names and header values may hold, are escaped; other letters stay.
fn one_line(text: &str) -> String {
    text.chars().flat_map(|c| if c.is_control() { c.escape_default().collect() } else { vec![c] }).collect()
}

fn place(hdu: Option<usize>) -> String {
    hdu.map_or_else(String::new, |number| format!(", HDU {number}"))
}
