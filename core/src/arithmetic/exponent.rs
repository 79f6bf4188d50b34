//! Exponents, sorted once so that no pixel pays for the general case without need.

/// A positive exponent. Powers of two are squarings or square roots, which are exact to half a
/// unit each, faster than `powf`, and the paper's own values (alpha = 1/4, beta = 4 and 8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exponent {
    /// `x^(2^n)`.
    Squarings(u8),
    /// `x^(2^-n)`.
    Roots(u8),
    /// Any other exponent.
    Any(f32),
}

/// More squarings or roots than this are left to the general power function.
const MOST: u8 = 8;

impl Exponent {
    /// Sorts the exponent `p > 0`.
    pub fn of(p: f32) -> Exponent {
        // A power of two has no fraction bits beside its leading one.
        let (fraction, exponent) = (p.to_bits() << 9, (p.to_bits() >> 23) as i32 - 127);
        let n = exponent.unsigned_abs();
        match u8::try_from(n) {
            Ok(n) if fraction == 0 && n <= MOST && exponent >= 0 => Exponent::Squarings(n),
            Ok(n) if fraction == 0 && n <= MOST => Exponent::Roots(n),
            _ => Exponent::Any(p),
        }
    }

    /// The exponent as a number.
    pub fn value(self) -> f32 {
        match self {
            Exponent::Squarings(n) => (0..n).fold(1.0, |p, _| p * 2.0),
            Exponent::Roots(n) => (0..n).fold(1.0, |p, _| p * 0.5),
            Exponent::Any(p) => p,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_two_are_recognised_and_kept() {
        for (p, sorted) in [
            (1.0, Exponent::Squarings(0)),
            (8.0, Exponent::Squarings(3)),
            (0.25, Exponent::Roots(2)),
            (0.125, Exponent::Roots(3)),
            (0.3, Exponent::Any(0.3)),
            (5000.0, Exponent::Any(5000.0)),
        ] {
            assert_eq!(Exponent::of(p), sorted);
            assert_eq!(sorted.value(), p);
        }
    }
}
