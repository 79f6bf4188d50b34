//! Photon noise: how the variance of a pixel grows with its brightness.
//!
//! A second difference along both axes takes away what is smooth (Immerkaer 1996,
//! doi:10.1006/cviu.1996.0060); its scatter on pixels of like brightness, against that on sky,
//! is the image's own photon transfer curve.

use crate::arithmetic::codec::Codec;
use crate::arithmetic::{Level, Real};
use crate::plane::field::Field;
use crate::plane::mask::Mask;
use crate::plane::part::{self, Question, Whole};
use crate::plane::sort::{Keys, median};
use crate::plane::walk::Walk;
use core::ops::Range;

/// Brightness from which the curve is read; each level is twice the one before it.
const FAINTEST: f32 = 4.0;
/// Levels of brightness.
const LEVELS: u32 = 4;
/// Pixels that a level must have.
const ENOUGH: usize = 100;

/// What is known of the photon transfer curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Curve {
    /// The scatter of the sky; 0 where it is not known.
    sky: f32,
    /// The least slope so far; NaN for none.
    least: f32,
    /// Pixels that are listed.
    listed: usize,
}

impl Curve {
    /// Nothing is known.
    pub const NOTHING: Curve = Curve { sky: 0.0, least: f32::NAN, listed: 0 };

    /// The list of fields, out or in.
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        codec.real(&mut self.sky)?;
        codec.real(&mut self.least)?;
        codec.size(&mut self.listed)
    }

    /// The photon noise.
    pub fn slope(&self) -> f32 {
        if self.sky > 0.0 && self.least > 0.0 { self.least } else { 0.0 }
    }
}

/// The photon noise `a` of a signal-to-noise image: a pixel of brightness v has the variance
/// `1 + a v`. The least of what the levels say, because structure only adds to the scatter; 0
/// where no level has enough pixels. `fine` is the signal lightly smoothed, the pixels near sources
/// are `masked`; `list` is scratch, as long as the plane. Cost: two looks at each pixel. While other parts of an image have
/// yet to answer, it means nothing.
pub(crate) fn step<L: Level>(
    walk: &mut Walk,
    (whole, curve): (Option<&dyn Whole>, &mut Curve),
    signal: Field<'_, L>,
    fine: &[L],
    masked: Mask<'_>,
    (list, mut keys): (&mut [u32], Keys<'_>),
) -> Option<()> {
    let mut scatter = |walk: &mut Walk, list: &[u32], question: Question, from: f32, to: f32| {
        let sky = question == Question::PhotonSky;
        let (from, to) = (L::of(from), L::of(to));
        let wanted = |bright: L, at: usize| if sky { !masked.has(at) } else { bright >= from && bright < to };
        let value = |at: usize| {
            let &bright = fine.get(at)?;
            if wanted(bright, at) { second_difference(signal, at) } else { None }
        };
        let sorted = match whole {
            None if !sky => {
                let some = |items: Range<usize>| list.get(items).unwrap_or(&[]).iter();
                Some(keys.gather(walk, (list.len(), 1), |items| some(items).filter_map(|&at| value(at as usize)))?)
            }
            _ => {
                let pixels = (fine.len(), signal.grid.width.get(), sky);
                part::sorted(walk, whole.map(|whole| (whole, question)), pixels, &mut keys, value)?
            }
        };
        Some(sorted.filter(|sorted| sorted.len() >= ENOUGH).map(|sorted| median::<L>(sorted).to_f32()))
    };
    let sky = scatter(walk, &[], Question::PhotonSky, 0.0, 0.0)?.filter(|&sky| sky > 0.0);
    let waiting = whole.is_some_and(Whole::is_waiting);
    walk.once(1, || *curve = Curve { sky: sky.or(waiting.then_some(1.0)).unwrap_or(0.0), ..Curve::NOTHING })?;
    let levels = if curve.sky > 0.0 { LEVELS } else { 0 };
    let pieces = if levels > 0 && whole.is_none() { fine.len().div_ceil(PIECE) } else { 0 };
    walk.pass(pieces, PIECE, |pieces| {
        for at in bright(fine, pieces) {
            if let Some(place) = list.get_mut(curve.listed) {
                *place = at as u32;
                curve.listed += 1;
            }
        }
    })?;
    let list = list.get(..curve.listed).unwrap_or(&[]);
    let mut from = FAINTEST;
    for number in 0..levels {
        let level = scatter(walk, list, Question::Photons(number), from, 2.0 * from)?;
        walk.once(1, || {
            if let Some(level) = level {
                let ratio = level / curve.sky;
                // The middle of the level, in the logarithm.
                let slope = (ratio * ratio - 1.0) / (from * core::f32::consts::SQRT_2);
                curve.least = if curve.least < slope { curve.least } else { slope };
            }
        })?;
        from *= 2.0;
    }
    Some(())
}

/// Pixels that are looked at together.
const PIECE: usize = 16;

/// The pixels of some pieces of a plane that are bright enough for a level.
fn bright<L: Level>(fine: &[L], pieces: Range<usize>) -> impl Iterator<Item = usize> {
    let from = L::of(FAINTEST);
    let (first, end) = (pieces.start * PIECE, fine.len().min(pieces.end * PIECE));
    let fine = fine.get(first..end).unwrap_or(&[]);
    let any = move |piece: &[L]| piece.iter().fold(false, |any, &value| any | (value >= from));
    let pieces = (first..).step_by(PIECE).zip(fine.chunks(PIECE)).filter(move |(_, piece)| any(piece));
    pieces.flat_map(|(first, piece)| (first..).zip(piece)).filter(move |(_, value)| **value >= from).map(|(at, _)| at)
}

/// The size of the difference along x of the difference along y; `None` at the frame's border.
fn second_difference<L: Level>(field: Field<'_, L>, at: usize) -> Option<L> {
    let (grid, (x, y)) = (field.grid, field.grid.place(at));
    if x == 0 || x + 1 == grid.width.get() || y == 0 || y + 1 == grid.height {
        return None;
    }
    let bend = |before: L, own: L, after: L| before - (own + own) + after;
    let row = |first: usize| {
        let three = field.values.get(first..).and_then(<[L]>::first_chunk);
        let &[before, own, after] = three.unwrap_or(&[L::ZERO; 3]);
        bend(before, own, after)
    };
    let (first, width) = (at - 1, grid.width.get());
    Some(bend(row(first - width), row(first), row(first + width)).magnitude())
}

/// The photon noise counts with this factor in the variance: the measured one is a lower bound.
const PHOTON_MARGIN: f32 = 1.5;

/// How much larger the noise is at the brightness `value` for the photon noise `photon` (see
/// [`crate::sky::photon`]).
pub fn grown<L: Level>(photon: f32, value: L) -> L {
    (L::ONE + value.positive().scaled(L::Weight::of(PHOTON_MARGIN * photon))).root()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::Fixed14;

    fn grows<L: Level>() {
        for (photon, light, noise) in [(0.2, 10.0, 2.0), (0.5, 20.0, 4.0), (0.5, -20.0, 1.0), (0.0, 1e4, 1.0)] {
            let found = grown(photon, L::of(light)).to_f32();
            assert!((found - noise).abs() < 1e-4 * noise, "{}: {found} at {light}, not {noise}", L::NAME);
        }
    }

    #[test]
    fn noise_grows_by_half_as_much_again_as_photons_say() {
        grows::<f32>();
        grows::<Fixed14>();
    }
}
