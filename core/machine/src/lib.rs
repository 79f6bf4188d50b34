#![doc = include_str!("../README.md")]
#![no_std]
#![deny(missing_docs)]
#![warn(clippy::undocumented_unsafe_blocks)]
#![cfg_attr(all(target_arch = "sparc", not(target_feature = "soft-float")), feature(asm_experimental_arch))]

use skyfront_core::arithmetic::machine::Machine;
use skyfront_core::arithmetic::vectors::NoVectors;

#[cfg_attr(all(target_arch = "arm", target_abi = "eabihf"), path = "arm.rs")]
#[cfg_attr(
    all(any(target_arch = "riscv32", target_arch = "riscv64"), any(target_feature = "f", feature = "riscv-f")),
    path = "riscv.rs"
)]
#[cfg_attr(all(target_arch = "sparc", not(target_feature = "soft-float")), path = "sparc.rs")]
#[cfg_attr(target_arch = "x86_64", path = "x86_64.rs")]
mod root;

/// Whether the square root is the processor's own.
pub const HARDWARE: bool = root::HARDWARE;

/// The processor that the program is built for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Processor;

impl Machine for Processor {
    type Vectors = NoVectors<f32, f32>;

    #[inline(always)]
    fn sqrt(x: f32) -> f32 {
        root::sqrt(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use skyfront_core::arithmetic::machine::Plain;

    /// Of every exponent, subnormal numbers included, the smallest and the largest mantissas and some between.
    fn numbers() -> impl Iterator<Item = f32> {
        let mantissas = || (0..0x80_0000).step_by(40_009).chain([1, 2, 0x3F_FFFF, 0x40_0000, 0x7F_FFFE, 0x7F_FFFF]);
        (0..255u32).flat_map(move |exponent| mantissas().map(move |mantissa| f32::from_bits(exponent << 23 | mantissa)))
    }

    #[test]
    fn the_root_has_the_bits_of_software() {
        for x in numbers() {
            assert_eq!(Processor::sqrt(x).to_bits(), Plain::sqrt(x).to_bits(), "of {x:e}");
        }
    }

    #[test]
    fn this_computer_has_the_root_that_the_table_says() {
        assert_eq!(HARDWARE, cfg!(any(target_arch = "x86_64", all(target_arch = "arm", target_abi = "eabihf"))));
    }
}
