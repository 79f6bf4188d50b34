//! No front: the run of a [`Segmenter`](crate::run::segmenter::Segmenter) ends with the filtered image.

use super::{Evolve, Step};
use crate::arithmetic::Arithmetic;
use crate::config::{Config, Scheme};
use crate::plane::sweep::Band;
use crate::plane::tiles::Tiles;
use core::ops::Range;

/// What filters for [`Scheme::Region`], whose front is an
/// [`Extractor`](crate::run::extract::Extractor)'s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Still;

impl<A: Arithmetic> Evolve<A> for Still {
    fn new(config: &Config, _unit: f32) -> Result<Self, Scheme> {
        match config.scheme {
            Scheme::Region => Ok(Still),
            other => Err(other),
        }
    }

    fn window(&self) -> usize {
        3
    }

    fn advance(&self, _: &mut Band<'_, A::Cell>, _: &mut Tiles<'_>, _: Range<usize>, _: &mut Step<A>) {}
}
