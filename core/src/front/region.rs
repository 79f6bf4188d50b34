//! The two regions of Chan and Vese: their means, from exact sums that know no order.
//!
//! A front value v in [-1, 1] weighs a pixel by 1 + v for the inside and by 1 - v for the outside.
//! v is taken in whole units of 2^-12 and the image in units of 2^-20, so that sums of their
//! products are whole numbers: rows may come in any order, from any number of threads, and pixels
//! that did not change need not be looked at, because a step adds only what it changed.

use crate::arithmetic::codec::Codec;
use crate::arithmetic::{Arithmetic, Real};

/// Units of a front value and of an image value.
const LEVELS: f32 = 4096.0;
const LIGHT: f32 = 1_048_576.0;

fn level<A: Arithmetic>(cell: A::Cell) -> i64 {
    i64::from((A::level(cell).to_f32() * LEVELS) as i32)
}

fn light<A: Arithmetic>(cell: A::Cell) -> i64 {
    i64::from((A::pixel(cell).to_f32() * LIGHT) as i32)
}

/// What a step changed in the sums of v and of v times the image. Parts of a step add up in any
/// order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moments {
    weight: i64,
    light: i64,
}

impl Moments {
    /// Takes in a piece of a row before and after the step.
    #[inline(always)]
    pub fn observe<A: Arithmetic>(&mut self, old: &[A::Cell], new: &[A::Cell], image: &[A::Cell]) {
        for ((&v, &w), &pixel) in old.iter().zip(new).zip(image) {
            let moved = level::<A>(w).wrapping_sub(level::<A>(v));
            self.weight = self.weight.wrapping_add(moved);
            self.light = self.light.wrapping_add(moved.wrapping_mul(light::<A>(pixel)));
        }
    }

    /// Adds another part of the same step.
    pub fn merge(&mut self, other: &Self) {
        self.weight = self.weight.wrapping_add(other.weight);
        self.light = self.light.wrapping_add(other.light);
    }

    /// The list of fields, out or in.
    pub(crate) fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        signed(codec, &mut self.weight)?;
        signed(codec, &mut self.light)
    }
}

fn signed<C: Codec>(codec: &mut C, number: &mut i64) -> Result<(), C::Error> {
    let mut bits = *number as u64;
    codec.long(&mut bits)?;
    *number = bits as i64;
    Ok(())
}

/// The means of inside and outside, in units of 2^-20.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Means {
    inside: u32,
    outside: u32,
}

impl Means {
    /// c1 and c2.
    pub fn values<A: Arithmetic>(&self) -> (A::Real, A::Real) {
        let value = |mean: u32| A::Real::of(mean.min(LIGHT as u32) as f32 / LIGHT);
        (value(self.inside), value(self.outside))
    }
}

/// The sums over a frame, and the means that follow from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Regions {
    pixels: u32,
    /// Sum of the image.
    light: u64,
    /// Sums of v and of v times the image.
    moments: Moments,
    /// The means: 1 inside and 0 outside as long as a region has no pixels.
    pub means: Means,
}

impl Regions {
    /// A frame without rows.
    pub const NONE: Regions = Regions {
        pixels: 0,
        light: 0,
        moments: Moments { weight: 0, light: 0 },
        means: Means { inside: LIGHT as u32, outside: 0 },
    };

    /// Takes in a row of the front before the first step.
    pub fn add_row<A: Arithmetic>(&mut self, front: &[A::Cell], image: &[A::Cell]) {
        for (&v, &pixel) in front.iter().zip(image) {
            let (v, light) = (level::<A>(v), light::<A>(pixel));
            self.pixels = self.pixels.saturating_add(1);
            self.light = self.light.saturating_add_signed(light);
            self.moments.merge(&Moments { weight: v, light: v.wrapping_mul(light) });
        }
    }

    /// Takes in what a step changed; whether the means are others now. Cost: two divisions.
    pub fn turn(&mut self, change: &Moments) -> bool {
        let before = self.means;
        self.moments.merge(change);
        let Moments { weight, light } = self.moments;
        let (pixels, total) = (u64::from(self.pixels) * LEVELS as u64, self.light.saturating_mul(LEVELS as u64));
        let mean = |light: u64, weight: u64| light.saturating_add(weight / 2).checked_div(weight);
        let part = |light: u64, weight: u64| mean(light, weight).map(|mean| mean.min(LIGHT as u64) as u32);
        if let Some(inside) = part(total.saturating_add_signed(light), pixels.saturating_add_signed(weight)) {
            self.means.inside = inside;
        }
        if let Some(outside) = part(
            total.saturating_add_signed(light.saturating_neg()),
            pixels.saturating_add_signed(weight.saturating_neg()),
        ) {
            self.means.outside = outside;
        }
        self.means != before
    }

    /// The list of fields, out or in.
    pub(crate) fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        codec.word(&mut self.pixels)?;
        codec.long(&mut self.light)?;
        self.moments.code(codec)?;
        codec.word(&mut self.means.inside)?;
        codec.word(&mut self.means.outside)
    }
}
