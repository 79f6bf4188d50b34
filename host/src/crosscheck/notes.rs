//! What was found of each step.

use crate::reference::Plane;

/// How far a step of the core is from the reference's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Name of the step.
    pub step: &'static str,
    /// Largest difference of a number.
    pub max: f64,
    /// The farthest that a number lies outside what the roundings inside the step explain.
    pub beyond: f64,
}

/// The steps so far, in the order in which they were looked at.
#[derive(Clone, Debug, Default)]
pub(super) struct Notes {
    /// One for each step.
    pub found: Vec<Difference>,
}

impl Notes {
    /// Notes how far `core` lies from the middle of two planes of the reference, and outside of them.
    pub fn plane(&mut self, step: &'static str, core: &Plane, low: &Plane, high: &Plane) {
        let bounds = low.values().iter().zip(high.values());
        for (&core, (&one, &other)) in core.values().iter().zip(bounds) {
            self.number(step, core, one.min(other), one.max(other));
        }
    }

    /// The same of a number.
    pub fn number(&mut self, step: &'static str, core: f64, low: f64, high: f64) {
        let max = (core - 0.5 * (low + high)).abs();
        let beyond = (low - core).max(core - high).max(0.0);
        // A number that is none is infinitely far off.
        if core.is_nan() { self.add(step, f64::INFINITY, f64::INFINITY) } else { self.add(step, max, beyond) }
    }

    /// So many things that are other than they should be.
    pub fn count(&mut self, step: &'static str, wrong: usize) {
        self.add(step, wrong as f64, wrong as f64);
    }

    /// Notes a difference.
    pub fn add(&mut self, step: &'static str, max: f64, beyond: f64) {
        match self.found.iter_mut().find(|found| found.step == step) {
            Some(found) => (found.max, found.beyond) = (found.max.max(max), found.beyond.max(beyond)),
            None => self.found.push(Difference { step, max, beyond }),
        }
    }

    /// A step that only one of the two took.
    pub fn missing(&mut self, step: &'static str) {
        self.number(step, f64::NAN, 0.0, 0.0);
    }
}
