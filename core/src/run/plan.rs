//! What a run does, as data: its steps in their order. Nothing else knows the order of the stages.
//!
//! From it follow what comes after a pass ([`crate::run::segmenter`]), the budget ([`crate::run::budget`]), the
//! soundness of a snapshot, and which plane holds what a step made, for digests and pictures.

use crate::config::{Config, Motion, Normalize, Order, Rescale, Scheme, Separate, Start, Tau};
use crate::front::march;
use crate::run::stage::Stage;
use crate::sky::noise;
use crate::sky::select;

/// Where a step leaves what it made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// In the image plane.
    Image,
    /// In the front plane.
    Front,
}

/// One step of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// What is done.
    pub stage: Stage,
    /// The most passes over the rows, whatever the image; at least 1.
    pub passes: u32,
    /// Whether each pass asks for the original pixels.
    pub reads_frame: bool,
    /// The plane that holds an image of its own when the step is over.
    pub leaves: Option<Plane>,
}

impl Step {
    const fn of(stage: Stage, passes: u32) -> Step {
        Step { stage, passes, reads_frame: reads_frame(stage), leaves: leaves(stage) }
    }
}

/// Whether a stage asks for the original pixels.
pub(crate) const fn reads_frame(stage: Stage) -> bool {
    matches!(
        stage,
        Stage::Extremes
            | Stage::LowPercentile
            | Stage::HighPercentile
            | Stage::Sky
            | Stage::Median
            | Stage::Normalize
            | Stage::Threshold
            | Stage::Provisional
            | Stage::Measure
    )
}

/// The plane that holds an image of its own when a stage is over.
pub const fn leaves(stage: Stage) -> Option<Plane> {
    match stage {
        Stage::Normalize | Stage::Rescale | Stage::Filter | Stage::Edge => Some(Plane::Image),
        Stage::Front | Stage::Evolve | Stage::Arrive | Stage::Turn | Stage::Measure => Some(Plane::Front),
        _ => None,
    }
}

/// How often the sky is measured on the way to signal-to-noise.
pub(crate) const ROUNDS: u32 = 3;
/// From the pixels to signal-to-noise: the sky is measured anew without the sources, twice.
const SKY: [Stage; 10] = [
    Stage::Values,
    Stage::Background,
    Stage::Smooth,
    Stage::Mask,
    Stage::Background,
    Stage::Smooth,
    Stage::Mask,
    Stage::Background,
    Stage::Smooth,
    Stage::Photon,
];
/// From the pixels to the image plane.
const NORMALISING: [Stage; 6] =
    [Stage::Extremes, Stage::LowPercentile, Stage::HighPercentile, Stage::Sky, Stage::Median, Stage::Normalize];
/// Steps 2 and 3, in both orders.
const RESCALING_FIRST: [Stage; 3] = [Stage::Threshold, Stage::Rescale, Stage::Filter];
const FILTERING_FIRST: [Stage; 3] = [Stage::Filter, Stage::Threshold, Stage::Rescale];
/// Step 3 alone: what a segmenter does for the front from the threshold, which is an extractor's.
const FILTERING: [Stage; 1] = [Stage::Filter];
const OUTLINING: [Stage; 1] = [Stage::Outline];
/// From the filtered image to the front at its end.
const FRONT: [Stage; 13] = [
    Stage::StartLevel,
    Stage::StartMark,
    Stage::StartUp,
    Stage::StartDown,
    Stage::Gradient,
    Stage::Edge,
    Stage::Front,
    Stage::Evolve,
    Stage::Seed,
    Stage::Sow,
    Stage::March,
    Stage::Arrive,
    Stage::Turn,
];
/// From the front to the catalogue.
const LABELLING: [Stage; 5] = [Stage::Provisional, Stage::Resolve, Stage::Count, Stage::Number, Stage::Measure];
/// From the outlines to sources, on signal-to-noise.
const DIVIDING: [Stage; 3] = [Stage::Tree, Stage::Deblend, Stage::Select];
const CONNECTING: [Stage; 2] = [Stage::Components, Stage::Select];

/// The steps of the run of a configuration.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    config: &'a Config,
    /// How often the steps up to the filtered image are taken.
    bands: u32,
}

impl<'a> Plan<'a> {
    /// The plan of a configuration, for frames of every size and one band.
    pub fn of(config: &'a Config) -> Plan<'a> {
        Plan { config, bands: 1 }
    }

    /// The same for frames of several bands ([`crate::front::bands`]), one at least.
    #[must_use]
    pub fn of_bands(config: &'a Config, bands: usize) -> Plan<'a> {
        Plan { config, bands: u32::try_from(bands).unwrap_or(u32::MAX).max(1) }
    }

    /// The configuration.
    pub(crate) fn config(self) -> &'a Config {
        self.config
    }

    /// The steps in their order, without those that take no pass.
    pub fn steps(self) -> impl Iterator<Item = Step> + 'a {
        self.stages().map(move |stage| Step::of(stage, self.most_passes(stage))).filter(|step| step.passes > 0)
    }

    fn stages(self) -> impl Iterator<Item = Stage> {
        let (sky, sources): (&'static [Stage], &'static [Stage]) =
            match (self.config.sky.is_known(), self.config.separate) {
                (false, _) => (&[], &LABELLING),
                (true, Separate::Tree) => (&SKY, &DIVIDING),
                (true, Separate::Components) => (&SKY, &CONNECTING),
            };
        sky.iter().chain(self.front_stages()).chain(sources).copied()
    }

    /// From the image to the front at its end.
    fn front_stages(self) -> impl Iterator<Item = &'static Stage> {
        let by_region = self.config.scheme == Scheme::Region;
        let (normalising, middle, front): (&'static [Stage], &'static [Stage], &'static [Stage]) =
            match (by_region, self.config.order) {
                (true, _) if self.config.filter.is_stepped() => (&NORMALISING, &FILTERING, &OUTLINING),
                (true, _) => (&[], &[], &OUTLINING),
                (false, Order::RescaleFirst) => (&NORMALISING, &RESCALING_FIRST, &FRONT),
                (false, Order::FilterFirst) => (&NORMALISING, &FILTERING_FIRST, &FRONT),
            };
        normalising.iter().chain(middle).chain(front)
    }

    /// A step of the run; `None` for a stage that it does without.
    pub fn step(self, stage: Stage) -> Option<Step> {
        self.steps().find(|step| step.stage == stage)
    }

    /// The stage of a segmenter after `stage` without those that `skip` names; [`Stage::Done`] after its
    /// last.
    pub(crate) fn after(self, stage: Stage, skip: impl Fn(Stage) -> bool) -> Stage {
        let mut rest = self.steps().map(|step| step.stage).skip_while(|&other| other != stage).skip(1);
        rest.find(|&next| !skip(next)).filter(|next| next.is_of_front()).unwrap_or(Stage::Done)
    }

    /// Whether `stage` comes before the image is in its plane.
    pub(crate) fn is_before_image(self, stage: Stage) -> bool {
        self.steps().take_while(|step| step.stage != Stage::Normalize).any(|step| step.stage == stage)
    }

    /// The most passes over the rows that a stage can take, whatever the image; 0 where the run
    /// does without it. A stage that is not a segmenter's is done at once, and counts as one.
    pub fn passes(self, stage: Stage) -> u32 {
        if self.stages().any(|other| other == stage) { self.most_passes(stage) } else { 0 }
    }

    fn most_passes(self, stage: Stage) -> u32 {
        let config = self.config;
        let marches = config.scheme == Scheme::FastMarching;
        let by_values = config.scheme.has_two_fronts();
        let starts_near = matches!(config.start, Start::Threshold { .. }) && !by_values;
        match stage {
            Stage::LowPercentile | Stage::HighPercentile => match config.normalize {
                Normalize::Percentile { .. } => select::PASSES,
                Normalize::MinMax | Normalize::Noise { .. } => 0,
            },
            // Signal-to-noise has a sky of 0 and a noise of 1.
            Stage::Sky if matches!(config.normalize, Normalize::Noise { .. }) && !config.sky.is_known() => {
                noise::PASSES
            }
            Stage::Sky => 0,
            Stage::Median => select::PASSES,
            Stage::Threshold => match config.rescale {
                Rescale::R3 { tau: Tau::Otsu | Tau::Kapur | Tau::Rosin, .. } => 1,
                Rescale::R3 { tau: Tau::Noise { .. }, .. } => noise::PASSES,
                _ => 0,
            },
            Stage::Rescale => u32::from(config.rescale != Rescale::None),
            Stage::Filter => config.filter.passes(config.filter_steps),
            // Four phases start from the classes of a histogram.
            Stage::StartLevel if by_values => 1,
            // The tau of r3 serves both.
            Stage::StartLevel if starts_near && !matches!(config.rescale, Rescale::R3 { .. }) => self.bands,
            Stage::StartLevel => 0,
            Stage::StartMark | Stage::StartUp | Stage::StartDown => u32::from(starts_near),
            // Regions are told apart by the image itself.
            Stage::Edge => u32::from(!config.scheme.is_by_regions()),
            Stage::Evolve if marches => 0,
            Stage::Evolve => config.max_steps(),
            Stage::Seed | Stage::Sow | Stage::Arrive => u32::from(marches),
            // As many looks a row as a row has pixels, and a last row that finds no pixel left.
            Stage::March if marches => march::looks(config.farthest()).saturating_add(1),
            Stage::March => 0,
            // Pixels are put into one phase each, then phases ranked.
            Stage::Turn if by_values => 2,
            Stage::Turn => u32::from(config.motion == Motion::Outward),
            Stage::Done => 0,
            _ => 1,
        }
    }

    /// The most row operations that a stage can take in a frame of `height` rows, in all bands.
    pub fn rows(self, height: usize, stage: Stage) -> u64 {
        let times = if stage.is_of_band() { self.bands } else { 1 };
        u64::from(self.passes(stage)).saturating_mul(height as u64).saturating_mul(times.into())
    }

    /// The most row operations of a segmenter's run.
    pub fn total_rows(self, height: usize) -> u64 {
        self.steps()
            .filter(|step| step.stage.is_of_front())
            .fold(0, |sum, step| sum.saturating_add(self.rows(height, step.stage)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Filter;

    /// Every stage but the end has a place in some plan, those of a segmenter one in each order.
    #[test]
    fn every_stage_has_a_place() {
        for middle in [RESCALING_FIRST, FILTERING_FIRST] {
            let stages = NORMALISING.iter().chain(&middle).chain(&FRONT).chain(&LABELLING);
            for stage in Stage::ALL.iter().filter(|stage| stage.is_of_front()) {
                assert_eq!(stages.clone().filter(|other| *other == stage).count(), 1, "{stage:?}");
            }
        }
        let outline = [Stage::Outline];
        let mut others = SKY.iter().chain(&outline).chain(&DIVIDING).chain(&CONNECTING);
        for stage in Stage::ALL.iter().filter(|stage| !stage.is_of_front() && **stage != Stage::Done) {
            assert!(others.clone().any(|other| other == stage), "{stage:?}");
        }
        assert!(others.all(|stage| !stage.is_of_front()));
    }

    #[test]
    fn every_choice_has_its_steps_on_signal_to_noise() {
        let stages = |config: &Config| {
            Plan::of(config).steps().map(|step| step.stage).skip(SKY.len()).collect::<heapless::Vec<_, 26>>()
        };
        assert_eq!(stages(&Config::NOISE_AWARE)[..], [Stage::Outline, Stage::Tree, Stage::Deblend, Stage::Select]);
        let rsa = stages(&Config::RSA);
        let front = [Stage::Extremes, Stage::Median, Stage::Normalize, Stage::Threshold, Stage::Rescale];
        assert_eq!(rsa[..5], front, "neither a sky of its own nor a filter in steps");
        assert_eq!(rsa[rsa.len() - 4..], [Stage::Evolve, Stage::Tree, Stage::Deblend, Stage::Select]);
        let filtered = Config { filter: Filter::Median, ..Config::NOISE_AWARE };
        let smoothed = stages(&filtered);
        assert_eq!(smoothed[..4], [Stage::Extremes, Stage::Median, Stage::Normalize, Stage::Filter]);
        assert_eq!(smoothed[4..], [Stage::Outline, Stage::Tree, Stage::Deblend, Stage::Select]);
        assert_eq!(Plan::of(&filtered).after(Stage::Filter, |_| false), Stage::Done, "the front is an extractor's");
        let components = Config { separate: Separate::Components, ..Config::NOISE_AWARE };
        assert_eq!(stages(&components)[..], [Stage::Outline, Stage::Components, Stage::Select]);
        assert_eq!(Plan::of(&Config::RSA).after(Stage::Evolve, |_| false), Stage::Done, "the segmenter's last");
    }

    #[test]
    fn steps_follow_from_the_configuration() {
        let stages =
            |config: &Config| Plan::of(config).steps().map(|step| step.stage).collect::<heapless::Vec<_, 26>>();
        let paper = stages(&Config::PAPER_F160);
        assert_eq!(
            paper[..],
            [
                Stage::Extremes,
                Stage::Median,
                Stage::Normalize,
                Stage::Threshold,
                Stage::Rescale,
                Stage::Filter,
                Stage::Gradient,
                Stage::Edge,
                Stage::Front,
                Stage::Evolve,
                Stage::Provisional,
                Stage::Resolve,
                Stage::Count,
                Stage::Number,
                Stage::Measure,
            ]
        );
        let given = Rescale::R3 { beta: 8, tau: Tau::Value(0.3) };
        let start = Start::Threshold { margin: 2.0 };
        let near = Config { rescale: given, start, order: Order::FilterFirst, ..Config::PAPER_F160 };
        let near = stages(&near.with_scheme(Scheme::FastMarching));
        assert_eq!(near[3..8], [Stage::Filter, Stage::Rescale, Stage::StartMark, Stage::StartUp, Stage::StartDown]);
        assert_eq!(near[11..15], [Stage::Seed, Stage::Sow, Stage::March, Stage::Arrive]);
    }

    #[test]
    fn what_comes_after_is_the_next_step_that_is_not_left_out() {
        let plan = Plan::of(&Config::PAPER_F160);
        assert_eq!(plan.after(Stage::Extremes, |_| false), Stage::Median);
        assert_eq!(plan.after(Stage::Extremes, |stage| stage == Stage::Median), Stage::Normalize);
        assert_eq!(plan.after(Stage::Measure, |_| false), Stage::Done);
        assert_eq!(plan.after(Stage::Sky, |_| false), Stage::Done, "a stage that the run does without");
        assert!(plan.is_before_image(Stage::Median) && !plan.is_before_image(Stage::Normalize));
        assert!(!plan.is_before_image(Stage::Evolve) && !plan.is_before_image(Stage::Done));
    }
}
