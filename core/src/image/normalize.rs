//! Step 1: pixel values become numbers in [0, 1] (`risc01`).

use crate::arithmetic::machine::Task;
use crate::arithmetic::{Arithmetic, Real};
use crate::sky::noise::Estimate;

/// The extremes and number of the defined pixels seen so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    /// The least defined pixel; +infinity before the first.
    pub least: f32,
    /// The greatest defined pixel; -infinity before the first.
    pub greatest: f32,
    /// Number of defined pixels.
    pub defined: u32,
}

impl Extremes {
    /// Before the first pixel.
    pub const NONE: Extremes = Extremes { least: f32::INFINITY, greatest: f32::NEG_INFINITY, defined: 0 };

    /// Takes in one row of pixels; NaN and infinities do not count.
    #[inline(always)]
    pub fn observe(&mut self, row: &[f32]) {
        let (mut least, mut greatest, mut defined) = (i32::MAX, i32::MIN, 0u32);
        for &pixel in row {
            let (rank, counts) = (rank(pixel), pixel.is_finite());
            least = least.min(if counts { rank } else { i32::MAX });
            greatest = greatest.max(if counts { rank } else { i32::MIN });
            defined += u32::from(counts);
        }
        if defined > 0 {
            let (least, greatest) = (of_rank(least), of_rank(greatest));
            self.least = if least < self.least { least } else { self.least };
            self.greatest = if greatest > self.greatest { greatest } else { self.greatest };
            self.defined = self.defined.saturating_add(defined);
        }
    }
}

/// A whole number that grows with the pixel: the extremes of such are what vector units find.
#[inline(always)]
fn rank(pixel: f32) -> i32 {
    // Both zeros have the rank of the positive one.
    let bits = (pixel + 0.0).to_bits() as i32;
    bits ^ ((bits >> 31) & i32::MAX)
}

fn of_rank(rank: i32) -> f32 {
    f32::from_bits((rank ^ ((rank >> 31) & i32::MAX)) as u32)
}

/// The linear map that takes `low` to 0 and `high` to 1, clipped.
///
/// ```
/// use skyfront_core::image::normalize::{Extremes, Range};
///
/// let mut extremes = Extremes::NONE;
/// extremes.observe(&[200.0, f32::NAN, 100.0, 150.0]);
/// let range = Range { low: extremes.least, high: extremes.greatest };
/// assert_eq!([100.0, 150.0, 999.0, f32::NAN].map(|pixel| range.apply(pixel, 0.0)), [0.0, 0.5, 1.0, 0.0]);
/// assert_eq!([0.0, 0.5, 1.0].map(|value| range.pixel(value)), [100.0, 150.0, 200.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Becomes 0.
    pub low: f32,
    /// Becomes 1; above `low`.
    pub high: f32,
}

impl Range {
    /// From the sky minus `below` to the sky plus `above` standard deviations of its noise; the
    /// `extremes` where there is no noise.
    pub fn around(sky: &Estimate, below: f32, above: f32, extremes: Range) -> Range {
        if sky.noise > 0.0 { Range { low: sky.above(-below), high: sky.above(above) } } else { extremes }
    }

    /// `(pixel - low) / (high - low)`, clipped to [0, 1]; `fill` for an undefined pixel.
    #[inline]
    pub fn apply(&self, pixel: f32, fill: f32) -> f32 {
        if !pixel.is_finite() {
            return fill;
        }
        let span = self.high - self.low;
        let value = if span < f32::INFINITY {
            (pixel - self.low) / span
        } else {
            // Halves are exact here and cannot overflow.
            (pixel * 0.5 - self.low * 0.5) / (self.high * 0.5 - self.low * 0.5)
        };
        if value > 0.0 { if value < 1.0 { value } else { 1.0 } } else { 0.0 }
    }

    /// The pixel that becomes `value`, of 0 to 1.
    pub fn pixel(&self, value: f32) -> f32 {
        self.low * (1.0 - value) + self.high * value
    }
}

/// One row of pixels into one row of the image plane.
pub fn row<A: Arithmetic>(range: Range, fill: f32, pixels: &[f32], image: &mut [A::Cell]) {
    A::wide(Row::<A> { range, fill, pixels, image });
}

struct Row<'a, A: Arithmetic> {
    range: Range,
    fill: f32,
    pixels: &'a [f32],
    image: &'a mut [A::Cell],
}

impl<A: Arithmetic> Task for Row<'_, A> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (cell, &pixel) in self.image.iter_mut().zip(self.pixels) {
            *cell = A::to_pixel(A::Real::of(self.range.apply(pixel, self.fill)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    const FAR: f32 = 1.701_411_8e38;

    #[test]
    fn extremes_are_those_of_all_defined_pixels() {
        let mut extremes = Extremes::NONE;
        extremes.observe(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY]);
        assert_eq!(extremes, Extremes::NONE);
        let mut zero = Extremes::NONE;
        zero.observe(&[-0.0]);
        assert_eq!([zero.least, zero.greatest].map(f32::to_bits), [0; 2]);
        extremes.observe(&[-0.0, -3.5, f32::NAN]);
        assert_eq!(extremes, Extremes { least: -3.5, greatest: 0.0, defined: 2 });
        extremes.observe(&[-2.0, 7.25, 1e-40, -1e-40]);
        extremes.observe(&[-1.0]);
        assert_eq!(extremes, Extremes { least: -3.5, greatest: 7.25, defined: 7 });
    }

    #[test]
    fn a_range_is_a_line_that_is_cut_off() {
        let range = Range { low: -2.0, high: 6.0 };
        let pixels = [-3.0, -2.0, 0.0, 4.0, 6.0, 9.0, f32::NAN, f32::INFINITY];
        let expected = [0.0, 0.0, 0.25, 0.75, 1.0, 1.0, 0.5, 0.5];
        assert_eq!(pixels.map(|pixel| range.apply(pixel, 0.5)), expected);
        let mut image = [9.0f32; 8];
        row::<F32>(range, 0.5, &pixels, &mut image);
        assert_eq!(image, expected);
        assert_eq!([0.0, 0.25, 0.75, 1.0].map(|value| range.pixel(value)), [-2.0, 0.0, 4.0, 6.0]);
        // The least number there is has no half, and what is less than nothing is 0 and not -0.
        let least = f32::from_bits(1);
        assert_eq!(Range { low: 0.0, high: least }.apply(least, 9.0), 1.0);
        assert_eq!(Range { low: 0.0, high: FAR }.apply(-least, 9.0).to_bits(), 0);
        // From -2^127 to 2^127: the difference is no number.
        let widest = Range { low: -FAR, high: FAR };
        assert_eq!(
            [-FAR, -0.5 * FAR, 0.0, 0.5 * FAR, FAR].map(|pixel| widest.apply(pixel, 9.0)),
            [0.0, 0.25, 0.5, 0.75, 1.0]
        );
    }

    #[test]
    fn without_noise_a_range_around_the_sky_is_that_of_the_extremes() {
        let (mut sky, extremes) = (Estimate::NONE, Range { low: 1.0, high: 2.0 });
        sky.level = 10.0;
        assert_eq!(Range::around(&sky, 3.0, 30.0, extremes), extremes);
        sky.noise = 2.0;
        assert_eq!(Range::around(&sky, 3.0, 30.0, extremes), Range { low: 4.0, high: 70.0 });
    }
}
