//! Nothing in the core can panic, in any arithmetic: `tests/no-panic` links.

use std::path::Path;
use std::process::Command;

#[test]
fn the_core_links_without_a_panic_handler() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("no-panic");
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no-panic");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["build", "--release", "--locked", "--manifest-path"])
        .arg(folder.join("Cargo.toml"))
        .arg("--target-dir")
        .arg(target)
        .output()
        .expect("cargo can be started");
    let messages = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "a panic can be reached:\n{messages}");
}
