//! What a run is to do: immutable, validated once, with the paper's values as defaults.

use crate::arithmetic::{Arithmetic, Cell};
use crate::detection::Detection;
use crate::error::Error;

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
    /// By sky and noise of the frame ([`crate::noise`]), clipped: neither a hot pixel nor a bright
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
    /// The greatest entropy of Kapur, Sahoo and Wong ([`crate::kapur`]).
    Kapur,
    /// Rosin's corner of a histogram with one peak ([`crate::rosin`]).
    Rosin,
    /// Sky plus `k` standard deviations of the noise ([`crate::noise`]), within [0, 1].
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

/// Step 3: the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// None.
    None,
    /// The heat equation (`schemacal`).
    Heat,
    /// Perona-Malik (`eq:PM`, doi:10.1109/34.56205).
    PeronaMalik {
        /// The diffusion coefficient.
        diffusivity: Diffusivity,
        /// The gradient at which diffusion falls off, in image units (0 to 1) per `dx`.
        mu: f32,
    },
}

/// The diffusion coefficient of Perona-Malik, with `s = |grad I| / mu`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Diffusivity {
    /// `1 / (1 + s^2)`.
    F1,
    /// `exp(-s^2)`.
    F2,
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

/// Step 5: the scheme that moves the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Finite differences, first order (`DFg`).
    Fd,
    /// Finite differences with curvature (`DFgk`).
    FdCurvature,
    /// Finite differences of second order, filtered ([`crate::scheme::FdFiltered`]).
    FdFiltered,
    /// Semi-Lagrangian (`SLg`).
    Sl,
    /// Semi-Lagrangian with curvature (`SLgk`).
    SlCurvature,
    /// Active contours without edges ([`crate::scheme::ChanVese`]), by the regions of the filtered
    /// image; the edge detector has no meaning there.
    ChanVese,
    /// The first-order equation by arrival times, in one pass (see [`crate::march`]): the front at
    /// `t_max`. The time step has no meaning there.
    FastMarching,
}

/// The weights of Chan and Vese's energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChanVese {
    /// Of the contour's length, in squared image units (0 to 1) times the paper's unit of length;
    /// 0 to 10. A disc of contrast c as small as a radius of `2 mu / c^2` is smoothed away.
    pub mu: f32,
    /// Of the variance inside; above 0, at most 10.
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

/// Which pixels touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connectivity {
    /// Edges only.
    Four,
    /// Edges and corners.
    Eight,
}

/// Everything a run depends on. Lengths are in the paper's unit, in which a pixel measures `dx`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
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
    /// Weights of the energy of [`Scheme::ChanVese`].
    pub chan_vese: ChanVese,
    /// Form of the curvature averages.
    pub curvature_form: CurvatureForm,
    /// The flat case of the curvature schemes begins at `|grad u| <= degenerate * dx`.
    pub degenerate: f32,
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
    /// The front is held in pixels and saturated to this half-width, or `None` for the paper's `u0`.
    pub band: Option<f32>,
    /// Which pixels of a source touch.
    pub connectivity: Connectivity,
    /// Smaller components are dropped; pixels, at least 1.
    pub min_area: u32,
    /// The noise-aware segmentation of [`crate::detect::detect`] in place of steps 1 to 6,
    /// or `None` for those steps, which are all that [`crate::segmenter::Segmenter`] does.
    pub detection: Option<Detection>,
}

/// The largest number of steps a front may take.
pub const MAX_STEPS: u32 = 100_000;

/// Rounding slack of the bounds that the paper's own values meet with equality.
const SLACK: f32 = 1.000_001;

impl Config {
    /// Test 1 of the paper at its best: `r3` with beta = 8, heat filter, `g2mod`, `DFg`.
    pub const PAPER_F160: Config = Config {
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
        directions: 16,
        dx: 0.1,
        dt: 0.025,
        t_max: 50.0,
        eps_front: 0.1,
        eps: 1e-3,
        stop: Stop::Paper,
        start: Start::Frame,
        band: None,
        connectivity: Connectivity::Eight,
        min_area: 1,
        detection: None,
    };

    /// The default: sources by their significance, one setting for every kind of sky.
    pub const NOISE_AWARE: Config =
        Config { detection: Some(Detection::DEFAULT), min_area: Detection::DEFAULT.min_area, ..Config::PAPER_F160 };

    /// Test 2 of the paper at its best: filter first (Perona-Malik, longer), `r1`, `g2mod`, `DFg`.
    pub const PAPER_REAL: Config = Config {
        rescale: Rescale::R1 { alpha: 0.25 },
        filter: Filter::PeronaMalik { diffusivity: Diffusivity::F2, mu: 30.0 },
        filter_steps: 15,
        filter_dt: 1e-3,
        order: Order::FilterFirst,
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

    /// The paper's time step for a scheme: dx/4, dx^2 with curvature, dx for semi-Lagrangian. Ours
    /// for Chan and Vese, in which one step moves a pixel of contrast 0.5 across the band.
    pub fn paper_dt(scheme: Scheme, dx: f32) -> f32 {
        match scheme {
            Scheme::Fd | Scheme::FdFiltered | Scheme::FastMarching => dx / 4.0,
            Scheme::FdCurvature => dx * dx,
            Scheme::Sl | Scheme::SlCurvature => dx,
            Scheme::ChanVese => 8.0,
        }
    }

    /// The same run with another scheme at the paper's time step for it. Chan and Vese's regions
    /// start near the objects, where their means differ, and get time for 200 steps.
    pub fn with_scheme(self, scheme: Scheme) -> Config {
        let config = Config { scheme, dt: Config::paper_dt(scheme, self.dx), ..self };
        match (scheme, self.start) {
            (Scheme::ChanVese, Start::Frame) => {
                Config { start: Start::Threshold { margin: 1.0 }, t_max: 200.0 * config.dt, ..config }
            }
            (Scheme::ChanVese, _) => Config { t_max: 200.0 * config.dt, ..config },
            _ => config,
        }
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

    /// Checks every parameter for arithmetic `A`.
    ///
    /// # Errors
    /// [`Error::Parameter`] names the first parameter that is out of bounds, or
    /// [`Error::Arithmetic`] what `A` cannot do.
    pub fn validate<A: Arithmetic>(&self) -> Result<(), Error> {
        self.validate_image_steps()?;
        self.validate_front()?;
        self.validate_range(A::NAME, A::LIMIT)?;
        self.validate_curvature(A::NAME, A::LEAST_CURVATURE)?;
        if self.scheme == Scheme::FastMarching && A::Cell::BYTES < 4 {
            return Err(Error::Arithmetic {
                name: A::NAME,
                reason: "fast marching needs front cells of 32 bits, for times and links",
            });
        }
        if A::NEEDS_BAND.is_some_and(|most| self.band.is_none_or(|band| band > most)) {
            return Err(Error::Arithmetic {
                name: A::NAME,
                reason: "its narrow front cells need a band of at most 8 pixels",
            });
        }
        Ok(())
    }

    fn validate_image_steps(&self) -> Result<(), Error> {
        above("dx", self.dx, 0.0)?;
        at_most("dx", self.dx, 1e3)?;
        if let Normalize::Percentile { low, high } = self.normalize {
            at_least("low percentile", low, 0.0)?;
            at_most("high percentile", high, 100.0)?;
            above("high percentile", high, low)?;
        }
        if let Normalize::Noise { below, above: bright } = self.normalize {
            at_least("noise units below the sky", below, 0.0)?;
            at_most("noise units below the sky", below, 1e6)?;
            above("noise units above the sky", bright, 0.0)?;
            at_most("noise units above the sky", bright, 1e6)?;
        }
        match self.rescale {
            Rescale::None => {}
            Rescale::R1 { alpha } | Rescale::R2 { alpha } => {
                above("alpha", alpha, 0.0)?;
                below("alpha", alpha, 1.0)?;
            }
            Rescale::R3 { beta, tau } => {
                at_least("beta", f32::from(beta), 1.0)?;
                match tau {
                    Tau::Value(tau) => {
                        above("tau", tau, 0.0)?;
                        below("tau", tau, 1.0)?;
                    }
                    Tau::Noise { k } => {
                        above("noise units of tau", k, 0.0)?;
                        at_most("noise units of tau", k, 1e3)?;
                    }
                    Tau::Otsu | Tau::Kapur | Tau::Rosin => {}
                }
            }
        }
        at_most("filter steps", f32::from(self.filter_steps), 1000.0)?;
        above("filter time step", self.filter_dt, 0.0)?;
        at_most("filter time step", self.filter_dt, self.dx * self.dx / 4.0 * SLACK)?;
        if let Filter::PeronaMalik { mu, .. } = self.filter {
            above("mu", mu, 0.0)?;
            at_most("mu", mu, 1e6)?;
        }
        match self.edge {
            Edge::G1 { p } => {
                at_least("p", p, 1.0)?;
                at_most("p", p, 1e6)
            }
            Edge::G2 => Ok(()),
            Edge::G2Mod { c2 } => {
                at_least("c2", c2, 0.0)?;
                below("c2", c2, 1.0)
            }
        }
    }

    /// Fixed point saturates: the coefficients that may be large must be inside its range.
    fn validate_range(&self, name: &'static str, limit: f32) -> Result<(), Error> {
        let out_of_range = |reason| Err(Error::Arithmetic { name, reason });
        if let Filter::PeronaMalik { mu, .. } = self.filter
            && 1.0 / (self.dx * mu) >= limit
        {
            return out_of_range("1 / (dx mu) must be below 128, the end of its range");
        }
        if matches!(self.edge, Edge::G1 { .. }) && 0.5 / self.dx >= limit {
            return out_of_range("g1 needs a dx above 1/256: 1 / (2 dx) must be below 128, the end of its range");
        }
        if self.scheme == Scheme::ChanVese {
            let ChanVese { mu, lambda1, lambda2 } = self.chan_vese;
            let weights = self.dt * (lambda1 + lambda2);
            // The squares around a pixel weigh at most 4 / degenerate together, twice.
            let divisor = 1.0 + 8.0 * self.dt * mu / (self.dx * self.degenerate);
            if weights >= limit || divisor >= limit || 1.0 / self.degenerate >= limit {
                return out_of_range(
                    "dt (lambda1 + lambda2), 1 / degenerate and 1 + 8 dt mu / (dx degenerate) must be below 128, \
                     the end of its range",
                );
            }
        }
        if self.band.is_some_and(|band| band >= limit) {
            return out_of_range("the band must be below 128 pixels, the end of its range");
        }
        Ok(())
    }

    fn validate_curvature(&self, name: &'static str, least: f32) -> Result<(), Error> {
        let bends = matches!(self.scheme, Scheme::FdCurvature | Scheme::SlCurvature);
        if bends && self.nu * self.dt / (self.dx * self.dx) < least {
            let reason = "its narrow front cells would round away so weak a curvature: \
                          nu dt / dx^2 must be at least 1/256";
            return Err(Error::Arithmetic { name, reason });
        }
        Ok(())
    }

    fn validate_front(&self) -> Result<(), Error> {
        at_least("nu", self.nu, 0.0)?;
        at_most("nu", self.nu, 1.0)?;
        above("time step", self.dt, 0.0)?;
        at_most("time step", self.dt, self.longest_step())?;
        let ChanVese { mu, lambda1, lambda2 } = self.chan_vese;
        at_least("mu", mu, 0.0)?;
        at_most("mu", mu, 10.0)?;
        for (name, weight) in [("lambda1", lambda1), ("lambda2", lambda2)] {
            above(name, weight, 0.0)?;
            at_most(name, weight, 10.0)?;
        }
        above("degenerate", self.degenerate, 0.0)?;
        at_most("degenerate", self.degenerate, 1e3)?;
        if self.directions != 16 && self.directions != 64 {
            return Err(parameter("directions", f32::from(self.directions), "16 or", 64.0));
        }
        above("t_max", self.t_max, 0.0)?;
        at_most("t_max", self.t_max, self.dt * MAX_STEPS as f32)?;
        above("eps_front", self.eps_front, 0.0)?;
        at_most("eps_front", self.eps_front, 1e6)?;
        above("eps", self.eps, 0.0)?;
        at_most("eps", self.eps, 1e6)?;
        if let Some(band) = self.band {
            at_least("band", band, 2.0)?;
            at_most("band", band, 1e4)?;
        }
        if let Start::Threshold { margin } = self.start {
            at_least("margin", margin, 1.0)?;
            at_most("margin", margin, 100.0)?;
        }
        at_least("min_area", self.min_area as f32, 1.0)
    }

    /// The bound on `dt` (CFL): 1/2 of a pixel a step for FD, 2/5 for the filtered FD, 1 for SL; the look along the contour,
    /// `sqrt(2 dt)`, within five pixels. None for Chan and Vese, whose step is implicit in the centre.
    ///
    /// FD with curvature must not overshoot: the weight of the old value v in the new one stays
    /// above 0. The four one-sided differences fall by `s = (a + |b| + c + |d|) / sqrt(a^2 + b^2 +
    /// c^2 + d^2) <= 2` times what v rises by, and Lambda by `2 (n_x^2 + n_y^2) = 2`, n being the
    /// unit normal, so that with g <= 1 the weight is at least `1 - 2 dt/dx - 2 nu dt/dx^2`. For
    /// nu = 0 that is the bound of FD, for small dx that of the explicit curvature.
    fn longest_step(&self) -> f32 {
        let longest = match self.scheme {
            Scheme::Fd | Scheme::FastMarching => self.dx / 2.0,
            Scheme::FdFiltered => self.dx * 0.4,
            Scheme::FdCurvature => self.dx * self.dx / (2.0 * (self.dx + self.nu)),
            Scheme::Sl => self.dx,
            Scheme::SlCurvature => self.dx.min(12.5 * self.dx * self.dx),
            // Stable for any step; a longer one would not be a faster one.
            Scheme::ChanVese => 1e3,
        };
        longest * SLACK
    }
}

fn parameter(name: &'static str, value: f32, bound: &'static str, limit: f32) -> Error {
    Error::Parameter { name, value, bound, limit }
}

// Each comparison is written so that a NaN fails it.

fn above(name: &'static str, value: f32, limit: f32) -> Result<(), Error> {
    if value > limit { Ok(()) } else { Err(parameter(name, value, "above", limit)) }
}

fn below(name: &'static str, value: f32, limit: f32) -> Result<(), Error> {
    if value < limit { Ok(()) } else { Err(parameter(name, value, "below", limit)) }
}

fn at_least(name: &'static str, value: f32, limit: f32) -> Result<(), Error> {
    if value >= limit { Ok(()) } else { Err(parameter(name, value, "at least", limit)) }
}

fn at_most(name: &'static str, value: f32, limit: f32) -> Result<(), Error> {
    if value <= limit { Ok(()) } else { Err(parameter(name, value, "at most", limit)) }
}
