//! Step 2: rescaling of intensities, so that faint objects stand out.
//!
//! All functions map [0, 1] onto itself, keep 0 and 1, and grow strictly (A1 to A3).

use crate::arithmetic::{Arithmetic, Exponent, Real};
use crate::config::Rescale;
use crate::machine::{Task, VECTORS};
use crate::noise::Estimate;

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
