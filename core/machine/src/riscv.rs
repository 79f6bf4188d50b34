//! RISC-V with the F extension; the instruction names its rounding, ties to even.

use core::arch::asm;

pub const HARDWARE: bool = true;

#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    let root: f32;
    // SAFETY: it reads and writes these registers only.
    unsafe { asm!("fsqrt.s {}, {}, rne", out(freg) root, in(freg) x, options(pure, nomem, nostack, preserves_flags)) }
    root
}
