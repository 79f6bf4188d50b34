//! The core for C and C++: `extern "C"` functions over caller's memory, with `include/skyfront.h`.
//!
//! This is the only crate of the workspace with `unsafe` code for others to call: it turns pointers into slices,
//! and every such place says what the caller has promised. Null pointers are an error, never a fault.
//!
//! A static library is made with
//!
//! ```sh
//! cargo rustc -p skyfront-c --release --crate-type staticlib --features std              # for a host
//! cargo rustc -p skyfront-c --release --crate-type staticlib --features panic-handler \
//!   --target thumbv7em-none-eabihf                                                       # for a flight computer
//! ```
//!
//! The core cannot panic (tests/no-panic), but a static library of Rust must say what a panic does: with the
//! feature `panic-handler` it waits for the watchdog. Without it the crate is for Rust applications.

#![no_std]
#![deny(missing_docs, unsafe_op_in_unsafe_fn)]
#![deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![deny(clippy::arithmetic_side_effects)]
#![allow(non_camel_case_types, reason = "names of C")]

#[cfg(feature = "std")]
extern crate std;

mod catalogue;
mod error;
mod memory;
mod packet;
mod pointer;
mod run;
mod search;
mod track;

pub use catalogue::*;
pub use error::*;
pub use packet::*;
pub use run::*;
pub use search::*;
pub use track::*;

use pointer::slice;

/// What a static library does in a panic that cannot happen: it stands still until the watchdog bites.
#[cfg(all(feature = "panic-handler", not(feature = "std"), not(test)))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}

/// The version of the interface: numbers and records of one version stay as they are.
pub const SKYFRONT_INTERFACE: u32 = 1;

/// The version of the interface that the library has; compare it with `SKYFRONT_INTERFACE`.
#[unsafe(no_mangle)]
pub extern "C" fn skyfront_interface() -> u32 {
    SKYFRONT_INTERFACE
}

/// CRC-32 (IEEE 802.3, as in zlib) of bytes; 0 for a null pointer.
///
/// # Safety
/// `bytes` points to `count` readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_crc32(bytes: *const u8, count: usize) -> u32 {
    let mut digest = skyfront_core::arithmetic::digest::Digest::default();
    // SAFETY: the caller's promise is the one that `slice` wants.
    if let Some(bytes) = unsafe { slice(bytes, count) } {
        digest.bytes(bytes);
    }
    digest.value()
}
