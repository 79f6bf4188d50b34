//! The regions of Chan and Vese, two by one front or four by two: their means, from exact sums that
//! know no order.
//!
//! A front value v in [-1, 1] weighs a pixel by 1 + v for the inside and by 1 - v for the outside;
//! of two fronts the weights multiply.
//! v is taken in whole units of 2^-12 and the image in units of 2^-20, so that sums of their
//! products are whole numbers: rows may come in any order, from any number of threads, and pixels
//! that did not change need not be looked at, because a step adds only what it changed.

use crate::arithmetic::codec::Codec;
use crate::arithmetic::{Arithmetic, Bits, Real};
use crate::front::pair::{self, PHASES};

/// Units of a front value and of an image value.
const LEVELS: f32 = 4096.0;
const LIGHT: f32 = 1_048_576.0;

fn level<A: Arithmetic>(cell: A::Cell) -> i64 {
    i64::from((A::level(cell).to_f32() * LEVELS) as i32)
}

fn light<A: Arithmetic>(cell: A::Cell) -> i64 {
    i64::from((A::pixel(cell).to_f32() * LIGHT) as i32)
}

/// A sum of weights, and of weights times the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Moment {
    weight: i64,
    light: i64,
}

impl Moment {
    #[inline(always)]
    fn add(&mut self, weight: i64, light: i64) {
        self.weight = self.weight.wrapping_add(weight);
        self.light = self.light.wrapping_add(weight.wrapping_mul(light));
    }

    fn merge(&mut self, other: &Self) {
        self.weight = self.weight.wrapping_add(other.weight);
        self.light = self.light.wrapping_add(other.light);
    }

    fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        signed(codec, &mut self.weight)?;
        signed(codec, &mut self.light)
    }
}

/// What a step changed in the sums of v and of v times the image: of a front, and where there are
/// two, of the other and of their product. Parts of a step add up in any order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moments {
    first: Moment,
    second: Moment,
    product: Moment,
}

impl Moments {
    /// Takes in a piece of a row of one front before and after the step.
    #[inline(always)]
    pub fn observe<A: Arithmetic>(&mut self, old: &[A::Cell], new: &[A::Cell], image: &[A::Cell]) {
        for ((&v, &w), &pixel) in old.iter().zip(new).zip(image) {
            let moved = level::<A>(w).wrapping_sub(level::<A>(v));
            self.first.add(moved, light::<A>(pixel));
        }
    }

    /// The same of two fronts.
    #[inline(always)]
    pub fn observe_pairs<A: Arithmetic>(&mut self, old: &[A::Cell], new: &[A::Cell], image: &[A::Cell]) {
        for ((&v, &w), &pixel) in old.iter().zip(new).zip(image) {
            let ([first, second, product], light) = (weights(v), light::<A>(pixel));
            let [first_new, second_new, product_new] = weights(w);
            self.first.add(first_new.wrapping_sub(first), light);
            self.second.add(second_new.wrapping_sub(second), light);
            self.product.add(product_new.wrapping_sub(product), light);
        }
    }

    /// Adds another part of the same step.
    pub fn merge(&mut self, other: &Self) {
        self.first.merge(&other.first);
        self.second.merge(&other.second);
        self.product.merge(&other.product);
    }

    /// The list of fields, out or in.
    pub(crate) fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        self.first.code(codec)?;
        self.second.code(codec)?;
        self.product.code(codec)
    }
}

/// Two front values and their product, in whole units.
#[inline(always)]
fn weights(cell: impl Bits) -> [i64; 3] {
    /// Steps of a value in a unit.
    const STEPS: i32 = pair::UNIT / LEVELS as i32;
    let [v, w] = pair::steps(cell).map(|steps| steps / STEPS);
    let product = v.wrapping_mul(w);
    // To nearest, and the same on both sides of 0: no phase weighs less than nothing.
    let half = if product < 0 { -(LEVELS as i32) / 2 } else { LEVELS as i32 / 2 };
    [v, w, product.wrapping_add(half) / LEVELS as i32].map(i64::from)
}

fn signed<C: Codec>(codec: &mut C, number: &mut i64) -> Result<(), C::Error> {
    let mut bits = *number as u64;
    codec.long(&mut bits)?;
    *number = bits as i64;
    Ok(())
}

/// The means of the phases, in units of 2^-20.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Means([u32; 4]);

impl Means {
    /// From values in [0, 1].
    pub fn of(values: [f32; 4]) -> Means {
        Means(values.map(|value| (value * LIGHT) as u32))
    }

    /// The means, those of [`PHASES`] in that order.
    pub fn values<A: Arithmetic>(&self) -> [A::Real; 4] {
        self.0.map(|mean| A::Real::of(mean.min(LIGHT as u32) as f32 / LIGHT))
    }
}

/// The sums over a frame, and the means that follow from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Regions {
    /// Whether two fronts part the frame, not one.
    two_fronts: bool,
    pixels: u32,
    /// Sum of the image.
    light: u64,
    moments: Moments,
    /// The means: those without pixels keep theirs, at first 1 inside and 0 outside.
    pub means: Means,
}

impl Regions {
    /// A frame without rows, parted by one front.
    pub const NONE: Regions = Regions::of(false);

    /// A frame without rows, parted by one front or by two.
    pub const fn of(two_fronts: bool) -> Regions {
        const NOTHING: Moment = Moment { weight: 0, light: 0 };
        Regions {
            two_fronts,
            pixels: 0,
            light: 0,
            moments: Moments { first: NOTHING, second: NOTHING, product: NOTHING },
            means: Means([0, LIGHT as u32, LIGHT as u32, LIGHT as u32]),
        }
    }

    /// The same means, but no rows.
    pub fn anew(self) -> Regions {
        Regions { means: self.means, ..Regions::of(self.two_fronts) }
    }

    /// Takes in a row of the front or the fronts before the first step.
    pub fn add_row<A: Arithmetic>(&mut self, front: &[A::Cell], image: &[A::Cell]) {
        for (&cell, &pixel) in front.iter().zip(image) {
            let light = light::<A>(pixel);
            self.pixels = self.pixels.saturating_add(1);
            self.light = self.light.saturating_add_signed(light);
            if self.two_fronts {
                let [first, second, product] = weights(cell);
                self.moments.first.add(first, light);
                self.moments.second.add(second, light);
                self.moments.product.add(product, light);
            } else {
                self.moments.first.add(level::<A>(cell), light);
            }
        }
    }

    /// Takes in what a step changed; whether the means are others now. Cost: a division for each.
    pub fn turn(&mut self, change: &Moments) -> bool {
        let before = self.means;
        self.moments.merge(change);
        let all = *self;
        for (mean, phase) in self.means.0.iter_mut().zip(PHASES) {
            if let Some(new) = all.mean(phase) {
                *mean = new;
            }
        }
        self.means != before
    }

    /// The weight of a phase, in units of 2^-12 and for two fronts of 1/4 of them, and its light.
    fn of_phase(&self, [in_first, in_second]: [bool; 2]) -> (u64, u64) {
        let Moments { first, second, product } = self.moments;
        let signed = |inside: bool, sum: i64| if inside { i128::from(sum) } else { -i128::from(sum) };
        let share = |all: i128, first: i64, second: i64, product: i64| {
            let all = all.wrapping_mul(LEVELS as i128).wrapping_add(signed(in_first, first));
            if !self.two_fronts {
                return all;
            }
            all.wrapping_add(signed(in_second, second)).wrapping_add(signed(in_first == in_second, product))
        };
        let weight = share(self.pixels.into(), first.weight, second.weight, product.weight);
        let light = share(self.light.into(), first.light, second.light, product.light);
        (u64::try_from(weight.max(0)).unwrap_or(u64::MAX), u64::try_from(light.max(0)).unwrap_or(u64::MAX))
    }

    /// The mean of a phase, where it has pixels.
    fn mean(&self, phase: [bool; 2]) -> Option<u32> {
        let [_, in_second] = phase;
        if in_second && !self.two_fronts {
            return None;
        }
        let (weight, light) = self.of_phase(phase);
        light.saturating_add(weight / 2).checked_div(weight).map(|mean| mean.min(LIGHT as u64) as u32)
    }

    /// The place of each phase among those that have pixels, by their means: 0 for the darkest.
    pub fn ranks(&self) -> [u8; 4] {
        let Means(means) = self.means;
        let peopled = PHASES.map(|phase| self.mean(phase).is_some());
        let key = |at: usize| means.get(at).copied().unwrap_or(0);
        let darker = |own: usize, other: usize| (key(other), other) < (key(own), own);
        core::array::from_fn(|own| {
            (0..).zip(peopled).filter(|&(other, peopled)| peopled && darker(own, other)).count() as u8
        })
    }

    /// The list of fields, out or in.
    pub(crate) fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        codec.word(&mut self.pixels)?;
        codec.long(&mut self.light)?;
        self.moments.code(codec)?;
        self.means.0.iter_mut().try_for_each(|mean| codec.word(mean))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    /// Eight pixels in four phases, two of each, some of them between two.
    const FRONTS: [[f32; 2]; 8] =
        [[-1.0, -1.0], [-1.0, -0.5], [1.0, -1.0], [0.3, -1.0], [1.0, 1.0], [0.9, 0.7], [-1.0, 1.0], [-0.2, 0.6]];
    const IMAGE: [f32; 8] = [0.1, 0.2, 0.4, 0.3, 0.6, 0.7, 0.9, 1.0];

    fn parted(fronts: &[[f32; 2]]) -> Regions {
        let cells: [f32; 8] = core::array::from_fn(|at| pair::cell(fronts[at]));
        let mut regions = Regions::of(true);
        regions.add_row::<F32>(&cells, &IMAGE);
        regions.turn(&Moments::default());
        regions
    }

    #[test]
    fn means_are_weighted_by_both_fronts() {
        for (mean, [in_first, in_second]) in parted(&FRONTS).means.values::<F32>().into_iter().zip(PHASES) {
            let share = |inside: bool, v: f32| if inside { 1.0 + v } else { 1.0 - v };
            let weights = FRONTS.map(|[v, w]| share(in_first, v) * share(in_second, w));
            let light = weights.iter().zip(IMAGE).map(|(weight, pixel)| weight * pixel).sum::<f32>();
            let exact = light / weights.iter().sum::<f32>();
            assert!((mean - exact).abs() < 2e-4, "{mean}, not {exact}");
        }
    }

    #[test]
    fn a_step_changes_the_sums_as_if_they_were_taken_anew() {
        let turned = FRONTS.map(|[v, w]| [w, -v]);
        let [old, new] = [FRONTS, turned].map(|fronts| fronts.map(pair::cell::<f32, f32>));
        let (mut change, mut regions) = (Moments::default(), parted(&FRONTS));
        change.observe_pairs::<F32>(&old, &new, &IMAGE);
        assert!(regions.turn(&change));
        assert_eq!(regions, parted(&turned));
        assert!(!regions.turn(&Moments::default()));
    }

    #[test]
    fn phases_are_ranked_by_their_means_and_those_without_pixels_left_out() {
        assert_eq!(parted(&FRONTS).ranks(), [0, 1, 2, 3]);
        assert_eq!(parted(&FRONTS.map(|[v, w]| [v, -w])).ranks(), [3, 2, 1, 0]);
        let two = FRONTS.map(|[_, w]| [1.0, if w > 0.0 { 1.0 } else { -1.0 }]);
        let [_, dark, bright, _] = parted(&two).ranks();
        assert_eq!([dark, bright], [0, 1]);
    }
}
