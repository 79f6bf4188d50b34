//! From source to images.

use crate::machines::{MACHINES, Machine};
use anyhow::{Context, Result, bail};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where the firmware's sources are.
#[must_use]
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware")
}

/// The programs of which nothing is measured.
const UNMEASURED: [&str; 3] = ["digests", "flight", "roots"];

/// The profile of a program.
fn profile(bin: &str) -> &'static str {
    if UNMEASURED.contains(&bin) { "unmeasured" } else { "release" }
}

/// The image of the program `bin` for `target`.
#[must_use]
pub fn image(target: &str, bin: &str) -> PathBuf {
    folder().join("target").join(target).join(profile(bin)).join(bin)
}

/// The compiler that `tests/firmware/setup` finds or installs.
struct Toolchain {
    rustc: String,
    cargo: String,
}

impl Toolchain {
    /// The path on which cargo looks for its parts, such as clippy: its own come first.
    fn path(&self) -> Result<OsString> {
        let own = Path::new(&self.cargo).parent().map(Path::to_owned);
        let rest = std::env::var_os("PATH").unwrap_or_default();
        Ok(std::env::join_paths(own.into_iter().chain(std::env::split_paths(&rest)))?)
    }
}

fn toolchain() -> Result<Toolchain> {
    let setup = folder().join("setup");
    let output = Command::new(&setup)
        .current_dir(folder())
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| format!("cannot start {}", setup.display()))?;
    if !output.status.success() {
        bail!("no toolchain for the processors: {} failed", setup.display());
    }
    let text = String::from_utf8(output.stdout)?;
    let value = |key: &str| {
        text.lines()
            .find_map(|line| line.strip_prefix(key)?.strip_prefix('='))
            .map(str::to_owned)
            .with_context(|| format!("{} did not tell {key}", setup.display()))
    };
    Ok(Toolchain { rustc: value("RUSTC")?, cargo: value("CARGO")? })
}

/// The compiler's version, to print beside sizes that depend on it.
pub fn compiler() -> Result<String> {
    let output = Command::new(toolchain()?.rustc).arg("--version").output()?;
    Ok(String::from_utf8(output.stdout)?.trim().to_owned())
}

/// Builds programs of the firmware, if any, for machines.
pub fn programs(names: &[&str], machines: &[Machine]) -> Result<()> {
    for profile in ["unmeasured", "release"] {
        let own = names.iter().filter(|name| self::profile(name) == profile);
        let bins: Vec<&str> = own.flat_map(|name| ["--bin", name]).collect();
        if !bins.is_empty() {
            let command = [&["build", "--profile", profile][..], &bins].concat();
            cargo(&command, machines, &[]).context("the firmware does not build")?;
        }
    }
    Ok(())
}

/// Looks for lints in the firmware, which is no part of the workspace; any is an error.
pub fn lint() -> Result<()> {
    cargo(&["clippy", "--release", "--bins"], &MACHINES, &["--", "-D", "warnings"]).context("the firmware has lints")
}

/// The core's static library for C, small as the firmware is; returns its file.
pub fn static_library(machine: &Machine) -> Result<PathBuf> {
    let manifest = folder().join("../../core/c/Cargo.toml");
    let manifest = manifest.to_str().context("a path in UTF-8")?;
    let rustc =
        ["rustc", "--release", "--manifest-path", manifest, "--crate-type", "staticlib", "--features", "panic-handler"];
    let small = ["profile.release.opt-level='s'", "profile.release.lto='fat'", "profile.release.panic='abort'"];
    let rest: Vec<&str> = small.iter().flat_map(|&line| ["--config", line]).collect();
    cargo(&rustc, &[*machine], &rest).context("the library for C does not build")?;
    Ok(folder().join("target").join(machine.target).join("release/libskyfront_c.a"))
}

/// Runs cargo in the firmware's folder, for machines.
fn cargo(command: &[&str], machines: &[Machine], rest: &[&str]) -> Result<()> {
    let tools = toolchain()?;
    let mut cargo = Command::new(&tools.cargo);
    cargo.current_dir(folder());
    // This program may itself run under another cargo, whose settings are not for the firmware.
    for (key, _) in std::env::vars() {
        if key.starts_with("CARGO") && key != "CARGO_HOME" || key.starts_with("RUST") {
            cargo.env_remove(key);
        }
    }
    cargo
        .env("RUSTC", &tools.rustc)
        .env("PATH", tools.path()?)
        // The library's source is built with the compiler it belongs to: a right of that compiler's own build.
        .env("RUSTC_BOOTSTRAP", "1")
        .args(command)
        .args(["--locked", "-Zbuild-std=core", "--target-dir", "target"]);
    for machine in machines {
        cargo.args(["--target", machine.target]);
    }
    let status = cargo.args(rest).status().with_context(|| format!("cannot start {}", tools.cargo))?;
    if !status.success() {
        bail!("cargo {} failed", command.join(" "));
    }
    Ok(())
}
