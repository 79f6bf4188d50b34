//! Stdout for results and stderr for messages, whoever listens.

use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write};

/// Results could not be written.
#[derive(Debug, thiserror::Error)]
#[error("stdout cannot be written: {0}")]
pub struct Unwritten(io::Error);

impl Unwritten {
    /// Whether the reader has gone, who then wants no message either.
    pub fn is_gone(&self) -> bool {
        self.0.kind() == ErrorKind::BrokenPipe
    }
}

/// Stdout, for `write!` and `writeln!`.
pub struct Stdout;

impl Stdout {
    /// Writes and flushes.
    ///
    /// # Errors
    /// [`Unwritten`], where `println!` would panic.
    pub fn write_fmt(&self, text: Arguments<'_>) -> Result<(), Unwritten> {
        let mut out = io::stdout().lock();
        out.write_fmt(text).and_then(|()| out.flush()).map_err(Unwritten)
    }
}

/// Stderr, for `write!` and `writeln!`: where nobody can hear, the work goes on.
pub struct Stderr;

impl Stderr {
    /// Writes what can be written.
    pub fn write_fmt(&self, text: Arguments<'_>) {
        let _ = io::stderr().write_fmt(text);
    }
}

/// Says what clap has to say, help or an error, and ends the process.
pub fn exit(error: &clap::Error) -> ! {
    let unwritten = error.print().and_then(|()| io::stdout().flush()).is_err();
    std::process::exit(if unwritten { 1 } else { error.exit_code() })
}
