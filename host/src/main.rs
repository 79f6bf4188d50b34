//! The `skyfront` command.
#![forbid(unsafe_code)]

fn main() -> std::process::ExitCode {
    skyfront::cli::main()
}
