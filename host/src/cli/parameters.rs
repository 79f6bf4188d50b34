//! `skyfront parameters`: the table of all parameters.

use super::given::notes;
use skyfront_core::config::PARAMETERS;

/// Prints every parameter by its step: name, forms of its values, keyword, bounds, default, use,
/// and what it and its words mean.
pub fn run() {
    let mut step = None;
    for parameter in PARAMETERS {
        if step != Some(parameter.step) {
            step = Some(parameter.step);
            println!("{}", parameter.step.title());
        }
        println!("  --{} {}   {} in FITS headers", parameter.name, parameter.forms(), parameter.keyword);
        println!("      {}", parameter.help);
        println!("      [{}]", notes(parameter).join("; "));
        for word in parameter.words.iter().filter(|word| !word.help.is_empty()) {
            println!("      {}: {}", word.name, word.help);
        }
    }
}
