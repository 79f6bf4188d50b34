//! Two fronts that part an image into four phases (L. A. Vese, T. F. Chan 2002, DOI 10.1023/A:1020874308076), with the
//! H of the two-phase model for v in \[-1, 1\], v = u counted in pixels.

use super::chan_vese::pull;
use super::initial::half_side;
use super::{Parameters, Plane};

/// Which fronts a phase lies inside of: the first, the second. In the order of the classes that they start from.
const PHASES: [(bool, bool); 4] = [(false, false), (true, false), (true, true), (false, true)];

/// Both fronts, in pixels.
#[derive(Clone, Debug)]
pub struct Fronts {
    /// The first.
    pub first: Plane,
    /// The second.
    pub second: Plane,
}

impl Fronts {
    /// The phases' shares of a pixel.
    fn weights(&self, i: isize, j: isize) -> [f64; 4] {
        let h = |v: f64, inside: bool| 0.5 * if inside { 1.0 + v } else { 1.0 - v };
        let (v, w) = (self.first.at(i, j), self.second.at(i, j));
        PHASES.map(|(first, second)| h(v, first) * h(w, second))
    }

    /// The means of the phases; one without pixels keeps that of before.
    pub fn means(&self, image: &Plane, before: [f64; 4]) -> [f64; 4] {
        let (mut light, mut weight) = ([0.0; 4], [0.0; 4]);
        self.each(|i, j| {
            for (at, share) in self.weights(i, j).into_iter().enumerate() {
                light[at] += share * image.at(i, j);
                weight[at] += share;
            }
        });
        std::array::from_fn(|at| if weight[at] > 0.0 { light[at] / weight[at] } else { before[at] })
    }

    /// The phase of each pixel by the signs of both fronts, as its place among those that have pixels: -1 for the one with
    /// the least mean, then from 1 on.
    pub fn ranks(&self, image: &Plane) -> Plane {
        let side = |v: f64| if v > 0.0 { 1.0 } else { -1.0 };
        let decided = Fronts { first: self.first.map(side), second: self.second.map(side) };
        let means = decided.means(image, [f64::INFINITY; 4]);
        let rank = means.map(|mean| match means.iter().filter(|&&other| other < mean).count() {
            0 => -1.0,
            rank => rank as f64,
        });
        self.map(|i, j| decided.weights(i, j).iter().zip(rank).map(|(share, rank)| share * rank).sum())
    }

    /// Both after a step: the first, then the second beside it. The means are those of [`PHASES`].
    pub(super) fn step(&self, p: &Parameters, image: &Plane, means: [f64; 4]) -> Fronts {
        let moved = Fronts { first: self.step_first(p, image, means), second: self.second.clone() };
        Fronts { second: moved.step_second(p, image, means), first: moved.first }
    }

    /// The first front after a step.
    pub fn step_first(&self, p: &Parameters, image: &Plane, means: [f64; 4]) -> Plane {
        self.map(|i, j| {
            let [c00, c10, c11, c01] = means.map(|c| (image.at(i, j) - c).powi(2));
            let h = 0.5 * (1.0 + self.second.at(i, j));
            pull(p, &self.first.around(i, j), -((c11 - c01) * h + (c10 - c00) * (1.0 - h)))
        })
    }

    /// The second front after a step, with the first as it is now.
    pub fn step_second(&self, p: &Parameters, image: &Plane, means: [f64; 4]) -> Plane {
        self.map(|i, j| {
            let [c00, c10, c11, c01] = means.map(|c| (image.at(i, j) - c).powi(2));
            let h = 0.5 * (1.0 + self.first.at(i, j));
            pull(p, &self.second.around(i, j), -((c11 - c10) * h + (c01 - c00) * (1.0 - h)))
        })
    }

    fn map(&self, value: impl Fn(isize, isize) -> f64) -> Plane {
        Plane::from_fn(self.first.width(), self.first.height(), value)
    }

    fn each(&self, mut see: impl FnMut(isize, isize)) {
        for j in 0..self.first.height() as isize {
            (0..self.first.width() as isize).for_each(|i| see(i, j));
        }
    }
}

/// Each pixel in the phase whose mean is nearest to it, the first of several.
pub fn start(image: &Plane, means: [f64; 4]) -> Fronts {
    let phase = |value: f64| {
        let nearest = |best: usize, at: usize| {
            if (value - means[at]).abs() < (value - means[best]).abs() { at } else { best }
        };
        PHASES[(1..4).fold(0, nearest)]
    };
    let side = |inside: bool| if inside { 1.0 } else { -1.0 };
    Fronts { first: image.map(|v| side(phase(v).0)), second: image.map(|v| side(phase(v).1)) }
}

/// Bins of the histogram that the phases start from.
const BINS: usize = 64;

/// The means of the four classes of least variance of a histogram of 64 bins over \[0, 1\] (ours): of the borders between
/// the middle two the one that, with the best borders on its sides, leaves the least, and of several the lowest. A class
/// without values has the mean of the one below it, the lowest that of the first that has values.
pub fn classes(image: &Plane) -> [f64; 4] {
    let mut counts = [0.0; BINS];
    image.values().iter().for_each(|v| counts[((v * BINS as f64) as usize).min(BINS - 1)] += 1.0);
    let mean = |from: usize, to: usize| {
        let count = counts[from..to].iter().sum::<f64>();
        let sum = (from..to).map(|bin| counts[bin] * bin as f64).sum::<f64>();
        (count > 0.0).then(|| (count, sum / count))
    };
    // What a border takes off the sum of squares.
    let gain = |from: usize, border: usize, to: usize| match (mean(from, border), mean(border, to)) {
        (Some((m, low)), Some((n, high))) => m * n / (m + n) * (high - low).powi(2),
        _ => 0.0,
    };
    let best = |from: usize, to: usize| {
        let gains = (from + 1..to).map(|border| (gain(from, border, to), border));
        gains.fold((0.0, to), |best, next| if next.0 > best.0 { next } else { best })
    };
    let mut most = (0.0, [0, BINS, BINS, BINS, BINS]);
    for middle in 1..=BINS {
        let (low, high) = (best(0, middle), best(middle, BINS));
        let all = gain(0, middle, BINS) + (low.0 + high.0);
        if all > most.0 {
            most = (all, [0, low.1, middle, high.1, BINS]);
        }
    }
    let middle = |class: usize| mean(most.1[class], most.1[class + 1]).map(|(_, mean)| (mean + 0.5) / BINS as f64);
    let mut last = (0..4).find_map(middle).unwrap_or(0.0);
    std::array::from_fn(|class| {
        last = middle(class).unwrap_or(last);
        last
    })
}

/// dx^2 times the sum of what both fronts change, in the unit of the paper's u, and whether a pixel crosses one of them.
pub(super) fn change(p: &Parameters, old: &Fronts, new: &Fronts) -> (f64, bool) {
    let both = [(&old.first, &new.first), (&old.second, &new.second)];
    let pairs = both.iter().flat_map(|(old, new)| old.values().iter().zip(new.values()));
    let sum = pairs.clone().map(|(a, b)| (b - a).abs()).sum::<f64>();
    let crossed = pairs.into_iter().any(|(a, b)| (*a > 0.0) != (*b > 0.0));
    (p.dx * p.dx * sum / half_side(&old.first), crossed)
}
