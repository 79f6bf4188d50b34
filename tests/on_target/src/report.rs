//! What a processor printed, and how two processors compare.

use std::collections::BTreeMap;

/// The lines of one run.
#[derive(Debug, Default, PartialEq)]
pub struct Report {
    /// CRC-32 by name.
    pub digests: BTreeMap<String, u32>,
    /// Value and unit by name.
    pub resources: BTreeMap<String, (u64, String)>,
}

impl Report {
    /// Takes one line; `false` when it is not part of the protocol or says a name again.
    pub fn add(&mut self, line: &str) -> bool {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            ["digest", name, value] if value.len() == 8 => {
                u32::from_str_radix(value, 16).is_ok_and(|crc| self.digests.insert(name.to_owned(), crc).is_none())
            }
            ["resource", name, value, unit] => value
                .parse()
                .is_ok_and(|value| self.resources.insert(name.to_owned(), (value, unit.to_owned())).is_none()),
            _ => false,
        }
    }

    /// One line for every digest of `expected` that is missing or different here, and for every one too many.
    #[must_use]
    pub fn differences(&self, expected: &BTreeMap<String, u32>) -> Vec<String> {
        let here = &self.digests;
        let wrong = expected.iter().filter_map(|(name, wanted)| match here.get(name) {
            None => Some(format!("{name}: missing, expected {wanted:08x}")),
            Some(got) if got != wanted => Some(format!("{name}: {got:08x}, expected {wanted:08x}")),
            Some(_) => None,
        });
        let extra =
            here.keys().filter(|name| !expected.contains_key(*name)).map(|name| format!("{name}: not expected"));
        wrong.chain(extra).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_protocol_is_taken() {
        let mut report = Report::default();
        assert!(report.add("digest f32/fd/g 0badcafe"));
        assert!(!report.add("digest f32/fd/g 0badcafe"), "the same name twice");
        assert!(!report.add("digest f32/fd/u badcafe"), "seven digits");
        assert!(!report.add("resource stack many bytes"));
        assert!(!report.add("fault 0x3"));
        assert!(!report.add(""));
    }

    #[test]
    fn missing_different_and_foreign_digests_are_named() {
        let mut report = Report::default();
        assert!(report.add("digest a 00000001"));
        assert!(report.add("digest c 00000003"));
        let expected = BTreeMap::from([("a".to_owned(), 2), ("b".to_owned(), 2)]);
        let told = report.differences(&expected);
        assert_eq!(told, ["a: 00000001, expected 00000002", "b: missing, expected 00000002", "c: not expected"]);
        assert!(report.differences(&report.digests.clone()).is_empty());
    }
}
