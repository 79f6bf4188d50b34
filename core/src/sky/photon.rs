//! Photon noise: how the variance of a pixel grows with its brightness.
//!
//! A second difference along both axes takes away what is smooth (Immerkaer 1996,
//! doi:10.1006/cviu.1996.0060); its scatter on pixels of like brightness, against that on sky,
//! is the image's own photon transfer curve.

use crate::arithmetic::{Level, Real};
use crate::plane::field::Field;
use crate::plane::mask::Mask;
use crate::plane::part::{self, Question, Whole};
use crate::plane::sort::{Keys, median};

/// Brightness from which the curve is read; each level is twice the one before it.
const FAINTEST: f32 = 4.0;
/// Levels of brightness.
const LEVELS: u32 = 4;
/// Pixels that a level must have.
const ENOUGH: usize = 100;

/// The photon noise `a` of a signal-to-noise image: a pixel of brightness v has the variance
/// `1 + a v`. The least of what the levels say, because structure only adds to the scatter; 0
/// where no level has enough pixels. `fine` is the signal lightly smoothed, the pixels near sources
/// are `masked`. Cost: five looks at each pixel. While other parts of an image have yet to answer, it means nothing.
pub fn slope<L: Level>(
    whole: Option<&dyn Whole>,
    signal: Field<'_, L>,
    fine: &[L],
    masked: Mask<'_>,
    mut keys: Keys<'_>,
) -> f32 {
    let mut scatter = |question: Question, from: f32, to: f32| {
        let sky = question == Question::PhotonSky;
        let (from, to) = (L::of(from), L::of(to));
        let wanted = |bright: L, at: usize| if sky { !masked.has(at) } else { bright >= from && bright < to };
        let value = |at: usize| {
            let &bright = fine.get(at)?;
            if wanted(bright, at) { second_difference(signal, at) } else { None }
        };
        let sorted = match whole {
            None if !sky => keys.sorted(bright(fine, from, to).filter_map(value)),
            _ => {
                let pixels = (fine.len(), signal.grid.width.get(), sky);
                part::sorted(whole.map(|whole| (whole, question)), pixels, &mut keys, value)?
            }
        };
        (sorted.len() >= ENOUGH).then(|| median::<L>(sorted).to_f32())
    };
    let sky = scatter(Question::PhotonSky, 0.0, 0.0).filter(|&sky| sky > 0.0);
    let waiting = whole.is_some_and(Whole::is_waiting);
    let Some(sky) = sky.or(waiting.then_some(1.0)) else { return 0.0 };
    let mut least = None;
    let mut from = FAINTEST;
    for number in 0..LEVELS {
        if let Some(level) = scatter(Question::Photons(number), from, 2.0 * from) {
            let ratio = level / sky;
            // The middle of the level, in the logarithm.
            let slope = (ratio * ratio - 1.0) / (from * core::f32::consts::SQRT_2);
            least = Some(if least.is_some_and(|least| least < slope) { least.unwrap_or(slope) } else { slope });
        }
        from *= 2.0;
    }
    least.filter(|&slope| slope > 0.0).unwrap_or(0.0)
}

/// Pixels that are looked at together.
const PIECE: usize = 16;

/// The pixels of a plane from the first of a piece to its last, where one has such a brightness.
fn bright<L: Level>(fine: &[L], from: L, to: L) -> impl Iterator<Item = usize> {
    let any = move |piece: &[L]| piece.iter().fold(false, |any, &value| any | ((value >= from) & (value < to)));
    let pieces = (0..).step_by(PIECE).zip(fine.chunks(PIECE)).filter(move |(_, piece)| any(piece));
    pieces.flat_map(|(first, piece)| first..first + piece.len())
}

/// The size of the difference along x of the difference along y; `None` at the frame's border.
fn second_difference<L: Level>(field: Field<'_, L>, at: usize) -> Option<L> {
    let (grid, (x, y)) = (field.grid, field.grid.place(at));
    if x == 0 || x + 1 == grid.width.get() || y == 0 || y + 1 == grid.height {
        return None;
    }
    let bend = |before: L, own: L, after: L| before - (own + own) + after;
    let row = |middle: usize| bend(field.at(middle - 1), field.at(middle), field.at(middle + 1));
    let width = grid.width.get();
    Some(bend(row(at - width), row(at), row(at + width)).magnitude())
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
