//! Names that users of other programs type, and what they are called here.

use crate::settings::ours;
use clap::Error;
use clap::error::ErrorKind;
use std::ffi::OsString;

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
    use crate::cli::command;
    use crate::settings::NAMES;

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
