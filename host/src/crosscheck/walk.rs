//! The core taken step by step, each beside the reference's step from the very same input.

use super::CheckError;
use super::notes::{Difference, Notes};
use super::rounding::{Rounding, bit};
use crate::pipeline::MOST_SOURCES;
use crate::planes::{BandRoom, Room};
use crate::reference::multiphase::{self, Fronts};
use crate::reference::{self as r, Filtering, Order, Parameters, Plane, Rescale, Scheme};
use skyfront_core::arithmetic::{Arithmetic, Cell, Real};
use skyfront_core::config::{self as c, Config};
use skyfront_core::front::pair;
use skyfront_core::image::filter::total_variation::components;
use skyfront_core::run::frame::{BandFrame, SliceFrame};
use skyfront_core::run::outcome::{Outcome, Progress};
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::stage::Stage;
use skyfront_core::sources::catalog::Source;

/// Runs the core and looks at each of its steps beside the reference's with `parameters`: those of the configuration,
/// or others to see whether it is noticed. After every pass `meddle` may do something to the run.
///
/// # Errors
/// What the core or the reference finds wrong with the configuration or the image.
pub fn walk<A: Arithmetic>(
    config: &Config,
    parameters: &Parameters,
    pixels: &[f32],
    (width, height): (usize, usize),
    meddle: &mut dyn FnMut(Stage, &mut Segmenter<'_, A>),
) -> Result<Vec<Difference>, CheckError> {
    let mut room = Room::<A>::new(config, width, height, (width * height / 4).clamp(1, MOST_SOURCES));
    let mut run = Segmenter::<A>::new(config, width, height, room.memory())?;
    let mut walk = Walk::new(config, *parameters, pixels, &run, None);
    loop {
        let stage = run.stage();
        let progress = run.poll(usize::MAX, &mut SliceFrame(pixels))?;
        meddle(stage, &mut run);
        walk.see(stage, &run, &progress);
        if let Progress::Done(outcome) = progress {
            walk.image_steps::<A>(&outcome)?;
            // The front of regions is another's.
            if config.scheme != c::Scheme::Region {
                let levels = [level::<A>(&outcome)];
                walk.start_level(levels[0]);
                walk.front_steps(&outcome, &levels);
            }
            // On signal-to-noise sources are another's concern.
            if !config.sky.is_known() {
                walk.sources(&outcome, run.front().iter().map(|cell| cell.label()), run.catalog());
            }
            return Ok(walk.notes.found);
        }
    }
}

/// The same of a front in several bands ([`skyfront_core::front::bands`]).
///
/// # Errors
/// Those of [`walk`].
pub fn walk_bands<A: Arithmetic>(
    config: &Config,
    parameters: &Parameters,
    bands: &[&[f32]],
    (width, height): (usize, usize),
) -> Result<Vec<Difference>, CheckError> {
    let mut room = Room::<A>::new(config, width, height, (width * height / 4).clamp(1, MOST_SOURCES));
    let mut more = BandRoom::<A>::new(bands.len(), width * height);
    let mut run = Segmenter::<A>::of_bands(config, width, height, room.memory(), more.bands())?;
    let of_band = |(at, pixels): (usize, &&[f32])| Walk::new(config, *parameters, pixels, &run, Some(at));
    let mut walks: Vec<Walk> = bands.iter().enumerate().map(of_band).collect();
    // Bands are made ready from the last to the first, and levels found.
    let (mut images, mut starts) = ((0..bands.len()).rev(), (0..bands.len()).rev());
    let (mut at, mut levels) = (images.next().unwrap_or_default(), vec![0.0; bands.len()]);
    loop {
        let (stage, known) = (run.stage(), run.outcome());
        let progress = run.poll(usize::MAX, &mut BandFrame(bands))?;
        if stage.is_of_band() {
            walks[at].see(stage, &run, &progress);
            if !run.stage().is_of_band() || run.stage() == Stage::Extremes {
                walks[at].image_steps::<A>(&known)?;
                levels[at] = level::<A>(&known);
                at = images.next().unwrap_or_default();
            }
            continue;
        }
        if stage == Stage::StartLevel
            && let Some(at) = starts.next()
        {
            levels[at] = level::<A>(&run.outcome());
            walks[at].start_level(levels[at]);
        }
        let Some((first, others)) = walks.split_first_mut() else { return Ok(Vec::new()) };
        if first.further.len() < others.len() {
            first.further = others.iter().map(|walk| walk.image.clone()).collect();
        }
        first.see(stage, &run, &progress);
        if let Progress::Done(outcome) = progress {
            first.front_steps(&outcome, &levels);
            first.sources(&outcome, run.front().iter().map(|cell| cell.label()), run.catalog());
            for note in others.iter().flat_map(|walk| &walk.notes.found) {
                first.notes.add(note.step, note.max, note.beyond);
            }
            return Ok(std::mem::take(&mut first.notes.found));
        }
    }
}

/// The threshold of `r3`, or that of the start, as the arithmetic has it.
fn level<A: Arithmetic>(outcome: &Outcome) -> f64 {
    A::Real::of(outcome.tau).to_f32().into()
}

/// What was seen of a run so far.
struct Walk {
    /// Which of several bands is looked at.
    band: Option<usize>,
    /// What the front sees of the bands after it.
    further: Vec<Plane>,
    p: Parameters,
    rounding: Rounding,
    pixels: Vec<f64>,
    /// Units of the front plane in 1 of the paper's u.
    unit: f64,
    /// Whether a banded front is drawn out after each step.
    settles: bool,
    /// Where the range of the arithmetic ends, in units of the front plane: fast marching holds a front in pixels.
    limit: f64,
    /// The image plane as the last step left it.
    image: Plane,
    normalised: Option<Plane>,
    rescaled: Option<Plane>,
    filtered: Option<Plane>,
    /// The image before the filter, and how far the filter has come.
    unfiltered: Option<Plane>,
    filtering: Option<Filtering>,
    filter_passes: u32,
    /// The filter's passes that the reference does without.
    measuring_passes: u32,
    g: Option<Plane>,
    u0: Option<Plane>,
    /// The front, in the paper's u.
    front: Plane,
    /// Where there are two, the second and the means of the phases.
    second: Option<Plane>,
    means: [f64; 4],
    steps: u32,
    notes: Notes,
}

impl Walk {
    fn new<A: Arithmetic>(
        config: &Config,
        p: Parameters,
        pixels: &[f32],
        run: &Segmenter<'_, A>,
        band: Option<usize>,
    ) -> Walk {
        let (width, height) = run.size();
        let empty = Plane::from_fn(width, height, |_, _| 0.0);
        Walk {
            band,
            further: Vec::new(),
            rounding: Rounding::of::<A>(p.band),
            pixels: pixels.iter().map(|&v| v.into()).collect(),
            unit: run.unit().into(),
            limit: f64::from(A::LIMIT),
            settles: p.band.is_some()
                && A::NEEDS_BAND.is_none()
                && !matches!(p.scheme, Scheme::ChanVese | Scheme::Multiphase),
            image: empty.clone(),
            normalised: None,
            rescaled: None,
            filtered: None,
            unfiltered: None,
            filtering: None,
            filter_passes: 0,
            measuring_passes: config.filter.passes(config.filter_steps).saturating_sub(p.filter.passes()),
            g: None,
            u0: None,
            front: empty,
            second: None,
            means: [0.0; 4],
            steps: 0,
            notes: Notes::default(),
            p,
        }
    }

    fn plane(&self, value: impl Fn(usize) -> f64) -> Plane {
        let width = self.image.width();
        Plane::from_fn(width, self.image.height(), |i, j| value(j as usize * width + i as usize))
    }

    /// Looks at what a pass left behind.
    fn see<A: Arithmetic>(&mut self, stage: Stage, run: &Segmenter<'_, A>, progress: &Progress) {
        let cells = self.band.map_or(run.image(), |band| run.band(band));
        let image = || self.plane(|at| cells.get(at).map_or(f64::NAN, |&cell| A::pixel(cell).to_f32().into()));
        let front_of = |value: &dyn Fn(A::Cell) -> A::Real| {
            let value = |&cell: &A::Cell| f64::from(value(cell).to_f32()) / self.unit;
            self.plane(|at| run.front().get(at).map_or(f64::NAN, value))
        };
        let front = || front_of(&A::level);
        let both = || [0, 1].map(|at| front_of(&|cell| pair::values(cell)[at]));
        let two_fronts = self.p.scheme == Scheme::Multiphase;
        match stage {
            Stage::Normalize => {
                self.image = image();
                self.normalised = Some(self.image.clone());
            }
            Stage::Rescale => {
                self.image = image();
                self.rescaled = Some(self.image.clone());
            }
            Stage::Filter => {
                let kept = self.kept::<A>(run);
                let next = Filtering { image: image(), kept };
                self.filter_pass(next);
            }
            Stage::Edge => self.g = Some(image()),
            Stage::Front if two_fronts => self.phases_start(both()),
            Stage::Evolve if two_fronts => {
                let next = both();
                self.steps += 1;
                self.phases_step(&next);
                let [first, second] = next;
                let before = std::mem::replace(&mut self.front, first);
                let second_before = self.second.replace(second.clone()).unwrap_or(second.clone());
                let first = self.front.clone();
                let pairs = [(&before, &first), (&second_before, &second)];
                self.stop_rule(&pairs, run.stage() != Stage::Evolve, progress);
            }
            // Counted in the first pass, ranked in the second.
            Stage::Turn if two_fronts && run.stage() != Stage::Turn => {
                let ranks = front();
                self.phases_ranked(&ranks);
                self.front = ranks;
            }
            Stage::Front => {
                self.front = front();
                self.u0 = Some(self.front.clone());
            }
            Stage::Evolve => {
                let next = front();
                self.steps += 1;
                self.front_step(&next);
                let before = std::mem::replace(&mut self.front, next);
                let pairs = [(&before, &self.front.clone())];
                self.stop_rule(&pairs, run.stage() != Stage::Evolve, progress);
            }
            Stage::Arrive => {
                self.front = front();
                self.arrivals();
            }
            _ => {}
        }
    }

    /// What a filter keeps in the front plane.
    fn kept<A: Arithmetic>(&self, run: &Segmenter<'_, A>) -> Vec<Plane> {
        let plane = |value: &dyn Fn(A::Cell) -> A::Real| {
            self.plane(|at| run.front().get(at).map_or(f64::NAN, |&cell| value(cell).to_f32().into()))
        };
        match self.p.filter {
            r::Filter::Starlet { .. } => vec![plane(&A::pixel)],
            r::Filter::TotalVariation { .. } => {
                vec![plane(&|cell| components(cell)[0]), plane(&|cell| components(cell)[1])]
            }
            _ => Vec::new(),
        }
    }

    /// A pass of the filter; those before the reference's first leave the image alone.
    fn filter_pass(&mut self, next: Filtering) {
        let pass = self.filter_passes.checked_sub(self.measuring_passes);
        let before = self.filtering.take().unwrap_or(Filtering { image: self.image.clone(), kept: Vec::new() });
        let first = self.unfiltered.get_or_insert_with(|| before.image.clone());
        let reference = match pass {
            Some(pass) => r::filter_pass(self.p.filter, self.p.dx, pass, first, &before),
            None => Filtering { kept: Vec::new(), ..before },
        };
        let (image_off, kept_off) = self.filter_off(pass.unwrap_or(0));
        let planes = [(&next.image, &reference.image, image_off)].into_iter();
        let kept = next.kept.iter().zip(&reference.kept).map(|(core, reference)| (core, reference, kept_off));
        for (core, reference, off) in planes.chain(kept) {
            self.notes.plane("filtered", core, &reference.map(|v| v - off), &reference.map(|v| v + off));
        }
        self.filter_passes += 1;
        self.filtered = Some(next.image.clone());
        self.image = next.image.clone();
        self.filtering = Some(next);
    }

    /// How far a pass may be off by what is rounded inside it: the image, and what is kept beside it.
    fn filter_off(&self, pass: u32) -> (f64, f64) {
        match self.p.filter {
            // A row of the spline along columns has cells; so have the details of which the noise is told.
            r::Filter::Starlet { significance, scales } if pass < scales => {
                let noise = 1.4826 * (self.rounding.cell + bit(23)) * r::scale_noise(pass);
                (self.rounding.cell, 2.0 * self.rounding.cell + 2.0 * significance * noise)
            }
            // The field ends a step short of 1.
            r::Filter::TotalVariation { weight, .. } => (weight * bit(21), bit(14)),
            // A mean of 25 products, each rounded.
            r::Filter::Bilateral { .. } => (25.0 * bit(25), 0.0),
            _ => (0.0, 0.0),
        }
    }

    /// Steps 1 to 3.
    fn image_steps<A: Arithmetic>(&mut self, outcome: &Outcome) -> Result<(), CheckError> {
        self.normalisation(outcome)?;
        let none = self.image.clone();
        let normalised = self.normalised.clone().unwrap_or(none);
        let into_rescaling = match (self.p.order, &self.filtered) {
            (Order::FilterFirst, Some(filtered)) => filtered.clone(),
            _ => normalised,
        };
        self.threshold(outcome, &into_rescaling);
        self.rescaling(&into_rescaling, level::<A>(outcome));
        if self.filtered.is_some() != (self.p.filter.passes() > 0) {
            self.notes.missing("filtered");
        }
        Ok(())
    }

    /// Step 4 and the front before it moves, in each band around what is above its level.
    fn front_steps(&mut self, outcome: &Outcome, levels: &[f64]) {
        let last = self.image.clone();
        if !self.is_by_regions() {
            self.detector(outcome, &last);
        }
        if self.p.scheme != Scheme::Multiphase {
            self.start(&last, levels);
        }
    }

    fn is_by_regions(&self) -> bool {
        matches!(self.p.scheme, Scheme::ChanVese | Scheme::Multiphase)
    }

    fn normalisation(&mut self, outcome: &Outcome) -> Result<(), CheckError> {
        let (low, high) = r::range(self.p.normalize, &self.pixels)?;
        let range = (f64::from(outcome.range.low), f64::from(outcome.range.high));
        let (rounded, span) = (bit(21) * (low.abs() + high.abs()), high - low);
        for (core, level) in [(range.0, low), (range.1, high)] {
            self.notes.number("levels", core / span, (level - rounded) / span, (level + rounded) / span);
        }
        match self.normalised.clone() {
            Some(core) => {
                let reference = r::normalize(range, &self.pixels, core.width(), core.height());
                self.notes.plane("normalised", &core, &reference, &reference);
            }
            None => self.notes.missing("normalised"),
        }
        Ok(())
    }

    /// The threshold that r3 used.
    fn threshold(&mut self, outcome: &Outcome, image: &Plane) {
        let defined: Vec<bool> = self.pixels.iter().map(|v| v.is_finite()).collect();
        if let Some(tau) = r::threshold(self.p.rescale, self.p.tau, image, &defined) {
            self.notes.number("tau", outcome.tau.into(), tau, tau);
        }
    }

    /// The level around which the front starts, where r3 has no threshold.
    fn start_level(&mut self, level: f64) {
        if self.p.start_margin.is_some() && !matches!(self.p.rescale, Rescale::R3 { .. }) {
            let otsu = r::otsu(self.image.values().iter().copied());
            self.notes.number("tau", level, otsu, otsu);
        }
    }

    fn rescaling(&mut self, image: &Plane, tau: f64) {
        if self.rescaled.is_some() != (self.p.rescale != Rescale::None) {
            self.notes.missing("rescaled");
        }
        let Some(core) = self.rescaled.clone() else { return };
        let off = self.rounding.value;
        let moved = |by: f64| r::rescale(self.p.rescale, Some(tau), &image.map(|x| (x + by).clamp(0.0, 1.0)));
        let (low, high) = (moved(-off), moved(off));
        self.notes.plane("rescaled", &core, &low, &high);
    }

    fn detector(&mut self, outcome: &Outcome, image: &Plane) {
        let slope = r::gradient(image, self.p.dx);
        let (m, big_m) = r::gradient_range(&slope);
        let per_dx = 0.5 / self.p.dx;
        let rounding = self.rounding;
        let off = |z: f64| rounding.of_gradient(z / per_dx) * per_dx;
        for (core, z) in [(outcome.gradient.0, m), (outcome.gradient.1, big_m)] {
            self.notes.number("gradient", core.into(), z - off(z), z + off(z));
        }
        let Some(core) = self.g.clone() else { return self.notes.missing("g") };
        let moved = |by: f64| {
            let slope = slope.map(|z| (z + by * off(z)).max(0.0));
            let (m, big_m) = ((m - by * off(m)).max(0.0), big_m - by * off(big_m));
            r::detector(self.p.edge, &slope, m, big_m).map(|g| g.clamp(0.0, 1.0))
        };
        let (low, high) = (moved(1.0), moved(-1.0));
        self.notes.plane("g", &core, &low, &high);
    }

    fn start(&mut self, image: &Plane, levels: &[f64]) {
        let Some(core) = self.u0.clone() else { return self.notes.missing("u0") };
        let (reference, roundings) = match self.p.start_margin {
            None => (r::framed(&self.p, image.width(), image.height()), 1.0),
            // A distance is a sum of as many steps.
            Some(margin) => (r::near_any(&self.p, &self.seen(image), levels, margin), margin + 4.0),
        };
        let (off, limit) = (self.rounding.start * roundings / self.unit, self.limit / self.unit);
        let reference = reference.map(|u| u.clamp(-limit, limit));
        self.notes.plane("u0", &core, &reference.map(|u| u - off), &reference.map(|u| u + off));
    }

    /// What the front sees of all bands.
    fn seen(&self, image: &Plane) -> Vec<Plane> {
        std::iter::once(image).chain(&self.further).cloned().collect()
    }

    /// What the front moves over: the edge detector, or for regions the image.
    fn speed(&self) -> &Plane {
        self.g.as_ref().filter(|_| !self.is_by_regions()).unwrap_or(&self.image)
    }

    /// One step of the front, in its own unit.
    fn front_step(&mut self, next: &Plane) {
        let step = |p: &Parameters| {
            let moved = match self.further[..] {
                [] => r::step(p, self.speed(), &self.front),
                _ => r::chan_vese::step(p, &self.seen(&self.image), &self.front),
            };
            self.settled(&moved)
        };
        let reference = step(&self.p);
        let off = self.step_off();
        let apart = |low: &Plane, high: &Plane| {
            let bounds = low.values().iter().zip(high.values()).zip(off.values());
            next.values().iter().zip(bounds).fold(0.0f64, |most, (v, ((low, high), off))| {
                let v = v * self.unit;
                most.max((low.min(*high) - off - v).max(v - low.max(*high) - off))
            })
        };
        let mut beyond = apart(&reference, &reference);
        // On which side of the least gradient a node lies may depend on a rounding.
        if beyond > bit(22) && matches!(self.p.scheme, Scheme::FdCurvature | Scheme::SlCurvature) {
            let flat = |share: f64| step(&Parameters { degenerate_c: self.p.degenerate_c * share, ..self.p });
            beyond = apart(&flat(1.0 - self.rounding.flat), &flat(1.0 + self.rounding.flat)).min(beyond);
        }
        let pairs = next.values().iter().zip(reference.values());
        let max = pairs.fold(0.0f64, |most, (v, w)| most.max((v * self.unit - w).abs()));
        self.notes.add("u", max, beyond);
    }

    /// How far a step may be off at each node by what is rounded inside it.
    fn step_off(&self) -> Plane {
        let all = self.rounding.grid + self.means_off();
        let front = &self.front;
        Plane::from_fn(front.width(), front.height(), |i, j| all + self.direction_off(i, j))
    }

    /// Schemes that look along the normal or the contour: half a unit turns either where the gradient has few of them.
    /// The second derivative of the filtered scheme changes by no more than itself; what is seen along the contour, by
    /// the slopes around times the way that the far end moves.
    fn direction_off(&self, i: isize, j: isize) -> f64 {
        if self.rounding.direction == 0.0 {
            return 0.0;
        }
        let (p, v, g) = (&self.p, self.front.around(i, j), self.speed().at(i, j));
        let turned = || {
            let (x, y) = ((v.e - v.w) / 2.0, (v.n - v.s) / 2.0);
            (self.rounding.direction / (x.hypot(y) * self.unit)).min(1.0) * self.unit
        };
        let courant = p.dt / p.dx;
        match p.scheme {
            Scheme::FdFiltered => {
                let twist = (v.ne - v.nw - v.se + v.sw).abs() / 2.0;
                let bend = (v.e - 2.0 * v.c + v.w).abs() + (v.n - 2.0 * v.c + v.s).abs() + twist;
                courant * courant * g * g * bend * turned()
            }
            Scheme::SlCurvature => {
                let sides = [v.e, v.w, v.n, v.s].map(|side| (side - v.c).abs());
                let look = (2.0 * p.dt).sqrt() / p.dx;
                p.nu * g * look * 4.0 * sides.into_iter().fold(0.0, f64::max) * turned()
            }
            _ => 0.0,
        }
    }

    /// A front after a step, in its own unit.
    fn settled(&self, front: &Plane) -> Plane {
        let front = front.map(|u| u * self.unit);
        match self.p.band {
            Some(band) if self.settles => r::settle(&front, band),
            _ => front,
        }
    }

    /// How far a step of Chan and Vese may be off because their means are sums of whole units, 2^-12 of v and 2^-20 of
    /// the image: both regions have lost a unit of each v that is no whole number of them.
    fn means_off(&self) -> f64 {
        if self.p.scheme != Scheme::ChanVese {
            return 0.0;
        }
        let v = || self.front.values().iter().map(|u| u * self.unit);
        let between = v().filter(|v| v.abs() < 1.0).count() as f64;
        let (inside, outside): (f64, f64) = (v().map(|v| 1.0 + v).sum(), v().map(|v| 1.0 - v).sum());
        let mean = |weight: f64| bit(12) * between / weight.max(1.0) + bit(19);
        2.0 * self.p.dt * (self.p.lambda.0 * mean(inside) + self.p.lambda.1 * mean(outside))
    }

    /// The change that a step reports, and whether it was the last.
    fn stop_rule(&mut self, moved: &[(&Plane, &Plane)], over: bool, progress: &Progress) {
        let (least, most) = (self.change(moved, false), self.change(moved, true));
        if let Progress::Working { last_change, .. } = progress {
            self.notes.number("change", f64::from(*last_change), least.0, most.0);
        }
        let may_rest = r::at_rest(&self.p, least.0, least.1);
        let must_rest = r::at_rest(&self.p, most.0, most.1);
        let last = self.steps >= self.p.max_steps();
        let sound = if over { last || may_rest } else { !last && !must_rest };
        self.notes.number("stop", f64::from(u8::from(!sound)), 0.0, 0.0);
    }

    /// `critarr` and whether a node near the front changed sign, as roundings make them least and most: of each change,
    /// of the distance that counts as near, and of the sum. A single change counts half a unit at most.
    fn change(&self, moved: &[(&Plane, &Plane)], most: bool) -> (f64, bool) {
        let share = if most { 1.0 + bit(16) } else { 1.0 - bit(16) };
        let near = if self.is_by_regions() { f64::INFINITY } else { self.p.eps_front * share };
        let values = moved.iter().flat_map(|(old, new)| old.values().iter().zip(new.values()));
        let (mut sum, mut crossed) = (0.0, false);
        for (&old, &new) in values.filter(|(old, _)| old.abs() <= near) {
            let change = (new - old).abs() * self.unit;
            let rounded = if most { change + self.rounding.change } else { change.min(0.5) - self.rounding.change };
            sum += rounded.max(0.0);
            crossed |= (old > 0.0) != (new > 0.0);
        }
        (sum * share * self.p.dx * self.p.dx / self.unit, crossed)
    }

    /// Two fronts in pixels, from the paper's u.
    fn fronts(&self, [first, second]: [&Plane; 2]) -> Fronts {
        Fronts { first: first.map(|u| u * self.unit), second: second.map(|u| u * self.unit) }
    }

    /// The phases before the first step. Where a pixel lies as near to two means, a rounding may decide.
    fn phases_start(&mut self, core: [Plane; 2]) {
        self.means = multiphase::classes(&self.image);
        let [below, above] = [-1.0, 1.0].map(|side| {
            let moved = self.image.map(|v| v + side * bit(20));
            multiphase::start(&moved, self.means)
        });
        let planes = [(&core[0], &below.first, &above.first), (&core[1], &below.second, &above.second)];
        for (core, one, other) in planes {
            self.notes.plane("u0", &core.map(|u| u * self.unit), one, other);
        }
        let [first, second] = core;
        (self.front, self.second) = (first, Some(second));
    }

    /// One step of both fronts: the second beside the core's own first.
    fn phases_step(&mut self, next: &[Plane; 2]) {
        let Some(second) = self.second.clone() else { return self.notes.missing("u") };
        let before = self.fronts([&self.front, &second]);
        self.means = before.means(&self.image, self.means);
        // The nearest step of a cell.
        let off = bit(15) + self.phases_off(&before);
        let between = self.fronts([&next[0], &second]);
        let after = self.fronts([&next[0], &next[1]]);
        let first = before.step_first(&self.p, &self.image, self.means);
        let second = between.step_second(&self.p, &self.image, self.means);
        for (core, reference) in [(&after.first, &first), (&after.second, &second)] {
            self.notes.plane("u", core, &reference.map(|v| v - off), &reference.map(|v| v + off));
        }
    }

    /// [`Self::means_off`] of four phases, whose weights have lost a unit of each front and of their product.
    fn phases_off(&self, fronts: &Fronts) -> f64 {
        let values = || fronts.first.values().iter().zip(fronts.second.values());
        let between = values().filter(|(v, w)| v.abs() < 1.0 || w.abs() < 1.0).count() as f64;
        let shares = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let mean = |(first, second): (f64, f64)| {
            let weight: f64 = values().map(|(v, w)| (1.0 + first * v) * (1.0 + second * w)).sum();
            // One that has no pixels keeps its mean.
            if weight > 0.0 { (3.0 * bit(12) * between / weight).min(1.0) + bit(19) } else { 0.0 }
        };
        4.0 * self.p.dt * shares.into_iter().map(mean).fold(0.0, f64::max)
    }

    /// The phases at the end by their ranks.
    fn phases_ranked(&mut self, core: &Plane) {
        let Some(second) = &self.second else { return self.notes.missing("phases") };
        let ranks = self.fronts([&self.front, second]).ranks(&self.image);
        let core = core.map(|u| u * self.unit);
        self.notes.plane("phases", &core, &ranks, &ranks);
    }

    /// Each time of arrival beside the one that follows from the times around it.
    fn arrivals(&mut self) {
        let Some(g) = self.g.clone() else { return self.notes.missing("arrival") };
        let (Some(u0), farthest) = (self.u0.clone(), self.p.t_max / self.p.dx) else { return };
        // Fixed point ends at -128: the time of what lies there is known to be earlier.
        let lost = |u: f64| u <= -127.9 && farthest > 127.0;
        let times = Plane::from_fn(u0.width(), u0.height(), |i, j| {
            let u = self.front.at(i, j) * self.unit;
            if u > 0.0 { f64::INFINITY } else { u + farthest }
        });
        for j in 0..u0.height() as isize {
            for i in 0..u0.width() as isize {
                let near = times.around(i, j);
                let known = [near.c, near.e, near.w, near.n, near.s].iter().all(|t| !lost(t - farthest));
                if u0.at(i, j) <= 0.0 || !known {
                    continue;
                }
                let (time, soonest) = (times.at(i, j), r::soonest(&g, &times, i, j));
                let rounded = bit(20) * farthest;
                let late = if time.is_finite() { (time - soonest).abs() } else { (farthest - soonest).max(0.0) };
                self.notes.number("arrival", late, 0.0, LATE + rounded);
            }
        }
    }

    /// Components of the core's own mask, and the catalogue of the core's own labels.
    fn sources(&mut self, outcome: &Outcome, labels: impl Iterator<Item = u32>, catalogue: &[Source]) {
        let labels: Vec<u32> = labels.collect();
        let inside = self.front.values().iter().zip(&self.pixels).map(|(&u, v)| u > 0.0 && v.is_finite());
        let mask: Vec<bool> = inside.collect();
        let width = self.image.width();
        let (wanted, sources) = r::sources(&self.p, &mask, width);
        let differ = labels.iter().zip(&wanted).filter(|(one, other)| one != other).count();
        self.notes.number("labels", differ as f64, 0.0, 0.0);
        self.notes.number("labels", f64::from(outcome.sources), sources.into(), sources.into());
        let pixels = mask.iter().filter(|&&inside| inside).count() as f64;
        self.notes.number("labels", outcome.mask_pixels.into(), pixels, pixels);
        let truth = r::centroids(&wanted, sources, &self.pixels, width, f64::from(outcome.range.low));
        for (source, (x, y)) in catalogue.iter().zip(truth) {
            let (cx, cy) = source.centroid();
            self.notes.number("centroids", (f64::from(cx) - x).hypot(f64::from(cy) - y), 0.0, 0.0);
        }
    }
}

/// A pixel is settled at most this much, in pixels of free motion, after its neighbours' times say: twice the square of
/// a bucket's width.
const LATE: f64 = 1.0 / 32.0;
