//! A program for one configuration: whatever other configurations need is left out of it.

use super::{Evolve, Step};
use crate::arithmetic::Arithmetic;
use crate::config::{Config, Scheme};
use crate::plane::sweep::Band;
use crate::plane::tiles::Tiles;
use core::marker::PhantomData;
use core::ops::{Deref, Range};

/// A configuration that is known when the program is built.
pub trait Fixed {
    /// The configuration.
    const CONFIG: Config;
}

/// The scheme `S` in the configuration of `P` alone: the smallest program, with the same bits.
#[derive(Clone, Copy, Debug)]
pub struct Preset<S, P> {
    scheme: S,
    config: PhantomData<P>,
}

impl<A: Arithmetic, S: Evolve<A>, P: Fixed> Evolve<A> for Preset<S, P> {
    const ONLY: Option<Config> = Some(P::CONFIG);
    const MARCHES: bool = S::MARCHES;
    const FOLLOWS: bool = S::FOLLOWS;

    fn new(config: &Config, unit: f32) -> Result<Self, Scheme> {
        if *config != P::CONFIG {
            return Err(config.scheme);
        }
        Ok(Preset { scheme: S::new(&P::CONFIG, unit)?, config: PhantomData })
    }

    fn window(&self) -> usize {
        self.scheme.window()
    }

    #[inline(always)]
    fn advance(&self, band: &mut Band<'_, A::Cell>, tiles: &mut Tiles<'_>, rows: Range<usize>, step: &mut Step<A>) {
        self.scheme.advance(band, tiles, rows, step);
    }

    #[inline(always)]
    fn follow(&self, band: &mut Band<'_, A::Cell>, tiles: &mut Tiles<'_>, rows: Range<usize>, step: &mut Step<A>) {
        self.scheme.follow(band, tiles, rows, step);
    }
}

/// The configuration of a run with scheme `S`: the program's own where it has only one, so that the
/// compiler sees what is not needed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chosen<A, S> {
    given: Config,
    program: PhantomData<(A, S)>,
}

impl<A, S> Chosen<A, S> {
    pub(crate) fn new(given: Config) -> Self {
        Chosen { given, program: PhantomData }
    }
}

impl<A: Arithmetic, S: Evolve<A>> Deref for Chosen<A, S> {
    type Target = Config;

    #[inline(always)]
    fn deref(&self) -> &Config {
        const { &S::ONLY }.as_ref().unwrap_or(&self.given)
    }
}
