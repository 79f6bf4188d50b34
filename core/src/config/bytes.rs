//! A configuration as bytes: the parameter table that a flight computer keeps, loads and checks.
//!
//! Little-endian words of 32 bits: "SkyP", the version of the format, the CRC-32 of all names and words of the
//! parameters, then three words for each parameter in the order of [`PARAMETERS`], and the CRC-32 of everything
//! before. Of a parameter's words the first is 0 where the configuration has no value for it; else its lower half
//! tells the word (0 for none, else its place in the parameter's list, from 1), its upper half the numbers
//! (1 none, 2 whole, 3 one, 4 two). The others are the numbers, whole or as bits of an `f32`.

use super::parameter::{Numbers, Parameter, Value};
use super::{Config, PARAMETERS};
use crate::arithmetic::digest::Digest;
use crate::error::Error;
use core::fmt;

/// "SkyP", little-endian.
const MAGIC: u32 = 0x5079_6B53;
/// Changes with the format.
const VERSION: u32 = 1;
/// Words before the parameters, of a parameter, and after them.
const WORDS: (usize, usize, usize) = (3, 3, 1);

/// Why a parameter table is not taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TableError {
    /// It has another length.
    Length {
        /// Its bytes.
        given: usize,
        /// The bytes of a table.
        needed: usize,
    },
    /// It is no parameter table, or one of another version.
    Foreign {
        /// What differs.
        what: &'static str,
    },
    /// Its checksum fails.
    Damaged,
    /// A parameter has a value of a form that it cannot have.
    Form {
        /// Its name.
        name: &'static str,
    },
    /// A parameter is out of its bounds, or two do not go together.
    Value(Error),
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TableError::Length { given, needed } => {
                write!(f, "the parameter table has {given} bytes, but must have {needed}")
            }
            TableError::Foreign { what } => write!(f, "the parameter table has another {what}"),
            TableError::Damaged => f.write_str("the parameter table is damaged: its checksum fails"),
            TableError::Form { name } => write!(f, "{name} has no value of this form"),
            TableError::Value(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for TableError {}

/// Bytes of a parameter table.
pub fn length() -> usize {
    let (before, each, after) = WORDS;
    each.saturating_mul(PARAMETERS.len()).saturating_add(before).saturating_add(after).saturating_mul(4)
}

/// The CRC-32 of all names and words: tables of programs with other parameters differ in it.
fn vocabulary() -> u32 {
    let mut digest = Digest::default();
    for parameter in PARAMETERS {
        digest.bytes(parameter.name.as_bytes());
        digest.bytes(&[0]);
        for word in parameter.words {
            digest.bytes(word.name.as_bytes());
            digest.bytes(&[1]);
        }
    }
    digest.value()
}

fn checksum(bytes: &[u8]) -> u32 {
    let mut digest = Digest::default();
    digest.bytes(bytes);
    digest.value()
}

/// A parameter's three words.
fn code(parameter: &Parameter, config: &Config) -> [u32; 3] {
    let Some(Value { word, numbers }) = parameter.get(config) else { return [0; 3] };
    let place = word.and_then(|word| parameter.words.iter().position(|known| known.name == word));
    let place = place.map_or(0, |place| place.saturating_add(1)) as u32;
    let (kind, first, second) = match numbers {
        Numbers::None => (1, 0, 0),
        Numbers::Whole(number) => (2, number, 0),
        Numbers::One(number) => (3, number.to_bits(), 0),
        Numbers::Two(one, other) => (4, one.to_bits(), other.to_bits()),
    };
    [kind << 16 | place, first, second]
}

/// The value of a parameter's three words; none where it cannot have such a value.
fn value(parameter: &Parameter, [head, first, second]: [u32; 3]) -> Option<Value> {
    let number = |bits: u32| Some(f32::from_bits(bits)).filter(|number| number.is_finite());
    let numbers = match head >> 16 {
        1 => Numbers::None,
        2 => Numbers::Whole(first),
        3 => Numbers::One(number(first)?),
        4 => Numbers::Two(number(first)?, number(second)?),
        _ => return None,
    };
    let (word, form) = match (head & 0xFFFF) as usize {
        0 => (None, parameter.bare),
        place => parameter.words.get(place.saturating_sub(1)).map(|word| (Some(word.name), word.numbers))?,
    };
    let same = core::mem::discriminant(&form) == core::mem::discriminant(&numbers);
    same.then_some(Value { word, numbers })
}

impl Config {
    /// Writes the configuration as a parameter table of [`length`] bytes; the rest of `out` is left as it is.
    ///
    /// ```
    /// use skyfront_core::config::{Config, bytes::length};
    ///
    /// let mut table = vec![0; length()];
    /// Config::STAR_TRACKER.to_bytes(&mut table)?;
    /// assert_eq!(Config::from_bytes(&table), Ok(Config::STAR_TRACKER));
    /// # Ok::<(), skyfront_core::error::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Length`] where `out` is too short.
    pub fn to_bytes(&self, out: &mut [u8]) -> Result<(), Error> {
        let (given, needed) = (out.len(), length());
        let Some((body, end)) = out.get_mut(..needed).and_then(|out| out.split_last_chunk_mut::<4>()) else {
            return Err(Error::Length { name: "the parameter table", given, needed });
        };
        let head = [MAGIC, VERSION, vocabulary()];
        let words = head.into_iter().chain(PARAMETERS.iter().flat_map(|parameter| code(parameter, self)));
        for (to, word) in body.chunks_exact_mut(4).zip(words) {
            to.iter_mut().zip(word.to_le_bytes()).for_each(|(to, byte)| *to = byte);
        }
        *end = checksum(body).to_le_bytes();
        Ok(())
    }

    /// Reads a parameter table, field by field, and checks every value.
    ///
    /// # Errors
    /// [`TableError`] names what is wrong; for a value the parameter, the value and its bound.
    pub fn from_bytes(bytes: &[u8]) -> Result<Config, TableError> {
        let (given, needed) = (bytes.len(), length());
        let Some((body, end)) = bytes.split_last_chunk::<4>().filter(|_| given == needed) else {
            return Err(TableError::Length { given, needed });
        };
        let mut words = body.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word));
        for (expected, what) in [(MAGIC, "kind of contents"), (VERSION, "format version")] {
            if words.next() != Some(expected) {
                return Err(TableError::Foreign { what });
            }
        }
        if checksum(body) != u32::from_le_bytes(*end) {
            return Err(TableError::Damaged);
        }
        if words.next() != Some(vocabulary()) {
            return Err(TableError::Foreign { what: "list of parameters" });
        }
        let mut config = Config::NOISE_AWARE;
        for parameter in PARAMETERS {
            let mut word = || words.next().unwrap_or(0);
            let code = [word(), word(), word()];
            if code != [0; 3] {
                let value = value(parameter, code).ok_or(TableError::Form { name: parameter.name })?;
                parameter.set(&mut config, value).map_err(TableError::Value)?;
            }
        }
        config.validate_values().map_err(TableError::Value)?;
        Ok(config)
    }
}

#[cfg(test)]
#[allow(clippy::arithmetic_side_effects, reason = "a test that overflows fails")]
mod tests {
    use super::*;

    extern crate std;
    use std::string::ToString;
    use std::vec::Vec;

    const PRESETS: [Config; 6] = [
        Config::NOISE_AWARE,
        Config::STAR_TRACKER,
        Config::RSA,
        Config::PAPER_F160,
        Config::PAPER_REAL,
        Config::CHAN_VESE,
    ];

    fn bytes(config: &Config) -> Vec<u8> {
        let mut bytes = std::vec![0; length()];
        config.to_bytes(&mut bytes).unwrap();
        bytes
    }

    /// Makes the checksum right again.
    fn signed(mut bytes: Vec<u8>) -> Vec<u8> {
        let (body, end) = bytes.split_last_chunk_mut::<4>().unwrap();
        *end = checksum(body).to_le_bytes();
        bytes
    }

    fn place(name: &str) -> usize {
        4 * (WORDS.0 + WORDS.1 * PARAMETERS.iter().position(|parameter| parameter.name == name).unwrap())
    }

    #[test]
    fn a_table_gives_the_same_configuration_again() {
        for preset in PRESETS {
            let read = Config::from_bytes(&bytes(&preset)).unwrap();
            assert_eq!(read.digest(), preset.digest());
            assert_eq!(bytes(&read), bytes(&preset));
        }
        let other = Config { min_area: 7, ..Config::PAPER_REAL };
        assert_eq!(Config::from_bytes(&bytes(&other)).unwrap().min_area, 7);
    }

    #[test]
    fn every_flipped_bit_is_found() {
        let good = bytes(&Config::NOISE_AWARE);
        for bit in 0..8 * good.len() {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(Config::from_bytes(&bad).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let good = bytes(&Config::NOISE_AWARE);
        let wrong = |bytes: &[u8]| Config::from_bytes(bytes).unwrap_err().to_string();
        assert!(wrong(&good[1..]).contains("but must have"));
        let changed = |at: usize, word: u32| {
            let mut bytes = good.clone();
            bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
            bytes
        };
        assert_eq!(wrong(&changed(0, 1)), "the parameter table has another kind of contents");
        assert_eq!(wrong(&changed(4, 2)), "the parameter table has another format version");
        assert_eq!(wrong(&signed(changed(8, 2))), "the parameter table has another list of parameters");
        assert_eq!(wrong(&changed(12, 2)), "the parameter table is damaged: its checksum fails");
        let threshold = place("threshold");
        assert_eq!(
            wrong(&signed(changed(threshold + 4, (-2.0f32).to_bits()))),
            "threshold is -2; must be at least 0.1"
        );
        assert_eq!(wrong(&signed(changed(threshold + 4, f32::NAN.to_bits()))), "threshold has no value of this form");
        assert_eq!(wrong(&signed(changed(threshold, 2 << 16))), "threshold has no value of this form");
        assert_eq!(wrong(&signed(changed(place("filter"), 1 << 16 | 99))), "filter has no value of this form");
        let short = Config::NOISE_AWARE.to_bytes(&mut [0; 8]);
        assert_eq!(short, Err(Error::Length { name: "the parameter table", given: 8, needed: length() }));
    }
}
