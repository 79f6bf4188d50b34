//! Helpers shared by the tests that span the crates.

pub mod command;
pub mod text;
