//! Lines of the protocol.

use core::fmt::{Display, Write};

/// `digest NAME 1a2b3c4d`: the CRC-32 of a stage's bytes, little-endian.
pub fn digest(line: &mut impl Write, name: impl Display, crc: u32) {
    // A line that cannot be written is missed by the reader, who knows every name to expect.
    let _ = writeln!(line, "digest {name} {crc:08x}");
}

/// `resource NAME VALUE UNIT`.
pub fn resource(line: &mut impl Write, name: impl Display, value: u64, unit: &str) {
    let _ = writeln!(line, "resource {name} {value} {unit}");
}

/// `done`: everything was printed.
pub fn done(line: &mut impl Write) {
    let _ = writeln!(line, "done");
}
