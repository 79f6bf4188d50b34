//! The `skyfront` command.

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    skyfront::cli::run(skyfront::cli::Cli::parse())
}
