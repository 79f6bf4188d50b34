//! Sky level and noise of a whole frame in constant memory: what noise-aware limits count from.
//!
//! The level is the median, the noise the distance from it down to the 15.87th percentile, which
//! is one standard deviation of a normal distribution: sources are bright, and the lower half of
//! the values knows little of them. Values more than [`CLIP`] of that noise above the level count
//! as sources, and both are measured again over the rest, [`ROUNDS`] times at most. Only ranks are
//! used, so that no single pixel, however bright, moves either number, and the result is exact.
//! Clipping makes the noise of pure sky 0.1 % too small.

use crate::arithmetic::Real;
use crate::arithmetic::codec::Codec;
use crate::sky::otsu::Histogram;
use crate::sky::select::{self, Select};

/// Rounds of measuring and clipping.
pub const ROUNDS: u32 = 3;
/// Values this many standard deviations above the level are not sky.
pub const CLIP: f32 = 3.0;
/// The most passes over the pixels: two ranks a round, and a count between rounds.
pub const PASSES: u32 = 2 * ROUNDS * select::PASSES + ROUNDS - 1;

/// Percent of a normal distribution more than one standard deviation below its middle.
const ONE_BELOW: f32 = 15.865_525;

/// What a pass is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Level,
    Spread,
    Count,
}

/// A measurement under way, or done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The level, in units of the values.
    pub level: f32,
    /// Standard deviation of a value, at least 0.
    pub noise: f32,
    phase: Phase,
    round: u32,
    /// How many of the least values are taken for sky.
    kept: u32,
    counted: u32,
}

impl Estimate {
    /// Before any measurement.
    pub const NONE: Estimate = Estimate { level: 0.0, noise: 0.0, phase: Phase::Level, round: 0, kept: 0, counted: 0 };

    /// Begins a measurement of `defined` finite values; `select` is its scratch memory until
    /// [`Self::end_pass`] says that it is done.
    pub fn new(defined: u32, select: &mut Select) -> Estimate {
        *select = Select::percentile(50.0, defined);
        Estimate { kept: defined, ..Estimate::NONE }
    }

    /// Takes in values of a pass; NaN and infinities do not count.
    pub fn observe(&mut self, select: &Select, counts: &mut Histogram, values: impl Iterator<Item = f32>) {
        if self.phase != Phase::Count {
            return select.observe(counts, values);
        }
        let limit = self.above(CLIP);
        let sky = values.filter(|value| value.is_finite() && *value <= limit).count();
        self.counted = self.counted.saturating_add(sky as u32);
    }

    /// Ends a pass; whether level and noise are known.
    pub fn end_pass(&mut self, select: &mut Select, counts: &mut Histogram) -> bool {
        match self.phase {
            Phase::Level => {
                if let Some(level) = select.end_pass(counts) {
                    (self.level, self.phase) = (level, Phase::Spread);
                    *select = Select::percentile(ONE_BELOW, self.kept);
                }
            }
            Phase::Spread => {
                if let Some(below) = select.end_pass(counts) {
                    self.noise = within(self.level - below).positive();
                    self.round = self.round.saturating_add(1);
                    (self.phase, self.counted) = (Phase::Count, 0);
                }
                return self.phase == Phase::Count && self.round >= ROUNDS;
            }
            Phase::Count => {
                if self.counted == self.kept {
                    return true;
                }
                (self.phase, self.kept) = (Phase::Level, self.counted);
                *select = Select::percentile(50.0, self.kept);
            }
        }
        false
    }

    /// The value `k` standard deviations above the level (below, where `k` is negative).
    pub fn above(&self, k: f32) -> f32 {
        within(self.level + within(k * self.noise))
    }

    /// The list of fields, out or in.
    pub(crate) fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        let mut phase = self.phase as u32;
        codec.real(&mut self.level)?;
        codec.real(&mut self.noise)?;
        codec.word(&mut phase)?;
        codec.word(&mut self.round)?;
        codec.word(&mut self.kept)?;
        codec.word(&mut self.counted)?;
        self.phase = match phase {
            0 => Phase::Level,
            1 => Phase::Spread,
            _ => Phase::Count,
        };
        Ok(())
    }

    /// Whether a measurement of at most `pixels` values can be in this state.
    pub(crate) fn is_sound(&self, pixels: usize) -> bool {
        let counts = [self.kept, self.counted].iter().all(|&count| count as usize <= pixels);
        self.level.is_finite() && self.noise.is_finite() && self.noise >= 0.0 && counts && self.round <= ROUNDS
    }
}

/// A value within the finite numbers.
fn within(value: f32) -> f32 {
    value.least(f32::MAX).greatest(f32::MIN)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    extern crate std;
    use std::vec::Vec;

    fn measured(values: &[f32]) -> (Estimate, u32) {
        let (mut select, mut counts) = (Select::new(0), Histogram::EMPTY);
        let mut estimate = Estimate::new(values.len() as u32, &mut select);
        for passes in 1..=PASSES {
            estimate.observe(&select, &mut counts, values.iter().copied());
            if estimate.end_pass(&mut select, &mut counts) {
                return (estimate, passes);
            }
        }
        panic!("not done after {PASSES} passes: {estimate:?}");
    }

    /// `count` values at the quantiles of a normal distribution: no sample is more typical.
    pub(crate) fn normal(count: usize, level: f32, noise: f32) -> Vec<f32> {
        let quantile = |p: f64| {
            // Bisection on the distribution function, half of erfc.
            let (mut low, mut high) = (-8.0f64, 8.0f64);
            for _ in 0..60 {
                let middle = (low + high) / 2.0;
                let below = 0.5 * libm::erfc(-middle / core::f64::consts::SQRT_2);
                if below < p { low = middle } else { high = middle }
            }
            low as f32
        };
        (0..count).map(|i| level + noise * quantile((i as f64 + 0.5) / count as f64)).collect()
    }

    #[test]
    fn pure_noise_is_measured_without_bias() {
        let (estimate, _) = measured(&normal(10_001, 100.0, 5.0));
        assert!((estimate.level - 100.0).abs() < 0.015, "{estimate:?}");
        assert!((estimate.noise / 5.0 - 1.0).abs() < 0.003, "{estimate:?}");
    }

    #[test]
    fn sources_and_hot_pixels_move_little() {
        let mut values = normal(10_001, -3.0, 0.5);
        let (quiet, _) = measured(&values);
        values[77] = 3e38;
        let (hot, _) = measured(&values);
        assert!((hot.level - quiet.level).abs() < 1e-3 && (hot.noise - quiet.noise).abs() < 1e-3);
        // A quarter of the frame holds sources of 5 to 500 noise units.
        values.extend((0..3333).map(|i| -3.0 + 2.5 * (1.0 + i as f32 / 33.0)));
        let (crowded, _) = measured(&values);
        assert!((crowded.level - quiet.level).abs() < 0.05 * 0.5, "{crowded:?}");
        assert!((crowded.noise / quiet.noise - 1.0).abs() < 0.03, "{crowded:?}");
    }

    #[test]
    fn nothing_leaves_the_finite_numbers() {
        let (estimate, _) = measured(&[f32::MIN, f32::MIN, f32::MAX, f32::MAX, f32::MAX]);
        assert!(estimate.is_sound(5), "{estimate:?}");
        assert!(estimate.above(1e3).is_finite() && estimate.above(-1e3).is_finite());
        let (constant, passes) = measured(&[7.0; 30]);
        assert_eq!((constant.level, constant.noise, passes), (7.0, 0.0, 2 * select::PASSES + 1));
    }
}
