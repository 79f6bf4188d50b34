//! The examples of C and C++: header and examples without a warning, and what they print.

use skyfront_tests::command::{Folder, workspace};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const STRICT: [&str; 5] = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1"];

fn done(command: &mut Command) -> Output {
    let output = command.output().unwrap_or_else(|error| panic!("cannot start {command:?}: {error}"));
    assert!(output.status.success(), "{command:?}:\n{}", String::from_utf8_lossy(&output.stderr));
    output
}

fn include() -> String {
    format!("-I{}", workspace().join("core/c/include").display())
}

/// The static library for this machine, from the core and its dependencies as they were compiled for the tests.
fn library() -> PathBuf {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    done(
        Command::new(cargo)
            .current_dir(workspace())
            .args(["rustc", "-p", "skyfront-c", "--locked", "--crate-type", "staticlib"])
            .args(["--features", "std,skyfront-core/hal"])
            .arg("--target-dir")
            .arg(&target),
    );
    target.join("debug/libskyfront_c.a")
}

#[test]
fn the_header_stands_alone_in_both_languages() {
    let header = workspace().join("core/c/include/skyfront.h");
    for (compiler, standard, language) in [("cc", "-std=c11", "c"), ("c++", "-std=c++17", "c++")] {
        done(Command::new(compiler).args(STRICT).args([standard, "-x", language, "-fsyntax-only"]).arg(&header));
    }
}

#[test]
fn examples_print_the_golden_digests() {
    let library = library();
    let folder = Folder::new("c-examples");
    let mut digests = Vec::new();
    for (compiler, standard, example) in [("cc", "-std=c11", "star_tracker.c"), ("c++", "-std=c++17", "segment.cpp")] {
        let program = folder.file(example);
        let source = workspace().join("core/c/examples").join(example);
        let libraries = ["-lm", "-lpthread", "-ldl"];
        let mut compile = Command::new(compiler);
        done(
            compile.args(STRICT).args([standard, &include(), "-o", &program]).args([&source, &library]).args(libraries),
        );
        let text = String::from_utf8(done(&mut Command::new(&program)).stdout).expect("a text");
        assert!(text.ends_with("done\n"), "{text}");
        digests.extend(text.lines().filter(|line| line.starts_with("digest")).map(str::to_owned));
    }
    let golden = std::fs::read_to_string(workspace().join("tests/golden.txt")).expect("tests/golden.txt");
    let mut golden: Vec<&str> = golden.lines().filter(|line| line.starts_with("digest c/")).collect();
    golden.sort_unstable();
    digests.sort_unstable();
    assert_eq!(digests, golden);
}

/// What a wrong call is answered with, and that memory by the macro is enough.
#[test]
fn wrong_calls_are_numbers_and_never_faults() {
    let folder = Folder::new("c-calls");
    let (source, program) = (folder.file("calls.c"), folder.file("calls"));
    std::fs::write(&source, include_str!("calls.c")).expect("a file");
    let library = library();
    let mut compile = Command::new("cc");
    let libraries = ["-lm", "-lpthread", "-ldl"];
    done(compile.args(STRICT).args(["-std=c11", &include(), "-o", &program, &source]).arg(&library).args(libraries));
    let text = String::from_utf8(done(&mut Command::new(&program)).stdout).expect("a text");
    assert_eq!(text, "done\n");
}
