//! Names that users of other programs type, and what they are called here.

use clap::Error;
use clap::error::ErrorKind;
use std::ffi::OsString;

/// A name elsewhere, in small letters, and ours.
const NAMES: [(&str, &str); 26] = [
    ("detect-thresh", "threshold"),
    ("analysis-thresh", "threshold"),
    ("thresh", "threshold"),
    ("detection-threshold", "threshold"),
    ("nsigma", "threshold"),
    ("sigma", "threshold"),
    ("detect-minarea", "min-area"),
    ("minarea", "min-area"),
    ("npixels", "min-area"),
    ("deblend-mincont", "deblend-contrast"),
    ("deblend-cont", "deblend-contrast"),
    ("contrast", "deblend-contrast"),
    ("flag-image", "mask"),
    ("weight-image", "weight"),
    ("back-value", "background"),
    ("mag-zeropoint", "zero-point"),
    ("zeropoint", "zero-point"),
    ("satur-level", "saturation"),
    ("phot-apertures", "apertures"),
    ("checkimage-type", "sky-maps"),
    ("catalog-type", "catalog-format"),
    ("catalog-name", "out"),
    ("parameters-name", "config"),
    ("nthreads", "threads"),
    ("verbose-type", "verbose"),
    ("output", "out"),
];

/// What a name of another program is called here.
pub fn ours(name: &str) -> Option<&'static str> {
    let name = name.trim_start_matches('-').to_lowercase().replace('_', "-");
    NAMES.iter().find(|(foreign, _)| *foreign == name).map(|(_, ours)| *ours)
}

/// The error for an unknown option, with our name for it where there is one.
pub fn translated(error: Error, line: &[OsString]) -> Error {
    if error.kind() != ErrorKind::UnknownArgument {
        return error;
    }
    let options = line.iter().filter_map(|word| word.to_str()).filter(|word| word.starts_with('-'));
    let names = options.map(|word| word.split('=').next().unwrap_or(word));
    match names.filter_map(|name| ours(name).map(|ours| (name, ours))).next() {
        Some((name, ours)) => {
            Error::raw(ErrorKind::UnknownArgument, format!("there is no {name}; here it is --{ours}\n"))
        }
        None => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::command;

    #[test]
    fn our_names_are_options_and_the_others_are_not() {
        let command = command();
        let segment = command.find_subcommand("segment").expect("a command");
        let known = |name: &str| segment.get_arguments().any(|arg| arg.get_long() == Some(name));
        for (foreign, ours) in NAMES {
            assert!(known(ours) && !known(foreign), "{foreign} and {ours}");
        }
    }
}
