//! A run: its steps in their order, its memory and budget, the poll that does a bounded piece of
//! work, snapshots, and what it found.

#[deny(clippy::arithmetic_side_effects)]
pub mod budget;
pub mod extract;
pub mod frame;
pub mod memory;
pub mod outcome;
pub mod plan;
#[deny(clippy::arithmetic_side_effects)]
pub mod segmenter;
pub mod snapshot;
pub mod stage;
#[deny(clippy::arithmetic_side_effects)]
pub(crate) mod state;
pub mod workspace;
