//! The command line: what can be asked, and the exit codes.
//!
//! Results go to files, messages to stderr.

mod arguments;
mod batch;
mod beside;
mod budget;
mod columns;
mod crosscheck;
mod demo;
mod examples;
mod folders;
mod foreign;
mod given;
mod instructions;
mod job;
mod manual;
mod measuring;
mod memory;
mod messages;
mod options;
mod packets;
mod parameters;
mod presets;
mod process;
mod reproduce;
mod say;
mod score;
mod segment;
mod settings;
mod simulate;
mod strips;
mod table;

pub use crate::truth::simulated;
pub use beside::Beside;
pub use measuring::Measuring;
pub use options::Options;

use crate::choices;
use crate::settings::Refused;
use anyhow::Result;
use clap::{Arg, ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
use say::{Stderr, Stdout, Unwritten};
use skyfront_core::config::Parameter;
use skyfront_core::error::Error;
use std::ffi::OsString;
use std::process::ExitCode;

/// What every help page ends with.
const EXIT_CODES: &str = "\
Exit codes: 0 done; 1 bad input or a failed check; 2 bad usage; 130 interrupted (Ctrl-C).
Results go to files or stdout, messages to stderr.";

/// Finds and outlines stars and galaxies in astronomical images with level-set methods.
#[derive(Debug, Parser)]
#[command(name = "skyfront", version, about, long_about = None, after_help = EXIT_CODES)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Segment images: FITS (also compressed or gzipped), PGM or 16-bit PNG.
    #[command(after_help = EXIT_CODES)]
    Segment(Box<arguments::Arguments>),
    /// Compare every step of a run with an independent f64 implementation of the paper and of the default.
    Crosscheck(Box<crosscheck::Arguments>),
    /// Run every caption of the paper's Tests 1 and 2, and hold its times and conclusions beside ours.
    Reproduce(reproduce::Arguments),
    /// Make a simulated sky, segment it and compare the result with its truth; needs no option.
    Demo(demo::Arguments),
    /// Tell the most memory and row operations that a run can need, before it starts.
    Budget(Box<budget::Arguments>),
    /// Write a simulated sky and its truth, which objects own which pixels.
    Simulate(simulate::Arguments),
    /// Score a segmentation map against the truth (Haigh et al. 2021).
    Score(score::Arguments),
    /// Print what packets from board hold: stars, maps of labels and cut-outs, each as one line of JSON.
    ///
    /// Damaged, lost and repeated packets are told on stderr, and the rest is used. Exit code 1 where something was
    /// lost. Pixel centres have whole coordinates from (0, 0), as on board; variances of stars that were not found
    /// are null, and so are missing pixels of cut-outs. Of a map of labels, runs are [first pixel in row-major order,
    /// length, label], and missing parts [first pixel, length].
    Packets(packets::Arguments),
    /// List the presets with their settings.
    Presets,
    /// List all parameters with their units, bounds, defaults and meanings.
    Parameters,
    /// List the columns of the catalogue and the bits of its flags.
    Columns(columns::Arguments),
    /// Print a manual page (read it with `skyfront man | man -l -`).
    Man(manual::ManArguments),
    /// Print the completions for a shell.
    Completions(manual::CompletionsArguments),
}

/// The whole program: the command line of this process.
pub fn main() -> ExitCode {
    process::prepare();
    run(std::env::args_os())
}

/// Runs a command line, the program's name first.
pub fn run(line: impl IntoIterator<Item = OsString>) -> ExitCode {
    let mut command = command();
    let matches = settings::parse(&mut command, line.into_iter().collect()).unwrap_or_else(|error| say::exit(&error));
    let done = dumped(&mut command, &matches).and_then(|text| match text {
        Some(text) => write!(Stdout, "{text}").map(|()| ExitCode::SUCCESS).map_err(anyhow::Error::from),
        None => obey(Cli::from_arg_matches(&matches).unwrap_or_else(|error| say::exit(&error.format(&mut command)))),
    });
    done.unwrap_or_else(|error| {
        if !error.downcast_ref().is_some_and(Unwritten::is_gone) {
            writeln!(Stderr, "skyfront: {}", message(&error));
        }
        if is_usage(&error) { ExitCode::from(2) } else { ExitCode::FAILURE }
    })
}

/// Options of `segment` beside the common parameters that its short help shows.
const SHORT: [&str; 17] = [
    "images",
    "out",
    "config_file",
    "preset",
    "mask",
    "weight",
    "weight_type",
    "background",
    "gain",
    "zero_point",
    "apertures",
    "regions",
    "no_pictures",
    "overwrite",
    "jobs",
    "quiet",
    "verbose",
];

/// The definition of the command line.
fn command() -> clap::Command {
    let parameter = |arg: &Arg| Parameter::named(arg.get_id().as_str()).is_some();
    let short = move |arg: Arg| {
        let shown = parameter(&arg) || SHORT.contains(&arg.get_id().as_str());
        if shown { arg } else { arg.hide_short_help(true) }
    };
    let with_examples = |command: clap::Command| match examples::of(command.get_name()) {
        Some(text) => command.after_long_help(format!("{text}\n\n{EXIT_CODES}")),
        None => command,
    };
    Cli::command()
        .after_long_help(format!("{}\n\n{EXIT_CODES}", examples::TASKS))
        .mut_subcommand("segment", |segment| segment.mut_args(short))
        .mut_subcommands(with_examples)
}

/// An error in one line; a parameter out of bounds by the name of its option.
fn message(error: &anyhow::Error) -> String {
    match core_error(error) {
        Some(refused @ Error::Parameter { .. }) => format!("--{refused}"),
        Some(Error::Together { choice, value, other, wanted }) => {
            format!("--{choice} {value} needs --{other} {wanted}")
        }
        _ => format!("{error:#}"),
    }
}

/// The core's error where it is one.
fn core_error(error: &anyhow::Error) -> Option<&Error> {
    match error.downcast_ref() {
        Some(Refused::Value(refused)) => Some(refused),
        _ => error.downcast_ref(),
    }
}

/// Options that do not go together.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Usage(&'static str);

/// Whether an error lies in the command line, not in the files.
fn is_usage(error: &anyhow::Error) -> bool {
    let refused =
        matches!(core_error(error), Some(Error::Parameter { .. } | Error::Together { .. } | Error::Arithmetic { .. }));
    refused || error.is::<Usage>() || error.is::<Refused>()
}

fn obey(cli: Cli) -> Result<ExitCode> {
    match cli.command {
        Some(Command::Segment(arguments)) => return segment::run(&arguments),
        Some(Command::Packets(arguments)) => return packets::run(&arguments),
        Some(Command::Crosscheck(arguments)) => crosscheck::run(&arguments)?,
        Some(Command::Budget(arguments)) => budget::run(&arguments)?,
        Some(Command::Reproduce(arguments)) => reproduce::run(&arguments)?,
        Some(Command::Demo(arguments)) => demo::run(&arguments)?,
        Some(Command::Simulate(arguments)) => simulate::run(&arguments)?,
        Some(Command::Score(arguments)) => score::run(&arguments)?,
        Some(Command::Presets) => presets::run()?,
        Some(Command::Parameters) => parameters::run()?,
        Some(Command::Columns(arguments)) => columns::run(&arguments)?,
        Some(Command::Man(arguments)) => manual::man(&arguments)?,
        Some(Command::Completions(arguments)) => manual::completions(&arguments)?,
        None => write!(Stdout, "{}", Cli::command().render_help())?,
    }
    Ok(ExitCode::SUCCESS)
}

/// What `--dump-config` prints, where it is asked for.
fn dumped(command: &mut clap::Command, matches: &ArgMatches) -> Result<Option<String>> {
    let Some((name, given)) = matches.subcommand() else { return Ok(None) };
    let wanted = given.try_get_one::<bool>("dump_config").ok().flatten();
    let Some(true) = wanted else { return Ok(None) };
    let options = Options::from_arg_matches(given).unwrap_or_else(|error| say::exit(&error.format(command)));
    let config = options.config()?;
    Ok(command.find_subcommand(name).map(|subcommand| settings::dump(subcommand, given, &config)))
}
