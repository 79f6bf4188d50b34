//! SPARC V8 with an FPU, whose registers inline assembly cannot name as operands: a function of four instructions.

use core::arch::naked_asm;

pub const HARDWARE: bool = true;

#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    root(x)
}

/// The argument comes in an integer register, and the caller's frame has a place for it; the result goes back in `%f0`.
// SAFETY: it keeps to the calling convention of SPARC V8 (SVR4 ABI), and changes no register that outlasts a call.
#[unsafe(naked)]
extern "C" fn root(x: f32) -> f32 {
    naked_asm!("st %o0, [%sp + 68]", "ld [%sp + 68], %f0", "retl", "fsqrts %f0, %f0")
}
