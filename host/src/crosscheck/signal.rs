//! A run on signal-to-noise taken step by step, each beside the reference's step from the very same input.
//!
//! What a number may differ by follows from its own step: a share of the numbers it is made of, in single precision
//! everywhere before signal-to-noise, and in fixed point a grain for every rounding after that. Where a number decides,
//! what lies within that of the border may go either way; of decisions that depend on one another
//! ([`reference::nearest`]) each may, as long as all that follows is the reference's. Where too many do, between
//! sources that compete for pixels, each is judged from the core's own labels before it ([`wrong_owners`]).

use super::CheckError;
use super::borders::{Passes, Seen, wrong_owners};
use super::notes::{Difference, Notes};
use super::rounding::bit;
use super::settings::{parameters, settings};
use super::walk::walk;
use crate::evolution::filter_in;
use crate::pipeline::{Drive, Segmentation, segment_in};
use crate::planes::SignalRoom;
use crate::reference::noise_aware::{
    self as reference, Facts, Judge, Mesh, Region, Regions, Roundings, Settings, Sky, Slack, Tail,
};
use crate::reference::{Parameters, Plane, ReferenceError, is_beyond_reach};
use skyfront_core::arithmetic::{Arithmetic, Level, Real};
use skyfront_core::config::{Config, Scheme};
use skyfront_core::front::outline::{Front, ROWS};
use skyfront_core::plane::crew::Alone;
use skyfront_core::plane::grid::Grid;
use skyfront_core::plane::mask::Mask;
use skyfront_core::run::extract::{Extractor, Found, Progress};
use skyfront_core::run::stage::Stage;
use skyfront_core::run::workspace::regions;
use skyfront_core::sky::view::Known;
use std::collections::HashMap;

/// Runs the core and looks at each of its steps beside the reference's with `asked`: the settings of the
/// configuration, or others to see whether it is noticed. A front of the paper moves in `A`.
///
/// # Errors
/// What the core or the reference finds wrong with the configuration or the image.
pub fn walk_signal<A: Arithmetic, L: Level>(
    config: &Config,
    asked: &Settings,
    pixels: &[f32],
    (width, height): (usize, usize),
) -> Result<Vec<Difference>, CheckError> {
    let mut room = SignalRoom::<L>::new(config, (pixels.len(), width), (width, height), regions(width, height), 1);
    let mut run = Extractor::new(config, pixels, width, Known::default(), room.workspace())?;
    let mut walk = Walk::new::<L>(config, *asked, pixels, width);
    let mut before = Left::of(&run, asked.cell, width);
    loop {
        match run.progress() {
            Progress::Done(found) => {
                walk.found(&found);
                return Ok(walk.notes.found);
            }
            Progress::Next(Stage::Deblend) => {
                let mut passes = Passes::default();
                while run.progress() == Progress::Next(Stage::Deblend) {
                    run.poll_pass()?;
                    passes.note(&run);
                }
                let after = Left::of(&run, asked.cell, width);
                walk.deblend(&before, &passes, &after);
                before = after;
            }
            Progress::Next(stage) => {
                run.poll(usize::MAX)?;
                let after = Left::of(&run, asked.cell, width);
                walk.see::<L>(stage, &before, &after);
                before = after;
            }
            Progress::Filter => {
                let image: Vec<f32> = run.image().iter().map(|value| value.to_f32()).collect();
                let (asked, mut last) = (parameters(config), Vec::new());
                walk.notes.found.extend(self::walk::<A>(config, &asked, &image, (width, height), &mut |_, run| {
                    last = run.image().iter().map(|&cell| f64::from(A::pixel(cell).to_f32())).collect();
                })?);
                let filtered = filter_in::<A>(config, &image, width, &mut Drive::default())?.image;
                run.start_from(|at| filtered[at]);
                walk.filtered(&asked, &image, &last, &filtered)?;
                before = Left::of(&run, walk.asked.cell, width);
            }
            Progress::Front => {
                let image: Vec<f32> = run.image().iter().map(|value| value.to_f32()).collect();
                walk.notes.found.extend(self::walk::<A>(
                    config,
                    &parameters(config),
                    &image,
                    (width, height),
                    &mut |_, _| {},
                )?);
                let front = segment_in::<A>(config, &image, width, height, &mut Drive::default())?.front;
                run.outline(|at| front[at] > 0.0);
                let after = Left::of(&run, asked.cell, width);
                walk.outline(&front, &after);
                before = after;
            }
        }
    }
}

/// The whole run of the reference.
///
/// # Errors
/// What it finds wrong.
pub fn whole_run(config: &Config, pixels: &[f32], width: usize) -> Result<reference::Found, ReferenceError> {
    let (asked, parameters) = (settings(config), parameters(config));
    let pixels: Vec<f64> = pixels.iter().map(|&v| v.into()).collect();
    reference::run(&asked, &pixels, width, |image, fine| {
        if config.scheme == Scheme::Region && config.filter.is_stepped() {
            return Ok(reference::region_front(&asked, &crate::reference::filtered(&parameters, image)?, fine));
        }
        if config.scheme == Scheme::Region {
            return Ok(reference::region_front(&asked, image, fine));
        }
        let (width, height) = (image.width(), image.height());
        let stages = crate::reference::run(&parameters, image.values(), width, height)?;
        let u = Plane::from_fn(width, height, |i, j| {
            let far = is_beyond_reach(&parameters, j as usize * width + i as usize, width, height);
            if far { stages.u.at(i, j).min(0.0) } else { stages.u.at(i, j) }
        });
        Ok(reference::Moved { u, steps: stages.steps, t: stages.t })
    })
}

/// The centroids of a run beside those of its own labels.
pub fn centroids(pixels: &[f32], core: &Segmentation) -> Difference {
    let pixels: Vec<f64> = pixels.iter().map(|&v| v.into()).collect();
    let floor = core.outcome.extremes.least.into();
    let truth = crate::reference::centroids(&core.labels, core.outcome.sources, &pixels, core.width, floor);
    let shifts = core.sources.iter().zip(truth).map(|(source, (x, y))| {
        let (core_x, core_y) = source.centroid();
        (f64::from(core_x) - x).hypot(f64::from(core_y) - y)
    });
    let max = shifts.fold(0.0, f64::max);
    Difference { step: "centroids", max, beyond: max }
}

/// What a step left.
struct Left {
    signal: Plane,
    fine: Plane,
    smooth: Plane,
    front: Plane,
    masked: Vec<bool>,
    mesh: Mesh,
    labels: Vec<u32>,
    regions: Vec<Seen>,
}

impl Left {
    fn of<L: Level>(run: &Extractor<'_, '_, L>, cell: usize, width: usize) -> Left {
        let work = run.work();
        let plane = |values: &[L]| {
            let value = |i: isize, j: isize| f64::from(values[j as usize * width + i as usize].to_f32());
            Plane::from_fn(width, values.len() / width, value)
        };
        let size = (width, work.signal.len() / width);
        let mut mesh = Mesh::unknown(size, cell);
        for (cell, sky) in mesh.cells.iter_mut().zip(work.mesh.iter()) {
            let known = sky.level.is_finite() && sky.noise.is_finite();
            *cell = known.then_some(Sky { level: sky.level.into(), noise: sky.noise.into() });
        }
        let most = work.labels.iter().max().map_or(0, |&label| label as usize);
        Left {
            signal: plane(work.signal),
            fine: plane(work.fine),
            smooth: plane(work.smooth),
            front: Plane::from_fn(width, work.labels.len() / width, |i, j| {
                f64::from(run.front(j as usize * width + i as usize).to_f32())
            }),
            masked: (0..work.labels.len()).map(|at| Mask(work.masked).has(at)).collect(),
            mesh,
            labels: work.labels.to_vec(),
            regions: Seen::table(work.regions.get(..most).unwrap_or(&[])),
        }
    }

    fn has(&self) -> (&[u32], &[Seen]) {
        (&self.labels, &self.regions)
    }

    /// The same regions in the core's order, each where the core's has its peak: in which order the components of the
    /// outlines are gone through, and so how their regions are numbered, changes no source.
    fn renumbered(&self, exact: &Regions) -> Regions {
        let mut place: Vec<Option<usize>> = vec![None; exact.table.len()];
        let mut taken = vec![false; exact.table.len()];
        let peaks: HashMap<usize, usize> =
            exact.table.iter().enumerate().map(|(at, region)| (region.peak, at)).collect();
        for (at, core) in self.regions.iter().enumerate().take(taken.len()) {
            if let Some(&own) = peaks.get(&core.peak) {
                (place[own], taken[at]) = (Some(at), true);
            }
        }
        let mut free = (0..taken.len()).filter(|&at| !taken[at]);
        let place: Vec<usize> = place.into_iter().map(|at| at.or_else(|| free.next()).unwrap_or_default()).collect();
        let mut table = exact.table.clone();
        exact.table.iter().zip(&place).for_each(|(region, &at)| table[at] = region.clone());
        let named = |&label: &u32| if label == 0 { 0 } else { place[label as usize - 1] as u32 + 1 };
        Regions { labels: exact.labels.iter().map(named).collect(), table }
    }
}

/// Whether each of so many regions has pixels.
fn has_pixels(labels: &[u32], regions: usize) -> Vec<bool> {
    let mut found = vec![false; regions];
    labels.iter().filter(|&&label| label > 0).for_each(|&label| found[label as usize - 1] = true);
    found
}

/// Pixels with another label, and of the regions with pixels the coordinates of centres, the parts that were divided
/// from them and the plateaus that are others: each may hang on a decision of its own.
fn apart((labels, regions): (&[u32], &[Seen]), exact: &Regions) -> usize {
    let differing_of = |((exact, core), _): ((&Region, &Seen), bool)| {
        let differ = [
            core.centre.0 != exact.centre.0,
            core.centre.1 != exact.centre.1,
            exact.plateau != core.plateau,
            exact.divided != core.divided,
        ];
        differ.into_iter().filter(|&differs| differs).count()
    };
    let has_pixels = has_pixels(labels, regions.len());
    let pairs = exact.table.iter().zip(regions).zip(has_pixels).filter(|(_, has_pixels)| *has_pixels);
    pairs.map(differing_of).sum::<usize>() + differing(&exact.labels, labels)
}

/// What was seen of a run so far.
struct Walk {
    config: Config,
    asked: Settings,
    /// The distance of two neighbouring numbers in fixed point; 0 in single precision.
    grain: f64,
    /// The greatest signal-to-noise.
    brightest: f64,
    pixels: Vec<f64>,
    width: usize,
    facts: Facts,
    defined: Vec<bool>,
    signals: Vec<bool>,
    /// What a filter in steps left, for the front to start from.
    filtered: Option<Plane>,
    /// The noise of the fine image, and the photon noise.
    noise: f64,
    photon: f64,
    /// The regions as the reference has them.
    regions: Regions,
    cut: f64,
    pixels_kept: usize,
    sources: u32,
    notes: Notes,
}

impl Walk {
    fn new<L: Level>(config: &Config, asked: Settings, pixels: &[f32], width: usize) -> Walk {
        let pixels: Vec<f64> = pixels.iter().map(|&v| v.into()).collect();
        let facts = Facts::of(&pixels, width);
        let defined: Vec<bool> = pixels.iter().map(|&pixel| facts.defines(pixel)).collect();
        let fixed = L::NAME != f32::NAME;
        Walk {
            config: *config,
            asked,
            grain: if fixed { bit(14) } else { 0.0 },
            brightest: if fixed { 32_768.0 } else { f64::INFINITY },
            signals: reference::has_signal(&defined, width),
            filtered: None,
            defined,
            facts,
            pixels,
            width,
            noise: 1.0,
            photon: 0.0,
            regions: Regions { labels: Vec::new(), table: Vec::new() },
            cut: 0.0,
            pixels_kept: 0,
            sources: 0,
            notes: Notes::default(),
        }
    }

    /// Looks at what a step left behind.
    fn see<L: Level>(&mut self, stage: Stage, before: &Left, after: &Left) {
        match stage {
            Stage::Background => {
                self.sky(before, after);
                self.signal(after);
            }
            Stage::Smooth => self.smooth(after),
            Stage::Mask => self.mask(before, after),
            Stage::Photon => self.photon = reference::photon_noise(&after.signal, &after.fine, &after.masked),
            Stage::Outline => self.front::<L>(before, after),
            Stage::Tree => self.tree(before, after),
            Stage::Components => self.components(before, after),
            Stage::Select => self.select(before, after),
            _ => {}
        }
    }

    /// How far decisions may be off: twice the place of a centre is known to 2^-14 pixels.
    fn slack(&self) -> Slack {
        Slack { relative: bit(13), absolute: 4.0 * self.grain }
    }

    /// Notes a plane that may be off by so much at each pixel.
    fn plane(&mut self, step: &'static str, core: &Plane, exact: &Plane, off: &Plane) {
        let (low, high) = (added(exact, off, -1.0), added(exact, off, 1.0));
        self.notes.plane(step, core, &low, &high);
    }

    fn sky(&mut self, before: &Left, after: &Left) {
        let seen = reference::seen(&self.defined, &before.masked);
        let measured = |off: f64| before.mesh.measure(&self.pixels, &seen, &self.facts, off).cells;
        let meshes = [measured(0.0), measured(bit(21)), measured(-bit(21))];
        for (index, core) in after.mesh.cells.iter().enumerate() {
            let cells: Vec<Sky> = meshes.iter().filter_map(|mesh| mesh[index]).collect();
            let (Some(core), Some(exact)) = (core, cells.first()) else {
                self.notes.count("sky", usize::from(core.is_some() == cells.is_empty()));
                continue;
            };
            let mut note = |of: fn(&Sky) -> f64| {
                let (low, high) = cells.iter().map(of).fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
                // What is off in a cell is off up to nine times beyond the border.
                let off = (high - low) + bit(19) * (exact.level.abs() + exact.noise);
                self.notes.number("sky", of(core) / exact.noise, (low - off) / exact.noise, (high + off) / exact.noise);
            };
            note(|sky| sky.level);
            note(|sky| sky.noise);
        }
    }

    fn signal(&mut self, after: &Left) {
        let raw = reference::signal(&self.pixels, &self.defined, &after.mesh, self.width, self.brightest);
        // A pixel may have the value of its neighbours.
        let off = greatest(&self.signal_off(&raw, &after.mesh), 1);
        let clean = reference::without_spikes(&raw, self.asked.spike_height, &Judge::exact());
        let clean = Plane::from_fn(raw.width(), raw.height(), |i, j| {
            let (core, exact, off) = (after.signal.at(i, j), clean.at(i, j), off.at(i, j));
            if (core - exact).abs() <= off {
                return exact;
            }
            // Whether it is a spike may hang on a rounding.
            let (left, low) = (i.min(1), j.min(1));
            let around = Plane::from_fn(
                (raw.width() as isize - i).min(2) as usize + left as usize,
                (raw.height() as isize - j).min(2) as usize + low as usize,
                |x, y| raw.at(i - left + x, j - low + y),
            );
            let slack = Slack { relative: bit(18), absolute: off };
            let own = |judge: &Judge| reference::without_spikes(&around, self.asked.spike_height, judge).at(left, low);
            reference::nearest(slack, own, |v| usize::from((core - v).abs() > off))
        });
        self.plane("signal", &after.signal, &clean, &off);
    }

    /// How far signal-to-noise may be off by the roundings of single precision: of the level, of the place between
    /// cells, and of the noise.
    fn signal_off(&self, raw: &Plane, mesh: &Mesh) -> Plane {
        let cells = || mesh.cells.iter().flatten();
        let range =
            |of: fn(&Sky) -> f64| cells().map(of).fold(f64::MIN, f64::max) - cells().map(of).fold(f64::MAX, f64::min);
        let (levels, noises) = (range(|sky| sky.level), range(|sky| sky.noise));
        Plane::from_fn(raw.width(), raw.height(), |i, j| {
            let (sky, signal) = (mesh.at(i as usize, j as usize), raw.at(i, j).abs());
            let level = bit(21) * sky.level.abs() + bit(17) * levels;
            let noise = bit(21) * sky.noise + bit(17) * noises;
            (level + signal * noise) / sky.noise + bit(21) * signal + 2.0 * self.grain
        })
    }

    fn smooth(&mut self, after: &Left) {
        let facts = self.facts;
        let (fine, off) = self.smoothed(&after.signal, 0.8);
        self.plane("fine", &after.fine, &fine, &off);
        self.noise = Tail::of(after.fine.values(), &after.masked, &facts).noise;
        let (spline, least) = reference::spline(&after.fine, &after.masked, &facts);
        let off = after.fine.map(|v| bit(20) * v.abs() + 3.0 * self.grain);
        let smooth = Plane::from_fn(spline.width(), spline.height(), |i, j| {
            let (fine, spline, off) = (after.fine.at(i, j), spline.at(i, j), off.at(i, j));
            let change = (fine - spline).abs();
            // The least change is five times what two ranks are apart.
            let open = (change - least).abs() <= 2.0 * off + 15.0 * self.grain + bit(18) * least;
            let fine_is_kept = if open { after.smooth.at(i, j) == fine } else { change >= least };
            if fine_is_kept { fine } else { spline }
        });
        let off = self.spline_off(&after.fine);
        self.plane("smooth", &after.smooth, &smooth, &off);
    }

    /// Three weights to a side.
    fn spline_off(&self, fine: &Plane) -> Plane {
        added(&Plane::from_fn(fine.width(), fine.height(), |_, _| 3.0 * self.grain), &greatest(fine, 2), bit(21))
    }

    /// A plane smoothed, and how far that may be off. In single precision, along either axis: the sums of as many weights
    /// and of as many products as there are to a side and in the middle, the sum of two values, an exponential, a product
    /// and a quotient. In fixed point a rounding for each weight, and the weights themselves.
    fn smoothed(&self, plane: &Plane, scale: f64) -> (Plane, Plane) {
        let reach = (3.5 * scale).ceil();
        let weights = if self.grain > 0.0 { 2.0 * (2.0 * reach + 1.0) * bit(25) } else { 0.0 };
        let share = (reach + 3.0) * bit(22);
        let off = reference::smoothed(&plane.map(f64::abs), scale).map(|v| share * v + (reach + 1.0) * self.grain);
        (reference::smoothed(plane, scale), added(&off, &greatest(plane, reach as isize), weights))
    }

    /// A plane sharpened, and how far that may be off.
    fn sharpened(&self, plane: &Plane, scale: f64, part: f64) -> (Plane, Plane) {
        let (_, off) = self.smoothed(plane, scale);
        let off = added(&off.map(|v| part.max(1.0) * v + self.grain), &plane.map(f64::abs), (1.0 + part) * bit(22));
        (reference::sharpened(plane, scale, part), off)
    }

    fn mask(&mut self, before: &Left, after: &Left) {
        let tail = Tail::of(before.fine.values(), &before.masked, &self.facts);
        let peak = tail.raised(3.5) * tail.noise;
        let border = 16.0 * self.grain + bit(20);
        let wrong = |marks: &Plane| {
            let pixels = marks.values().iter().zip(&after.masked).zip(&self.signals);
            let wrong = pixels.filter(|((mark, masked), signal)| {
                let is_open = (*mark - reference::MASKED).abs() <= border && **signal;
                !is_open && **masked != (**mark > reference::MASKED || !**signal)
            });
            wrong.count()
        };
        let slack = Slack { relative: bit(20), absolute: 3.0 * self.grain };
        let run = |judge: &Judge| reference::marks(&before.fine, &before.smooth, self.asked.threshold, peak, judge);
        let wrong = wrong(&reference::nearest(slack, run, wrong));
        self.notes.count("mask", wrong);
    }

    /// Signal-to-noise after a filter in steps, whose last image lies between 0 and 1.
    fn filtered(
        &mut self,
        asked: &Parameters,
        image: &[f32],
        last: &[f64],
        filtered: &[f32],
    ) -> Result<(), ReferenceError> {
        let (width, height) = (self.width, image.len() / self.width);
        let plane =
            |value: &dyn Fn(usize) -> f64| Plane::from_fn(width, height, |i, j| value(j as usize * width + i as usize));
        let pixels: Vec<f64> = image.iter().map(|&v| v.into()).collect();
        let range = crate::reference::range(asked.normalize, &pixels)?;
        let exact = crate::reference::denormalized(range, &plane(&|at| last[at]));
        let core = plane(&|at| filtered[at].into());
        let off = exact.map(|_| bit(22) * (range.0.abs() + range.1.abs()));
        self.plane("smoothed", &core, &exact, &off);
        self.filtered = Some(core);
        Ok(())
    }

    fn front<L: Level>(&mut self, before: &Left, after: &Left) {
        use reference::{FLAT, start, step};
        let (asked, width, height) = (self.asked, self.width, before.fine.height());
        let front = Front::<L>::new(self.config.outline);
        let filtered = self.filtered.clone();
        let image = match asked.smoothing {
            reference::Smoothing::None => filtered.as_ref().unwrap_or(&before.signal),
            reference::Smoothing::Fine => &before.fine,
            reference::Smoothing::ByNeed => &before.smooth,
        };
        let cells = |plane: &Plane| plane.values().iter().map(|&v| L::of(v as f32)).collect::<Vec<L>>();
        let level = |bits: u32| f64::from(L::from_bits(bits).to_f32());
        let plane = |bits: &[u32]| Plane::from_fn(width, height, |i, j| level(bits[j as usize * width + i as usize]));
        let (signal, mut u, mut rows) = (cells(&before.fine), vec![0; width * height], vec![L::ZERO; ROWS * width]);
        front.start(&cells(image), &mut u);
        let Some(grid) = Grid::of(u.len(), width) else { return };
        let off = image.map(|v| self.grain + bit(23) * (v.abs() + 1.0));
        self.plane("u0", &plane(&u), &start(image, asked.threshold), &off);
        for _ in 0..asked.steps {
            let old = plane(&u);
            front.step(&signal, &mut u, &mut rows, grid, &Alone);
            let off = self.front_off(&old, &before.fine);
            // On which side of the least gradient a pixel lies may hang on a rounding.
            let open = if self.grain > 0.0 { 0.05 } else { bit(12) };
            let moved = |flat: f64| step(&old, &before.fine, asked.threshold, asked.curvature, flat);
            let [low, exact, high] = [FLAT * (1.0 - open), FLAT, FLAT * (1.0 + open)].map(moved);
            let core = plane(&u);
            let nearest = Plane::from_fn(width, height, |i, j| {
                let far = |plane: &&Plane| (plane.at(i, j) - core.at(i, j)).abs();
                let ways = [&exact, &low, &high];
                ways.into_iter().min_by(|a, b| far(a).total_cmp(&far(b))).map_or(0.0, |plane| plane.at(i, j))
            });
            self.plane("u", &core, &nearest, &off);
        }
        // What was stepped here is what the run did.
        self.plane("u", &after.front, &plane(&u), &off.map(|_| 0.0));
    }

    /// The length of the gradient is taken to a thousandth; fixed point rounds twice the parts of the direction, the
    /// products and the quotient, each a grain of the second differences.
    fn front_off(&self, u: &Plane, fine: &Plane) -> Plane {
        Plane::from_fn(u.width(), u.height(), |i, j| {
            let v = u.around(i, j);
            let force = reference::force(fine.at(i, j), self.asked.threshold);
            let bends =
                (v.e + v.w - 2.0 * v.c).abs() + (v.n + v.s - 2.0 * v.c).abs() + 0.5 * (v.ne + v.sw - v.nw - v.se).abs();
            let way = 1.05e-3 * force.abs() * reference::steepness(&v, force);
            let rounded = self.grain * (6.0 + 8.0 * bends) + bit(20) * (1.0 + bends);
            reference::STEP * (way + self.grain * force.abs() + self.asked.curvature * rounded) + self.grain + bit(22)
        })
    }

    fn outline(&mut self, front: &[f32], after: &Left) {
        let (width, height) = (self.width, after.front.height());
        let p = parameters(&self.config);
        let wrong = (0..front.len()).filter(|&at| {
            let far = is_beyond_reach(&p, at, width, height);
            (front[at] > 0.0 && !far) != (after.front.values()[at] > 0.0)
        });
        self.notes.count("outline", wrong.count());
    }

    fn inside(&self, left: &Left) -> Vec<bool> {
        left.front.values().iter().zip(&self.signals).map(|(&u, &signal)| u > 0.0 && signal).collect()
    }

    fn tree(&mut self, before: &Left, after: &Left) {
        let (sharp, off) = self.sharpened(&before.fine, 1.5, self.asked.sharpening);
        self.plane("sharpened", &after.fine, &sharp, &off);
        let inside = self.inside(before);
        let run =
            |judge: &Judge| after.renumbered(&reference::tree(&after.fine, &inside, self.photon, &self.asked, judge));
        self.regions = reference::nearest(self.slack(), run, |regions| apart(after.has(), regions));
        self.notes.count("tree", apart(after.has(), &self.regions));
        let pairs = self.regions.table.iter().zip(&after.regions).filter(|(exact, _)| exact.area >= 3);
        self.notes.count("tree", pairs.filter(|(exact, core)| exact.peak != core.peak).count());
    }

    fn components(&mut self, before: &Left, after: &Left) {
        self.regions = reference::components(&self.inside(before), self.width, self.asked.connectivity);
        reference::drop_undefined(&mut self.regions.labels, &self.defined);
        self.notes.count("components", differing(&self.regions.labels, &after.labels));
    }

    fn deblend(&mut self, before: &Left, passes: &Passes, after: &Left) {
        let image = &before.fine;
        let Some(competitions) = passes.competitions(image) else { return self.notes.missing("shapes") };
        let opened = &competitions[0][0];
        let run = |judge: &Judge| {
            let mut regions = self.regions.clone();
            let noise = (self.noise, self.photon);
            reference::opened(image, &before.smooth, &mut regions, noise, &self.asked, judge);
            regions
        };
        let distance = |regions: &Regions| apart((&opened.labels, &opened.regions), regions);
        self.regions = reference::nearest(self.slack(), run, distance);
        self.notes.count("opened", distance(&self.regions));
        let roundings = Roundings { grain: self.grain, unit: bit(24) };
        let most = image.values().iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let has_pixels = has_pixels(&opened.labels, opened.regions.len());
        let pairs = opened.regions.iter().zip(&self.regions.table).zip(has_pixels);
        for ((core, exact), _) in pairs.filter(|(_, has_pixels)| *has_pixels) {
            // Of every pixel of a group the mirrored light is taken away.
            let off = exact.area as f64 * (3.0 * self.grain + bit(21) * most) + bit(40) * exact.sum.abs();
            self.notes.number("opened", core.sum, exact.sum - off, exact.sum + off);
        }
        for passes in competitions {
            for [core, exact, off] in passes[0].shapes(image) {
                self.notes.number("shapes", core, exact - off, exact + off);
            }
            self.notes.count("borders", wrong_owners(image, roundings, passes));
        }
        let [.., last] = competitions[1] else { return self.notes.missing("deblended") };
        self.regions.labels.clone_from(&last.labels);
        self.make_room(last.regions.len());
        let run = |judge: &Judge| {
            let mut regions = self.regions.clone();
            reference::settle(image, &mut regions, &self.asked, judge);
            reference::drop_undefined(&mut regions.labels, &self.defined);
            regions
        };
        self.regions = reference::nearest(self.slack(), run, |regions| apart(after.has(), regions));
        self.notes.count("deblended", apart(after.has(), &self.regions));
    }

    /// Where the two differ already, the core may have more regions.
    fn make_room(&mut self, regions: usize) {
        let table = &mut self.regions.table;
        table.resize(table.len().max(regions), Region::BLANK);
    }

    fn select(&mut self, before: &Left, after: &Left) {
        let (settings, core) = (self.asked, &after.fine);
        if settings.by_significance {
            let (smooth, first) = self.smoothed(&before.signal, 1.7);
            let (matched, second) = self.sharpened(&smooth, 2.5, 0.6);
            let off = added(&second, &first, 3.0);
            self.plane("matched", core, &matched, &off);
        }
        self.make_room(before.regions.len());
        let regions = Regions { labels: before.labels.clone(), table: std::mem::take(&mut self.regions.table) };
        let (signal, masked) = (&before.signal, &before.masked);
        let run = |judge: &Judge| {
            let cut = reference::cut(signal, core, masked, &self.facts, &regions, &settings, judge);
            (cut.significance, reference::select(signal, core, &regions, cut, &settings, judge))
        };
        let slack = Slack { relative: bit(18), absolute: 2.0 * self.grain };
        let wrong = |(labels, _): &(Vec<u32>, u32)| differing(labels, &after.labels);
        let (significance, selected) = reference::nearest(slack, run, |(_, selected)| wrong(selected));
        self.notes.count("labels", wrong(&selected));
        self.cut = significance;
        self.sources = selected.1;
        self.pixels_kept = selected.0.iter().filter(|&&label| label != 0).count();
    }

    /// The numbers that a run tells.
    fn found(&mut self, found: &Found) {
        let (facts, values) = (self.facts, found.values);
        let fill = values.fill.is_finite().then(|| f64::from(values.fill));
        let count = |what: &[bool]| what.iter().filter(|&&is| is).count() as u32;
        let filled = self.pixels.iter().filter(|&&v| Some(v) == facts.fill).count() as u32;
        let whole = [
            fill != facts.fill,
            values.piled != facts.cut_off,
            values.coarse != facts.coarse,
            values.defined != count(&self.defined),
            values.filled != filled,
            found.sources != self.sources,
            found.mask_pixels as usize != self.pixels_kept,
        ];
        self.notes.count("facts", whole.into_iter().filter(|&wrong| wrong).count());
        for (core, exact) in [(values.step, facts.step), (values.resolution, facts.resolution)] {
            let scale = if exact > 0.0 { exact } else { 1.0 };
            self.notes.number("facts", f64::from(core) / scale, exact / scale - bit(21), exact / scale + bit(21));
        }
        let off = bit(18) * (1.0 + 4.0 * self.photon);
        self.notes.number("photon", found.photon.into(), self.photon - off, self.photon + off);
        let off = bit(18) * (1.0 + self.cut) + 8.0 * self.grain;
        self.notes.number("cut", found.significance.into(), self.cut - off, self.cut + off);
    }
}

/// A plane and so many times another.
fn added(plane: &Plane, other: &Plane, times: f64) -> Plane {
    Plane::from_fn(plane.width(), plane.height(), |i, j| plane.at(i, j) + times * other.at(i, j))
}

/// The greatest size of a number so near along both axes.
fn greatest(plane: &Plane, reach: isize) -> Plane {
    let (width, height) = (plane.width(), plane.height());
    let most = |of: &dyn Fn(isize) -> f64| (-reach..=reach).map(|n| of(n).abs()).fold(0.0, f64::max);
    let rows = Plane::from_fn(width, height, |i, j| most(&|n| plane.at(i + n, j)));
    Plane::from_fn(width, height, |i, j| most(&|n| rows.at(i, j + n)))
}

/// Pixels with another label.
fn differing(one: &[u32], other: &[u32]) -> usize {
    one.iter().zip(other).filter(|(one, other)| one != other).count()
}
