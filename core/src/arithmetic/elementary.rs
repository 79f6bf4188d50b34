//! Powers, logarithm and exponential in fixed point: bounded loops of shifts and additions.
//!
//! `log2` and `2^x` are Briggs' method: a number in [1, 2] is a product of some of the factors
//! 1 + 2^-i, and its logarithm the sum of theirs (J.-M. Muller, Elementary Functions, chapter on
//! shift-and-add algorithms). Square roots and squares keep 31 fraction bits in between, because
//! a small `x^(1/4)` shows what its root has lost.
//!
//! | function | range | largest error, in units of 2^-24 |
//! |---|---|---|
//! | `roots` | x in [0, 1], up to 8 roots | 0.7 |
//! | `squarings` | x in [0, 1], up to 8 squarings | 1.3 |
//! | `power` | x in [0, 1], 0 < p <= 10^6 | 0.51 |
//! | `log2_1p` | x in [0, 1] | 0.51 |
//! | `exp_neg` | x in [0, 128) | 0.51 |

use super::fixed32::{Fixed24, ONE};
use super::{Exponent, Real, roots};

/// Fraction bits of logarithms and of the numbers they are taken of.
const BITS: u32 = 58;
/// 1 with that many fraction bits.
const UNIT: u64 = 1 << BITS;
/// Factors that a logarithm tries: its error is below 2^-46.
const LOG_STEPS: usize = 48;
/// Factors that a power of two tries: its relative error is below 2^-31.
const EXP_STEPS: usize = 32;

/// `log2(1 + 2^-i)` for i = 1, 2, ...
///
/// Squaring doubles a logarithm: whenever the square passes 2, the next bit is a one.
#[allow(clippy::indexing_slicing, reason = "evaluated by the compiler")]
const LOGS: [u64; LOG_STEPS] = {
    let mut logs = [0; LOG_STEPS];
    let mut i = 0;
    while i < LOG_STEPS {
        let mut m: u128 = (1 << 62) + (1 << (61 - i));
        let mut bit = 0;
        while bit < BITS {
            m = (m * m) >> 62;
            logs[i] <<= 1;
            if m >= 1 << 63 {
                m >>= 1;
                logs[i] |= 1;
            }
            bit += 1;
        }
        i += 1;
    }
    logs
};

/// `log2(m)` for m in [1, 2], both with [`BITS`] fraction bits.
fn log2(m: u64) -> u64 {
    let (mut product, mut sum) = (UNIT, 0u64);
    for (i, log) in (1u32..).zip(&LOGS) {
        let next = product.wrapping_add(product >> i);
        if next <= m {
            (product, sum) = (next, sum.wrapping_add(*log));
        }
    }
    sum
}

/// `2^-y` for y with 40 fraction bits.
fn exp2_neg(y: u64) -> Fixed24 {
    const WHOLE: u32 = 40;
    // 2^-26 and less are nearer to 0 than to one step.
    let whole = y >> WHOLE;
    if whole >= 26 {
        return Fixed24::ZERO;
    }
    let mut rest = UNIT.wrapping_sub((y & ((1 << WHOLE) - 1)) << (BITS - WHOLE));
    let mut product = UNIT;
    for (i, log) in (1u32..).zip(&LOGS).take(EXP_STEPS) {
        if *log <= rest {
            (product, rest) = (product.wrapping_add(product >> i), rest.wrapping_sub(*log));
        }
    }
    round(product, BITS.wrapping_add(1).wrapping_add(whole as u32))
}

/// A number with `bits` fraction bits, 24 < bits < 88, rounded to nearest.
fn round(number: u64, bits: u32) -> Fixed24 {
    let half = number.wrapping_shr(bits.wrapping_sub(25));
    Fixed24::saturated((half.wrapping_add(1)) >> 1)
}

/// The square root of `x >= 0`, rounded to nearest.
pub fn sqrt(x: Fixed24) -> Fixed24 {
    Fixed24::saturated(u64::from(roots::nearest64(u64::from(x.positive().size()) << 24)))
}

/// `x^p` for x in [0, 1].
pub fn pow(x: Fixed24, p: Exponent) -> Fixed24 {
    let bits = x.positive().size().min(ONE);
    match p {
        Exponent::Squarings(n) => squarings(bits, n),
        Exponent::Roots(n) => roots(bits, n),
        Exponent::Any(p) => power(bits, p),
    }
}

/// `x^(2^n)`.
fn squarings(bits: u32, n: u8) -> Fixed24 {
    let square = |x: u64, _| (x.wrapping_mul(x).wrapping_add(1 << 30)) >> 31;
    round((0..n).fold(u64::from(bits) << 7, square), 31)
}

/// `x^(2^-n)`.
fn roots(bits: u32, n: u8) -> Fixed24 {
    let root = |x: u64, _| u64::from(roots::nearest64(x << 31));
    round((0..n).fold(u64::from(bits) << 7, root), 31)
}

/// `x^p = 2^(p log2 x)`, p an ordinary positive number.
fn power(bits: u32, p: f32) -> Fixed24 {
    if bits == 0 {
        return Fixed24::ZERO;
    }
    // x = m 2^-shift with m in [1, 2).
    let shift = bits.leading_zeros().saturating_sub(7);
    let log = log2(u64::from(bits) << (BITS - 24) << shift);
    let minus_log = (u64::from(shift) << BITS).wrapping_sub(log);
    // p = mantissa 2^exponent; the product has 58 fraction bits more than 2^exponent, 40 are kept.
    let exponent = (p.to_bits() >> 23 & 0xFF) as i32 - 150;
    let mantissa = p.to_bits() & 0x7F_FFFF | 0x80_0000;
    let product = u128::from(minus_log).wrapping_mul(u128::from(mantissa));
    let cut = (18 - exponent).clamp(0, 127) as u32;
    exp2_neg(u64::try_from(product >> cut).unwrap_or(u64::MAX))
}

/// `log2(1 + x)` for x in [0, 1].
pub fn log2_1p(x: Fixed24) -> Fixed24 {
    let bits = x.positive().size().min(ONE);
    round(log2(UNIT.wrapping_add(u64::from(bits) << (BITS - 24))), BITS)
}

/// `exp(-x)` for x >= 0: `2^(-x log2 e)`.
pub fn exp_neg(x: Fixed24) -> Fixed24 {
    /// `log2 e` with 32 fraction bits.
    const LOG2_E: u64 = 0x1_7154_7653;
    // 31 bits times 33 bits, with 56 fraction bits.
    exp2_neg(u64::from(x.positive().size()).wrapping_mul(LOG2_E) >> 16)
}

/// What an arithmetic over [`Fixed24`] takes from here as it is.
macro_rules! functions {
    () => {
        #[inline]
        fn sqrt(x: Fixed24) -> Fixed24 {
            elementary::sqrt(x)
        }

        #[inline]
        fn pow(x: Fixed24, p: Exponent) -> Fixed24 {
            elementary::pow(x, p)
        }

        #[inline]
        fn log2_1p(x: Fixed24) -> Fixed24 {
            elementary::log2_1p(x)
        }

        #[inline]
        fn exp_neg(x: Fixed24) -> Fixed24 {
            elementary::exp_neg(x)
        }
    };
}
pub(super) use functions;

#[cfg(test)]
mod tests {
    use super::*;

    extern crate std;

    /// Inputs in [0, 1]: both ends, the neighbourhood of every power of two, and every 509th; all
    /// 2^24 + 1 of them where the environment has SKYFRONT_LONG (two minutes in a release build).
    fn inputs() -> impl Iterator<Item = u32> {
        let stride = if std::env::var_os("SKYFRONT_LONG").is_some() { 1 } else { 509 };
        let ends = (0..5000).chain(ONE - 5000..=ONE);
        let powers = (12..24).flat_map(|bit| (1 << bit) - 100..(1 << bit) + 100);
        (0..=ONE).step_by(stride).chain(ends).chain(powers)
    }

    /// The largest error over all inputs, in steps.
    fn worst(found: impl Fn(Fixed24) -> Fixed24, exact: impl Fn(f64) -> f64) -> f64 {
        let unit = f64::from(ONE);
        let error = |bits: u32| {
            let found = found(Fixed24::from_bits(bits as i32)).to_bits();
            (f64::from(found) - exact(f64::from(bits) / unit) * unit).abs()
        };
        inputs().map(error).fold(0.0, f64::max)
    }

    #[test]
    fn roots_and_squarings_keep_their_bounds() {
        for n in 0..=8u8 {
            let p = f64::from(1u32 << n);
            let error = worst(|x| pow(x, Exponent::Roots(n)), |x| libm::pow(x, 1.0 / p));
            assert!(error <= 0.7, "{n} roots: {error}");
            let error = worst(|x| pow(x, Exponent::Squarings(n)), |x| libm::pow(x, p));
            assert!(error <= 1.3, "{n} squarings: {error}");
        }
    }

    #[test]
    fn any_power_keeps_its_bound() {
        for p in [1e-30f32, 0.001, 0.1, 0.3, 1.0 / 3.0, 0.7, 0.99, 1.5, 3.0, 7.0, 100.0, 5000.0, 1e6] {
            let error = worst(|x| pow(x, Exponent::Any(p)), |x| if x > 0.0 { libm::pow(x, p.into()) } else { 0.0 });
            assert!(error <= 0.51, "p = {p}: {error}");
        }
    }

    #[test]
    fn logarithm_and_exponential_keep_their_bounds() {
        let error = worst(log2_1p, |x| libm::log1p(x) / core::f64::consts::LN_2);
        assert!(error <= 0.51, "log2(1 + x): {error}");
        for scale in [1u32, 8, 127] {
            let scaled = |x: Fixed24| exp_neg(Fixed24::from_bits(x.to_bits().saturating_mul(scale as i32)));
            let error = worst(scaled, |x| libm::exp(-x * f64::from(scale)));
            assert!(error <= 0.51, "exp(-{scale} x): {error}");
        }
    }
}
