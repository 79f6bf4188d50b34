//! The bounds of every parameter of a run.

use super::{ChanVese, Config, Edge, Filter, MAX_STEPS, Normalize, Rescale, Scheme, Start, Tau};
use crate::arithmetic::{Arithmetic, Cell};
use crate::error::Error;

/// Rounding slack of the bounds that the paper's own values meet with equality.
const SLACK: f32 = 1.000_001;

impl Config {
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
        at_most("nu", self.nu, self.greatest_nu())?;
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

    /// The bound on `nu`. A step of SL with curvature takes `nu v` off a value, and the least value
    /// on the ball, `dt / dx` pixels away at most, holds no more of the old v than that interpolant
    /// does: `1 - dt/dx` along an axis, `(1 - dt/(dx sqrt 2))^2` along a diagonal. Up to there no
    /// value falls below all others. At the paper's `dt = dx` nothing of v is left; but as a step
    /// then adds at most `nu` of their range to it, it is at most e times as wide after a run with
    /// `nu` up to one over its steps.
    fn greatest_nu(&self) -> f32 {
        if self.scheme != Scheme::SlCurvature {
            return 1.0;
        }
        let reach = self.dt / self.dx;
        let (axis, diagonal) = (1.0 - reach, 1.0 - reach * core::f32::consts::FRAC_1_SQRT_2);
        let centre = axis.min(diagonal * diagonal);
        centre.max(1.0 / self.max_steps().max(1) as f32).min(1.0) * SLACK
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
