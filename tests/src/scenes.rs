//! Simulated skies with known truth, kept beside the repository; tests that need them say so when they are absent.

use skyfront::read::{Image, image};
use std::path::PathBuf;

/// `../shared/scenes`, or `None` with a note on stderr.
pub fn folder() -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    if path.is_dir() {
        return Some(path);
    }
    eprintln!("SKIPPED: ../shared/scenes is absent");
    None
}

/// The scene of that name.
pub fn load(name: &str) -> Option<Image> {
    let path = folder()?.join(name).with_extension("fits");
    Some(image(&path, None).unwrap_or_else(|error| panic!("{error}")))
}

/// The scene of that name, for a command that cannot do without.
pub fn needed(name: &str) -> Image {
    load(name).expect("../shared/scenes, which holds the scenes")
}
