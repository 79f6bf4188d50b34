//! Floating-point images as integers: `scale * (n + 0.5 - dither) + zero` (FITS standard 4.0, section 10.2).

use std::sync::LazyLock;

/// Length of the standard's sequence of random numbers.
const SEQUENCE: usize = 10_000;
/// `n` that stands for exactly zero with the second kind of dithering.
const ZERO: i64 = -2_147_483_646;

/// The uniform random numbers of the standard: a linear congruential generator that started with 1.
static RANDOM: LazyLock<Vec<f32>> = LazyLock::new(|| {
    const MODULUS: u64 = 2_147_483_647;
    let states = std::iter::successors(Some(16_807u64), |state| Some(state * 16_807 % MODULUS));
    states.take(SEQUENCE).map(|state| (state as f64 / MODULUS as f64) as f32).collect()
});

/// How the integers of a floating-point image were made (`ZQUANTIZ`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    /// Rounded.
    Rounded,
    /// Random numbers were subtracted before rounding; the seed is `ZDITHER0`.
    Dithered {
        /// `ZDITHER0`.
        seed: i64,
        /// Whether exact zeros were kept apart (`SUBTRACTIVE_DITHER_2`).
        keeps_zero: bool,
    },
}

/// What turns the integers of one tile back into numbers.
pub(super) struct Tile {
    pub(super) scale: f64,
    pub(super) zero: f64,
    /// The integer that stands for NaN.
    pub(super) blank: Option<i64>,
    /// Number of the tile in the image, from 0.
    pub(super) number: usize,
}

impl Tile {
    /// The physical values of the integers of this tile, in order.
    pub(super) fn values(&self, method: Method, stored: &[i64], mut put: impl FnMut(f64)) {
        let mut dither = match method {
            Method::Rounded => None,
            Method::Dithered { seed, .. } => Some(Dither::new(self.number as i64 + seed - 1)),
        };
        let keeps_zero = matches!(method, Method::Dithered { keeps_zero: true, .. });
        for &n in stored {
            // A random number is used up even where the pixel has no use for it.
            let random = dither.as_mut().map(Dither::next);
            put(match random {
                _ if self.blank == Some(n) => f64::NAN,
                Some(_) if keeps_zero && n == ZERO => 0.0,
                Some(random) => (n as f64 - f64::from(random) + 0.5) * self.scale + self.zero,
                None => n as f64 * self.scale + self.zero,
            });
        }
    }
}

/// A walk through the random numbers that starts at a place that depends on the tile.
struct Dither {
    start: usize,
    at: usize,
}

impl Dither {
    fn new(start: i64) -> Self {
        let start = start.rem_euclid(SEQUENCE as i64) as usize;
        Self { start, at: Self::entry(start) }
    }

    fn entry(start: usize) -> usize {
        (RANDOM[start] * 500.0) as usize
    }

    fn next(&mut self) -> f32 {
        let random = RANDOM[self.at];
        self.at += 1;
        if self.at == SEQUENCE {
            self.start = (self.start + 1) % SEQUENCE;
            self.at = Self::entry(self.start);
        }
        random
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_random_sequence_is_that_of_the_standard() {
        // The standard gives the generator's state after 10000 steps, as a check.
        const MODULUS: u64 = 2_147_483_647;
        let last = (0..SEQUENCE).fold(1u64, |state, _| state * 16_807 % MODULUS);
        assert_eq!(last, 1_043_618_065);
        assert_eq!(RANDOM.len(), SEQUENCE);
        assert_eq!(RANDOM[SEQUENCE - 1], (last as f64 / MODULUS as f64) as f32);
    }

    #[test]
    fn blanks_and_zeros_are_kept_apart() {
        let tile = Tile { scale: 2.0, zero: 1.0, blank: Some(-5), number: 0 };
        let mut values = Vec::new();
        tile.values(Method::Dithered { seed: 1, keeps_zero: true }, &[-5, ZERO, 3], |v| values.push(v));
        assert!(values[0].is_nan());
        assert_eq!(values[1], 0.0);
        assert!((values[2] - 7.0).abs() <= 1.0);
        let mut plain = Vec::new();
        tile.values(Method::Rounded, &[3], |v| plain.push(v));
        assert_eq!(plain, [7.0]);
    }
}
