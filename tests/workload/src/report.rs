//! Lines of the protocol, written without `core::fmt`: it would be a good part of a small program.

use core::fmt::Write;

/// The most digits of a number.
const DIGITS: usize = 10;

/// `digest NAME 1a2b3c4d`: the CRC-32 of a stage's bytes. The parts of the name are joined by `/`.
pub fn digest(line: &mut impl Write, name: &[&str], crc: u32) {
    start(line, "digest", name);
    let nibbles = (0..8).rev().map(|n| (crc >> (4 * n)) & 15);
    nibbles.for_each(|nibble| put(line, b"0123456789abcdef", nibble as usize));
    end(line, "");
}

/// `resource NAME VALUE UNIT`; 32 bits, because the division of longer words would be a part of small programs too.
pub fn resource(line: &mut impl Write, name: &[&str], value: u32, unit: &str) {
    start(line, "resource", name);
    let (mut digits, mut rest, mut count) = ([0; DIGITS], value, 0);
    for digit in &mut digits {
        *digit = (rest % 10) as usize;
        rest /= 10;
        count += 1;
        if rest == 0 {
            break;
        }
    }
    digits.iter().take(count).rev().for_each(|&digit| put(line, b"0123456789", digit));
    end(line, unit);
}

/// `done`: everything was printed.
pub fn done(line: &mut impl Write) {
    text(line, "done\n");
}

fn start(line: &mut impl Write, what: &str, name: &[&str]) {
    text(line, what);
    for (part, separator) in name.iter().zip([" "].into_iter().chain(core::iter::repeat("/"))) {
        text(line, separator);
        text(line, part);
    }
    text(line, " ");
}

fn put(line: &mut impl Write, digits: &[u8], index: usize) {
    let digit = digits.get(index..=index).and_then(|digit| core::str::from_utf8(digit).ok());
    text(line, digit.unwrap_or("?"));
}

fn end(line: &mut impl Write, unit: &str) {
    if !unit.is_empty() {
        text(line, " ");
        text(line, unit);
    }
    text(line, "\n");
}

/// A line that cannot be written is missed by the reader, who knows every name to expect.
fn text(line: &mut impl Write, text: &str) {
    let _ = line.write_str(text);
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::String;

    #[test]
    fn lines_read_as_promised() {
        let mut text = String::new();
        digest(&mut text, &["f32", "fd"], 0x00AB_CDEF);
        resource(&mut text, &["stack"], 0, "bytes");
        resource(&mut text, &["a", "b", "c"], u32::MAX, "steps");
        done(&mut text);
        let wanted = "digest f32/fd 00abcdef\nresource stack 0 bytes\nresource a/b/c 4294967295 steps\ndone\n";
        assert_eq!(text, wanted);
    }
}
