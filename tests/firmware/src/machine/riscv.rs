//! RV32IMAC and RV32IMAFC: QEMU's `virt` board.

use super::{PAINT, write};
use core::arch::{asm, global_asm};

/// Whether [`ticks`] tells anything.
pub const COUNTS: bool = true;

const UART_DATA: usize = 0x1000_0000;
const FINISHER: usize = 0x0010_0000;

global_asm!(
    ".section .start, \"ax\"",
    ".globl _start",
    "_start:",
    "la sp, _stack_top",
    "la t0, _fault",
    "csrw mtvec, t0",
    // Let the FPU run; without one, the bits cannot be set.
    "li t0, 0x2000",
    "csrs mstatus, t0",
    "la t0, _stack_bottom",
    "li t1, {paint}",
    "1: sw t1, 0(t0)",
    "addi t0, t0, 4",
    "bltu t0, sp, 1b",
    "la t0, _bss_start",
    "la t1, _bss_end",
    "j 3f",
    "2: sw zero, 0(t0)",
    "addi t0, t0, 4",
    "3: bltu t0, t1, 2b",
    "call application",
    ".align 2",
    "_fault:",
    "csrr a0, mcause",
    "la sp, _stack_top",
    "call fault",
    paint = const PAINT,
);

/// A running number; differences hold up to 2^32 instructions.
#[must_use]
pub fn ticks() -> u32 {
    let count: u32;
    // Sound: reads a counter.
    unsafe { asm!("csrr {}, minstret", out(reg) count) }
    count
}

/// Instructions in a difference of [`ticks`]: the counter is `minstret` itself.
#[must_use]
pub fn instructions(ticks: u32) -> u64 {
    u64::from(ticks)
}

pub(super) fn put(byte: u8) {
    // The line is byte-wide; its neighbours are registers of their own.
    unsafe { (UART_DATA as *mut u8).write_volatile(byte) }
}

/// Ends the emulation (the test device: pass).
pub fn stop() -> ! {
    loop {
        write(FINISHER, 0x5555);
    }
}
