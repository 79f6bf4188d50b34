//! The bytes of an input file, decompressed on the way if it is gzip or bzip2, with a checksum of the file itself.

use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::Path;

use bzip2::bufread::BzDecoder;
use flate2::bufread::GzDecoder;

use super::error::Fault;

/// Read-ahead on the file. Pixels are asked for in larger pieces, which pass it by.
const BUFFER: usize = 1 << 15;
/// The first bytes of a gzip member.
const GZIP: &[u8] = &[0x1f, 0x8b];
/// The first bytes of a bzip2 stream.
const BZIP2: &[u8] = b"BZh";
/// Deflate cannot expand a byte to more than this many (zlib's technical notes).
const DEFLATE_RATIO: u64 = 1032;
/// Nor can bzip2: a block holds 900 000 bytes, of which five stand for 259 at most, and takes 24 bytes at least.
const BZIP2_RATIO: u64 = 1 << 21;
/// No file is unpacked beyond this many bytes, whatever it holds.
const MOST_UNPACKED: u64 = 1 << 36;
/// What follows an image is unpacked, to check it, up to this many bytes.
const CHECKED: u64 = 1 << 30;

/// A file open for one pass from its first byte to its last.
pub(super) struct Source {
    stream: Stream,
    /// Bytes that were looked at and not yet read.
    ahead: Vec<u8>,
    position: u64,
    limit: Option<u64>,
}

enum Stream {
    Plain(BufReader<Summed>),
    Gzip(Box<GzDecoder<BufReader<Summed>>>),
    Bzip2(BzDecoder<BufReader<Summed>>),
}

impl Stream {
    /// The file below the decompressor.
    fn raw(&mut self) -> &mut BufReader<Summed> {
        match self {
            Stream::Plain(raw) => raw,
            Stream::Gzip(decoder) => decoder.get_mut(),
            Stream::Bzip2(decoder) => decoder.get_mut(),
        }
    }

    fn into_raw(self) -> BufReader<Summed> {
        match self {
            Stream::Plain(raw) => raw,
            Stream::Gzip(decoder) => decoder.into_inner(),
            Stream::Bzip2(decoder) => decoder.into_inner(),
        }
    }

    /// Goes on with the compressed stream behind the one that has ended, where there is one: both belong to the file
    /// (RFC 1952, section 2.2).
    fn next_member(&mut self) -> std::io::Result<bool> {
        let (first, new): (_, fn(_) -> _) = match self {
            Stream::Plain(_) => return Ok(false),
            Stream::Gzip(_) => (GZIP.first(), |raw| Stream::Gzip(Box::new(GzDecoder::new(raw)))),
            Stream::Bzip2(_) => (BZIP2.first(), |raw| Stream::Bzip2(BzDecoder::new(raw))),
        };
        let follows = self.raw().fill_buf()?.first() == first;
        if follows {
            let none = BufReader::with_capacity(0, Summed { input: Box::new(std::io::empty()), crc: <_>::default() });
            *self = new(std::mem::replace(self, Stream::Plain(none)).into_raw());
        }
        Ok(follows)
    }
}

impl Read for Stream {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        loop {
            let count = match self {
                Stream::Plain(raw) => raw.read(buffer),
                Stream::Gzip(decoder) => decoder.read(buffer),
                Stream::Bzip2(decoder) => decoder.read(buffer),
            }?;
            // A member may be empty.
            if count > 0 || buffer.is_empty() || !self.next_member()? {
                return Ok(count);
            }
        }
    }
}

/// The input below everything else: every byte read from it goes into the checksum.
struct Summed {
    input: Box<dyn Read>,
    crc: crc32fast::Hasher,
}

impl Read for Summed {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.input.read(buffer)?;
        self.crc.update(&buffer[..count]);
        Ok(count)
    }
}

impl Source {
    /// Opens a file by its name, which is taken literally.
    pub(super) fn open(path: &Path) -> Result<Self, Fault> {
        let file = File::open(path)?;
        let about = file.metadata()?;
        if about.is_dir() {
            return Err(Fault::Directory);
        }
        Self::new(Box::new(file), about.is_file().then_some(about.len()))
    }

    /// A stream of bytes, with their number if it is known, and a look at the first ones for gzip and bzip2.
    pub(super) fn new(input: Box<dyn Read>, length: Option<u64>) -> Result<Self, Fault> {
        let mut raw = BufReader::with_capacity(BUFFER, Summed { input, crc: crc32fast::Hasher::new() });
        let head = raw.fill_buf()?;
        let unpacked = |ratio: u64| length.map(|bytes| bytes.saturating_mul(ratio).min(MOST_UNPACKED));
        let (stream, limit) = if head.starts_with(GZIP) {
            (Stream::Gzip(Box::new(GzDecoder::new(raw))), unpacked(DEFLATE_RATIO))
        } else if head.starts_with(BZIP2) {
            (Stream::Bzip2(BzDecoder::new(raw)), unpacked(BZIP2_RATIO))
        } else if let Some(name) = foreign_compression(head) {
            return Err(Fault::Wrapping(format!("is compressed with {name}, which is not read here")));
        } else {
            (Stream::Plain(raw), length)
        };
        Ok(Self { stream, ahead: Vec::new(), position: 0, limit })
    }

    /// The first bytes, which are read again afterwards. For the beginning of the file only.
    pub(super) fn peek(&mut self) -> Result<&[u8], Fault> {
        let mut head = vec![0; 8];
        let count = self.fill(&mut head)?;
        head.truncate(count);
        self.position = 0;
        self.ahead = head;
        Ok(&self.ahead)
    }

    /// The most bytes that can still follow, if that is known before reading them.
    pub(super) fn at_most_left(&self) -> Option<u64> {
        self.limit.map(|limit| limit.saturating_sub(self.position))
    }

    /// Fills as much of `buffer` as the stream still holds and returns how much that is.
    pub(super) fn fill(&mut self, buffer: &mut [u8]) -> Result<usize, Fault> {
        let mut filled = 0;
        while filled < buffer.len() {
            match self.read(&mut buffer[filled..]) {
                Ok(0) => break,
                Ok(count) => filled += count,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(self.broken(error)),
            }
        }
        Ok(filled)
    }

    /// Passes over `count` bytes and returns how many of them there were.
    pub(super) fn skip(&mut self, count: u64) -> Result<u64, Fault> {
        let skipped = std::io::copy(&mut Read::take(&mut *self, count), &mut std::io::sink());
        skipped.map_err(|error| self.broken(error))
    }

    /// Reads the rest of the file and returns the CRC-32 (IEEE) of its bytes as they lie on the disk.
    pub(super) fn checksum(mut self) -> Result<u32, Fault> {
        self.skip(CHECKED)?;
        let mut raw = self.stream.into_raw();
        std::io::copy(&mut raw, &mut std::io::sink())?;
        Ok(raw.into_inner().crc.finalize())
    }

    /// A read error told as what it means for this kind of file.
    pub(super) fn broken(&self, error: std::io::Error) -> Fault {
        match self.stream {
            Stream::Plain(_) => Fault::Io(error),
            Stream::Gzip(_) => Fault::Wrapping(format!("broken gzip stream ({error})")),
            Stream::Bzip2(_) => Fault::Wrapping(format!("broken bzip2 stream ({error})")),
        }
    }
}

impl Read for Source {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = match &mut self.stream {
            _ if !self.ahead.is_empty() => {
                let count = self.ahead.len().min(buffer.len());
                self.ahead.drain(..count).zip(buffer).for_each(|(byte, to)| *to = byte);
                Ok(count)
            }
            stream => stream.read(buffer),
        }?;
        self.position += count as u64;
        Ok(count)
    }
}

/// Compressions that occur around FITS files and are refused by name.
fn foreign_compression(head: &[u8]) -> Option<&'static str> {
    const MAGIC: [(&[u8], &str); 4] = [
        (&[0x1f, 0x9d], "Unix compress"),
        (&[0xfd, b'7', b'z', b'X', b'Z'], "xz"),
        (&[0x28, 0xb5, 0x2f, 0xfd], "zstd"),
        (b"PK\x03\x04", "zip"),
    ];
    MAGIC.iter().find(|(magic, _)| head.starts_with(magic)).map(|(_, name)| *name)
}
