//! When the front has stopped (`critarr`).

use crate::arithmetic::vectors::COLUMNS;
use crate::arithmetic::vectors::Vectors;
use crate::arithmetic::{Arithmetic, Real};
use crate::config::{Config, Stop};
use crate::front::pair;
use crate::front::region::Moments;
use crate::plane::sweep::RowOf;

/// What one step changed near the front. Parts of a step add up in any order to the same value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change<A: Arithmetic> {
    /// Sum of `|v(n+1) - v(n)|` near the front, in [`Arithmetic::CHANGE_UNITS`].
    pub sum: u64,
    /// Pixels near the front that crossed zero; counted only for the rule per unit time.
    pub crossings: u32,
    /// What it changed in the sums of regions; nothing but the schemes by regions has any.
    pub regions: Moments,
    near: Near<A>,
}

/// Which pixels are near the front, and whether crossings are wanted.
#[derive(Clone, Copy, Debug)]
struct Near<A: Arithmetic> {
    limit: A::Real,
    count_crossings: bool,
}

impl<A: Arithmetic> PartialEq for Near<A> {
    fn eq(&self, other: &Self) -> bool {
        self.limit == other.limit && self.count_crossings == other.count_crossings
    }
}

impl<A: Arithmetic> Eq for Near<A> {}

impl<A: Arithmetic> Change<A> {
    /// Nothing yet, for the rule of a configuration.
    pub fn none(rule: &StopRule<A>) -> Self {
        let near = Near { limit: rule.near, count_crossings: rule.stop == Stop::Rate };
        Change { sum: 0, crossings: 0, regions: Moments::default(), near }
    }

    /// Takes in a row, or a piece of one, before and after the step.
    #[inline(always)]
    pub fn observe(&mut self, old: &[A::Cell], new: &[A::Cell]) {
        self.sum = self.sum.saturating_add(A::change(old, new, self.near.limit));
        if self.near.count_crossings {
            self.cross(old, new);
        }
    }

    /// The same of two fronts in the plane of one.
    #[inline(always)]
    pub fn observe_pairs(&mut self, old: &[A::Cell], new: &[A::Cell]) {
        let (steps, crossings) = pair::change(old, new);
        let units = (A::CHANGE_UNITS * (1.0 / pair::UNIT as f32)) as u64;
        self.sum = self.sum.saturating_add(steps.saturating_mul(units));
        if self.near.count_crossings {
            self.crossings = self.crossings.saturating_add(crossings);
        }
    }

    /// [`Self::observe`] on vector units.
    #[inline(always)]
    pub fn observe_on_vectors(&mut self, vectors: A::Vectors, old: RowOf<A>, new: RowOf<A>) {
        self.sum = self.sum.saturating_add(vectors.change(old, new, self.near.limit));
        if self.near.count_crossings {
            let mut cells = [[A::Cell::default(); COLUMNS]; 2];
            let [before, after] = &mut cells;
            vectors.store(old, before);
            vectors.store(new, after);
            self.cross(before, after);
        }
    }

    /// Counts the pixels that cross zero.
    #[inline(always)]
    fn cross(&mut self, old: &[A::Cell], new: &[A::Cell]) {
        let crossed = old.iter().zip(new).filter(|&(&v, &w)| {
            let v = A::level(v);
            v.magnitude() <= self.near.limit && (v > A::Real::ZERO) != (A::level(w) > A::Real::ZERO)
        });
        self.crossings = self.crossings.saturating_add(crossed.count() as u32);
    }

    /// Adds what another part of the same step changed.
    pub fn merge(&mut self, other: &Self) {
        self.sum = self.sum.saturating_add(other.sum);
        self.crossings = self.crossings.saturating_add(other.crossings);
        self.regions.merge(&other.regions);
    }
}

/// A stopping rule with its constants in units of the front plane.
#[derive(Clone, Copy, Debug)]
pub struct StopRule<A: Arithmetic> {
    stop: Stop,
    near: A::Real,
    /// The greatest sum of a front at rest.
    rest: u64,
    /// `dx^2` over the units of the sum: what makes the sum the paper's norm.
    scale: f32,
}

impl<A: Arithmetic> StopRule<A> {
    /// The rule of a configuration, for a front plane with `unit` units to the paper's one.
    pub fn new(config: &Config, unit: f32) -> Self {
        let scale = config.dx * config.dx / (unit * A::CHANGE_UNITS);
        let eps = match config.stop {
            Stop::Paper => config.eps,
            Stop::Rate => config.eps * config.dt,
        };
        // Every pixel takes part in the means of Chan and Vese.
        let near = if config.scheme.is_by_regions() { 1.0 } else { config.eps_front * unit };
        StopRule { stop: config.stop, near: A::Real::of(near), rest: (eps / scale) as u64, scale }
    }

    /// Whether a step that changed this much was the last.
    pub fn at_rest(&self, change: &Change<A>) -> bool {
        change.sum <= self.rest && (self.stop == Stop::Paper || change.crossings == 0)
    }

    /// The paper's norm of a change: `dx^2` times the sum.
    pub fn norm(&self, change: &Change<A>) -> f32 {
        change.sum as f32 * self.scale
    }
}
