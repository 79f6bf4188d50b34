//! Sources that compete for the pixels at their borders, sweep by sweep.
//!
//! Every decision changes what the next ones see, and there are as many as pixels: so each is judged by what the core
//! itself saw. A sweep takes pixel by pixel, and both ends of it tell how the labels were before each.

use super::rounding::bit;
use crate::reference::Plane;
use crate::reference::noise_aware::{Contest, Moments, Roundings, moments};
use skyfront_core::arithmetic::Level;
use skyfront_core::run::extract::Extractor;
use skyfront_core::sources::tree::Region;
use std::cmp::Ordering;

/// A region as the core has it.
pub(super) struct Seen {
    pub peak: usize,
    pub centre: (f64, f64),
    pub plateau: bool,
    pub divided: Option<usize>,
    /// Its light in all.
    pub sum: f64,
    /// How many have less.
    rank: f64,
    /// What it has of its shape: sums meanwhile, then `(xx - yy, 2 xy)` as parts of `xx + yy`.
    measured: ((f64, f64), f64),
}

impl Seen {
    /// The first regions of a table.
    pub fn table<L: Level>(regions: &[Region<L>]) -> Vec<Seen> {
        let mut sorted: Vec<&Region<L>> = regions.iter().collect();
        let compared = |a: L::Sum, b: L::Sum| a.partial_cmp(&b).unwrap_or(Ordering::Equal);
        sorted.sort_by(|a, b| compared(a.sum, b.sum));
        let rank = |region: &Region<L>| sorted.partition_point(|other| compared(other.sum, region.sum).is_lt());
        let light = |bits: u64| if L::NAME == f32::NAME { f64::from_bits(bits) } else { bits as i64 as f64 * bit(14) };
        let seen = |region: &Region<L>| Seen {
            peak: region.peak as usize,
            centre: (region.centre.0.to_f32().into(), region.centre.1.to_f32().into()),
            plateau: region.plateau > 0.0,
            divided: (region.divided as usize).checked_sub(1),
            sum: light(L::sum_bits(region.sum)),
            rank: rank(region) as f64,
            measured: ((region.offsets.0.into(), region.offsets.1.into()), region.plateau.into()),
        };
        regions.iter().map(seen).collect()
    }
}

/// What a pass left.
pub(super) struct Pass {
    pub labels: Vec<u32>,
    pub regions: Vec<Seen>,
}

/// What the passes of a step left, one after the other; those of a loop in its first round.
#[derive(Default)]
pub(super) struct Passes {
    pub all: Vec<Pass>,
    last: u32,
}

impl Passes {
    /// Notes what a pass left.
    pub fn note<L: Level>(&mut self, run: &Extractor<'_, '_, L>) {
        if run.passes() > self.last {
            self.last = run.passes();
            let work = run.work();
            let most = work.labels.iter().max().map_or(0, |&label| label as usize);
            let regions = Seen::table(work.regions.get(..most).unwrap_or(&[]));
            self.all.push(Pass { labels: work.labels.to_vec(), regions });
        }
    }

    /// The passes of both competitions, each from the one that measures the shapes to the last before sources have others:
    /// the second has as many.
    pub fn competitions(&self, image: &Plane) -> Option<[&[Pass]; 2]> {
        let from = |first: usize| Some(first + self.all.get(first..)?.iter().position(|pass| pass.has_shapes(image))?);
        let first = from(0)?;
        let same = |pass: &&Pass| pass.measured().eq(self.all[first].measured());
        let length = self.all[first..].iter().take_while(same).count();
        let second = from(first + length)?;
        Some([self.all.get(first..first + length)?, self.all.get(second..second + length)?])
    }
}

impl Pass {
    fn measured(&self) -> impl Iterator<Item = ((f64, f64), f64)> {
        self.regions.iter().map(|region| region.measured)
    }

    /// Shapes beside the reference's of the same labels, each number with how far it may be off: by a rounding for each
    /// pixel in both sums, and eight in a pixel's share.
    pub fn shapes(&self, image: &Plane) -> impl Iterator<Item = [f64; 3]> {
        let centres: Vec<_> = self.regions.iter().map(|region| region.centre).collect();
        let beside = |(region, moments): (&Seen, Moments)| {
            let (shape, (core, _)) = (moments.shape(), region.measured);
            let off = (moments.pixels as f64 + 8.0) * bit(23);
            [[core.0, shape.0, off], [core.1, shape.1, off]]
        };
        let found: Vec<_> = self.regions.iter().zip(moments(image, &self.labels, &centres)).map(beside).collect();
        found.into_iter().flatten()
    }

    fn has_shapes(&self, image: &Plane) -> bool {
        self.labels.iter().all(|&label| label as usize <= self.regions.len())
            && self.shapes(image).all(|[core, exact, off]| (core - exact).abs() <= off)
    }
}

/// How many pixels have another owner than may be after a competition, forwards and once backwards.
pub(super) fn wrong_owners(image: &Plane, roundings: Roundings, passes: &[Pass]) -> usize {
    let mut planes: Vec<&[u32]> = passes.iter().map(|pass| &pass.labels[..]).collect();
    planes.dedup();
    let [before, ..] = planes[..] else { return 0 };
    // A sweep may change nothing.
    let forwards = planes.get(1).copied().unwrap_or(before);
    let backwards = planes.get(2).copied().unwrap_or(forwards);
    let regions = &passes[0].regions;
    let centres: Vec<_> = regions.iter().map(|region| region.centre).collect();
    let lights: Vec<_> = regions.iter().map(|region| region.rank).collect();
    let shapes: Vec<_> =
        regions.iter().map(|region| if region.plateau { (0.0, 0.0) } else { region.measured.0 }).collect();
    let contest = Contest { image, centres: &centres, lights: &lights, shapes: &shapes, roundings };
    let pixels = 0..before.len();
    let sweeps = wrong(&contest, pixels.clone(), before, forwards) + wrong(&contest, pixels.rev(), forwards, backwards);
    sweeps + planes.iter().skip(3).map(|plane| plane.len()).sum::<usize>()
}

/// The same of a sweep over pixels in an order.
fn wrong(contest: &Contest<'_>, order: impl Iterator<Item = usize>, before: &[u32], after: &[u32]) -> usize {
    let mut labels = before.to_vec();
    let is_wrong = |&at: &usize| {
        let is_wrong = !contest.owners(&labels, at).contains(&after[at]);
        labels[at] = after[at];
        is_wrong
    };
    order.filter(is_wrong).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::noise_aware::{Region as Source, Regions, compete};

    const SIDE: usize = 48;

    /// Two stars, of which the second is opened in the light of the first, as they are before they compete: the one left
    /// of a line that is not the border, the other right of it.
    fn pair() -> (Plane, Regions) {
        let star = |x: f64, y: f64, light: f64| light * (-(x * x / 12.0 + y * y / 8.0)).exp();
        let image = Plane::from_fn(SIDE, SIDE, |i, j| {
            let (x, y) = (i as f64, j as f64);
            star(x - 16.0, y - 20.0, 100.0) + star(x - 26.5, y - 21.0, 60.0)
        });
        let label = |(at, &v): (usize, &f64)| if v > 1.0 { 1 + u32::from(at % SIDE > 24) } else { 0 };
        let labels = image.values().iter().enumerate().map(label).collect();
        let region = |centre, sum| Source { centre, sum, ..Source::BLANK };
        (image, Regions { labels, table: vec![region((16.0, 20.0), 3000.0), region((26.5, 21.0), 2000.0)] })
    }

    /// Passes that left these labels, with the shapes of the first.
    fn passes(image: &Plane, regions: &Regions, planes: &[&Vec<u32>]) -> Vec<Pass> {
        let centres: Vec<_> = regions.table.iter().map(|region| region.centre).collect();
        let seen = |(region, moments): (&Source, Moments)| Seen {
            peak: 0,
            centre: region.centre,
            plateau: false,
            divided: None,
            sum: region.sum,
            rank: region.sum,
            measured: (moments.shape(), 0.0),
        };
        let pass = |&labels: &&Vec<u32>| {
            let measured = moments(image, planes[0], &centres);
            Pass { labels: labels.clone(), regions: regions.table.iter().zip(measured).map(seen).collect() }
        };
        planes.iter().map(pass).collect()
    }

    const FIXED: Roundings = Roundings { grain: bit(14), unit: bit(24) };

    /// The labels after a sweep without roundings.
    fn swept(image: &Plane, regions: &Regions, order: impl Iterator<Item = usize>, shapes: &[(f64, f64)]) -> Vec<u32> {
        let centres = [regions.table[0].centre, regions.table[1].centre];
        let contest = Contest { image, centres: &centres, lights: &[2.0, 1.0], shapes, roundings: Roundings::NONE };
        let mut labels = regions.labels.clone();
        order.for_each(|at| labels[at] = contest.owners(&labels, at)[0]);
        labels
    }

    #[test]
    fn a_pixel_of_another_owner_is_found() {
        let (image, mut regions) = pair();
        let mut competed = regions.clone();
        compete(&image, &mut competed);
        let (before, after, pixels) = (regions.labels.clone(), competed.labels, 0..SIDE * SIDE);
        let centres = [regions.table[0].centre, regions.table[1].centre];
        let shapes: Vec<_> = moments(&image, &before, &centres).iter().map(Moments::shape).collect();
        regions.labels = swept(&image, &regions, pixels.clone(), &shapes);
        let between = regions.labels.clone();
        assert_eq!(swept(&image, &regions, pixels.rev(), &shapes), after);
        assert!(before != between && between != after);
        let wrong = |planes: &[&Vec<u32>]| wrong_owners(&image, FIXED, &passes(&image, &regions, planes));
        assert_eq!(wrong(&[&before, &between, &after]), 0);
        assert!(wrong(&[&before]) > 0 && wrong(&[&before, &between]) > 0, "a sweep is missing");
        assert_eq!(wrong(&[&before, &between, &after, &before]), SIDE * SIDE, "a sweep too many");
        let mut missed = Vec::new();
        for at in (0..SIDE * SIDE).filter(|&at| after[at] > 0) {
            for other in (0..=2).filter(|&label| label != after[at]) {
                let mut planted = after.clone();
                planted[at] = other;
                if wrong(&[&before, &between, &planted]) == 0 {
                    missed.push((at, other));
                }
            }
        }
        assert_eq!(missed, []);
    }

    #[test]
    fn the_second_competition_has_as_many_passes_as_the_first() {
        let (image, regions) = pair();
        let left = &regions.labels;
        let mut all = passes(&image, &regions, &[left; 9]);
        let unmeasured = |pass: &mut Pass| pass.regions.iter_mut().for_each(|seen| seen.measured = ((0.0, 0.0), 7.0));
        [0, 4].into_iter().for_each(|at| unmeasured(&mut all[at]));
        let found = Passes { all, last: 9 }.competitions(&image).map(|found| found.map(<[Pass]>::len));
        assert_eq!(found, Some([3, 3]), "of five from the second on two are others'");
        let mut all = passes(&image, &regions, &[left; 4]);
        unmeasured(&mut all[3]);
        assert!(Passes { all, last: 4 }.competitions(&image).is_none(), "shapes are measured once");
    }
}
