//! The configuration file: a TOML table whose keys are the long options of a command.
//!
//! The options are the only registry: what a file may hold, what `--dump-config` prints and what
//! the help says come from the same definitions. The command line goes before the file, the file
//! before the preset.

use super::foreign::translated;
use crate::provenance::parameters;
use crate::settings::ours;
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command, Error};
use skyfront_core::config::{Config, Start};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// The argument that names the file.
const FILE: &str = "config_file";
/// Options that say what to do now, not how: they stand on the command line only.
const NOT_SETTINGS: [&str; 6] = [FILE, "dump_config", "out", "job_list", "help", "version"];

/// The options that a file may set.
fn settings(command: &Command) -> impl Iterator<Item = (&Arg, &str)> {
    command
        .get_arguments()
        .filter(|arg| !NOT_SETTINGS.contains(&arg.get_id().as_str()))
        .filter_map(|arg| arg.get_long().map(|long| (arg, long)))
}

/// Parses a command line, and once more with the settings of the file it names.
///
/// # Errors
/// What is wrong with the line, or with the file, which is then named.
pub fn parse(command: &mut Command, mut line: Vec<OsString>) -> Result<ArgMatches, Error> {
    let matches = command.try_get_matches_from_mut(&line).map_err(|error| translated(error, &line))?;
    let Some((name, given)) = matches.subcommand() else { return Ok(matches) };
    let (Ok(Some(path)), Some(subcommand)) = (given.try_get_one::<PathBuf>(FILE), command.find_subcommand(name)) else {
        return Ok(matches);
    };
    let settings = from_file(subcommand, given, path)
        .map_err(|reason| Error::raw(ErrorKind::ValueValidation, format!("{}: {reason}\n", path.display())))?;
    let after_name = line.iter().position(|word| word == name).map_or(line.len(), |at| at + 1);
    line.splice(after_name..after_name, settings);
    command.try_get_matches_from_mut(line)
}

/// The settings of a file as arguments, without those that the command line gives.
fn from_file(command: &Command, given: &ArgMatches, path: &Path) -> Result<Vec<OsString>, String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("cannot be read: {error}"))?;
    let table: Table = text.parse().map_err(|error: toml::de::Error| one_line(&error.to_string()))?;
    let mut words = Vec::new();
    for (key, value) in &table {
        // summary.json spells the names with underscores; both are welcome.
        let name = key.replace('_', "-");
        let Some((arg, _)) = settings(command).find(|(_, long)| *long == name) else {
            if let Some(ours) = ours(key) {
                return Err(format!("unknown key '{key}'; here it is {ours}"));
            }
            let known: Vec<&str> = settings(command).map(|(_, long)| long).collect();
            return Err(format!("unknown key '{key}'; known are {}", known.join(", ")));
        };
        let word = words_of(arg, &name, value).map_err(|reason| format!("key '{key}': {reason}"))?;
        check(command, &word)?;
        if given.value_source(arg.get_id().as_str()) != Some(ValueSource::CommandLine) {
            words.extend(word);
        }
    }
    Ok(words)
}

/// A setting as it would stand on the command line.
fn words_of(arg: &Arg, name: &str, value: &Value) -> Result<Vec<OsString>, String> {
    let scalar = |value: &Value| match value {
        Value::String(text) => Ok(text.clone()),
        Value::Integer(number) => Ok(number.to_string()),
        Value::Float(number) => Ok(number.to_string()),
        _ => Err("a number, a text or true is wanted".to_owned()),
    };
    if !arg.get_action().takes_values() {
        return match value {
            Value::Boolean(true) => Ok(vec![format!("--{name}").into()]),
            Value::Boolean(false) => Ok(Vec::new()),
            _ => Err("true or false is wanted".to_owned()),
        };
    }
    let values = match value {
        Value::Array(values) => values.iter().map(scalar).collect::<Result<Vec<_>, _>>()?,
        single => vec![scalar(single)?],
    };
    let values = if matches!(arg.get_action(), ArgAction::Append) { values } else { vec![values.join(",")] };
    Ok(values.into_iter().map(|value| format!("--{name}={value}").into()).collect())
}

/// Whether the option takes such a value; the message of the command line in one line if not.
fn check(command: &Command, words: &[OsString]) -> Result<(), String> {
    let line = ["", "--dump-config"].map(OsString::from);
    let alone = command.clone().no_binary_name(false).try_get_matches_from(line.iter().chain(words));
    match alone {
        Err(error) if matches!(error.kind(), ErrorKind::InvalidValue | ErrorKind::ValueValidation) => {
            let text = error.render().to_string();
            let message = text.split("\n\n").next().unwrap_or_default();
            Err(one_line(message.trim_start_matches("error: ")))
        }
        // Options that lean on each other are judged together with the command line.
        _ => Ok(()),
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The effective settings of a command line as a configuration file.
pub fn dump(command: &Command, given: &ArgMatches, config: &Config) -> String {
    let effective: BTreeMap<&str, String> =
        parameters(config).into_iter().map(|parameter| (parameter.name, parameter.value.to_string())).collect();
    let mut text = format!("# Settings of skyfront {}.\n", env!("CARGO_PKG_VERSION"));
    for (arg, name) in settings(command) {
        let values = match effective.get(name) {
            // Not given, it follows from the frame.
            Some(_) if name == "t-max" => raw_values(arg, given),
            // The configuration knows that there is a map, the command line knows which.
            Some(value) if !matches!(config.start, Start::Given) || name != "start" => vec![value.clone()],
            _ => raw_values(arg, given),
        };
        let value = match values.as_slice() {
            [] => continue,
            [value] => toml_of(value),
            several => Value::Array(several.iter().map(|value| toml_of(value)).collect()),
        };
        if let Some(help) = arg.get_help() {
            let _ = write!(text, "\n# {}", one_line(&help.to_string()));
        }
        let _ = writeln!(text, "\n{name} = {value}");
    }
    text
}

/// What was given for an option, or its default; nothing for a flag that is not set.
fn raw_values(arg: &Arg, given: &ArgMatches) -> Vec<String> {
    let id = arg.get_id().as_str();
    if !arg.get_action().takes_values() {
        return if given.get_flag(id) { vec!["true".to_owned()] } else { Vec::new() };
    }
    let raw = given.get_raw(id).into_iter().flatten();
    raw.map(|value| value.to_string_lossy().into_owned()).collect()
}

/// A value as TOML: a number or a truth where it reads as one.
fn toml_of(text: &str) -> Value {
    let number = || text.parse().map(Value::Float).ok().filter(|_| text.contains(|c: char| c.is_ascii_digit()));
    let integer = text.parse().map(Value::Integer).ok();
    let truth = text.parse().map(Value::Boolean).ok();
    integer.or_else(number).or(truth).unwrap_or_else(|| Value::String(text.to_owned()))
}
