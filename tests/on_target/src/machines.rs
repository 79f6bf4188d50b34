//! The emulated machines.

/// A processor and the emulator that has it.
#[derive(Debug, Clone, Copy)]
pub struct Machine {
    /// What the firmware calls it.
    pub name: &'static str,
    /// Rust's name of the target.
    pub target: &'static str,
    /// The emulator and its arguments, up to the image's name.
    pub emulator: &'static [&'static str],
    /// Whether it has an instruction for square roots, which its programs are to use.
    pub has_root: bool,
}

/// The machines whose needs are in the table: one with an FPU, one without, both of which count instructions.
pub const MEASURED: [Machine; 2] = [MACHINES[0], MACHINES[2]];

/// RISC-V with the F extension: beside the others for its square root alone.
pub const RV32IMAFC: Machine =
    Machine { name: "rv32imafc", target: "riscv32imafc-unknown-none-elf", has_root: true, ..MACHINES[2] };

/// Every machine that the promise of equal bits is kept for.
pub const MACHINES: [Machine; 4] = [
    Machine {
        name: "cortex-m7",
        target: "thumbv7em-none-eabihf",
        emulator: &[
            "qemu-system-arm",
            "-M",
            "mps2-an500",
            "-nographic",
            "-semihosting-config",
            "enable=on,target=native",
            "-icount",
            "shift=0",
            "-kernel",
        ],
        has_root: true,
    },
    Machine {
        name: "cortex-m3",
        target: "thumbv7m-none-eabi",
        emulator: &[
            "qemu-system-arm",
            "-M",
            "mps2-an385",
            "-nographic",
            "-semihosting-config",
            "enable=on,target=native",
            "-icount",
            "shift=0",
            "-kernel",
        ],
        has_root: false,
    },
    Machine {
        name: "rv32imac",
        target: "riscv32imac-unknown-none-elf",
        emulator: &[
            "qemu-system-riscv32",
            "-M",
            "virt",
            "-bios",
            "none",
            "-nographic",
            "-icount",
            "shift=0",
            "-kernel",
        ],
        has_root: false,
    },
    Machine {
        name: "leon3",
        target: "sparc-unknown-none-elf",
        emulator: &["qemu-system-sparc", "-M", "leon3_generic", "-nographic", "-kernel"],
        has_root: true,
    },
];
