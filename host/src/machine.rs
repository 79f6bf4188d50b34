//! The workstation's processor: hardware square roots and wide vectors, chosen at run time.
//!
//! Both give the bits of plain code: IEEE 754 rounds square roots correctly, and the core's row
//! loops do not depend on how many pixels are worked on at once.

use skyfront_core::arithmetic::machine::{Machine, Task};
#[cfg(not(target_arch = "x86_64"))]
use skyfront_core::arithmetic::vectors::NoVectors;

/// This computer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Native;

impl Machine for Native {
    #[cfg(target_arch = "x86_64")]
    type Vectors = crate::avx2::Avx2;
    #[cfg(not(target_arch = "x86_64"))]
    type Vectors = NoVectors<f32, f32>;

    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn vectors() -> Option<Self::Vectors> {
        crate::avx2::Avx2::detect()
    }

    #[inline(always)]
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }

    #[inline(always)]
    fn wide<T: Task>(row: T) -> T::Output {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2, which is all that `with_avx2` asks for.
            return unsafe { with_avx2(row) };
        }
        row.run()
    }
}

/// The same code, compiled for 256-bit vectors. FMA stays off: a fused product has other bits.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2<T: Task>(row: T) -> T::Output {
    row.run()
}
