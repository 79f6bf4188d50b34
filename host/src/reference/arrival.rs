//! Times of arrival: g |grad T| = 1 where the front has not been, T = u0 where it starts (fast marching, J. A. Sethian
//! 1996, DOI 10.1073/pnas.93.4.1591). Times are in pixels of free motion: t = T dx.

use super::{Parameters, Plane, half_side};
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// The time at a node from the earlier times along its two axes: the larger root of (T - x)^2 + (T - y)^2 = delay^2, or
/// from one axis alone where the other comes too late to matter.
pub fn arrival(x: f64, y: f64, delay: f64) -> f64 {
    let (first, second) = (x.min(y), x.max(y));
    let lag = second - first;
    if lag < delay { (first + second + (2.0 * delay * delay - lag * lag).sqrt()) / 2.0 } else { first + delay }
}

/// A time in a heap.
#[derive(PartialEq)]
struct Time(f64);

impl Eq for Time {}

impl PartialOrd for Time {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Time {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// When the front arrives at every node; infinite where g is 0.
pub fn arrivals(g: &Plane, u0: &Plane) -> Plane {
    let (width, height) = (u0.width() as isize, u0.height() as isize);
    let half = half_side(u0);
    let mut times = u0.map(|u| if u > 0.0 { f64::INFINITY } else { (u * half).max(-1.5) });
    let mut heap: BinaryHeap<_> = (0..height)
        .flat_map(|j| (0..width).map(move |i| (i, j)))
        .filter(|&(i, j)| times.at(i, j).is_finite())
        .map(|(i, j)| Reverse((Time(times.at(i, j)), i, j)))
        .collect();
    while let Some(Reverse((Time(time), i, j))) = heap.pop() {
        if time > times.at(i, j) {
            continue;
        }
        for (i, j) in [(i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)] {
            if i < 0 || j < 0 || i >= width || j >= height {
                continue;
            }
            let later = soonest(g, &times, i, j);
            if later < times.at(i, j) {
                times.set(i, j, later);
                heap.push(Reverse((Time(later), i, j)));
            }
        }
    }
    times
}

/// When the front arrives at a node at the earliest, as far as the times around it are known.
pub fn soonest(g: &Plane, times: &Plane, i: isize, j: isize) -> f64 {
    let around = times.around(i, j);
    arrival(around.e.min(around.w), around.n.min(around.s), 1.0 / g.at(i, j))
}

/// The front at t_max in the unit of the paper's u0: the time since it was at a node, one pixel where it has not been.
pub(super) fn front(p: &Parameters, times: &Plane) -> Plane {
    let (farthest, half) = (p.t_max / p.dx, half_side(times));
    times.map(|time| if time <= farthest { (time - farthest) / half } else { 1.0 / half })
}
