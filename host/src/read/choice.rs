//! Which HDU of a file is wanted.

use std::fmt;
use std::str::FromStr;

use super::hdu::Hdu;

/// An HDU by number (`0` = primary) or by name (`SCI`, or `SCI,2` for its second version).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HduChoice {
    /// Position in the file, 0 = primary.
    Number(usize),
    /// `EXTNAME`, compared without regard to case, and `EXTVER` if one was given.
    Name(String, Option<i64>),
}

impl HduChoice {
    /// Whether this HDU is the wanted one.
    pub(super) fn matches(&self, hdu: &Hdu) -> bool {
        match self {
            Self::Number(number) => *number == hdu.number,
            Self::Name(name, version) => {
                let named = hdu.name().is_some_and(|own| own.eq_ignore_ascii_case(name));
                let primary = hdu.number == 0 && name.eq_ignore_ascii_case("PRIMARY");
                (named || primary) && version.is_none_or(|v| hdu.header.integer("EXTVER").unwrap_or(1) == v)
            }
        }
    }
}

impl FromStr for HduChoice {
    type Err = std::convert::Infallible;

    /// Digits are a number; anything else is a name, with a version after the last comma if that is an integer.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim();
        if let Ok(number) = text.parse() {
            return Ok(Self::Number(number));
        }
        let versioned = text.rsplit_once(',').and_then(|(name, v)| Some((name.trim(), v.trim().parse().ok()?)));
        Ok(match versioned {
            Some((name, version)) => Self::Name(name.to_owned(), Some(version)),
            None => Self::Name(text.to_owned(), None),
        })
    }
}

impl fmt::Display for HduChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Name(name, None) => f.write_str(name),
            Self::Name(name, Some(version)) => write!(f, "{name},{version}"),
        }
    }
}
