//! Header entries to be written: keyword, value, comment.

use crate::read::Card;
use crate::read::header::CARD;

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
///
/// ```
/// use skyfront::write::Entry;
///
/// let entries = [Entry::new("EXPTIME", 120.5, "seconds"), Entry::new("OBJECT", "M 13", "")];
/// assert!(matches!(&entries[0], Entry::Key(keyword, ..) if keyword == "EXPTIME"));
/// ```
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

/// The keyword of what is told again of the image with a number, from 2 on: a keyword has eight letters.
pub fn numbered(keyword: &str, number: usize) -> String {
    format!("{keyword:.6}{number}")
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
    let comment = if comment.is_empty() { String::new() } else { format!(" / {}", ascii(comment)) };
    Some(Card::new(&format!("{head}{token:>20}{comment}")))
}

/// The cards of a text: what does not fit in one is continued (FITS standard 4.0, section 4.2.1.2). A comment that
/// does not fit is cut.
pub(super) fn text_cards(keyword: &str, text: &str, comment: &str) -> Vec<Card> {
    const LONGEST: usize = 78; // The rest of a card is for an ampersand and a quote.
    let head = if keyword.len() <= 8 { format!("{keyword:<8}= '") } else { format!("HIERARCH {keyword} = '") };
    let quoted = ascii(text).replace('\'', "''");
    let comment = if comment.is_empty() { String::new() } else { format!(" / {}", ascii(comment)) };
    if head.len() + quoted.len() < CARD {
        return vec![Card::new(&format!("{head}{quoted:8}'{comment}"))];
    }
    let (mut cards, mut line) = (Vec::new(), head);
    for letter in ascii(text).chars() {
        let letter = if letter == '\'' { "''".to_owned() } else { letter.to_string() };
        if line.len() + letter.len() > LONGEST {
            cards.push(Card::new(&format!("{line}&'")));
            "CONTINUE  '".clone_into(&mut line);
        }
        line += &letter;
    }
    cards.push(Card::new(&format!("{line}'{comment}")));
    cards
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::Header;

    #[test]
    fn texts_of_every_length_read_back() {
        for length in 0..300 {
            for letter in ["a", "'", "&"] {
                let text = letter.repeat(length);
                let header = Header::new(text_cards("KEY", &text, "note"));
                assert_eq!(header.text("KEY").as_deref(), Some(text.as_str()));
            }
        }
        assert_eq!(text_cards("KEY", &"a".repeat(68), "").len(), 1);
    }

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
