//! What a configuration must fulfil: the bounds of its parameters, and what an arithmetic can do.

use super::{ChanVese, Config, Edge, Filter, Motion, Scheme, Select, Separate, Start, table};
use crate::arithmetic::{Arithmetic, Cell};
use crate::error::Error;

impl Config {
    /// Checks every parameter for arithmetic `A`.
    ///
    /// # Errors
    /// [`Error::Parameter`] names the first parameter that is out of bounds, or
    /// [`Error::Arithmetic`] what `A` cannot do.
    pub fn validate<A: Arithmetic>(&self) -> Result<(), Error> {
        self.validate_values()?;
        if self.sky.is_known() && A::Cell::BYTES < 4 {
            return Err(Error::Arithmetic {
                name: A::NAME,
                reason: "signal-to-noise, from a fraction of the noise to bright stars, needs cells of 32 bits; without \
                         a sky it runs in 16",
            });
        }
        self.validate_range(A::NAME, A::LIMIT, A::Cell::BYTES)?;
        self.validate_curvature(A::NAME, A::LEAST_CURVATURE)?;
        if self.scheme == Scheme::FastMarching && A::Cell::BYTES < 4 {
            return Err(Error::Arithmetic {
                name: A::NAME,
                reason: "fast marching needs front cells of 32 bits, for times and links",
            });
        }
        if self.scheme.has_two_fronts() && A::Cell::BYTES < 4 {
            return Err(Error::Arithmetic {
                name: A::NAME,
                reason: "four phases need front cells of 32 bits, for two fronts of 16 bits each",
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

    /// Checks every parameter for what all arithmetics can do.
    ///
    /// # Errors
    /// [`Error::Parameter`] names the first parameter that is out of bounds, [`Error::Together`] two
    /// choices that cannot go together.
    pub fn validate_values(&self) -> Result<(), Error> {
        table::check(self)?;
        if self.directions != 16 && self.directions != 64 {
            let value = f32::from(self.directions);
            return Err(Error::Parameter { name: "directions", value, bound: "16 or", limit: 64.0 });
        }
        self.validate_together()
    }

    /// What needs signal-to-noise needs a sky.
    fn validate_together(&self) -> Result<(), Error> {
        let apart = |choice, value, other, wanted| Err(Error::Together { choice, value, other, wanted });
        if !self.sky.is_known() {
            let on_signal = [
                (self.scheme == Scheme::Region, "scheme", "region"),
                (self.filter == Filter::Gauss, "filter", "gauss"),
                (self.filter == Filter::Adaptive, "filter", "adaptive"),
                (self.separate == Separate::Tree, "separate", "tree"),
                (self.select == Select::Significance, "select", "significance"),
            ];
            if let Some((_, choice, value)) = on_signal.into_iter().find(|(chosen, ..)| *chosen) {
                return apart(choice, value, "sky", "mesh or frame");
            }
        }
        if self.motion == Motion::Outward && self.start != Start::Given {
            return apart("motion", "outward", "start", "map");
        }
        if self.motion == Motion::Outward && (self.scheme == Scheme::Region || self.scheme.is_by_regions()) {
            return apart("motion", "outward", "scheme", "fd");
        }
        if self.filter.uses_front_plane() && self.start == Start::Given {
            return apart("filter", self.filter.name(), "start", "frame or threshold");
        }
        Ok(())
    }

    /// Fixed point saturates: the coefficients that may be large must be inside its range.
    fn validate_range(&self, name: &'static str, limit: f32, cell_bytes: usize) -> Result<(), Error> {
        let out_of_range = |reason| Err(Error::Arithmetic { name, reason });
        if let Some(reason) = self.filter.beyond(self.dx, limit, cell_bytes) {
            return out_of_range(reason);
        }
        if matches!(self.edge, Edge::G1 { .. }) && 0.5 / self.dx >= limit {
            return out_of_range("g1 needs a dx above 1/256: 1 / (2 dx) must be below 128, the end of its range");
        }
        if self.scheme.is_by_regions() {
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

    /// The bound on `nu`. A step of SL with curvature takes `nu v` off a value, and the least value
    /// on the ball, `dt / dx` pixels away at most, holds no more of the old v than that interpolant
    /// does: `1 - dt/dx` along an axis, `(1 - dt/(dx sqrt 2))^2` along a diagonal. Up to there no
    /// value falls below all others. At the paper's `dt = dx` nothing of v is left; but as a step
    /// then adds at most `nu` of their range to it, it is at most e times as wide after a run with
    /// `nu` up to one over its steps.
    pub(super) fn greatest_nu(&self) -> f32 {
        if self.scheme != Scheme::SlCurvature {
            return 1.0;
        }
        let reach = self.dt / self.dx;
        let (axis, diagonal) = (1.0 - reach, 1.0 - reach * core::f32::consts::FRAC_1_SQRT_2);
        let centre = axis.min(diagonal * diagonal);
        centre.max(1.0 / self.max_steps().max(1) as f32).min(1.0)
    }

    /// The bound on `dt` (CFL): 1/2 of a pixel a step for FD, 2/5 for the filtered FD, 1 for SL; the look along the contour,
    /// `sqrt(2 dt)`, within five pixels. None for Chan and Vese, whose step is implicit in the centre.
    ///
    /// FD with curvature must not overshoot: the weight of the old value v in the new one stays
    /// above 0. The four one-sided differences fall by `s = (a + |b| + c + |d|) / sqrt(a^2 + b^2 +
    /// c^2 + d^2) <= 2` times what v rises by, and Lambda by `2 (n_x^2 + n_y^2) = 2`, n being the
    /// unit normal, so that with g <= 1 the weight is at least `1 - 2 dt/dx - 2 nu dt/dx^2`. For
    /// nu = 0 that is the bound of FD, for small dx that of the explicit curvature.
    pub(super) fn longest_step(&self) -> f32 {
        match self.scheme {
            Scheme::Region | Scheme::Fd | Scheme::FastMarching => self.dx / 2.0,
            Scheme::FdFiltered => self.dx * 0.4,
            Scheme::FdCurvature => self.dx * self.dx / (2.0 * (self.dx + self.nu)),
            Scheme::Sl => self.dx,
            Scheme::SlCurvature => self.dx.min(12.5 * self.dx * self.dx),
            // Stable for any step; a longer one would not be a faster one.
            Scheme::ChanVese | Scheme::Multiphase => 1e3,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_front_grows_from_a_map_and_by_edges() {
        let grows = Config { motion: Motion::Outward, start: Start::Given, ..Config::PAPER_F160 };
        assert_eq!(grows.validate_values(), Ok(()));
        let apart = |other, wanted| Err(Error::Together { choice: "motion", value: "outward", other, wanted });
        assert_eq!(Config { start: Start::Frame, ..grows }.validate_values(), apart("start", "map"));
        let regions = Config { start: Start::Given, ..grows.with_scheme(Scheme::ChanVese) };
        assert_eq!(regions.validate_values(), apart("scheme", "fd"));
    }
}
