//! Sky and noise (`default.md`, 2).

use super::{Facts, median};

/// Level and noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// In units of the image.
    pub level: f64,
    /// Standard deviation of a pixel.
    pub noise: f64,
}

/// What a pixel is to the sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// Not defined.
    Nothing,
    /// Masked.
    Source,
    /// Sky.
    Sky,
}

/// The cells over a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    columns: usize,
    rows: usize,
    size: (usize, usize),
    /// Row-major; `None` where nothing is known.
    pub cells: Vec<Option<Sky>>,
}

/// Cells of a side along an axis.
fn along(length: usize, side: usize) -> usize {
    ((length + side / 2) / side).clamp(1, 64)
}

impl Mesh {
    /// A mesh over a frame whose cells have about so many pixels along each side.
    pub fn over((width, height): (usize, usize), side: usize, cells: Vec<Option<Sky>>) -> Mesh {
        Mesh { columns: along(width, side), rows: along(height, side), size: (width, height), cells }
    }

    /// Measures anew the cells of a frame with pixels in rows; in a mesh of the first round nothing is known. `off` is
    /// 0, or a share of the numbers by which a decision to clip may be off.
    pub fn measure(&self, pixels: &[f64], seen: &[Seen], facts: &Facts, off: f64) -> Mesh {
        let mut mesh = Mesh { cells: Vec::new(), ..*self };
        let cells: Vec<Vec<usize>> = (0..mesh.columns * mesh.rows).map(|cell| mesh.pixels(cell)).collect();
        let count = |cell: &[usize], what: fn(Seen) -> bool| cell.iter().filter(|&&at| what(seen[at])).count();
        let enough = |cell: &[usize]| {
            let (sky, defined) = (count(cell, |s| s == Seen::Sky), count(cell, |s| s != Seen::Nothing));
            sky >= 16 && 100 * sky >= 30 * defined && 64 * sky >= cell.len()
        };
        let seen_at_all = cells.iter().filter(|cell| count(cell, |s| s != Seen::Nothing) > 0).count();
        let crowded = 2 * cells.iter().filter(|cell| enough(cell)).count() < seen_at_all;
        for (index, cell) in cells.iter().enumerate() {
            let sky = || cell.iter().filter(|&&at| seen[at] == Seen::Sky).map(|&at| pixels[at] + 0.0).collect();
            let known = || {
                let sky = self.cells[index].filter(|_| crowded)?;
                let quiet = mesh.quiet(index, sky.level, pixels, seen, facts);
                let noise = quiet.filter(|quiet| *quiet < 0.9 * sky.noise).unwrap_or(sky.noise);
                Some(Sky { noise, ..sky })
            };
            mesh.cells.push(if enough(cell) { Some(clipped(sky(), facts, off)) } else { known() });
        }
        mesh.filled().smoothed()
    }

    /// The noise of the darkest pixels of a cell.
    fn quiet(&self, cell: usize, level: f64, pixels: &[f64], seen: &[Seen], facts: &Facts) -> Option<f64> {
        let (width, height) = self.size;
        let mut sizes = Vec::new();
        for at in self.pixels(cell) {
            let (x, y) = (at % width, at / width);
            if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
                continue;
            }
            let near: Vec<usize> = (0..9).map(|n| at + n % 3 + n / 3 * width - width - 1).collect();
            let weights = [1.0, -2.0, 1.0, -2.0, 4.0, -2.0, 1.0, -2.0, 1.0];
            let mean = near.iter().map(|&at| pixels[at]).sum::<f64>() / 9.0;
            if near.iter().all(|&at| seen[at] != Seen::Nothing) && mean <= level {
                sizes.push(near.iter().zip(weights).map(|(&at, weight)| weight * pixels[at]).sum::<f64>().abs());
            }
        }
        if sizes.len() < 100 {
            return None;
        }
        sizes.sort_by(f64::total_cmp);
        let bends = 1.4826 / 6.0 * ranked(&sizes, sizes.len() / 2, facts.step);
        let mut values: Vec<f64> =
            self.pixels(cell).into_iter().filter(|&at| seen[at] != Seen::Nothing).map(|at| pixels[at]).collect();
        if values.len() < 1600 {
            return None;
        }
        values.sort_by(f64::total_cmp);
        let [a, b, c] = [200, 40, 8].map(|parts| ranked(&values, values.len() / parts, facts.step));
        let ratio = if b > a { ((c - b) / (b - a)).max(1.1) } else { 1.1 };
        let tail = 0.4 * (c - a) / (ratio - 0.7);
        let noise = if bends <= 1.6 * tail && tail <= 1.6 * bends { bends } else { tail };
        (noise > 0.0).then_some(noise)
    }

    /// The mesh of which nothing is known yet.
    pub fn unknown(size: (usize, usize), side: usize) -> Mesh {
        let mesh = Mesh::over(size, side, Vec::new());
        Mesh { cells: vec![None; mesh.columns * mesh.rows], ..mesh }
    }

    /// The pixels of a cell.
    fn pixels(&self, cell: usize) -> Vec<usize> {
        let (column, row, (width, height)) = (cell % self.columns, cell / self.columns, self.size);
        let (left, right) = (column * width / self.columns, (column + 1) * width / self.columns);
        let (first, end) = (row * height / self.rows, (row + 1) * height / self.rows);
        (first..end).flat_map(|y| (left..right).map(move |x| y * width + x)).collect()
    }

    /// Ring by ring the mean of the known neighbours.
    fn filled(mut self) -> Mesh {
        while self.cells.iter().any(Option::is_some) && self.cells.iter().any(Option::is_none) {
            let old = self.clone();
            for (index, cell) in self.cells.iter_mut().enumerate().filter(|(_, cell)| cell.is_none()) {
                let near = super::neighbours(index, old.columns, old.rows, 8);
                let known: Vec<Sky> = near.into_iter().filter_map(|near| old.cells[near]).collect();
                let mean = |of: fn(&Sky) -> f64| known.iter().map(of).sum::<f64>() / known.len() as f64;
                *cell = (!known.is_empty()).then(|| Sky { level: mean(|sky| sky.level), noise: mean(|sky| sky.noise) });
            }
        }
        self
    }

    /// The median of 3 x 3 cells.
    fn smoothed(&self) -> Mesh {
        let median = |index: usize, straight: f64, of: fn(Sky) -> f64| {
            let (x, y) = ((index % self.columns) as isize, (index / self.columns) as isize);
            let row = |x: isize, y: isize| beyond(x, self.columns, straight, |x| self.value(x, y, of));
            let mut near: Vec<f64> = (0..9)
                .map(|n| (x + n % 3 - 1, y + n / 3 - 1))
                .map(|(x, y)| beyond(y, self.rows, straight, |y| row(x, y)))
                .collect();
            near.sort_by(f64::total_cmp);
            near[4]
        };
        let cell = |index: usize| {
            self.cells[index]?;
            Some(Sky { level: median(index, 1.0, |sky| sky.level), noise: median(index, 0.0, |sky| sky.noise) })
        };
        Mesh { cells: (0..self.cells.len()).map(cell).collect(), ..*self }
    }

    fn value(&self, x: isize, y: isize, of: fn(Sky) -> f64) -> f64 {
        self.cells[y as usize * self.columns + x as usize].map_or(f64::NAN, of)
    }

    /// The sky of a pixel.
    pub fn at(&self, x: usize, y: usize) -> Sky {
        let place = |at: usize, cells: usize, length: usize| (at as f64 + 0.5) * cells as f64 / length as f64 - 0.5;
        let (x, y) = (place(x, self.columns, self.size.0), place(y, self.rows, self.size.1));
        let first = |place: f64, cells: usize| (place as isize).clamp(0, cells.saturating_sub(2) as isize);
        let (i, j) = (first(x, self.columns), first(y, self.rows));
        let next = |i: isize, cells: usize| (i + 1).min(cells as isize - 1);
        let (s, t) = (x - i as f64, y - j as f64);
        let blend = |of: fn(Sky) -> f64, s: f64, t: f64| {
            let row = |j: isize| self.value(i, j, of) * (1.0 - s) + self.value(next(i, self.columns), j, of) * s;
            row(j) * (1.0 - t) + row(next(j, self.rows)) * t
        };
        let (inner_s, inner_t) = (s.clamp(0.0, 1.0), t.clamp(0.0, 1.0));
        Sky { level: blend(|sky| sky.level, s, t), noise: blend(|sky| sky.noise, inner_s, inner_t) }
    }
}

/// The value at a place of an axis, and one cell beyond its ends.
fn beyond(at: isize, cells: usize, straight: f64, value: impl Fn(isize) -> f64) -> f64 {
    let last = cells as isize - 1;
    let near = at.clamp(0, last);
    let before = (near + (near - at)).clamp(0, last);
    value(near) + straight * (value(near) - value(before))
}

/// Level and noise among the values of a cell.
fn clipped(mut values: Vec<f64>, facts: &Facts, off: f64) -> Sky {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let step = clump(&values).filter(|&wide| wide > 1.5 * facts.step && clumps(&values, wide)).unwrap_or(facts.step);
    let least = facts.resolution.max(step / 12f64.sqrt());
    let lowest = values.iter().filter(|&&v| v == values[0]).count();
    let cut_off = 10 * lowest >= n;
    let middle = ranked(&values, n / 2, step);
    let mut width = middle - ranked(&values, n / 4, step);
    if cut_off {
        width = width.max(ranked(&values, n - 1 - n / 4, step) - middle);
        if lowest < n {
            width = width.max(median(&values[lowest..]) - values[0] - step);
        }
    }
    let coarse = |noise: f64| cut_off || noise < step;
    let mut noise = (1.4826 * width).max(least);
    let (mut centre, mut middle, mut mean, mut kept) = (middle, middle, middle, &values[..]);
    for _ in 0..10 {
        let distance = (if cut_off { 5.0 } else { 3.0 } * noise).max(1.5 * step);
        let distance = distance + off * (centre.abs() + distance);
        let near = |v: &f64| (v - centre).abs() <= distance;
        let inside = match (kept.iter().position(near), kept.iter().rposition(near)) {
            (Some(first), Some(last)) if last - first + 1 >= 8 => &kept[first..=last],
            _ => break,
        };
        let done = inside.len() == kept.len();
        kept = inside;
        let count = kept.len() as f64;
        mean = kept.iter().sum::<f64>() / count;
        middle = ranked(kept, kept.len() / 2, step);
        let variance = kept.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count;
        noise = (1.015 * variance.sqrt()).max(least);
        centre = if coarse(noise) { mean } else { middle };
        if done {
            break;
        }
    }
    let level = if coarse(noise) {
        mean
    } else if (mean - middle).abs() >= 0.3 * noise || noise < 2.0 * step {
        middle
    } else {
        2.5 * middle - 1.5 * mean
    };
    Sky { level, noise }
}

/// The value of a rank, equal values being spread over a step.
fn ranked(sorted: &[f64], rank: usize, step: f64) -> f64 {
    let v = sorted[rank];
    let below = sorted.iter().filter(|&&other| other < v - step / 3.0).count();
    let until = sorted.iter().filter(|&&other| other <= v + step / 3.0).count();
    v + step * ((rank as f64 - below as f64 + 0.5) / (until - below) as f64 - 0.5)
}

/// The widest interval that few values bridge.
fn clump(sorted: &[f64]) -> Option<f64> {
    let n = sorted.len();
    let inner = sorted.get(n / 100..n - n / 20).filter(|_| n >= 200)?;
    inner.windows(n / 50 + 1).map(|few| few[few.len() - 1] - few[0]).reduce(f64::max)
}

/// Whether values lie near multiples of an interval.
fn clumps(sorted: &[f64], wide: f64) -> bool {
    let parts = sorted.iter().map(|v| (v - sorted[sorted.len() / 2]) / wide);
    let others: Vec<f64> = parts.filter(|part| part.round_ties_even() != 0.0).collect();
    let near = others.iter().filter(|part| (*part - part.round_ties_even()).abs() < 1.0 / 6.0).count();
    50 * others.len() >= sorted.len() && 10 * near > 7 * others.len()
}
