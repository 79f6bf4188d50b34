//! The scheme chosen at run time.

use super::{ChanVese, Evolve, Fd, FdCurvature, FdFiltered, Marching, Multiphase, Sl, SlCurvature, Step, Still};
use crate::arithmetic::Arithmetic;
use crate::config::{Config, Scheme};
use crate::plane::sweep::Band;
use crate::plane::tiles::Tiles;
use core::ops::Range;

/// Any of the schemes. A program that needs only one names it instead and is smaller.
#[derive(Clone, Copy, Debug)]
pub enum AnyScheme<A: Arithmetic> {
    /// `DFg`.
    Fd(Fd<A>),
    /// `DFgk`.
    FdCurvature(FdCurvature<A>),
    /// `DFg`, filtered, second order.
    FdFiltered(FdFiltered<A>),
    /// `SLg`, 16 directions.
    Sl(Sl<A>),
    /// `SLg`, 64 directions.
    SlFine(Sl<A, 15>),
    /// `SLgk`, 16 directions.
    SlCurvature(SlCurvature<A>),
    /// `SLgk`, 64 directions.
    SlCurvatureFine(SlCurvature<A, 15>),
    /// Active contours without edges.
    ChanVese(ChanVese<A>),
    /// Active contours without edges, four phases.
    Multiphase(Multiphase<A>),
    /// No steps at all.
    FastMarching(Marching),
    /// No front at all.
    Region(Still),
}

/// The same expression for whichever scheme it is.
macro_rules! each {
    ($any:expr, $scheme:ident => $expression:expr) => {
        match $any {
            AnyScheme::Fd($scheme) => $expression,
            AnyScheme::FdCurvature($scheme) => $expression,
            AnyScheme::FdFiltered($scheme) => $expression,
            AnyScheme::Sl($scheme) => $expression,
            AnyScheme::SlFine($scheme) => $expression,
            AnyScheme::SlCurvature($scheme) => $expression,
            AnyScheme::SlCurvatureFine($scheme) => $expression,
            AnyScheme::ChanVese($scheme) => $expression,
            AnyScheme::Multiphase($scheme) => $expression,
            AnyScheme::FastMarching($scheme) => $expression,
            AnyScheme::Region($scheme) => $expression,
        }
    };
}

impl<A: Arithmetic> Evolve<A> for AnyScheme<A> {
    const MARCHES: bool = true;
    const FOLLOWS: bool = true;

    fn new(config: &Config, unit: f32) -> Result<Self, Scheme> {
        let fine = config.directions == 64;
        match (config.scheme, fine) {
            (Scheme::Region, _) => <Still as Evolve<A>>::new(config, unit).map(AnyScheme::Region),
            (Scheme::Fd, _) => Fd::new(config, unit).map(AnyScheme::Fd),
            (Scheme::FdCurvature, _) => FdCurvature::new(config, unit).map(AnyScheme::FdCurvature),
            (Scheme::FdFiltered, _) => FdFiltered::new(config, unit).map(AnyScheme::FdFiltered),
            (Scheme::Sl, false) => Sl::new(config, unit).map(AnyScheme::Sl),
            (Scheme::Sl, true) => Sl::new(config, unit).map(AnyScheme::SlFine),
            (Scheme::ChanVese, _) => ChanVese::new(config, unit).map(AnyScheme::ChanVese),
            (Scheme::Multiphase, _) => Multiphase::new(config, unit).map(AnyScheme::Multiphase),
            (Scheme::FastMarching, _) => <Marching as Evolve<A>>::new(config, unit).map(AnyScheme::FastMarching),
            (Scheme::SlCurvature, false) => SlCurvature::new(config, unit).map(AnyScheme::SlCurvature),
            (Scheme::SlCurvature, true) => SlCurvature::new(config, unit).map(AnyScheme::SlCurvatureFine),
        }
    }

    fn window(&self) -> usize {
        each!(self, scheme => Evolve::<A>::window(scheme))
    }

    fn advance(&self, band: &mut Band<'_, A::Cell>, tiles: &mut Tiles<'_>, rows: Range<usize>, step: &mut Step<A>) {
        each!(self, scheme => Evolve::<A>::advance(scheme, band, tiles, rows, step));
    }

    fn follow(&self, band: &mut Band<'_, A::Cell>, tiles: &mut Tiles<'_>, rows: Range<usize>, step: &mut Step<A>) {
        if let AnyScheme::ChanVese(scheme) = self {
            scheme.follow(band, tiles, rows, step);
        }
    }
}
