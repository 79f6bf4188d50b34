//! `skyfront parameters`: the table of all parameters.

use super::say::{Stdout, Unwritten};
use crate::settings::notes;
use skyfront_core::config::PARAMETERS;

/// Prints every parameter by its step: name, forms of its values, keyword, bounds, default, use,
/// and what it and its words mean.
///
/// # Errors
/// Where stdout cannot be written.
pub fn run() -> Result<(), Unwritten> {
    let mut step = None;
    for parameter in PARAMETERS {
        if step != Some(parameter.step) {
            step = Some(parameter.step);
            writeln!(Stdout, "{}", parameter.step.title())?;
        }
        writeln!(Stdout, "  --{} {}   {} in FITS headers", parameter.name, parameter.forms(), parameter.keyword)?;
        writeln!(Stdout, "      {}", parameter.help)?;
        writeln!(Stdout, "      [{}]", notes(parameter).join("; "))?;
        for word in parameter.words.iter().filter(|word| !word.help.is_empty()) {
            writeln!(Stdout, "      {}: {}", word.name, word.help)?;
        }
    }
    Ok(())
}
