//! The `skyfront` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    // Without a handler an interrupt would leave temporary files behind; if none can be set, that is all that is lost.
    let _ = ctrlc::set_handler(|| skyfront::write::interrupted());
    skyfront::cli::run(std::env::args_os())
}
