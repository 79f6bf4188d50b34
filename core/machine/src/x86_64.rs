//! x86-64: the workstation on which flight software is tried.

use core::arch::x86_64::{_mm_cvtss_f32, _mm_set_ss, _mm_sqrt_ss};

pub const HARDWARE: bool = true;

#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    // SAFETY: every x86-64 has SSE, which is all that these ask for.
    unsafe { _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x))) }
}
