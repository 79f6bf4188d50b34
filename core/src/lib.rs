//! Level-set segmentation of astronomical images for any processor.
//!
//! An image goes through the rooms from the top down:
//!
//! * [`sky`]: what the detector did to the numbers, background and noise, signal-to-noise;
//! * [`image`](mod@image): pixel values become numbers in [0, 1], are rescaled and filtered;
//! * [`front`]: edge detectors, the start, the schemes that move the front until it stops;
//! * [`sources`]: components or the tree of level sets, deblending, significance, the catalogue;
//! * [`track`](mod@track): stars in windows, where a star tracker expects them;
//! * [`packet`]: what goes to the ground, in packets that are read one by one;
//! * [`run`]: all steps in their order, in slices of bounded work, in memory that the caller
//!   provides and whose size [`run::memory`] tells beforehand.
//!
//! Below them lie the number types ([`arithmetic`]), planes of pixels ([`plane`]) and what a run is
//! to do ([`config`]); beside them devices ([`hal`]) and a simulated sky ([`simulate`]). No room
//! uses one that lies above it.
//!
//! The crate does not allocate, has no `unsafe` code and gives the same bits on every processor:
//! sums have a fixed order or are exact, `libm` is pinned, no NaN is ever made. That it does not
//! panic is proved by linking (tests/no-panic).
//!
//! Planes are row-major; row 0 comes first and is the bottom row of a FITS image. Pixel centres
//! have whole coordinates from (0, 0).
//!
//! # A tour
//!
//! Each of these is a program in `examples`, which `cargo run --example NAME` runs.
//!
//! `front_in_slices`: the paper's front, which needs two planes, and of which each call does a bounded
//! piece of work.
#![doc = concat!("```\n", include_str!("../examples/front_in_slices.rs"), "```\n")]
//! `default`: what finds most, in four planes, two lists, a mesh and a table of regions.
#![doc = concat!("```\n", include_str!("../examples/default.rs"), "```\n")]
//! `default_in_slices`: the same over a camera's buffer, a few rows of work per poll.
#![doc = concat!("```\n", include_str!("../examples/default_in_slices.rs"), "```\n")]
//! `front_on_signal`: both together, the front of the paper over the default's signal-to-noise.
#![doc = concat!("```\n", include_str!("../examples/front_on_signal.rs"), "```\n")]
//! `snapshot`: a run that ends elsewhere than it began.
#![doc = concat!("```\n", include_str!("../examples/snapshot.rs"), "```\n")]
//! `star_tracker`: stars in windows, with their errors.
#![doc = concat!("```\n", include_str!("../examples/star_tracker.rs"), "```\n")]
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
// What could panic is proved absent by linking (tests/no-panic); these find it while it is written.
#![cfg_attr(not(test), deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic))]

// Modules that deny arithmetic side effects count with numbers of the caller, of a snapshot or of
// memory that an upset has changed: nothing there may overflow.
pub mod arithmetic;
pub mod config;
pub mod error;
pub mod front;
#[cfg(feature = "hal")]
#[deny(clippy::arithmetic_side_effects)]
pub mod hal;
pub mod image;
#[deny(clippy::arithmetic_side_effects)]
pub mod packet;
pub mod plane;
pub mod run;
pub mod simulate;
pub mod sky;
pub mod sources;
pub mod track;
