//! Arm with an FPU, of single precision at least, as all targets have whose calls pass numbers in its registers.

use core::arch::asm;

pub const HARDWARE: bool = true;

#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    let root: f32;
    // SAFETY: it reads and writes these registers only.
    unsafe { asm!("vsqrt.f32 {}, {}", out(sreg) root, in(sreg) x, options(pure, nomem, nostack, preserves_flags)) }
    root
}
