//! LEON3, the European space processor: big-endian SPARC V8 with eight register windows.

use super::{PAINT, write};
use core::arch::{asm, global_asm};

/// Whether [`ticks`] tells anything: QEMU's LEON3 counts no instructions.
pub const COUNTS: bool = false;

const UART_DATA: usize = 0x8000_0100;
const UART_CONTROL: usize = 0x8000_0108;

// The trap table fills the first 4 KiB: 256 entries of four instructions, whose last one is a delay slot.
// Trap 5 (window overflow) and 6 (window underflow) belong to every deep call; all others are faults.
// PSR on entry: FPU on, interrupts off, supervisor, traps on, window 0; the invalid window is 1.
global_asm!(
    ".section .start, \"ax\"",
    ".align 4096",
    "traps:",
    "ba _start; nop; nop; nop",
    ".rept 4",
    "rd %psr, %l0; ba _fault; rd %tbr, %l3; nop",
    ".endr",
    "rd %wim, %l3; ba _overflow; mov %g1, %l7; nop",
    "rd %wim, %l3; ba _underflow; nop; nop",
    ".rept 249",
    "rd %psr, %l0; ba _fault; rd %tbr, %l3; nop",
    ".endr",
    // The window behind the invalid one becomes invalid; the old one goes to its stack frame.
    "_overflow:",
    "srl %l3, 1, %g1",
    "sll %l3, 7, %l4",
    "or %l4, %g1, %g1",
    "save",
    "wr %g1, 0, %wim",
    "nop; nop; nop",
    "std %l0, [%sp]",
    "std %l2, [%sp + 8]",
    "std %l4, [%sp + 16]",
    "std %l6, [%sp + 24]",
    "std %i0, [%sp + 32]",
    "std %i2, [%sp + 40]",
    "std %i4, [%sp + 48]",
    "std %i6, [%sp + 56]",
    "restore",
    "mov %l7, %g1",
    "jmp %l1",
    "rett %l2",
    // The window before the invalid one becomes invalid; the other comes back from its stack frame.
    "_underflow:",
    "sll %l3, 1, %l4",
    "srl %l3, 7, %l5",
    "or %l5, %l4, %l5",
    "wr %l5, 0, %wim",
    "nop; nop; nop",
    "restore",
    "restore",
    "ldd [%sp], %l0",
    "ldd [%sp + 8], %l2",
    "ldd [%sp + 16], %l4",
    "ldd [%sp + 24], %l6",
    "ldd [%sp + 32], %i0",
    "ldd [%sp + 40], %i2",
    "ldd [%sp + 48], %i4",
    "ldd [%sp + 56], %i6",
    "save",
    "save",
    "jmp %l1",
    "rett %l2",
    ".globl _start",
    "_start:",
    "wr %g0, 2, %wim",
    "set traps, %g1",
    "wr %g1, 0, %tbr",
    "set 0x1fe0, %g1",
    "wr %g1, 0, %psr",
    "nop; nop; nop",
    "set _stack_bottom, %g1",
    "set _stack_top, %g2",
    "set {paint}, %g3",
    "1: st %g3, [%g1]",
    "add %g1, 4, %g1",
    "cmp %g1, %g2",
    "blu 1b",
    "nop",
    "set _bss_start, %g1",
    "set _bss_end, %g3",
    "ba 3f",
    "nop",
    "2: st %g0, [%g1]",
    "add %g1, 4, %g1",
    "3: cmp %g1, %g3",
    "blu 2b",
    "nop",
    // The first frame: room for a window and the arguments, as the calling convention has it.
    "sub %g2, 96, %sp",
    "mov %g0, %fp",
    "call {prepare}",
    "nop",
    "call application",
    "nop",
    "_fault:",
    "and %l3, 0xff0, %o0",
    "set _stack_top - 96, %sp",
    "wr %g0, 2, %wim",
    "wr %g0, 0xfe0, %psr",
    "nop; nop; nop",
    "srl %l3, 4, %o0",
    "call fault",
    "and %o0, 0xff, %o0",
    paint = const PAINT,
    prepare = sym prepare,
);

extern "C" fn prepare() {
    write(UART_CONTROL, 3);
}

/// No counter: always 0.
#[must_use]
pub fn ticks() -> u32 {
    0
}

/// Instructions in a difference of [`ticks`]: always 0.
#[must_use]
pub fn instructions(_ticks: u32) -> u64 {
    0
}

pub(super) fn put(byte: u8) {
    write(UART_DATA, u32::from(byte));
}

/// Ends the emulation: a trap while traps are off halts the processor.
pub fn stop() -> ! {
    loop {
        // Sound: nothing runs after it.
        unsafe { asm!("wr %g0, 0xc0, %psr", "nop", "nop", "nop", "ta 0") }
    }
}
