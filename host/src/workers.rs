//! Work on many things by several threads, with the results in order.

use crate::machine::Native;
use crate::planes::thread_can_be_had;
use skyfront_core::arithmetic::machine::{Machine, Task};
use skyfront_core::plane::crew::Crew;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::{Builder, scope};

/// `work(0)` to `work(count - 1)`, each of which may use the memory of its thread. Threads take a
/// `piece` of so many when they are free; where a thread cannot be had, the others do its work.
pub(crate) fn in_order<M: Default, T: Send>(
    count: usize,
    piece: usize,
    threads: usize,
    work: impl Fn(usize, &mut M) -> T + Sync,
) -> Vec<T> {
    let (next, step) = (AtomicUsize::new(0), piece.max(1));
    let pieces = Mutex::new(Vec::new());
    let help = || {
        let mut memory = M::default();
        loop {
            let first = next.fetch_add(step, Ordering::Relaxed);
            if first >= count {
                break;
            }
            let last = count.min(first + step);
            let piece: Vec<T> = (first..last).map(|index| work(index, &mut memory)).collect();
            pieces.lock().unwrap_or_else(PoisonError::into_inner).push((first, piece));
        }
    };
    scope(|scope| {
        for _ in 1..threads.min(count.div_ceil(step)) {
            if !thread_can_be_had() || Builder::new().spawn_scoped(scope, help).is_err() {
                break;
            }
        }
        help();
    });
    let mut pieces = pieces.into_inner().unwrap_or_else(PoisonError::into_inner);
    pieces.sort_unstable_by_key(|&(first, _)| first);
    pieces.into_iter().flat_map(|(_, piece)| piece).collect()
}

/// Lets each thread work on a group of items, of which it is told the first one's number, counted from 1.
pub(crate) fn in_groups<T: Send>(items: &mut [T], threads: usize, work: impl Fn(usize, &mut [T]) + Sync) {
    let size = items.len().div_ceil(threads.max(1)).max(1);
    Threads(threads).each((1..).step_by(size).zip(items.chunks_mut(size)), |(first, items)| work(first, items));
}

/// So many threads for the core's bands of rows; where one cannot be had, the others do its work.
#[derive(Clone, Copy, Debug)]
pub struct Threads(pub usize);

impl Crew for Threads {
    #[inline(always)]
    fn wide<T: Task>(&self, row: T) -> T::Output {
        Native::wide(row)
    }

    fn hands(&self) -> usize {
        self.0.max(1)
    }

    fn each<T: Send>(&self, items: impl Iterator<Item = T> + Send, work: impl Fn(T) + Sync) {
        let items = Mutex::new(items);
        let next = || items.lock().unwrap_or_else(PoisonError::into_inner).next();
        let help = || {
            while let Some(item) = next() {
                work(item);
            }
        };
        scope(|scope| {
            for _ in 1..self.hands() {
                if !thread_can_be_had() || Builder::new().spawn_scoped(scope, help).is_err() {
                    break;
                }
            }
            help();
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use skyfront_core::plane::crew::Alone;

    #[test]
    fn every_item_is_worked_on_once_whatever_the_threads() {
        fn squares(crew: &impl Crew) -> Vec<usize> {
            let mut numbers: Vec<usize> = (0..1000).collect();
            crew.each(numbers.chunks_mut(7), |piece| piece.iter_mut().for_each(|number| *number *= *number));
            numbers
        }
        for threads in [0, 1, 2, 5, 40] {
            assert_eq!(squares(&Threads(threads)), squares(&Alone));
        }
    }

    #[test]
    fn every_item_is_in_one_group() {
        for (count, threads) in [(0, 2), (1, 3), (10, 0), (10, 1), (10, 3), (10, 40)] {
            let mut numbers = vec![0; count];
            in_groups(&mut numbers, threads, |first, numbers| {
                (first..).zip(numbers).for_each(|(number, place)| *place += number);
            });
            assert!(numbers.into_iter().eq(1..=count), "{count} {threads}");
        }
    }

    #[test]
    fn results_come_in_order_whatever_the_threads() {
        for count in [0, 1, 32, 100, 1000] {
            let expected: Vec<usize> = (0..count).map(|n| n * n).collect();
            for (piece, threads) in [(32, 0), (32, 1), (32, 3), (32, 64), (1, 1), (1, 3), (1, 200)] {
                assert_eq!(in_order(count, piece, threads, |n, _: &mut ()| n * n), expected);
            }
        }
    }
}
