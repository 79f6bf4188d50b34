//! `skyfront packets`: what came down from board.

use super::say::{Stderr, Stdout};
use crate::packets::Received;
use anyhow::{Context, Result, bail};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Debug, Args)]
pub struct Arguments {
    /// Packets one behind the other, as they came down.
    file: PathBuf,
}

/// Prints stars, maps of labels and cut-outs, each as one line of JSON; what is damaged or lost is told, and the
/// rest is used.
///
/// # Errors
/// A file that cannot be read or holds no packet, or what stdout refuses.
pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let file = arguments.file.display();
    let bytes = std::fs::read(&arguments.file).with_context(|| format!("{file} cannot be read"))?;
    let received = Received::of(&bytes);
    if received.packets() == 0 {
        bail!("{file} holds no packet");
    }
    received.lines(|line| writeln!(Stdout, "{line}"))?;
    received.remarks.iter().for_each(|remark| writeln!(Stderr, "warning: {file}: {remark}"));
    let lost = received.remarks.iter().any(crate::packets::Remark::is_loss);
    Ok(if lost { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}
