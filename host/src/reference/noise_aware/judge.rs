//! Comparisons of numbers of which another program knows the last digits differently.

use std::cell::Cell;
use std::collections::BTreeSet;

/// How far a number may be off: a share of it, and a part that is always there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slack {
    /// Share.
    pub relative: f64,
    /// Part that is always there, in noise units.
    pub absolute: f64,
}

/// Decides what exceeds what. A decision that roundings leave open can be turned: what follows from it is right
/// either way.
#[derive(Debug, Default)]
pub struct Judge {
    slack: Slack,
    turned: BTreeSet<usize>,
    open: Cell<usize>,
}

impl Judge {
    /// One to whom every number is exact.
    pub fn exact() -> Judge {
        Judge::default()
    }

    /// Whether `a` is above `b`.
    pub fn exceeds(&self, a: f64, b: f64) -> bool {
        if (a - b).abs() > self.slack.absolute + self.slack.relative * (a.abs() + b.abs())
            || self.slack == Slack::default()
        {
            return a > b;
        }
        let number = self.open.replace(self.open.get() + 1);
        (a > b) != self.turned.contains(&number)
    }
}

/// The most open decisions that are tried.
const MOST: usize = 200;

/// Of the results of `run` that roundings allow one that has the least `distance`: open decisions are turned one after
/// the other, and stay so where that brings the result nearer.
pub fn nearest<T>(slack: Slack, run: impl Fn(&Judge) -> T, distance: impl Fn(&T) -> usize) -> T {
    let judged = |turned: &BTreeSet<usize>| {
        let judge = Judge { slack, turned: turned.clone(), open: Cell::new(0) };
        let result = run(&judge);
        (distance(&result), result, judge.open.get())
    };
    let mut turned = BTreeSet::new();
    let (mut best, mut result, mut open) = judged(&turned);
    let mut next = 0;
    while best > 0 && next < open.min(MOST) {
        turned.insert(next);
        match judged(&turned) {
            (now, nearer, left) if now < best => (best, result, open) = (now, nearer, left),
            _ => drop(turned.remove(&next)),
        }
        next += 1;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_open_decisions_are_turned() {
        let values = [(1.0, 2.0), (3.0, 3.0 + 1e-9), (5.0, 4.0), (7.0, 7.0 - 1e-9)];
        let run = |judge: &Judge| values.map(|(a, b)| judge.exceeds(a, b));
        let slack = Slack { relative: 1e-6, absolute: 0.0 };
        let towards = |wanted: [bool; 4]| {
            nearest(slack, run, |found| found.iter().zip(wanted).filter(|(found, wanted)| **found != *wanted).count())
        };
        assert_eq!(run(&Judge::exact()), [false, false, true, true]);
        for wanted in [[false, true, true, true], [false, true, true, false], [false, false, true, true]] {
            assert_eq!(towards(wanted), wanted);
        }
        assert_eq!(towards([true, true, false, false]), [false, true, true, false], "what is clear stays");
    }
}
