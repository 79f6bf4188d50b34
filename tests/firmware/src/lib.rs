//! Skyfront on flight processors: what the images under `src/bin` share.
//!
//! Assembly and `unsafe` live in [`machine`] alone. Everything else also builds for the host, where the
//! tests run it to know what the processors have to print.
//!
//! The protocol on the serial line, one item a line: `digest NAME 1a2b3c4d`, `resource NAME VALUE UNIT`,
//! and `done` at the end. Anything else, such as `panic ...` or `fault ...`, is a failure.

#![no_std]
#![cfg_attr(target_arch = "sparc", feature(asm_experimental_arch))]
#![deny(unsafe_code)]

pub mod bits;
pub mod case;
pub mod fram;
#[cfg(target_os = "none")]
#[allow(unsafe_code)]
pub mod machine;
#[cfg(target_os = "none")]
pub mod measured;
pub mod paper;
pub mod report;
pub mod run;
