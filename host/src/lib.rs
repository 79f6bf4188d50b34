//! The host side of Skyfront: files in, the core at work, files and pictures out.
//!
//! A program that links it without the command line takes it with `default-features = false`. Then
//! [`read`] gives an image, [`pipeline::segment`] its labels, [`catalogue::Catalogue`] its sources, and
//! [`mod@write`] and [`picture`] what goes to files:
#![doc = concat!("```no_run\n", include_str!("../examples/segment_file.rs"), "```\n")]
//! Pixels in memory need no file:
#![doc = concat!("```\n", include_str!("../examples/segment_pixels.rs"), "```\n")]
//!
//! Unsafe code is denied but in the modules that say here what for.
#![deny(unsafe_code)]

pub mod arithmetics;
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "instructions of AVX2, behind the proof that the processor has them")]
mod avx2;
pub mod background;
pub mod catalogue;
pub mod choices;
#[cfg(feature = "cli")]
pub mod cli;
pub mod crosscheck;
pub mod evolution;
pub mod extraction;
pub mod given;
pub mod input;
#[allow(unsafe_code, reason = "calls of functions compiled for AVX2, where the processor has it")]
pub mod machine;
pub mod measure;
pub mod mosaic;
pub mod nothing;
pub mod outline;
pub mod outputs;
pub mod packets;
pub mod parallel;
pub mod peer;
pub mod picture;
pub mod pipeline;
#[allow(unsafe_code, reason = "large pages, which change no content, and tables of zeros")]
pub mod planes;
pub mod provenance;
pub mod read;
pub mod reference;
pub mod remarks;
pub mod report;
pub mod reproduce;
pub mod score;
pub mod segmentation;
pub mod settings;
pub mod sky;
pub mod strips;
pub mod summary;
pub mod truth;
pub mod vectors;
mod workers;
pub mod write;
