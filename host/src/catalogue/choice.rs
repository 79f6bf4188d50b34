//! Which columns a catalogue is to have.

use super::columns::is_magnitude;
use super::names::{KNOWN, Known, Needs, known, meant};
use super::{Column, Setting, columns};
use crate::measure::Wanted;
use std::fs;
use std::path::Path;

/// All that is usual.
const USUAL: &str = "default";
/// All that there is.
const ALL: &str = "all";

/// Columns by their names, in order; the usual ones where none is named.
///
/// ```
/// use skyfront::catalogue::Choice;
///
/// let choice = Choice::new(&["label".to_owned(), "flux_kron".to_owned()])?;
/// assert!(!choice.magnitudes() && !choice.apertures());
/// assert!(Choice::new(&["flux_krom".to_owned()]).is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choice(Vec<String>);

impl Choice {
    /// The columns that words name; a word that is a file stands for the words in it, each on its
    /// own line before any `#`, as in SExtractor's parameter files.
    ///
    /// # Errors
    /// A file that cannot be read, a name that no column has.
    pub fn new(words: &[String]) -> Result<Choice, String> {
        let mut names = Vec::new();
        for word in words.iter().map(|word| word.trim()).filter(|word| !word.is_empty()) {
            if Path::new(word).is_file() {
                let text = fs::read_to_string(word).map_err(|error| format!("{word}: {error}"))?;
                let lines = text.lines().filter_map(|line| line.split('#').next());
                names.extend(lines.flat_map(str::split_whitespace).map(str::to_owned));
            } else {
                names.push(word.to_owned());
            }
        }
        match names.iter().find(|name| !exists(name)) {
            Some(name) => Err(format!("{name} is no column; `skyfront columns` lists them")),
            None => Ok(Choice(names)),
        }
    }

    /// The columns of a catalogue.
    pub fn columns(&self, setting: &Setting) -> Vec<Column> {
        let mut all: Vec<Option<Column>> = columns(setting).into_iter().map(Some).collect();
        let mut chosen = Vec::new();
        let usual = [USUAL.to_owned()];
        let words = if self.0.is_empty() { &usual[..] } else { &self.0[..] };
        for word in words {
            let is_meant = meant(word);
            for place in &mut all {
                let wanted = |column: &Column| match word.as_str() {
                    USUAL => setting.usual(&column.name),
                    ALL => true,
                    _ => is_meant(&column.name),
                };
                chosen.extend(place.take_if(|column| wanted(column)));
            }
        }
        chosen
    }

    /// What must be measured for these columns.
    pub fn wanted(columns: &[Column]) -> Wanted {
        let needs =
            |needs: Needs| columns.iter().filter_map(|column| known(&column.name)).any(|one| one.needs == needs);
        Wanted {
            kron: needs(Needs::Kron),
            windowed: needs(Needs::Windowed),
            local: needs(Needs::Local),
            petrosian: needs(Needs::Petrosian),
        }
    }

    /// Whether magnitudes are named, which need a zero point.
    pub fn magnitudes(&self) -> bool {
        self.name_any(|known| is_magnitude(known.name))
    }

    /// Whether fluxes or magnitudes within circles are named.
    pub fn apertures(&self) -> bool {
        self.name_any(|known| known.name.contains('#'))
    }

    fn name_any(&self, of_kind: impl Fn(&Known) -> bool) -> bool {
        self.0.iter().any(|word| KNOWN.iter().any(|known| of_kind(known) && names(word, known.name)))
    }
}

/// Whether a word names the columns of a pattern.
fn names(word: &str, pattern: &str) -> bool {
    let of_pattern = known(word).is_some_and(|one| one.name == pattern);
    of_pattern || meant(word)(pattern)
}

fn exists(word: &str) -> bool {
    [USUAL, ALL].contains(&word) || KNOWN.iter().any(|one| names(word, one.name))
}
