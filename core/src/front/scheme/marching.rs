//! The scheme without steps: the run finds arrival times instead ([`crate::front::march`]).

use super::{Evolve, Step};
use crate::arithmetic::Arithmetic;
use crate::config::{Config, Scheme};
use crate::plane::sweep::Band;
use crate::plane::tiles::Tiles;
use core::ops::Range;

/// Fast marching: the front never moves by steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Marching;

impl<A: Arithmetic> Evolve<A> for Marching {
    const MARCHES: bool = true;

    fn new(config: &Config, _unit: f32) -> Result<Self, Scheme> {
        match config.scheme {
            Scheme::FastMarching => Ok(Marching),
            other => Err(other),
        }
    }

    fn window(&self) -> usize {
        3
    }

    fn advance(&self, _: &mut Band<'_, A::Cell>, _: &mut Tiles<'_>, _: Range<usize>, _: &mut Step<A>) {}
}
