//! What the paper concludes, held beside what its captions find here.

/// The name of the default's run among those of captions.
pub const DEFAULT: &str = "the default";
/// The name of source-extractor's.
pub const SEXTRACTOR: &str = "source-extractor";

/// A conclusion of the paper, by runs of one of its tests: in each pair the first finds more than the second.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// In few words.
    pub text: &'static str,
    /// The test.
    pub test: u8,
    /// The runs, by the texts of their captions.
    pub pairs: &'static [(&'static str, &'static str)],
}

/// The conclusions of the paper's last section.
pub const CLAIMS: [Claim; 9] = [
    Claim {
        text: "A rescaling shows more objects than none (high resolution)",
        test: 1,
        pairs: &[
            ("r1, FD, g2mod 0.8", "none, FD, g2mod 0.8"),
            ("r3, FD, g2mod 0.8", "none, FD, g2mod 0.8"),
            ("r1, SL, g2mod 0.8", "none, SL, g2mod 0.8"),
            ("r3, SL, g2mod 0.8", "none, SL, g2mod 0.8"),
        ],
    },
    Claim {
        text: "A rescaling shows more objects than none (low resolution)",
        test: 2,
        pairs: &[("r1, SL, g2mod 0.78", "none, SL, g2mod 0.6"), ("r3 beta 4, SL, g2mod 0.6", "none, SL, g2mod 0.6")],
    },
    Claim {
        text: "r3 is best (high resolution)",
        test: 1,
        pairs: &[("r3, FD, g2mod 0.8", "r1, FD, g2mod 0.8"), ("r3, SL, g2mod 0.8", "r1, SL, g2mod 0.8")],
    },
    Claim {
        text: "r1 is best (low resolution)",
        test: 2,
        pairs: &[
            ("r1, FD, g2mod 0.78", "r3 beta 4, FD, g2mod 0.6"),
            ("r1, SL, g2mod 0.78", "r3 beta 4, SL, g2mod 0.6"),
        ],
    },
    Claim {
        text: "r1 finds more than SExtractor (low resolution)",
        test: 2,
        pairs: &[("r1, FD, g2mod 0.78", SEXTRACTOR)],
    },
    Claim {
        text: "Perona and Malik's filter finds a few more than the heat equation (high resolution)",
        test: 1,
        pairs: &[("r1, PM, SL, g2mod 0.8", "r1, SL, g2mod 0.8")],
    },
    Claim {
        text: "Perona and Malik's filter finds a few more than the heat equation (low resolution)",
        test: 2,
        pairs: &[("r1, PM, FD, g2mod 0.78", "r1, FD, g2mod 0.78")],
    },
    Claim {
        text: "Without a rescaling that filter fails (high resolution)",
        test: 1,
        pairs: &[("r1, PM, SL, g2mod 0.8", "none, PM, SL, g2mod 0.8")],
    },
    Claim {
        text: "g1 is not a good choice: g2mod finds more (low resolution)",
        test: 2,
        pairs: &[("none, SL, g2mod 0.6", "none, SL, g1 p = 1e4")],
    },
];

/// Whether what came out agrees with a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// In each pair.
    Agrees,
    /// In some.
    InPart,
    /// In none.
    Not,
}

impl Verdict {
    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Verdict::Agrees => "agrees",
            Verdict::InPart => "agrees in part",
            Verdict::Not => "does not agree",
        }
    }
}

impl Claim {
    /// What the runs of each pair found; none where a run is missing.
    pub fn found(&self, found: impl Fn(&str) -> Option<usize>) -> Option<Vec<(usize, usize)>> {
        self.pairs.iter().map(|(more, fewer)| Some((found(more)?, found(fewer)?))).collect()
    }
}

/// What pairs of runs, of which the first should have found more, say.
pub fn verdict(pairs: &[(usize, usize)]) -> Verdict {
    match pairs.iter().filter(|(more, fewer)| more > fewer).count() {
        0 => Verdict::Not,
        more if more == pairs.len() => Verdict::Agrees,
        _ => Verdict::InPart,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::captions;

    #[test]
    fn every_claim_is_of_captions_that_there_are() {
        let captions = captions();
        for claim in CLAIMS {
            for name in claim.pairs.iter().flat_map(|(more, fewer)| [more, fewer]) {
                let known =
                    captions.iter().filter(|caption| (caption.test, caption.text) == (claim.test, name)).count();
                assert!(known == 1 || *name == SEXTRACTOR, "{name} of test {}", claim.test);
            }
        }
    }

    #[test]
    fn a_claim_agrees_where_the_first_of_each_pair_finds_more() {
        assert_eq!(verdict(&[(5, 4), (2, 1)]), Verdict::Agrees);
        assert_eq!(verdict(&[(5, 4), (1, 1)]), Verdict::InPart);
        assert_eq!(verdict(&[(4, 4), (1, 3)]), Verdict::Not);
        let [claim, ..] = CLAIMS;
        assert_eq!(claim.found(|name| name.starts_with("none").then_some(1)), None);
        assert_eq!(claim.found(|name| Some(name.len())).map(|pairs| pairs.len()), Some(4));
    }
}
