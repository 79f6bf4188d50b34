//! A step in parts: how far it is, and how much of it may be done now.
//!
//! A step is a chain of passes over rows, pixels of a list, cells of a mesh or regions. It is written down as one
//! function, which is called anew for every part: passes that are done are gone over, the one under way goes on, and
//! where nothing more may be done the function ends with `None`. What one pass leaves to another lies in planes,
//! lists and named structs. Which passes there are may depend on nothing else.

use crate::arithmetic::codec::Codec;
use crate::plane::rows::next_with;
use core::ops::Range;

/// Values of a byte.
pub(crate) const BYTES: usize = 256;

/// More passes than a loop has.
const LOOP: u32 = 64;

/// What a pass counts and sums up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tally {
    /// Keys that were gathered, or pixels that were listed.
    pub count: usize,
    /// The least and the greatest key.
    pub keys: (u32, u32),
    /// How many keys have a byte, then where the next of them goes.
    pub places: [u32; BYTES],
    /// Sums.
    pub sums: [f64; 4],
}

/// How far a step is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Walk {
    /// The number of the pass that comes next.
    at: u32,
    /// Passes that are done.
    done: u32,
    /// Items of the pass under way that are done.
    next: usize,
    /// Cells that may still be worked on.
    left: usize,
    /// Whether the part ends with the pass under way.
    is_single: bool,
    /// Cells that have been worked on since the first step.
    spent: u64,
    pub tally: Tally,
}

impl Walk {
    /// A step that may be done as a whole.
    pub const fn whole() -> Walk {
        let tally = Tally { count: 0, keys: (0, 0), places: [0; BYTES], sums: [0.0; 4] };
        Walk { at: 0, done: 0, next: 0, left: usize::MAX, is_single: false, spent: 0, tally }
    }

    /// The list of fields, out or in.
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        codec.word(&mut self.done)?;
        codec.size(&mut self.next)?;
        codec.long(&mut self.spent)?;
        let Tally { count, keys, places, sums } = &mut self.tally;
        codec.size(count)?;
        codec.word(&mut keys.0)?;
        codec.word(&mut keys.1)?;
        codec.words(places)?;
        sums.iter_mut().try_for_each(|sum| codec.double(sum))
    }

    /// The next part of the step, of so many cells.
    pub fn resume(&mut self, cells: usize) {
        (self.at, self.left, self.is_single) = (0, cells.max(1), false);
    }

    /// The next part of the step, of what is left of one pass.
    pub fn resume_pass(&mut self) {
        (self.at, self.left, self.is_single) = (0, usize::MAX / 2, true);
    }

    /// How many passes of the step are done; in a loop those before it, and those of its round.
    pub fn done(&self) -> u32 {
        self.done
    }

    /// Whether all that is left of the step may be done now, and nothing of the next pass is done.
    pub fn is_open(&self) -> bool {
        self.left > usize::MAX / 2 && self.done == self.at && self.next == 0
    }

    /// The next step.
    pub fn end(&mut self) {
        (self.at, self.done, self.next) = (0, 0, 0);
    }

    /// The work so far, in cells.
    pub fn spent(&self) -> u64 {
        self.spent
    }

    /// A pass over `items`, each with the work of `cost` cells: does of it what may be done now, at least one item.
    /// `None` where it is not over.
    pub fn pass(&mut self, items: usize, cost: usize, work: impl FnOnce(Range<usize>)) -> Option<()> {
        self.tally(items, cost, |_, range| work(range))
    }

    /// The same, with what it counts.
    pub fn tally(&mut self, items: usize, cost: usize, work: impl FnOnce(&mut Tally, Range<usize>)) -> Option<()> {
        if self.goes_over() {
            return Some(());
        }
        if self.left == 0 {
            return None;
        }
        let most = self.left.checked_div(cost).unwrap_or(usize::MAX).max(1);
        let start = self.next.min(items);
        let end = start.saturating_add(most).min(items);
        self.spend(end.saturating_sub(start).saturating_mul(cost));
        work(&mut self.tally, start..end);
        self.next = end;
        if end < items {
            self.left = 0;
            return None;
        }
        self.end_pass()
    }

    /// What is done once between two passes, with the work of `cost` cells.
    pub fn once(&mut self, cost: usize, work: impl FnOnce()) -> Option<()> {
        self.pass(1, cost, |_| work())
    }

    /// A pass of which the end shows itself: `work` takes the numbers of its items, and says whether there are more.
    pub fn until(&mut self, mut work: impl FnMut(&mut Tally, usize) -> bool) -> Option<()> {
        if self.goes_over() {
            return Some(());
        }
        while self.left > 0 {
            let at = self.next;
            self.spend(1);
            self.next = at.saturating_add(1);
            if !work(&mut self.tally, at) {
                return self.end_pass();
            }
        }
        None
    }

    /// The head of a loop of fewer than [`LOOP`] passes: of `count` items the first from `next` on that `find` finds in
    /// a range. There `next` is then; the loop sets it to the one behind and goes on by [`Walk::again`]. Within,
    /// `None` where there is no more.
    pub fn seek(
        &mut self,
        count: usize,
        next: &mut usize,
        find: impl FnOnce(Range<usize>) -> Option<usize>,
    ) -> Option<Option<usize>> {
        let end_of_loop = self.at.saturating_add(LOOP);
        if self.done >= end_of_loop {
            self.at = end_of_loop;
            return Some(None);
        }
        if self.goes_over() {
            return Some(Some(*next));
        }
        if self.left == 0 {
            return None;
        }
        let end = next.saturating_add(self.left).min(count);
        let found = find(*next..end);
        let reached = found.unwrap_or(end.max(*next));
        self.spend(reached.saturating_sub(*next).max(1));
        *next = reached;
        if found.is_none() {
            if reached < count {
                return None;
            }
            self.at = end_of_loop;
        }
        self.end_pass()?;
        Some(found)
    }

    /// The same for the cells of a plane that have one of the `bits`.
    pub fn seek_bits(&mut self, plane: &[u32], next: &mut usize, bits: u32) -> Option<Option<usize>> {
        self.seek(plane.len(), next, |range| next_with(plane.get(..range.end)?, range.start, bits))
    }

    /// The same for one item after another.
    pub fn each(&mut self, count: usize, next: &mut usize) -> Option<Option<usize>> {
        self.seek(count, next, |mut range| range.next())
    }

    /// Where a loop of passes begins.
    pub fn mark(&self) -> u32 {
        self.at
    }

    /// The loop goes on with its first pass.
    pub fn again(&mut self, mark: u32) {
        (self.at, self.done, self.next) = (mark, mark, 0);
    }

    /// Whether the next pass is done; else it is under way.
    fn goes_over(&mut self) -> bool {
        self.at = self.at.saturating_add(1);
        self.done >= self.at
    }

    fn end_pass(&mut self) -> Option<()> {
        (self.done, self.next) = (self.at, 0);
        if self.is_single {
            self.left = 0;
        }
        Some(())
    }

    fn spend(&mut self, cells: usize) {
        self.left = self.left.saturating_sub(cells);
        self.spent = self.spent.saturating_add(cells as u64);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::arithmetic_side_effects)]

    use super::*;

    extern crate std;
    use std::vec::Vec;

    /// What a step leaves behind: the items of its passes in their order.
    #[derive(Debug, Default, PartialEq)]
    struct Left {
        items: Vec<usize>,
        next: usize,
        found: Vec<usize>,
    }

    /// Two passes, and one for each cell that is 1, as often as its index.
    fn step(walk: &mut Walk, plane: &[u32], left: &mut Left) -> Option<()> {
        walk.pass(5, 3, |items| left.items.extend(items))?;
        walk.once(10, || left.items.push(100))?;
        for _ in 0..2 {
            walk.once(1, || left.next = 0)?;
            found(walk, plane, left)?;
        }
        walk.pass(2, 1, |items| left.items.extend(items))
    }

    fn found(walk: &mut Walk, plane: &[u32], left: &mut Left) -> Option<()> {
        let mark = walk.mark();
        while let Some(at) = walk.seek_bits(plane, &mut left.next, 1)? {
            walk.until(|_, n| {
                left.found.push(at);
                n + 1 < at
            })?;
            left.next = at + 1;
            walk.again(mark);
        }
        Some(())
    }

    #[test]
    fn a_pass_is_a_part() {
        let plane = [0, 0, 1, 0, 1, 1, 0];
        let (mut walk, mut left, mut done) = (Walk::whole(), Left::default(), Vec::new());
        let mut whole = Left::default();
        step(&mut Walk::whole(), &plane, &mut whole).expect("the whole step");
        for expected in [5, 6, 6, 6] {
            walk.resume_pass();
            assert_eq!(step(&mut walk, &plane, &mut left), None);
            done.push(walk.done());
            assert_eq!(left.items.len(), expected);
        }
        while step(&mut walk, &plane, &mut left).is_none() {
            done.push(walk.done());
            walk.resume_pass();
        }
        assert_eq!(left, whole);
        // Before the pass that ends the step: two, and twice what sets a loop up and the loop.
        assert_eq!((&done[..4], done.last()), (&[1, 2, 3, 4][..], Some(&(2 + 2 * (1 + LOOP)))));
    }

    #[test]
    fn parts_make_the_whole() {
        let plane = [0, 0, 1, 0, 1, 1, 0];
        let mut whole = Left::default();
        step(&mut Walk::whole(), &plane, &mut whole).expect("the whole step");
        assert_eq!(whole.items, [0, 1, 2, 3, 4, 100, 0, 1]);
        let once = [2, 2, 4, 4, 4, 4, 5, 5, 5, 5, 5];
        assert_eq!(whole.found, [once, once].concat());
        for cells in 1..60 {
            let (mut walk, mut left, mut parts) = (Walk::whole(), Left::default(), 0);
            loop {
                walk.resume(cells);
                parts += 1;
                if step(&mut walk, &plane, &mut left).is_some() {
                    break;
                }
            }
            assert_eq!(left, whole, "{cells}");
            assert!(parts <= 70 / cells + 14, "{parts} parts of {cells}");
        }
    }
}
