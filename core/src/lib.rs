//! Level-set segmentation of astronomical images for any processor.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
