//! The page of `skyfront reproduce`: the paper's tests and conclusions beside what came out here, as Markdown.

use super::claims::{CLAIMS, verdict};
use std::fmt::Write;

/// A run over an image.
#[derive(Clone, Debug)]
pub struct Tried {
    /// The test of the caption; none for what is not the paper's.
    pub test: Option<u8>,
    /// The caption, or what else was run.
    pub text: &'static str,
    /// When the front stopped, in the paper and here; of fronts alone.
    pub times: Option<(Option<f64>, f64)>,
    /// Pixels in sources.
    pub pixels: usize,
    /// Sources.
    pub sources: usize,
    /// Those that are objects of a simulated sky.
    pub found: Option<usize>,
}

/// All runs over an image.
#[derive(Clone, Debug)]
pub struct Part {
    /// The image.
    pub name: String,
    /// Objects of a simulated sky.
    pub objects: Option<usize>,
    /// The runs.
    pub runs: Vec<Tried>,
    /// The file of its picture.
    pub picture: String,
}

impl Tried {
    /// What conclusions go by: true objects where they are known, else sources.
    pub fn counted(&self) -> usize {
        self.found.unwrap_or(self.sources)
    }
}

/// Times that differ by no more than this share agree.
const SAME: f64 = 0.01;

/// Whether the time at which a front stopped is the paper's, where that gives one.
pub fn same_time((paper, here): (Option<f64>, f64)) -> Option<bool> {
    paper.map(|paper| (here - paper).abs() <= SAME * paper)
}

/// [`same_time`] in a word.
pub fn word_of_time(same: Option<bool>) -> &'static str {
    match same {
        None => "-",
        Some(true) => "agrees",
        Some(false) => "differs",
    }
}

impl Part {
    fn found(&self, test: u8, text: &str) -> Option<usize> {
        let run = self.runs.iter().find(|run| run.text == text && run.test.is_none_or(|own| own == test));
        run.map(Tried::counted)
    }

    fn table(&self) -> String {
        let mut table = String::new();
        let all = self.objects.map_or("sources".to_owned(), |objects| format!("found of {objects} | false"));
        let _ = writeln!(table, "| test | run | t in the paper | t here | | pixels | {all} |");
        let _ = writeln!(table, "|---|---|---|---|---|---|---|{}", if self.objects.is_some() { "---|" } else { "" });
        for run in &self.runs {
            let test = run.test.map_or("-".to_owned(), |test| test.to_string());
            let paper = run.times.and_then(|times| times.0).map_or("-".to_owned(), |t| t.to_string());
            let here = run.times.map_or("-".to_owned(), |times| format!("{:.3}", times.1));
            let word = word_of_time(run.times.and_then(same_time));
            let found = match run.found {
                Some(found) => format!("{found} | {}", run.sources - found),
                None => run.sources.to_string(),
            };
            let _ = writeln!(table, "| {test} | {} | {paper} | {here} | {word} | {} | {found} |", run.text, run.pixels);
        }
        table
    }

    /// The paper's conclusions beside what was found, as rows of a table.
    fn conclusions(&self) -> String {
        let mut rows = String::new();
        for claim in CLAIMS {
            let Some(found) = claim.found(|text| self.found(claim.test, text)) else { continue };
            let pairs = claim.pairs.iter().zip(&found);
            let told: Vec<String> =
                pairs.map(|((more, fewer), found)| format!("{more}: {}; {fewer}: {}", found.0, found.1)).collect();
            let _ = writeln!(rows, "| {} | {} | **{}** |", claim.text, told.join("<br>"), verdict(&found).name());
        }
        rows
    }
}

/// The page, with the files of its pictures of curves and of all fronts.
pub fn page(parts: &[Part], curves: &str, sheet: &str) -> String {
    let mut page = String::from(
        "# The paper's tests, tried\n\n\
         S. Tozza and M. Falcone, \"On the segmentation of astronomical images via level-set methods\", segment two images \
         with every scheme, rescaling and filter. Here all their captions are run again; simulated skies stand in for \
         their images where none is given. Times agree where they differ by 1 % at most.\n\n",
    );
    let _ = writeln!(
        page,
        "## Rescalings, and the first front\n\nr1 and r2 lift all that is faint; r3 damps what is below tau and lifts what \
         is above. u0 is a pyramid, 0 two pixels inside the frame: the front starts there and shrinks.\n\n![{curves}]({curves})\n"
    );
    for part in parts {
        let Part { name, objects, picture, .. } = part;
        let truth = objects.map_or(String::new(), |objects| format!(", {objects} objects"));
        let _ = writeln!(page, "## {name}{truth}\n\n{}\n![{picture}]({picture})\n", part.table());
    }
    let _ = writeln!(page, "All fronts and segmented images:\n\n![{sheet}]({sheet})\n\n## What the paper concludes\n");
    for part in parts {
        let counted = if part.objects.is_some() { "true objects" } else { "sources" };
        let _ = writeln!(page, "{}, by {counted}:\n", part.name);
        let _ = writeln!(page, "| the paper | here | |\n|---|---|---|\n{}", part.conclusions());
    }
    page
}

#[cfg(test)]
mod tests {
    use super::super::claims::SEXTRACTOR;
    use super::*;

    fn tried(test: Option<u8>, text: &'static str, times: Option<(Option<f64>, f64)>, found: usize) -> Tried {
        Tried { test, text, times, pixels: 9, sources: found + 1, found: Some(found) }
    }

    #[test]
    fn times_and_conclusions_have_verdicts() {
        let runs = vec![
            tried(Some(2), "none, SL, g2mod 0.6", Some((Some(15.85), 15.8)), 3),
            tried(Some(2), "none, SL, g1 p = 1e4", Some((Some(15.85), 15.0)), 2),
            tried(Some(2), "r1, FD, g2mod 0.78", Some((None, 15.0)), 4),
            tried(None, SEXTRACTOR, None, 20),
        ];
        let part = Part { name: "a sky".to_owned(), objects: Some(30), runs, picture: "one.png".to_owned() };
        let text = page(&[part], "curves.png", "sheet.png");
        for expected in [
            "| 2 | none, SL, g2mod 0.6 | 15.85 | 15.800 | agrees | 9 | 3 | 1 |",
            "| 2 | none, SL, g1 p = 1e4 | 15.85 | 15.000 | differs | 9 | 2 | 1 |",
            "| - | source-extractor | - | - | - | 9 | 20 | 1 |",
            "| none, SL, g2mod 0.6: 3; none, SL, g1 p = 1e4: 2 | **agrees** |",
            "| r1, FD, g2mod 0.78: 4; source-extractor: 20 | **does not agree** |",
            "## a sky, 30 objects",
            "![one.png](one.png)",
        ] {
            assert!(text.contains(expected), "{expected} is not in\n{text}");
        }
        assert!(!text.contains("r3 is best"), "a claim without its runs");
    }
}
