//! The `skyfront` command once more: cargo builds it with the tests, and it shares all that they compiled.
#![forbid(unsafe_code)]

fn main() -> std::process::ExitCode {
    skyfront::cli::main()
}
