//! The front: where it starts, what speed it has, the schemes that move it, and when it stops.

pub mod bands;
pub mod edge;
pub mod march;
pub mod outline;
pub mod pair;
pub mod profile;
pub mod region;
pub mod scheme;
pub mod settle;
pub mod start;
#[deny(clippy::arithmetic_side_effects)]
pub mod stop;
