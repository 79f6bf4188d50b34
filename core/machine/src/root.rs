//! Any processor: software.

use skyfront_core::arithmetic::machine::{Machine, Plain};

pub const HARDWARE: bool = false;

#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    Plain::sqrt(x)
}
