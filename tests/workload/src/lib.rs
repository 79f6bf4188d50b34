//! What runs on every processor, the workstation's included: scenes, digests, simulated devices.
//!
//! The protocol on the serial line, one item a line: `digest NAME 1a2b3c4d`, `resource NAME VALUE UNIT`,
//! and `done` at the end. Anything else, such as `panicked at ...`, is a failure.

#![no_std]
#![forbid(unsafe_code)]

pub mod bits;
pub mod case;
pub mod cost;
pub mod fram;
pub mod paper;
pub mod polls;
pub mod report;
pub mod run;
pub mod sources;
pub mod track;
