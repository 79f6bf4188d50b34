//! Level-set segmentation of astronomical images for any processor.
//!
//! An image goes through the steps of Tozza and Falcone's Rescaling Segmentation Algorithm, one
//! file a step: [`normalize`], [`rescale`] (with [`otsu`] and the other thresholds), [`filter`], [`edge`], [`front`] and
//! [`scheme`] (until [`stop`]), [`label`], [`catalog`]. [`segmenter::Segmenter`] drives them all
//! in slices of bounded work, in memory that the caller provides and whose size
//! [`memory`] tells beforehand.
//!
//! The crate does not allocate, has no `unsafe` code and gives the same bits on every processor:
//! sums have a fixed order or are exact, `libm` is pinned, no NaN is ever made. That it does not
//! panic is proved by linking (tests/no-panic).
//!
//! Planes are row-major; row 0 comes first and is the bottom row of a FITS image. Pixel centres
//! have whole coordinates from (0, 0).
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
// What could panic is proved absent by linking (tests/no-panic); these find it while it is written.
#![cfg_attr(not(test), deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic))]

// Marked modules count with numbers of the caller, of a snapshot or of memory that an upset has
// changed: nothing there may overflow.
pub mod arithmetic;
mod beside;
#[deny(clippy::arithmetic_side_effects)]
pub mod budget;
#[deny(clippy::arithmetic_side_effects)]
pub mod catalog;
mod centre;
#[deny(clippy::arithmetic_side_effects)]
mod codec;
pub mod config;
pub mod deblend;
pub mod detect;
pub mod detection;
pub mod digest;
pub mod edge;
pub mod error;
pub mod filter;
pub mod flags;
pub mod frame;
pub mod front;
pub mod grid;
#[cfg(feature = "hal")]
#[deny(clippy::arithmetic_side_effects)]
pub mod hal;
pub mod kapur;
pub mod label;
pub mod machine;
pub mod march;
pub mod memory;
#[deny(clippy::arithmetic_side_effects)]
pub mod noise;
pub mod normalize;
#[deny(clippy::arithmetic_side_effects)]
pub mod otsu;
pub mod outcome;
pub mod photon;
mod pieces;
pub mod region;
pub mod rescale;
pub mod rosin;
pub mod scheme;
#[deny(clippy::arithmetic_side_effects)]
pub mod segmenter;
#[deny(clippy::arithmetic_side_effects)]
pub mod select;
pub mod settle;
pub mod significance;
pub mod simulate;
pub mod sky;
pub mod smooth;
pub mod snapshot;
pub mod sort;
pub mod spike;
pub mod stage;
pub mod start;
#[deny(clippy::arithmetic_side_effects)]
mod state;
#[deny(clippy::arithmetic_side_effects)]
pub mod stop;
pub mod sum;
pub mod sweep;
pub mod tiles;
pub mod tree;
mod typical;
pub mod vectors;
