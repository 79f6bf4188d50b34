//! What a run is to do: immutable, validated once, with the paper's values as defaults.

#[deny(clippy::arithmetic_side_effects)]
pub mod bytes;
mod filter;
mod parameter;
mod scheme;
mod sources;
mod table;
mod validate;

pub use filter::{Diffusivity, Filter};
pub use parameter::{End, Forms, Need, Numbers, Parameter, Range, Step, Value, Word};
pub use scheme::Scheme;
pub use sources::{Background, Deblending, Outline, Select, Separate, Significance, narrow_area, part_area};
pub use table::PARAMETERS;

use crate::arithmetic::digest::Digest;

/// Step 1: how pixel values become numbers in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Normalize {
    /// By the least and the greatest defined pixel (`risc01`).
    MinMax,
    /// By two percentiles in percent, clipped: one hot pixel must not flatten the frame.
    Percentile {
        /// Becomes 0.
        low: f32,
        /// Becomes 1.
        high: f32,
    },
    /// By sky and noise of the frame ([`crate::sky::noise`]), clipped: neither a hot pixel nor a bright
    /// star flattens the rest. A frame without noise is normalised by its extremes.
    Noise {
        /// The sky minus this many standard deviations becomes 0.
        below: f32,
        /// The sky plus this many standard deviations becomes 1.
        above: f32,
    },
}

/// Where `r3` changes from damping to amplifying. All rules but a given value look at the image
/// that is rescaled: the filtered one with [`Order::FilterFirst`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tau {
    /// Otsu's threshold (doi:10.1109/TSMC.1979.4310076), of a histogram of 256 bins over [0, 1] as
    /// the next two.
    Otsu,
    /// The greatest entropy of Kapur, Sahoo and Wong ([`crate::sky::kapur`]).
    Kapur,
    /// Rosin's corner of a histogram with one peak ([`crate::sky::rosin`]).
    Rosin,
    /// Sky plus `k` standard deviations of the noise ([`crate::sky::noise`]), within [0, 1].
    Noise {
        /// Above 0, at most 1000.
        k: f32,
    },
    /// A given value in (0, 1).
    Value(f32),
}

/// Step 2: the rescaling of intensities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rescale {
    /// None.
    None,
    /// `x^alpha`.
    R1 {
        /// In (0, 1).
        alpha: f32,
    },
    /// `(ln(x + 1) / ln 2)^alpha`.
    R2 {
        /// In (0, 1).
        alpha: f32,
    },
    /// `x^beta` below tau, `x^(1/beta)` above, shifted and stretched to be continuous.
    R3 {
        /// 1, 2, 3, ...
        beta: u16,
        /// The threshold.
        tau: Tau,
    },
}

/// Whether step 2 or step 3 comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// The algorithm as printed, and Test 1.
    RescaleFirst,
    /// Test 2.
    FilterFirst,
}

/// Step 4: the edge detector, from `z = |grad I|`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Edge {
    /// `1 / (1 + z^p)` (`g1`).
    G1 {
        /// At least 1.
        p: f32,
    },
    /// `1 - (z - m) / (M - m)`, m and M the extremes of z (`g2`).
    G2,
    /// `max(g2 - c2, 0) / (1 - c2)` (`g2mod`).
    G2Mod {
        /// In [0, 1).
        c2: f32,
    },
}

/// The weights of Chan and Vese's energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChanVese {
    /// Of the contour's length, in squared image units (0 to 1) times the paper's unit of length;
    /// 0 to 10. A disc of contrast c as small as a radius of `2 mu / c^2` is smoothed away.
    pub mu: f32,
    /// Of the variance inside; above 0, at most 10. Four phases weigh alike, as do these at 1.
    pub lambda1: f32,
    /// Of the variance outside; above 0, at most 10.
    pub lambda2: f32,
}

/// Which form of the averages in `DFgk` and `SLgk` is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurvatureForm {
    /// With `- v` in every average: the form that approximates the equation.
    Consistent,
    /// As printed, without `- v`: to check that the printed form never settles.
    Printed,
}

/// When the front counts as stopped. Both sum |v(n+1) - v(n)| over `|v(n)| <= eps_front`, times dx^2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The sum is at most `eps` (`critarr`).
    Paper,
    /// The sum per unit of time is at most `eps`, and no pixel of it changed sign.
    Rate,
}

/// Where the front starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// At the frame's border: the centred `u0`, two pixels inside.
    Frame,
    /// Near the objects: `margin` pixels outside the level set of the filtered image at the tau of
    /// `r3`, or at Otsu's threshold of the filtered image where the rescaling has no tau.
    Threshold {
        /// 1 to 100 pixels.
        margin: f32,
    },
    /// From the values the caller has put into the front plane, in the front's unit.
    Given,
}

/// Which way the front moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// It shrinks onto what it encloses: what it leaves is the objects.
    Inward,
    /// It grows from where it starts until edges hold it: what it has enclosed is the objects.
    Outward,
}

/// Which pixels touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connectivity {
    /// Edges only.
    Four,
    /// Edges and corners.
    Eight,
}

impl Connectivity {
    /// Neighbours of a pixel that touch it, the first of [`crate::plane::grid::Grid::neighbours`].
    pub const fn neighbours(self) -> usize {
        match self {
            Connectivity::Four => 4,
            Connectivity::Eight => 8,
        }
    }
}

/// Everything a run depends on. Lengths are in the paper's unit, in which a pixel measures `dx`.
///
/// ```
/// use skyfront_core::config::Config;
///
/// let config = Config { min_area: 9, ..Config::NOISE_AWARE };
/// assert!(config.validate_values().is_ok());
/// let broken = Config { min_area: 0, ..config };
/// assert!(broken.validate_values().expect_err("a bound").to_string().contains("min-area"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// How sky and noise are known; with them the run is on signal-to-noise.
    pub sky: Background,
    /// A pixel that stands alone by more than this many noise units is a hot pixel or a cosmic ray, and the median of its
    /// neighbours takes its place; 0 leaves all. 0 to 10^6.
    pub spike_height: f32,
    /// Step 1.
    pub normalize: Normalize,
    /// Step 2.
    pub rescale: Rescale,
    /// Step 3.
    pub filter: Filter,
    /// Number of filter steps, 0 to 1000.
    pub filter_steps: u16,
    /// Time step of the filter, at most `dx^2 / 4`.
    pub filter_dt: f32,
    /// Which of steps 2 and 3 comes first.
    pub order: Order,
    /// Step 4.
    pub edge: Edge,
    /// Step 5.
    pub scheme: Scheme,
    /// Weight of the curvature, 0 to 1.
    pub nu: f32,
    /// Weights of the energy of [`Scheme::ChanVese`] and [`Scheme::Multiphase`].
    pub chan_vese: ChanVese,
    /// Form of the curvature averages.
    pub curvature_form: CurvatureForm,
    /// The flat case of the curvature schemes begins at `|grad u| <= degenerate * dx^degenerate_power`.
    pub degenerate: f32,
    /// The power of dx there, 0 to 8.
    pub degenerate_power: u16,
    /// Directions of the semi-Lagrangian minimum: 16 or 64.
    pub directions: u8,
    /// Width of a pixel.
    pub dx: f32,
    /// Time step of the front.
    pub dt: f32,
    /// The front is given up at this time; `t_max / dt` is at most 100 000 steps.
    pub t_max: f32,
    /// Pixels with `|u|` up to here are near the front.
    pub eps_front: f32,
    /// Tolerance of the stopping rule.
    pub eps: f32,
    /// The stopping rule.
    pub stop: Stop,
    /// Where the front starts.
    pub start: Start,
    /// Which way it moves; outward from [`Start::Given`].
    pub motion: Motion,
    /// The front is held in pixels and saturated to this half-width, or `None` for the paper's `u0`.
    pub band: Option<f32>,
    /// The outline of a run on signal-to-noise.
    pub outline: Outline,
    /// How outlined pixels become sources.
    pub separate: Separate,
    /// When the parts of a blend are sources of their own.
    pub deblending: Deblending,
    /// Which pixels of a source touch.
    pub connectivity: Connectivity,
    /// Which sources are kept.
    pub select: Select,
    /// Smaller sources are dropped; pixels, at least 1.
    pub min_area: u32,
    /// What noise alone would not make.
    pub significance: Significance,
}

/// The largest number of steps a front may take.
pub const MAX_STEPS: u32 = 100_000;

impl Config {
    /// Test 1 of the paper at its best: `r3` with beta = 8, heat filter, `g2mod`, `DFg`.
    pub const PAPER_F160: Config = Config {
        sky: Background::None,
        spike_height: 5.0,
        normalize: Normalize::MinMax,
        rescale: Rescale::R3 { beta: 8, tau: Tau::Otsu },
        filter: Filter::Heat,
        filter_steps: 5,
        filter_dt: 1e-4,
        order: Order::RescaleFirst,
        edge: Edge::G2Mod { c2: 0.8 },
        scheme: Scheme::Fd,
        nu: 1e-4,
        chan_vese: ChanVese { mu: 0.005, lambda1: 1.0, lambda2: 1.0 },
        curvature_form: CurvatureForm::Consistent,
        degenerate: 0.1,
        degenerate_power: 1,
        directions: 16,
        dx: 0.1,
        dt: 0.025,
        t_max: 50.0,
        eps_front: 0.1,
        eps: 1e-3,
        stop: Stop::Paper,
        start: Start::Frame,
        motion: Motion::Inward,
        band: None,
        outline: Outline::DEFAULT,
        separate: Separate::Components,
        deblending: Deblending::DEFAULT,
        connectivity: Connectivity::Eight,
        select: Select::Area,
        min_area: 1,
        significance: Significance::DEFAULT,
    };

    /// The default: signal-to-noise outlined by a front from the threshold, divided by the tree of
    /// level sets, and kept by its significance; one setting for every kind of sky.
    pub const NOISE_AWARE: Config = Config { scheme: Scheme::Region, ..Config::RSA };

    /// The default for frames of stars that a tracker is to recognise: those that stand out well, their light
    /// not drawn aside by what is faint around them, without steps that only faint and wide sources need.
    pub const STAR_TRACKER: Config = Config {
        filter: Filter::Gauss,
        outline: Outline { threshold: 2.0, steps: 0, ..Outline::DEFAULT },
        ..Config::NOISE_AWARE
    };

    /// The paper's front with what the default knows: its sky, its filter, its separation and its
    /// selection.
    pub const RSA: Config = Config {
        sky: Background::Mesh { size: 64 },
        normalize: Normalize::Noise { below: 3.0, above: 30.0 },
        rescale: Rescale::R3 { beta: 8, tau: Tau::Noise { k: 3.0 } },
        filter: Filter::Adaptive,
        start: Start::Threshold { margin: 1.0 },
        separate: Separate::Tree,
        select: Select::Significance,
        min_area: 6,
        ..Config::PAPER_F160
    };

    /// Test 2 of the paper at its best: `r1`, then Perona-Malik (longer), `g2mod`, `DFg`. The other
    /// figures of that test filter by the heat equation, before they rescale.
    pub const PAPER_REAL: Config = Config {
        rescale: Rescale::R1 { alpha: 0.25 },
        filter: Filter::PeronaMalik { diffusivity: Diffusivity::F2, mu: 30.0 },
        filter_steps: 15,
        filter_dt: 1e-3,
        edge: Edge::G2Mod { c2: 0.78 },
        ..Config::PAPER_F160
    };

    /// Active contours without edges for real images: pixels in units of the noise, those above
    /// 3 of them lifted by `r3`, and a contour that two noisy pixels are not worth.
    pub const CHAN_VESE: Config = Config {
        normalize: Normalize::Noise { below: 3.0, above: 30.0 },
        rescale: Rescale::R3 { beta: 8, tau: Tau::Noise { k: 3.0 } },
        scheme: Scheme::ChanVese,
        chan_vese: ChanVese { mu: 0.015, lambda1: 1.0, lambda2: 1.0 },
        dt: 8.0,
        t_max: 1600.0,
        start: Start::Threshold { margin: 1.0 },
        min_area: 5,
        ..Config::PAPER_F160
    };

    /// The same run with another scheme at its usual time step. Chan and Vese's regions start near
    /// the objects, where their means differ, and get time for 200 steps.
    pub fn with_scheme(self, scheme: Scheme) -> Config {
        let config = Config { scheme, dt: scheme.usual_dt(self.dx), ..self };
        match (scheme.is_by_regions(), self.start) {
            (true, Start::Frame) if !scheme.has_two_fronts() => {
                Config { start: Start::Threshold { margin: 1.0 }, t_max: 200.0 * config.dt, ..config }
            }
            (true, _) => Config { t_max: 200.0 * config.dt, ..config },
            _ => config,
        }
    }

    /// The CRC-32 of all parameters: what a snapshot knows its configuration by.
    pub fn digest(&self) -> u32 {
        let mut digest = Digest::default();
        table::feed(self, &mut digest);
        digest.value()
    }

    /// The threshold of `r3` before any rule has looked at the image: the given value, else 0.
    pub fn given_tau(&self) -> f32 {
        match self.rescale {
            Rescale::R3 { tau: Tau::Value(tau), .. } => tau,
            _ => 0.0,
        }
    }

    /// The same run with time for a front to cross a frame from its border: at least 5/3 of the
    /// shorter side, the share of the paper's 50 of its 300 pixels, as far as [`MAX_STEPS`] go.
    /// A front that starts near the objects has no frame to cross.
    pub fn with_time_for(self, width: usize, height: usize) -> Config {
        if !self.crosses_frame() {
            return self;
        }
        let way = width.min(height) as f32 * (5.0 / 3.0) * self.dx;
        let most = self.dt * MAX_STEPS as f32;
        let way = if way > most { most } else { way };
        Config { t_max: if way > self.t_max { way } else { self.t_max }, ..self }
    }

    /// Whether a run on signal-to-noise has steps of a [`Segmenter`](crate::run::segmenter::Segmenter): a
    /// front of the paper, or a filter in steps before the region's own.
    pub fn needs_segmenter(&self) -> bool {
        self.scheme != Scheme::Region || self.filter.is_stepped()
    }

    /// Whether the front has to come from the frame's border.
    fn crosses_frame(&self) -> bool {
        self.start == Start::Frame && self.scheme != Scheme::Region && !self.scheme.is_by_regions()
    }

    /// So many pixels from the border begins what no front can reach by `t_max`, whose speed is 1
    /// at most; two more for the width of its profile. `None` where it does not come from there.
    pub(crate) fn beyond_reach(&self) -> Option<usize> {
        self.crosses_frame().then_some((self.farthest() + 3.5) as usize + 1)
    }

    /// `t_max` in pixels of free motion.
    pub fn farthest(&self) -> f32 {
        self.t_max / self.dx
    }

    /// The most steps the front can take: `t_max / dt`, rounded up.
    pub fn max_steps(&self) -> u32 {
        let steps = self.t_max / self.dt;
        let whole = steps as u32;
        // A quotient a rounding error above a whole number is that number.
        if steps - whole as f32 > 1e-3 { whole.saturating_add(1) } else { whole }
    }
}
