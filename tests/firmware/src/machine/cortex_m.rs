//! Cortex-M7 with FPU and Cortex-M3: the MPS2 boards AN500 and AN385.

use super::{PAINT, read, write};
use core::arch::{asm, global_asm};

/// Whether [`ticks`] tells anything.
pub const COUNTS: bool = true;
/// Instructions for each count of SysTick: under `-icount shift=0` one takes 1 ns, and the clock is 25 MHz.
const PER_COUNT: u64 = 40;

const UART_DATA: usize = 0x4000_4000;
const UART_CONTROL: usize = 0x4000_4008;
const UART_DIVISOR: usize = 0x4000_4010;
const SYSTICK_CONTROL: usize = 0xE000_E010;
const SYSTICK_RELOAD: usize = 0xE000_E014;
const SYSTICK_VALUE: usize = 0xE000_E018;

// The vector table, then: let the FPU run (without one the register ignores it), paint, clear, go.
global_asm!(
    ".section .start, \"ax\"",
    ".word _stack_top",
    ".word _start",
    ".rept 14",
    ".word _fault",
    ".endr",
    ".thumb_func",
    ".globl _start",
    "_start:",
    "ldr r0, =0xE000ED88",
    "ldr r1, =0x00F00000",
    "str r1, [r0]",
    "dsb",
    "isb",
    "ldr r0, =_stack_bottom",
    "ldr r1, =_stack_top",
    "ldr r2, ={paint}",
    "1: str r2, [r0], #4",
    "cmp r0, r1",
    "blo 1b",
    "ldr r0, =_bss_start",
    "ldr r1, =_bss_end",
    "movs r2, #0",
    "b 3f",
    "2: str r2, [r0], #4",
    "3: cmp r0, r1",
    "blo 2b",
    "bl {prepare}",
    "bl application",
    ".thumb_func",
    "_fault:",
    "mrs r0, ipsr",
    "bl fault",
    ".ltorg",
    paint = const PAINT,
    prepare = sym prepare,
);

extern "C" fn prepare() {
    write(UART_DIVISOR, 16);
    write(UART_CONTROL, 1);
    write(SYSTICK_RELOAD, 0x00FF_FFFF);
    write(SYSTICK_VALUE, 0);
    write(SYSTICK_CONTROL, 0b101);
}

/// A running number; differences hold up to 671 million instructions.
#[must_use]
pub fn ticks() -> u32 {
    // The counter runs down in the upper bits, so that differences wrap as they should.
    0u32.wrapping_sub(read(SYSTICK_VALUE) << 8)
}

/// Instructions in a difference of [`ticks`].
#[must_use]
pub fn instructions(ticks: u32) -> u64 {
    u64::from(ticks >> 8) * PER_COUNT
}

pub(super) fn put(byte: u8) {
    write(UART_DATA, u32::from(byte));
}

/// Ends the emulation (semihosting: exit without error).
pub fn stop() -> ! {
    loop {
        // Sound: the emulator takes this breakpoint for itself and does not return.
        unsafe { asm!("bkpt 0xab", in("r0") 0x18, in("r1") 0x20026) }
    }
}
