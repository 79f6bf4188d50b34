//! From an outlined image to sources: components or the tree of level sets, deblending,
//! significance, labels and the catalogue.

#[deny(clippy::arithmetic_side_effects)]
pub mod catalog;
pub(crate) mod centre;
pub mod deblend;
pub mod flags;
pub(crate) mod knots;
pub mod label;
pub mod measure;
pub(crate) mod pieces;
pub mod selection;
pub mod separate;
pub mod significance;
pub mod tree;
pub mod typical;
