//! The host side of Skyfront: files in, the core at work, files and pictures out.

pub mod machine;
pub mod pipeline;
pub mod read;
pub mod write;
