//! Simulated skies with known truth, kept beside the repository, for the tests that are asked for by name.

use skyfront::read::{Image, image};
use std::path::PathBuf;

/// `../shared/scenes`.
pub fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes")
}

/// The scene of that name.
pub fn needed(name: &str) -> Image {
    let path = folder().join(name).with_extension("fits");
    image(&path, None).unwrap_or_else(|error| panic!("{error}"))
}
