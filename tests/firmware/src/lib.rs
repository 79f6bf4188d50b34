//! Skyfront on flight processors: what the programs under `src/bin` share.
//!
//! Assembly and `unsafe` live in [`machine`] alone; what the programs compute is in `skyfront-workload`,
//! which also runs on the host.

#![no_std]
#![cfg_attr(target_arch = "sparc", feature(asm_experimental_arch))]
#![deny(unsafe_code)]

#[allow(unsafe_code)]
pub mod machine;
pub mod sized;
