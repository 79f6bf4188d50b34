//! Helpers shared by the tests that span the crates.

pub mod agreement;
pub mod captions;
pub mod command;
pub mod compressed;
pub mod evolve;
pub mod fits_bytes;
pub mod frames;
pub mod noise;
pub mod scenes;
pub mod specimens;
pub mod text;

/// The code of the README and of the documents is compiled and run as a test.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
#[doc = include_str!("../../core/doc/on-board.md")]
pub struct Pages;
pub mod runs;
