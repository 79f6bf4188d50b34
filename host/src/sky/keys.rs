//! The keywords of one coordinate system of a header, read strictly: what is there and cannot be read
//! is no absent keyword, and no default takes its place.

use crate::read::{Card, Header};
use std::collections::HashMap;

/// Keywords of a whole system.
const WHOLE: [&str; 6] = ["LONPOLE", "LATPOLE", "EQUINOX", "EPOCH", "RADESYS", "RADECSYS"];
/// Those of the whole image that no letter follows.
const LETTERLESS: [&str; 2] = ["EPOCH", "RADECSYS"];
/// Keywords of an axis.
const PER_AXIS: [&str; 6] = ["CTYPE", "CUNIT", "CRVAL", "CRPIX", "CDELT", "CROTA"];
/// Keywords whose values are text.
const TEXTS: [&str; 5] = ["CTYPE", "CUNIT", "RADESYS", "RADECSYS", "PLTDECSN"];
/// Keywords of a photographic plate, but for its coefficients.
const PLATE: [&str; 13] = [
    "PPO3", "PPO6", "XPIXELSZ", "YPIXELSZ", "CNPIX1", "CNPIX2", "PLTRAH", "PLTRAM", "PLTRAS", "PLTDECSN", "PLTDECD",
    "PLTDECM", "PLTDECS",
];
/// Its coefficients.
const PLATE_TERMS: [&str; 2] = ["AMDX", "AMDY"];
/// Polynomials of SIP.
const SIP: [&str; 2] = ["A_", "B_"];

/// The values of the first two axes.
#[derive(Debug, Default)]
pub struct Keys {
    texts: HashMap<String, String>,
    numbers: HashMap<String, f64>,
}

impl Keys {
    /// The keywords of the system with this letter; without one the primary system. Of several equal
    /// keywords the last counts, as in wcslib.
    ///
    /// # Errors
    /// The first card that is there and cannot be read.
    pub fn of(header: &Header, letter: Option<char>) -> Result<Keys, String> {
        let mut keys = Keys::default();
        for card in header.cards() {
            let raw = card.keyword();
            let keyword = raw.trim_start().to_ascii_uppercase();
            let Some(name) = standard(&keyword, letter) else { continue };
            if keyword != raw {
                return Err(unreadable(card, "keywords are in capital letters"));
            }
            keys.add(name, card)?;
        }
        Ok(keys)
    }

    fn add(&mut self, name: String, card: &Card) -> Result<(), String> {
        if !card.has_value() {
            return Err(unreadable(card, "an equals sign and a blank belong before the value"));
        }
        // A card with a blank value leaves it undefined (FITS standard 4.0, section 4.1.2.3).
        let Some(value) = card.value() else { return Ok(()) };
        if name.starts_with("WAT") {
            self.texts.insert(name, value);
        } else if TEXTS.iter().any(|text| name.starts_with(text)) {
            self.texts.insert(name, value.trim().to_owned());
        } else {
            let number = crate::read::header::real(&value).ok_or_else(|| unreadable(card, "it is no number"))?;
            self.numbers.insert(name, number);
        }
        Ok(())
    }

    /// A text.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.texts.get(name).map(String::as_str)
    }

    /// A number.
    pub fn real(&self, name: &str) -> Option<f64> {
        self.numbers.get(name).copied()
    }

    /// The pieces of a long text whose keywords begin with `prefix`, in order. Each fills its card: what
    /// blanks a reader has cut off its end separate it from the next.
    pub fn pieces(&self, prefix: &str) -> String {
        const LENGTH: usize = 68;
        let numbered = |(name, text): (&String, &String)| Some((number(name.strip_prefix(prefix)?)?, text.clone()));
        let mut pieces: Vec<(u16, String)> = self.texts.iter().filter_map(numbered).collect();
        pieces.sort_unstable();
        pieces.iter().map(|(_, text)| format!("{text:LENGTH$}")).collect()
    }

    /// The same without the parameters of the projection (`PVi_m`).
    pub fn without_parameters(&self) -> Keys {
        let numbers = self.numbers.iter().filter(|(name, _)| !name.starts_with("PV"));
        Keys { texts: self.texts.clone(), numbers: numbers.map(|(name, &value)| (name.clone(), value)).collect() }
    }

    /// The same with these numbers as the parameters of an axis.
    pub fn with_parameters(&self, axis: usize, parameters: &[(usize, f64)]) -> Keys {
        let mut keys = self.without_parameters();
        keys.numbers.extend(parameters.iter().map(|(m, value)| (format!("PV{axis}_{m}"), *value)));
        keys
    }

    /// The names and values of all numbers that begin with `prefix`.
    pub fn numbers<'a>(&'a self, prefix: &'a str) -> impl Iterator<Item = (&'a str, f64)> {
        self.numbers.iter().filter_map(move |(name, &value)| Some((name.strip_prefix(prefix)?, value)))
    }
}

fn unreadable(card: &Card, why: &str) -> String {
    format!("card {:?} cannot be read: {why}", card.text().trim_end())
}

/// The standard's name, without the system's letter, of a keyword that matters to this system. Old
/// matrices are numbered `PC001002` or `PC01_02`.
fn standard(keyword: &str, letter: Option<char>) -> Option<String> {
    if SIP.iter().any(|name| keyword.strip_prefix(name).is_some_and(is_power)) {
        return Some(keyword.to_owned());
    }
    if letter.is_none() && (LETTERLESS.contains(&keyword) || is_plate(keyword) || is_piece(keyword)) {
        return Some(keyword.to_owned());
    }
    let base = match letter {
        Some(letter) => keyword.strip_suffix(letter)?,
        None => keyword,
    };
    if WHOLE.contains(&base) && !LETTERLESS.contains(&base) {
        return Some(base.to_owned());
    }
    if let Some((name, axis)) = PER_AXIS.iter().find_map(|name| Some((name, base.strip_prefix(name)?))) {
        return matches!(axis, "1" | "2").then(|| format!("{name}{axis}"));
    }
    let (name, numbers) = base.split_at_checked(2)?;
    let (i, j) = match (numbers.split_once('_'), numbers.len()) {
        (Some(pair), _) => pair,
        (None, 6) => numbers.split_at_checked(3)?,
        _ => return None,
    };
    let (i, j) = (number(i)?, number(j)?);
    let planar = (1..=2).contains(&i) && (name == "PV" || (1..=2).contains(&j));
    (matches!(name, "CD" | "PC" | "PV") && planar).then(|| format!("{name}{i}_{j}"))
}

/// Whether a keyword belongs to a photographic plate.
fn is_plate(keyword: &str) -> bool {
    let term = |name: &&str| keyword.strip_prefix(*name).is_some_and(|n| number(n).is_some());
    PLATE.contains(&keyword) || PLATE_TERMS.iter().any(term)
}

/// Whether a keyword holds a piece of the text of one of the first two axes, `WATi_nnn`.
fn is_piece(keyword: &str) -> bool {
    let numbers = keyword.strip_prefix("WAT").and_then(|rest| rest.split_once('_'));
    numbers.is_some_and(|(axis, n)| matches!(axis, "1" | "2") && number(n).is_some())
}

/// Whether a SIP keyword goes on with a pair of powers, or is the order.
fn is_power(rest: &str) -> bool {
    rest == "ORDER" || rest.split_once('_').is_some_and(|(p, q)| number(p).is_some() && number(q).is_some())
}

fn number(digits: &str) -> Option<u16> {
    digits.bytes().all(|byte| byte.is_ascii_digit()).then(|| digits.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keywords_of_a_system_are_told_apart() {
        for (keyword, letter, name) in [
            ("CRVAL1", None, Some("CRVAL1")),
            ("CRVAL1A", None, None),
            ("CRVAL1A", Some('A'), Some("CRVAL1")),
            ("CRVAL1", Some('A'), None),
            ("CRVAL3", None, None),
            ("PC001002", None, Some("PC1_2")),
            ("PC01_02", None, Some("PC1_2")),
            ("CD2_1B", Some('B'), Some("CD2_1")),
            ("PV2_13", None, Some("PV2_13")),
            ("PV3_1", None, None),
            ("A_ORDER", Some('A'), Some("A_ORDER")),
            ("A_1_2", None, Some("A_1_2")),
            ("AP_1_2", None, None),
            ("LONPOLEA", Some('A'), Some("LONPOLE")),
            ("EPOCH", None, Some("EPOCH")),
            ("GAIN", None, None),
            ("PCOUNT", None, None),
        ] {
            assert_eq!(standard(keyword, letter).as_deref(), name, "{keyword} {letter:?}");
        }
    }
}
