//! Comparisons of numbers of which another program knows the last digits differently.

use std::cell::RefCell;
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
/// either way. It is known by its numbers, so that what is asked twice is answered once.
#[derive(Debug, Default)]
pub struct Judge {
    slack: Slack,
    turned: BTreeSet<Question>,
    open: RefCell<Vec<Question>>,
}

/// Two numbers, by their bits.
type Question = (u64, u64);

impl Judge {
    /// One to whom every number is exact.
    pub fn exact() -> Judge {
        Judge::default()
    }

    /// Whether `a` is above `b`.
    pub fn exceeds(&self, a: f64, b: f64) -> bool {
        self.exceeds_of(1.0, a, b)
    }

    /// The same where the roundings of what they are made of count so many times in them.
    pub fn exceeds_of(&self, times: f64, a: f64, b: f64) -> bool {
        let off = self.slack.absolute * times + self.slack.relative * (a.abs() + b.abs());
        if off == 0.0 || (a - b).abs() > off {
            return a > b;
        }
        let question = (a.to_bits(), b.to_bits());
        self.open.borrow_mut().push(question);
        (a > b) != self.turned.contains(&question)
    }
}

/// How often an open decision is turned, at most.
const MOST: usize = 2000;

/// Of the results of `run` that roundings allow one that has the least `distance`: open decisions are turned one after
/// the other, and stay so where that brings the result nearer; once more all of them, also back again, until none does.
pub fn nearest<T>(slack: Slack, run: impl Fn(&Judge) -> T, distance: impl Fn(&T) -> usize) -> T {
    let judged = |turned: &BTreeSet<Question>| {
        let judge = Judge { slack, turned: turned.clone(), open: RefCell::default() };
        let result = run(&judge);
        (distance(&result), result, judge.open.into_inner())
    };
    let (mut turned, mut tried, mut is_nearer) = (BTreeSet::new(), BTreeSet::new(), false);
    let (mut best, mut result, mut open) = judged(&turned);
    for _ in 0..MOST {
        if best == 0 {
            break;
        }
        let Some(next) = open.iter().copied().find(|question| !tried.contains(question)) else {
            if !is_nearer {
                break;
            }
            (tried, is_nearer) = (BTreeSet::new(), false);
            continue;
        };
        tried.insert(next);
        let other: BTreeSet<Question> = turned.symmetric_difference(&BTreeSet::from([next])).copied().collect();
        let (now, nearer, others) = judged(&other);
        if now < best {
            (best, result, open, turned, is_nearer) = (now, nearer, others, other, true);
        }
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
        // The same numbers are one decision.
        let twice = |judge: &Judge| [judge.exceeds(1.0, 1.0 + 1e-9), judge.exceeds(1.0, 1.0 + 1e-9)];
        assert_eq!(nearest(slack, twice, |found| found.iter().filter(|found| !**found).count()), [true, true]);
        assert_eq!(towards([true, true, false, false]), [false, true, true, false], "what is clear stays");
    }

    /// Decisions that are all wrong at first, and one that is of use only when the last of them is turned.
    #[test]
    fn many_decisions_take_few_runs() {
        const MANY: usize = 300;
        let runs = std::cell::Cell::new(0);
        let run = |judge: &Judge| {
            runs.set(runs.get() + 1);
            (0..MANY).filter(|&n| judge.exceeds(n as f64, n as f64 + 1e-9)).collect::<Vec<_>>()
        };
        let slack = Slack { relative: 0.0, absolute: 1e-6 };
        let distance = |right: &Vec<usize>| {
            let left = MANY - 1 - right.iter().filter(|&&n| n > 0).count();
            left + usize::from(left > 0 || right.first() != Some(&0))
        };
        assert_eq!(nearest(slack, run, distance).len(), MANY);
        assert!(runs.get() <= 2 * MANY + 1, "{} runs", runs.get());
    }
}
