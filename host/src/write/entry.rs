//! Header entries to be written: keyword, value, comment.

use crate::read::Card;

/// A value of a header entry.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Text of any length; what does not fit in one card is continued (`CONTINUE`). Written in ASCII.
    Text(String),
    /// An integer.
    Integer(i64),
    /// A finite number, written with as many digits as are needed to read the same bits again.
    Real(f64),
    /// `T` or `F`.
    Logical(bool),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Integer(value) => value.fmt(f),
            Self::Real(value) => value.fmt(f),
            Self::Logical(value) => value.fmt(f),
        }
    }
}

/// One header entry.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// A keyword of at most eight capital letters and digits (longer ones become `HIERARCH`), its value, a comment.
    Key(String, Value, String),
    /// A card copied as it is.
    Copy(Card),
}

impl Entry {
    /// An entry from its three parts.
    pub fn new(keyword: &str, value: impl Into<Value>, comment: &str) -> Self {
        Self::Key(keyword.to_owned(), value.into(), comment.to_owned())
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<i64> for Value {
    fn from(value: i64) -> Self {
        Self::Integer(value)
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Self::Real(value)
    }
}

impl From<bool> for Value {
    fn from(value: bool) -> Self {
        Self::Logical(value)
    }
}

/// Text as FITS headers allow it: printable ASCII, everything else as an escape such as `\u{e4}`.
pub(super) fn ascii(text: &str) -> String {
    let keep = |c: char| matches!(c, ' '..='~');
    text.chars().flat_map(|c| if keep(c) { vec![c] } else { c.escape_default().collect() }).collect()
}

/// The card of a value that is not text, in fixed format; `None` for text, and for numbers that FITS cannot write.
pub(super) fn fixed_card(keyword: &str, value: &Value, comment: &str) -> Option<Card> {
    let token = match value {
        Value::Integer(value) => value.to_string(),
        Value::Real(value) if value.is_finite() => format!("{value:?}").replace('e', "E"),
        Value::Logical(value) => if *value { "T" } else { "F" }.to_owned(),
        Value::Real(_) | Value::Text(_) => return None,
    };
    let head = if keyword.len() <= 8 { format!("{keyword:<8}= ") } else { format!("HIERARCH {keyword} = ") };
    Some(Card::new(&format!("{head}{token:>20} / {}", ascii(comment))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cards_read_back_as_written() {
        for (value, text) in [(Value::Integer(-7), "-7"), (Value::Real(1e-300), "1E-300"), (Value::Logical(true), "T")]
        {
            let card = fixed_card("KEY", &value, "note").unwrap();
            assert_eq!(card.value().as_deref(), Some(text));
            assert!(card.text().contains("/ note"));
        }
        assert_eq!(fixed_card("KEY", &Value::Real(f64::NAN), ""), None);
    }

    #[test]
    fn text_is_made_ascii() {
        assert_eq!(ascii("näme\n1"), "n\\u{e4}me\\n1");
    }
}
