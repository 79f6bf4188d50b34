//! Exact order statistics of a frame in constant memory: a radix select over several passes.
//!
//! Every finite `f32` has a key of 32 bits that sorts like the number. Each pass counts one byte
//! of the keys that agree with the bytes found so far; after four passes the key, and with it the
//! value of the wanted rank, is known exactly. Cost: four passes over the pixels.

use crate::arithmetic::Level;
use crate::arithmetic::codec::Codec;
use crate::sky::otsu::Histogram;

/// Number of passes that a selection takes.
pub const PASSES: u32 = 4;

/// The search for the value of one rank; it counts in a histogram that is empty before the first pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Select {
    prefix: u32,
    pass: u32,
    rank: u32,
}

impl Select {
    /// Looks for the value with `rank` smaller or equal values before it (0 = the least).
    pub fn new(rank: u32) -> Select {
        Select { prefix: 0, pass: 0, rank }
    }

    /// The rank of a percentile among `defined` pixels: the lower nearest rank.
    pub fn percentile(percent: f32, defined: u32) -> Select {
        let last = defined.saturating_sub(1);
        let millionths = (percent * 1e6) as u64;
        let rank = millionths.saturating_mul(u64::from(last)) / 100_000_000;
        Select::new((rank as u32).min(last))
    }

    /// The list of fields, out or in.
    pub(crate) fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        codec.word(&mut self.prefix)?;
        codec.word(&mut self.pass)?;
        codec.word(&mut self.rank)
    }

    /// Whether a selection can be in this state.
    pub(crate) fn is_sound(&self) -> bool {
        self.pass <= PASSES
    }

    /// Counts pixels of a pass; NaN and infinities do not count.
    pub fn observe(&self, counts: &mut Histogram, pixels: impl Iterator<Item = f32>) {
        let shift = 24u32.saturating_sub(self.pass.saturating_mul(8));
        for pixel in pixels.filter(|pixel| pixel.is_finite()) {
            let key = pixel.key();
            // The bytes above the one that is counted; the shift of the first pass would be 32.
            let agrees = self.pass == 0 || (key >> shift) >> 8 == self.prefix;
            if agrees && let Some(count) = counts.0.get_mut((key >> shift & 0xFF) as usize) {
                *count = count.saturating_add(1);
            }
        }
    }

    /// Ends a pass and empties the histogram; the value after the last one.
    pub fn end_pass(&mut self, counts: &mut Histogram) -> Option<f32> {
        let mut byte = 0;
        for (value, &count) in (0u32..).zip(&counts.0) {
            byte = value;
            if self.rank < count {
                break;
            }
            self.rank = self.rank.saturating_sub(count);
        }
        self.prefix = self.prefix << 8 | byte;
        self.pass = self.pass.saturating_add(1);
        counts.clear();
        (self.pass >= PASSES).then(|| f32::of_key(self.prefix)).map(|value| if value.is_finite() { value } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rank_of_a_small_set() {
        let pixels = [3.0, -1.0, f32::NAN, 0.0, -0.0, 1e-40, f32::INFINITY, -7.5, 3.0];
        let sorted = [-7.5, -1.0, -0.0, 0.0, 1e-40, 3.0, 3.0];
        for (rank, expected) in (0u32..).zip(sorted) {
            let (mut select, mut counts) = (Select::new(rank), Histogram::EMPTY);
            let mut found = None;
            for _ in 0..PASSES {
                select.observe(&mut counts, pixels.iter().copied());
                found = select.end_pass(&mut counts);
            }
            assert_eq!(found.map(f32::to_bits), Some(f32::to_bits(expected)), "rank {rank}");
        }
    }
}
