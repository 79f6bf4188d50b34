//! Step 2: rescaling of intensities, so that faint objects stand out.
//!
//! All functions map [0, 1] onto itself, keep 0 and 1, and grow strictly (A1 to A3). Their numbers
//! in an arithmetic keep 0 and 1 and never fall; where a function rises by less than a step of the
//! cells, as `r3` far below tau, neighbouring levels become one.

use crate::arithmetic::machine::{Task, VECTORS};
use crate::arithmetic::{Arithmetic, Exponent, Real};
use crate::config::Rescale;
use crate::sky::noise::Estimate;

/// The threshold `k` standard deviations above the sky, within [0, 1]. It is lowered by 2^-18 of
/// itself: pixels of whole numbers often lie exactly there, and rounding must not decide about
/// them, because `r3` lifts what is just above tau by its eighth root.
pub fn noise_threshold(sky: &Estimate, k: f32) -> f32 {
    let tau = sky.above(k) * (1.0 - 1.0 / 262_144.0);
    if tau > 0.0 { if tau < 1.0 { tau } else { 1.0 } } else { 0.0 }
}

/// A rescaling with its constants.
#[derive(Clone, Copy, Debug)]
pub enum Rescaler<A: Arithmetic> {
    /// `x^alpha`.
    R1(Exponent),
    /// `(ln(x + 1) / ln 2)^alpha`.
    R2(Exponent),
    /// Around a threshold.
    R3 {
        /// The threshold.
        tau: A::Real,
        /// `x^beta`.
        damp: Exponent,
        /// `x^(1/beta)`.
        lift: Exponent,
    },
}

impl<A: Arithmetic> Rescaler<A> {
    /// The rescaling `which`, with `tau` for `r3`; `None` where there is nothing to do.
    pub fn new(which: Rescale, tau: A::Real) -> Option<Self> {
        match which {
            Rescale::None => None,
            Rescale::R1 { alpha } => Some(Rescaler::R1(Exponent::of(alpha))),
            Rescale::R2 { alpha } => Some(Rescaler::R2(Exponent::of(alpha))),
            Rescale::R3 { beta, .. } => {
                let damp = Exponent::of(f32::from(beta));
                let lift = match damp {
                    Exponent::Squarings(n) => Exponent::Roots(n),
                    other => Exponent::of(1.0 / other.value()),
                };
                Some(Rescaler::R3 { tau, damp, lift })
            }
        }
    }

    /// Applies it to a value in [0, 1].
    #[inline(always)]
    pub fn apply(&self, x: A::Real) -> A::Real {
        let value = match *self {
            Rescaler::R1(alpha) => A::pow(x, alpha),
            Rescaler::R2(alpha) => A::pow(A::log2_1p(x), alpha),
            Rescaler::R3 { tau, damp, lift } => r3::<A>(x, tau, damp, lift),
        };
        bounded::<A>(value)
    }

    /// Applies it in place to a row of the image plane.
    pub fn row(&self, image: &mut [A::Cell]) {
        A::wide(Row { rescaler: *self, image });
    }
}

struct Row<'a, A: Arithmetic> {
    rescaler: Rescaler<A>,
    image: &'a mut [A::Cell],
}

impl<A: Arithmetic> Task for Row<'_, A> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Row { rescaler, image } = self;
        match rescaler {
            Rescaler::R3 { tau, damp: EIGHTH, lift: EIGHTH_ROOT } if VECTORS => eighth_row::<A>(image, tau),
            _ => fill::<A>(image, |x| rescaler.apply(x)),
        }
    }
}

/// The paper's own power, in which there is no loop once it is a constant.
const EIGHTH: Exponent = Exponent::Squarings(3);
const EIGHTH_ROOT: Exponent = Exponent::Roots(3);
/// Pixels that are looked at together, whether all lie below tau.
const PIECE: usize = 32;

/// `r3` with that power, as vectors: most of an image is sky, which takes no roots.
#[inline(always)]
fn eighth_row<A: Arithmetic>(image: &mut [A::Cell], tau: A::Real) {
    let rescaler = Rescaler::<A>::R3 { tau, damp: EIGHTH, lift: EIGHTH_ROOT };
    for piece in image.chunks_mut(PIECE) {
        if piece.iter().fold(true, |all, &cell| all & (A::pixel(cell) < tau)) {
            fill::<A>(piece, |x| bounded::<A>(damped::<A>(x, tau, EIGHTH)));
        } else {
            fill::<A>(piece, |x| rescaler.apply(x));
        }
    }
}

/// Rescales cells one by one.
#[inline(always)]
fn fill<A: Arithmetic>(cells: &mut [A::Cell], rescale: impl Fn(A::Real) -> A::Real) {
    for cell in cells {
        *cell = A::to_pixel(rescale(A::pixel(*cell)));
    }
}

/// Roundings may lead beyond [0, 1].
#[inline(always)]
fn bounded<A: Arithmetic>(value: A::Real) -> A::Real {
    value.positive().least(A::Real::ONE)
}

/// `x^beta / tau^(beta-1)` below tau is `tau (x/tau)^beta`, and
/// `(x-tau)^(1/beta) / (1-tau)^(1/beta-1) + tau` is `(1-tau) ((x-tau)/(1-tau))^(1/beta) + tau`:
/// the same numbers, without powers that leave [0, 1].
#[inline(always)]
fn r3<A: Arithmetic>(x: A::Real, tau: A::Real, damp: Exponent, lift: Exponent) -> A::Real {
    if x < tau {
        damped::<A>(x, tau, damp)
    } else {
        let above = A::Real::ONE - tau;
        above * A::pow((x - tau).ratio(above), lift) + tau
    }
}

/// The part of `r3` below tau.
#[inline(always)]
fn damped<A: Arithmetic>(x: A::Real, tau: A::Real, damp: Exponent) -> A::Real {
    tau * A::pow(x.ratio(tau), damp)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::{F32, Q11, Q24};
    use crate::config::Tau;

    /// Each level of q11's image, from 0 to 1, in order; how many levels are left.
    fn levels<A: Arithmetic>(which: Rescale) -> usize {
        let rescaler = Rescaler::<A>::new(which, A::Real::of(0.3)).expect("a rescaling");
        let mut image = [A::Cell::default(); 32_769];
        image.iter_mut().zip(0u16..).for_each(|(cell, k)| *cell = A::to_pixel(A::Real::of(f32::from(k) / 32_768.0)));
        rescaler.row(&mut image);
        let value = |cell: &A::Cell| A::pixel(*cell).to_f32();
        assert_eq!(image.first().map(value), Some(0.0), "{}, {which:?}", A::NAME);
        assert!(image.last().map(value).is_some_and(|one| (one - 1.0).abs() < 1e-6), "{}, {which:?}", A::NAME);
        let falls = image.windows(2).filter(|pair| value(&pair[1]) < value(&pair[0])).count();
        assert_eq!(falls, 0, "{}, {which:?}", A::NAME);
        1 + image.windows(2).filter(|pair| value(&pair[1]) > value(&pair[0])).count()
    }

    #[test]
    fn numbers_never_fall_but_may_be_one() {
        let r3 = Rescale::R3 { beta: 8, tau: Tau::Otsu };
        for which in [Rescale::R1 { alpha: 0.25 }, Rescale::R2 { alpha: 0.25 }, Rescale::R1 { alpha: 0.7 }, r3] {
            let [narrow, fixed, float] = [levels::<Q11>(which), levels::<Q24>(which), levels::<F32>(which)];
            assert!(narrow < 32_769 && narrow <= fixed && narrow <= float, "{which:?}: {narrow}, {fixed}, {float}");
        }
        // x^8 leaves nothing of the faintest levels even in q24.
        assert!(levels::<Q24>(r3) < 32_769);
    }

    #[test]
    fn values_are_the_papers() {
        let r3 = Rescale::R3 { beta: 8, tau: Tau::Otsu };
        let cases = [
            (Rescale::R1 { alpha: 0.5 }, 0.25, 0.5),
            (Rescale::R1 { alpha: 0.25 }, 1.0 / 256.0, 0.25),
            (Rescale::R1 { alpha: 0.3 }, 0.5, 0.812_252_4),
            // log2(1.5) and its root.
            (Rescale::R2 { alpha: 1.0 }, 0.5, 0.584_962_5),
            (Rescale::R2 { alpha: 0.5 }, 0.5, 0.764_828_4),
            // Half of tau, and a 256th of the way from tau to 1.
            (r3, 0.15, 0.3 / 256.0),
            (r3, 0.3 + 0.7 / 256.0, 0.3 + 0.7 * 0.5),
            (Rescale::R3 { beta: 3, tau: Tau::Otsu }, 0.15, 0.3 / 8.0),
            (Rescale::R3 { beta: 3, tau: Tau::Otsu }, 0.3 + 0.7 / 8.0, 0.3 + 0.7 * 0.5),
        ];
        for (which, x, expected) in cases {
            let rescaler = Rescaler::<F32>::new(which, 0.3).expect("a rescaling");
            let mut row = [x; PIECE + 1];
            rescaler.row(&mut row);
            for found in [rescaler.apply(x), row[0], row[PIECE]] {
                assert!((found - expected).abs() < 2e-6, "{which:?} of {x}: {found}, not {expected}");
            }
        }
    }

    /// Pixels below tau and above it in one piece of a row.
    #[test]
    fn a_row_is_rescaled_pixel_by_pixel() {
        let rescaler = Rescaler::<F32>::new(Rescale::R3 { beta: 8, tau: Tau::Otsu }, 0.3).expect("a rescaling");
        let mut row: [f32; 3 * PIECE] =
            core::array::from_fn(|at| if at > PIECE { at as f32 / 96.0 } else { 0.002 * at as f32 });
        let expected = row.map(|x| rescaler.apply(x));
        rescaler.row(&mut row);
        assert_eq!(row, expected);
    }

    #[test]
    fn a_threshold_of_noise_lies_just_below_and_within_the_image() {
        let threshold = |level: f32, noise: f32, k: f32| {
            let mut sky = Estimate::NONE;
            (sky.level, sky.noise) = (level, noise);
            noise_threshold(&sky, k)
        };
        let part = threshold(0.25, 0.125, 2.0) / 0.5;
        assert!(part < 1.0 && part > 1.0 - 1.0 / 200_000.0, "{part}");
        assert_eq!((threshold(0.9, 0.1, 2.0), threshold(-0.5, 0.1, 2.0)), (1.0, 0.0));
    }
}
