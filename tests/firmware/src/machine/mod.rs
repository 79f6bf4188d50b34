//! The machines: start-up, serial line, instruction counter, end. One file each, all of one shape.
//!
//! Each starts with the stack painted and the memory cleared, and calls the function that [`entry!`](crate::entry)
//! names. Interrupts stay off. QEMU executes instructions, not pipelines: what the counters tell are
//! instructions, never cycles.

use core::cell::{Cell, UnsafeCell};
use core::fmt::{self, Write};
use core::panic::PanicInfo;
use skyfront_workload::report;

#[cfg_attr(target_arch = "arm", path = "cortex_m.rs")]
#[cfg_attr(target_arch = "riscv32", path = "riscv.rs")]
#[cfg_attr(target_arch = "sparc", path = "leon3.rs")]
mod this;

pub use this::{COUNTS, instructions, stop, ticks};

/// What the start-up code fills the stack with.
const PAINT: u32 = 0x5AFE_57AC;

unsafe extern "C" {
    static _stack_bottom: [u32; 0];
    static _stack_top: [u32; 0];
}

/// The serial line.
pub struct Console;

impl Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(this::put);
        Ok(())
    }
}

/// Bytes of stack used so far at the deepest: what no longer shows the paint.
#[must_use]
pub fn stack_used() -> usize {
    let (bottom, top) = (&raw const _stack_bottom as usize, &raw const _stack_top as usize);
    let painted = (bottom..top)
        .step_by(4)
        // Sound: the linker script reserves these words, aligned, for the stack alone.
        .take_while(|&at| unsafe { (at as *const u32).read_volatile() } == PAINT)
        .count();
    top - bottom - 4 * painted
}

/// Static memory that is handed out once.
///
/// `static_cell` does the same wherever a byte can be swapped atomically, which a LEON3 cannot.
pub struct Once<T> {
    taken: Cell<bool>,
    value: UnsafeCell<T>,
}

// Sound: there is one core, and interrupts stay off, so that nothing happens at the same time.
unsafe impl<T> Sync for Once<T> {}

impl<T> Once<T> {
    /// The memory with its first value; all zeros take no flash.
    pub const fn new(value: T) -> Self {
        Once { taken: Cell::new(false), value: UnsafeCell::new(value) }
    }

    /// The memory; asking twice ends the program, as a fault does.
    #[expect(clippy::mut_from_ref, reason = "given out once, which is the purpose of the type")]
    pub fn take(&'static self) -> &'static mut T {
        if self.taken.replace(true) {
            fault(0);
        }
        // Sound: this is the first call, so that nobody else has a reference.
        unsafe { &mut *self.value.get() }
    }
}

/// Names the application: a `fn(Console)` that the start-up code calls once; the machine ends when it returns.
#[macro_export]
macro_rules! entry {
    ($application:path) => {
        #[unsafe(export_name = "application")]
        extern "C" fn start() -> ! {
            $application($crate::machine::Console);
            $crate::machine::stop()
        }
    };
}

#[panic_handler]
fn panic(reason: &PanicInfo) -> ! {
    let _ = writeln!(Console, "{reason}");
    stop()
}

/// Where every processor fault ends.
#[unsafe(no_mangle)]
extern "C" fn fault(cause: usize) -> ! {
    // Without `writeln!`, so that a program that cannot panic carries no formatting at all.
    report::resource(&mut Console, &["fault"], cause as u32, "(the processor's number)");
    stop()
}

/// Writes a device register.
fn write(address: usize, value: u32) {
    // Sound: the callers name registers of devices that the emulated boards have, outside all memory.
    unsafe { (address as *mut u32).write_volatile(value) }
}

/// Reads a device register.
#[allow(dead_code)] // Not every machine has one to read.
fn read(address: usize) -> u32 {
    // Sound: as for `write`.
    unsafe { (address as *const u32).read_volatile() }
}
