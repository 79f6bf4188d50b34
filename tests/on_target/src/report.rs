//! What a processor printed, and how two processors compare.

use std::collections::{BTreeMap, BTreeSet};

/// The lines of one run.
#[derive(Debug, Default, PartialEq)]
pub struct Report {
    /// CRC-32 by name.
    pub digests: BTreeMap<String, u32>,
    /// The names of the digests as they came: the stages of a run in the order of its pipeline.
    told: Vec<String>,
    /// Value and unit by name.
    pub resources: BTreeMap<String, (u64, String)>,
}

impl Report {
    /// Takes one line; `false` when it is not part of the protocol or says a name again.
    pub fn add(&mut self, line: &str) -> bool {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            ["digest", name, value] if value.len() == 8 => {
                u32::from_str_radix(value, 16).is_ok_and(|crc| self.digest(name.to_owned(), crc))
            }
            ["resource", name, value, unit] => value
                .parse()
                .is_ok_and(|value| self.resources.insert(name.to_owned(), (value, unit.to_owned())).is_none()),
            _ => false,
        }
    }

    /// Takes a digest; `false` when its name was there before.
    pub fn digest(&mut self, name: String, crc: u32) -> bool {
        self.told.push(name.clone());
        self.digests.insert(name, crc).is_none()
    }

    /// One line for every run (`ARITHMETIC/SCENE/SCHEME`) whose digests are not those of `expected`, with the stage
    /// that differs first, and one for every digest that is missing here or too many.
    #[must_use]
    pub fn differences(&self, expected: &BTreeMap<String, u32>) -> Vec<String> {
        let (mut lines, mut seen) = (Vec::new(), BTreeSet::new());
        for name in &self.told {
            let (run, stage) = name.rsplit_once('/').unwrap_or(("", name));
            match (self.digests.get(name), expected.get(name)) {
                (_, None) => lines.push(format!("{name}: not expected")),
                (Some(got), Some(wanted)) if got != wanted && seen.insert(run) => {
                    lines.push(format!("{run}: {stage} differs first, {got:08x}, expected {wanted:08x}"));
                }
                _ => {}
            }
        }
        let missing = expected.iter().filter(|(name, _)| !self.digests.contains_key(*name));
        lines.extend(missing.map(|(name, wanted)| format!("{name}: missing, expected {wanted:08x}")));
        lines
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
        for line in ["digest a/sl/rescale 1", "digest a/sl/filter 2", "digest a/sl/edge 3", "digest a/fd/edge 4"] {
            let (line, crc) = line.rsplit_once(' ').unwrap();
            assert!(report.add(&format!("{line} 0000000{crc}")));
        }
        let expected = ["a/sl/edge", "a/sl/filter", "a/sl/rescale", "a/sl/u"].map(|name| (name.to_owned(), 1));
        assert_eq!(
            report.differences(&expected.into()),
            [
                "a/sl: filter differs first, 00000002, expected 00000001",
                "a/fd/edge: not expected",
                "a/sl/u: missing, expected 00000001",
            ]
        );
        assert!(report.differences(&report.digests.clone()).is_empty());
    }
}
