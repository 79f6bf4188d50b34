//! FITS header cards: 80 bytes each, `KEYWORD = value / comment` (FITS standard 4.0, section 4).

/// Bytes in one header card.
pub const CARD: usize = 80;

/// The cards of one HDU, in file order, without `END`.
///
/// ```
/// use skyfront::read::{Card, Header};
///
/// let cards = ["GAIN    =                  2.5", "OBJECT  = 'M 13    '"];
/// let header = Header::new(cards.iter().map(|card| Card::new(card)).collect());
/// assert_eq!((header.real("GAIN"), header.text("OBJECT").as_deref()), (Some(2.5), Some("M 13")));
/// assert_eq!(header.integer("NAXIS"), None);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Header {
    cards: Vec<Card>,
}

/// One header card, kept as the bytes of the file so that a copy is exact.
///
/// ```
/// use skyfront::read::Card;
///
/// let card = Card::new("EXPTIME =                120.5 / seconds");
/// assert_eq!((card.keyword(), card.value().as_deref()), ("EXPTIME", Some("120.5")));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Card(pub [u8; CARD]);

impl Card {
    /// A card with `text` at its start, cut or filled with blanks to 80 bytes.
    pub fn new(text: &str) -> Self {
        let mut bytes = [b' '; CARD];
        bytes.iter_mut().zip(text.bytes()).for_each(|(to, from)| *to = from);
        Self(bytes)
    }

    /// The keyword: the first eight bytes without trailing blanks (empty if they are not ASCII).
    pub fn keyword(&self) -> &str {
        let field = self.0.split_at(8).0;
        str::from_utf8(field).unwrap_or_default().trim_end_matches(' ')
    }

    /// The value field with its comment, if the card has a value indicator.
    fn field(&self) -> Option<&[u8]> {
        let (_, rest) = self.0.split_at(8);
        rest.strip_prefix(b"= ").or_else(|| rest.strip_prefix(b"=\0"))
    }

    /// Whether an equals sign and a blank announce a value, even a blank one.
    pub fn has_value(&self) -> bool {
        self.field().is_some()
    }

    /// The value as text: a string without its quotes and trailing blanks, or the bare token of any other value.
    pub fn value(&self) -> Option<String> {
        value_text(self.field()?)
    }

    /// The card as text, for messages and copies; bytes outside ASCII become `?`.
    pub fn text(&self) -> String {
        self.0.iter().map(|&b| if matches!(b, 0x20..=0x7e) { char::from(b) } else { '?' }).collect()
    }
}

/// Text of a value field: what stands between the quotes, or the token before the comment.
fn value_text(field: &[u8]) -> Option<String> {
    let field = field.trim_ascii_start();
    let bytes = match field.strip_prefix(b"'") {
        Some(quoted) => unquote(quoted),
        None => field.split(|&b| b == b'/').next()?.to_vec(),
    };
    // Old headers have letters of Latin-1, the sign for micro among them.
    let text = str::from_utf8(&bytes).map_or_else(|_| bytes.iter().copied().map(char::from).collect(), str::to_owned);
    let text = text.trim_end_matches(['\0', ' ']).to_owned();
    (!text.is_empty() || field.starts_with(b"'")).then_some(text)
}

/// The bytes up to the closing quote; a doubled quote stands for one.
fn unquote(quoted: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut bytes = quoted.iter().copied().peekable();
    while let Some(byte) = bytes.next() {
        if byte == b'\'' && bytes.next_if_eq(&b'\'').is_none() {
            break;
        }
        out.push(byte);
    }
    out
}

/// A finite number, perhaps with the exponent letter of Fortran.
pub fn real(text: &str) -> Option<f64> {
    let text = text.trim().replace(['d', 'D'], "E");
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

/// The unit of the pixels (`BUNIT`), spelled as the FITS standard has it: `u` for the sign of micro,
/// singular and small letters for what is counted.
pub fn unit(header: &Header) -> Option<String> {
    const COUNTED: [&str; 5] = ["electron", "count", "photon", "adu", "pixel"];
    let text = header.text("BUNIT")?.trim().replace(['\u{b5}', '\u{3bc}'], "u");
    let mut counts = false;
    let mut word = |word: &str| {
        let small = word.to_ascii_lowercase();
        let singular = small.strip_suffix('s').unwrap_or(&small);
        let counted = COUNTED.iter().find(|name| **name == singular);
        counts |= counted.is_some();
        match (counted, small.as_str()) {
            (Some(name), _) => (*name).to_owned(),
            (None, "s" | "sec" | "second" | "seconds") if counts => "s".to_owned(),
            _ => word.to_owned(),
        }
    };
    let mut spelled = String::new();
    for piece in text.split_inclusive(['/', '*', ' ']) {
        let (name, mark) = piece.split_at(piece.trim_end_matches(['/', '*', ' ']).len());
        spelled += &word(name);
        spelled += mark;
    }
    Some(spelled)
}

/// The name of a keyword of one or two axes, their numbers, and what follows: of `PVi_m` the
/// parameter belongs to the rest.
fn axes_of(keyword: &str) -> Option<(&str, Vec<usize>, &str)> {
    const ONE: [&str; 8] = ["CTYPE", "CUNIT", "CRVAL", "CRPIX", "CDELT", "CROTA", "CRDER", "CSYER"];
    const TWO: [&str; 2] = ["CD", "PC"];
    const FIRST: [&str; 2] = ["PV", "PS"];
    let digits = |text: &'_ str| text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let after = |names: &[&'static str]| names.iter().find_map(|name| Some((*name, keyword.strip_prefix(name)?)));
    if let Some((name, rest)) = after(&ONE).or_else(|| after(&FIRST)) {
        let (number, rest) = rest.split_at(digits(rest));
        return Some((name, vec![number.parse().ok()?], rest));
    }
    let (name, rest) = after(&TWO)?;
    let (one, rest) = rest.split_at(digits(rest));
    let (one, two, rest) = match rest.strip_prefix('_') {
        Some(rest) => (one, &rest[..digits(rest)], &rest[digits(rest)..]),
        None => (one.get(..3)?, one.get(3..)?, rest),
    };
    Some((name, vec![one.parse().ok()?, two.parse().ok()?], rest))
}

impl Header {
    /// A header made of the given cards.
    pub fn new(cards: Vec<Card>) -> Self {
        Self { cards }
    }

    /// All cards in file order.
    pub fn cards(&self) -> &[Card] {
        &self.cards
    }

    /// The header of an image of which only two axes, numbered from 1, are longer than a pixel: their
    /// coordinates become those of the axes 1 and 2, and the others are left out.
    pub fn with_axes(&self, kept: [usize; 2]) -> Header {
        let renumbered = |card: &Card| match axes_of(card.keyword()) {
            None => Some(*card),
            Some((name, numbers, rest)) => {
                let new: Option<Vec<usize>> =
                    numbers.iter().map(|number| Some(kept.iter().position(|axis| axis == number)? + 1)).collect();
                let new: Vec<String> = new?.iter().map(usize::to_string).collect();
                let mut bytes = card.0;
                let keyword = format!("{name}{}{rest}", new.join("_"));
                bytes.iter_mut().take(8).zip(keyword.bytes().chain([b' '; 8])).for_each(|(to, from)| *to = from);
                Some(Card(bytes))
            }
        };
        Header::new(self.cards.iter().filter_map(renumbered).collect())
    }

    /// What a user should know of keywords that stand in the header more than once or that hold no
    /// number where one belongs.
    pub fn oddities(&self) -> Vec<String> {
        const NUMBERS: [&str; 3] = ["GAIN", "SATURATE", "EXPTIME"];
        const FREE: [&str; 5] = ["", "COMMENT", "HISTORY", "CONTINUE", "HIERARCH"];
        let mut first = std::collections::HashMap::new();
        let mut twice = Vec::new();
        for card in self.cards.iter().filter(|card| card.has_value() && !FREE.contains(&card.keyword())) {
            let before = *first.entry(card.keyword()).or_insert(card);
            if before.value() != card.value() && !twice.contains(&card.keyword()) {
                twice.push(card.keyword());
            }
        }
        let mut warnings: Vec<String> = NUMBERS
            .iter()
            .filter(|name| self.text(name).is_some() && self.real(name).is_none())
            .map(|name| format!("{name} = {} is no number and is left out", self.text(name).unwrap_or_default()))
            .collect();
        if !twice.is_empty() {
            let names = twice.join(", ");
            warnings.push(format!("with several values: {names}; the last counts for coordinates, else the first"));
        }
        warnings
    }

    /// The value of the first card with this keyword, long strings (`CONTINUE`) joined.
    pub fn text(&self, keyword: &str) -> Option<String> {
        let at = self.cards.iter().position(|card| card.keyword() == keyword && card.field().is_some())?;
        let mut text = self.cards[at].value()?;
        for card in self.cards[at + 1..].iter().take_while(|card| card.keyword() == "CONTINUE") {
            if !text.ends_with('&') {
                break;
            }
            text.pop();
            text.push_str(&value_text(&card.0[8..]).unwrap_or_default());
        }
        Some(text)
    }

    /// The first card with this keyword as an integer; `None` if absent or not an integer.
    pub fn integer(&self, keyword: &str) -> Option<i64> {
        self.text(keyword)?.trim().parse().ok()
    }

    /// The first card with this keyword as a finite number; `None` if absent or not one.
    pub fn real(&self, keyword: &str) -> Option<f64> {
        real(&self.text(keyword)?)
    }

    /// The first card with this keyword as a whole number, perhaps written as a real one.
    pub fn whole(&self, keyword: &str) -> Option<i64> {
        let whole = |value: &f64| value.fract() == 0.0 && value.abs() < 9e15;
        self.integer(keyword).or_else(|| self.real(keyword).filter(whole).map(|value| value as i64))
    }

    /// Whether the first card with this keyword says true (`T`).
    pub fn flag(&self, keyword: &str) -> bool {
        self.text(keyword).is_some_and(|text| text == "T")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(cards: &[&str]) -> Header {
        Header::new(cards.iter().map(|text| Card::new(text)).collect())
    }

    #[test]
    fn values_of_every_kind_are_read() {
        let header = header(&[
            "SIMPLE  =                    T / yes",
            "NAXIS1  =                   96",
            "NAXIS1  =                   97 / the first counts",
            "GAIN    =               1.5D+1 / with the exponent letter of Fortran",
            "OBJECT  = 'O''Neill / M13 '    / quote and slash inside",
            "EMPTY   = ''",
            "HUGE    = 99999999999999999999",
        ]);
        assert!(header.flag("SIMPLE"));
        assert_eq!(header.integer("NAXIS1"), Some(96));
        assert_eq!(header.real("GAIN"), Some(15.0));
        assert_eq!(header.text("OBJECT").as_deref(), Some("O'Neill / M13"));
        assert_eq!(header.text("EMPTY").as_deref(), Some(""));
        assert_eq!(header.integer("HUGE"), None);
        assert_eq!(header.text("ABSENT"), None);
    }

    #[test]
    fn coordinates_of_the_axes_that_are_left_are_renumbered() {
        let cards = ["CTYPE1  = 'STOKES'", "CTYPE3  = 'RA---TAN'", "CRVAL4A = 1", "PC3_4   = 2", "PC1_3   = 3"];
        let more = ["PV4_1   = 4", "PC004003= 5", "GAIN    = 6", "CD3_3   = 7"];
        let header = header(&[&cards[..], &more[..]].concat()).with_axes([3, 4]);
        let keywords: Vec<&str> = header.cards().iter().map(Card::keyword).collect();
        assert_eq!(keywords, ["CTYPE1", "CRVAL2A", "PC1_2", "PV2_1", "PC2_1", "GAIN", "CD1_1"]);
        assert_eq!((header.text("CTYPE1").as_deref(), header.real("PC2_1")), (Some("RA---TAN"), Some(5.0)));
    }

    #[test]
    fn keywords_with_several_values_and_without_a_number_are_told() {
        let cards = ["GAIN    = 'high'", "A       = 1", "B       = 1", "A       = 2", "B       = 1", "COMMENT = 1"];
        let warnings = header(&cards).oddities();
        assert!(warnings.len() == 2 && warnings[0].contains("GAIN = high") && warnings[1].contains("values: A;"));
    }

    #[test]
    fn whole_numbers_may_be_written_as_real_ones() {
        let header = header(&["BLANK   = -32768.0", "HALF    = 0.5", "INT     = 7"]);
        assert_eq!(["BLANK", "HALF", "INT"].map(|name| header.whole(name)), [Some(-32768), None, Some(7)]);
    }

    #[test]
    fn units_are_spelled_as_the_standard_has_them() {
        for (found, spelled) in [
            ("ELECTRONS/S", "electron/s"),
            ("electrons", "electron"),
            ("counts/sec", "count/s"),
            ("ADU", "adu"),
            ("\u{b5}Jy", "uJy"),
            ("\u{3bc}Jy/pixel", "uJy/pixel"),
            ("MJy/sr", "MJy/sr"),
            ("Jy/beam", "Jy/beam"),
            ("S", "S"),
        ] {
            assert_eq!(unit(&header(&[&format!("BUNIT   = '{found}'")])).as_deref(), Some(spelled));
        }
        let mut latin = Card::new("BUNIT   = '?Jy'");
        latin.0[11] = 0xb5;
        assert_eq!(unit(&Header::new(vec![latin])).as_deref(), Some("uJy"));
    }

    #[test]
    fn a_continued_string_is_joined() {
        let header = header(&["LONG    = 'one &'", "CONTINUE  'two &' / note", "CONTINUE  'three'"]);
        assert_eq!(header.text("LONG").as_deref(), Some("one two three"));
    }

    #[test]
    fn a_comment_card_has_no_value() {
        assert_eq!(Card::new("COMMENT = 5").value().as_deref(), Some("5"));
        assert_eq!(Card::new("COMMENT   5").value(), None);
    }
}
