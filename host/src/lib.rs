//! The host side of Skyfront: files in, the core at work, files and pictures out.

pub mod arithmetics;
#[cfg(target_arch = "x86_64")]
mod avx2;
pub mod background;
pub mod catalogue;
pub mod cli;
pub mod crosscheck;
pub mod detection;
pub mod input;
pub mod machine;
pub mod measure;
pub mod nothing;
pub mod outline;
pub mod outputs;
pub mod parallel;
pub mod picture;
pub mod pipeline;
pub mod planes;
pub mod provenance;
pub mod read;
pub mod reference;
pub mod remarks;
pub mod report;
pub mod reproduce;
pub mod score;
pub mod sky;
pub mod summary;
pub mod truth;
pub mod vectors;
pub mod write;
