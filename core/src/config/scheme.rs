//! Step 5, the scheme that moves the front: which there are. Words and usual steps of each are told
//! here, and nowhere else.

use super::parameter::{Word, word};

/// Step 5: the scheme that moves the front.
///
/// ```
/// use skyfront_core::config::{Config, Scheme};
///
/// let names: Vec<&str> = Scheme::ALL.iter().map(|scheme| scheme.name()).collect();
/// assert!(names.contains(&"fd") && names.contains(&"chan-vese"));
/// let config = Config { scheme: Scheme::Sl, ..Config::PAPER_F160 };
/// assert!(config.validate_values().is_ok());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// A front that starts where signal-to-noise crosses a threshold, with that as its force
    /// ([`crate::front::outline`]).
    Region,
    /// Finite differences, first order (`DFg`).
    Fd,
    /// Finite differences with curvature (`DFgk`).
    FdCurvature,
    /// Finite differences of second order, filtered ([`crate::front::scheme::FdFiltered`]).
    FdFiltered,
    /// Semi-Lagrangian (`SLg`).
    Sl,
    /// Semi-Lagrangian with curvature (`SLgk`).
    SlCurvature,
    /// Active contours without edges ([`crate::front::scheme::ChanVese`]), by the regions of the filtered
    /// image; the edge detector has no meaning there.
    ChanVese,
    /// Active contours without edges with four phases in place of two regions
    /// ([`crate::front::scheme::Multiphase`]).
    Multiphase,
    /// The first-order equation by arrival times, in one pass (see [`crate::front::march`]): the front at
    /// `t_max`. The time step has no meaning there.
    FastMarching,
}

/// Makes the lists of the schemes.
macro_rules! schemes {
    ($($scheme:ident),+ $(,)?) => {
        impl Scheme {
            /// Every scheme.
            pub const ALL: [Scheme; [$(Scheme::$scheme),+].len()] = [$(Scheme::$scheme),+];
        }
        /// Their words.
        pub(super) const WORDS: &[Word] = &[$(Scheme::$scheme.word()),+];
    };
}

schemes!(Region, Fd, Sl, FdCurvature, SlCurvature, FdFiltered, ChanVese, Multiphase, FastMarching);

impl Scheme {
    const fn word(self) -> Word {
        match self {
            Scheme::Region => word(
                "region",
                "from the threshold, outwards where there is more signal-to-noise and inwards where there is less",
            ),
            Scheme::Fd => word("fd", "finite differences of first order"),
            Scheme::Sl => word("sl", "semi-Lagrangian"),
            Scheme::FdCurvature => word("fd-curvature", "finite differences with curvature"),
            Scheme::SlCurvature => word("sl-curvature", "semi-Lagrangian with curvature"),
            Scheme::FdFiltered => word("fd-filtered", "finite differences of second order, filtered"),
            Scheme::ChanVese => word("chan-vese", "two regions of least variance, without edges"),
            Scheme::Multiphase => word("multiphase", "four regions of least variance, without edges"),
            Scheme::FastMarching => word("fast-marching", "arrival times in one pass"),
        }
    }

    /// Its name among the parameters.
    pub const fn name(self) -> &'static str {
        self.word().name
    }

    /// Whether it parts the image into regions by their means: no edge holds its front, and every
    /// pixel takes part.
    pub const fn is_by_regions(self) -> bool {
        matches!(self, Scheme::ChanVese | Scheme::Multiphase)
    }

    /// Whether it moves two fronts in the plane of one.
    pub const fn has_two_fronts(self) -> bool {
        matches!(self, Scheme::Multiphase)
    }

    /// The paper's time step: dx/4, dx^2 with curvature, dx for semi-Lagrangian. Ours for Chan and
    /// Vese, in which one step moves a pixel of contrast 0.5 across the band.
    pub fn usual_dt(self, dx: f32) -> f32 {
        match self {
            Scheme::Region | Scheme::Fd | Scheme::FdFiltered | Scheme::FastMarching => dx / 4.0,
            Scheme::FdCurvature => dx * dx,
            Scheme::Sl | Scheme::SlCurvature => dx,
            Scheme::ChanVese | Scheme::Multiphase => 8.0,
        }
    }
}
