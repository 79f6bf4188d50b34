//! Sums of many `f32` without loss: a compensated sum in two words.

use crate::arithmetic::codec::Codec;

/// A running sum; the error of the result is about one unit in its last place, however many terms
/// (Knuth's two-sum: what each addition rounds away is kept).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sum {
    high: f32,
    low: f32,
}

impl Sum {
    /// No term yet.
    pub const ZERO: Sum = Sum { high: 0.0, low: 0.0 };

    /// Adds a finite term. A sum beyond the range of `f32` stays at its last value.
    #[inline]
    pub fn add(&mut self, term: f32) {
        let sum = self.high + term;
        if !sum.is_finite() {
            return;
        }
        let part = sum - self.high;
        let rest = self.low + ((self.high - (sum - part)) + (term - part));
        // Renormalised, so that the low word never grows beyond half a unit of the high one.
        self.high = sum + rest;
        self.low = rest - (self.high - sum);
    }

    /// The list of fields, out or in; a sum that is no number comes in as 0.
    pub(crate) fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        codec.real(&mut self.high)?;
        codec.real(&mut self.low)?;
        if !(self.high.is_finite() && self.low.is_finite()) {
            *self = Sum::ZERO;
        }
        Ok(())
    }

    /// The sum, rounded.
    #[inline]
    pub fn value(self) -> f32 {
        self.high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_tenths() {
        let mut sum = Sum::default();
        for _ in 0..1_000_000 {
            sum.add(0.1);
        }
        // One unit in the last place of 1e5 is 2^-7.
        let exact = f64::from(0.1f32) * 1e6;
        assert!((f64::from(sum.value()) - exact).abs() <= 1.0 / 128.0);
    }
}
