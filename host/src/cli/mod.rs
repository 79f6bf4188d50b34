//! The command line: what can be asked, and the exit codes.
//!
//! Results go to files, messages to stderr. Exit codes: 0 done, 1 bad input or a failed check,
//! 2 bad usage, 130 interrupted.

mod demo;
mod options;
mod segment;

pub use demo::simulated;
pub use options::Options;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Finds and outlines stars and galaxies in astronomical images with level-set methods.
#[derive(Debug, Parser)]
#[command(name = "skyfront", version, about, long_about = None)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Segment an image: FITS (also compressed or gzipped), PGM or 16-bit PNG.
    Segment(Box<segment::Arguments>),
    /// Make a simulated sky and segment it. Without any command this goes into skyfront-out/.
    Demo(demo::Arguments),
}

/// Runs a command line.
pub fn run(cli: Cli) -> ExitCode {
    let result = match cli.command {
        Some(Command::Segment(arguments)) => segment::run(&arguments),
        Some(Command::Demo(arguments)) => demo::run(&arguments),
        None => demo::run(&demo::Arguments::into_default_folder()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("skyfront: {error:#}");
            ExitCode::FAILURE
        }
    }
}
