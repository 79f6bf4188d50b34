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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    const PAPER: Config =
        Config { dx: 0.1, dt: 0.02, eps: 1e-3, eps_front: 0.5, stop: Stop::Paper, ..Config::PAPER_F160 };

    fn changed(rule: &StopRule<F32>, old: &[f32], new: &[f32]) -> Change<F32> {
        let mut change = Change::none(rule);
        change.observe(old, new);
        change
    }

    #[test]
    fn the_norm_is_that_near_the_front_times_the_area_of_a_pixel() {
        for unit in [1.0, 10.0] {
            let rule = StopRule::<F32>::new(&PAPER, unit);
            // The last two lie farther from the front than 0.5.
            let old = [0.5, -0.4, 0.1, 0.6, -0.6].map(|v: f32| v * unit);
            let new = [0.49, -0.4, 0.06, 0.59, -0.59].map(|v: f32| v * unit);
            let norm = rule.norm(&changed(&rule, &old, &new));
            assert!((norm - 0.01 * 0.05).abs() < 1e-7, "{norm}");
        }
    }

    #[test]
    fn a_front_rests_from_eps_on() {
        let rule = StopRule::<F32>::new(&PAPER, 1.0);
        // A sum of 0.1 is a norm of 0.001.
        assert!(rule.at_rest(&changed(&rule, &[0.2], &[0.1001])) && !rule.at_rest(&changed(&rule, &[0.2], &[0.0999])));
        assert!(rule.at_rest(&changed(&rule, &[0.05], &[-0.04])), "crossings do not count");
        let per_time = StopRule::<F32>::new(&Config { stop: Stop::Rate, ..PAPER }, 1.0);
        let rests = |old: f32, new: f32| per_time.at_rest(&changed(&per_time, &[old], &[new]));
        assert!(rests(0.2, 0.1981) && !rests(0.2, 0.1979));
        assert!(rests(-0.001, 0.0) && !rests(0.0, 0.001) && !rests(0.001, 0.0) && rests(0.6, -0.6));
    }

    #[test]
    fn parts_of_a_step_add_up() {
        let rule = StopRule::<F32>::new(&Config { stop: Stop::Rate, ..PAPER }, 1.0);
        let (old, new) = ([0.5, -0.25, 0.125, 0.25], [0.25, 0.25, -0.125, 0.25]);
        let whole = changed(&rule, &old, &new);
        let mut parts = changed(&rule, &old[..1], &new[..1]);
        parts.merge(&changed(&rule, &old[1..], &new[1..]));
        assert_eq!((whole, whole.crossings), (parts, 2));
        // What is near by another rule is another change.
        let none = |config: Config| Change::none(&StopRule::<F32>::new(&config, 1.0));
        assert_ne!(none(PAPER), none(Config { stop: Stop::Rate, ..PAPER }));
        assert_ne!(none(PAPER), none(Config { eps_front: 0.4, ..PAPER }));
    }

    #[test]
    fn two_fronts_in_a_plane_change_as_one_does() {
        let rule =
            StopRule::<F32>::new(&Config { stop: Stop::Rate, scheme: crate::config::Scheme::Multiphase, ..PAPER }, 1.0);
        let mut change = Change::none(&rule);
        change.observe_pairs(&[pair::cell([0.5, -0.25])], &[pair::cell([0.25, 0.25])]);
        assert!((rule.norm(&change) - 0.01 * 0.75).abs() < 1e-7 && change.crossings == 1, "{change:?}");
    }
}
