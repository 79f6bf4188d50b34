//! Everything that changes during a run but lies not in a plane: plain data.

use crate::arithmetic::codec::Codec;
use crate::arithmetic::{Arithmetic, Bits, Real};
use crate::config::Config;
use crate::front::edge::GradientRange;
use crate::front::march::March;
use crate::front::region::Regions;
use crate::front::stop::{Change, StopRule};
use crate::image::normalize::{Extremes, Range};
use crate::run::outcome::StopReason;
use crate::run::plan::Plan;
use crate::run::stage::Stage;
use crate::sky::noise::Estimate;
use crate::sky::select::Select;

/// The state between two polls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State<A: Arithmetic> {
    pub stage: Stage,
    pub pass: u32,
    pub row: usize,
    pub extremes: Extremes,
    pub select: Select,
    pub noise: Estimate,
    pub range: Range,
    pub fill: f32,
    pub tau: f32,
    pub gradient: GradientRange<A>,
    pub march: March,
    pub marching: bool,
    pub change: Change<A>,
    pub regions: Regions,
    pub last_change: f32,
    pub reason: StopReason,
    pub steps: u32,
    pub mask_pixels: u32,
    pub labels: u32,
    pub numbered: u32,
    pub unlabelled: u32,
    pub unreached: u32,
    pub work: u64,
}

impl<A: Arithmetic> State<A> {
    /// Before the first row.
    pub fn new(config: &Config, rule: &StopRule<A>) -> Self {
        State {
            stage: Stage::Extremes,
            pass: 0,
            row: 0,
            extremes: Extremes::NONE,
            select: Select::new(0),
            noise: Estimate::NONE,
            range: Range { low: 0.0, high: 1.0 },
            fill: 0.0,
            tau: config.given_tau(),
            gradient: GradientRange::none(),
            march: March::new(config.farthest()),
            marching: true,
            change: Change::none(rule),
            regions: Regions::of(config.scheme.has_two_fronts()),
            last_change: 0.0,
            reason: StopReason::TimeLimit,
            steps: 0,
            mask_pixels: 0,
            labels: 0,
            numbered: 0,
            unlabelled: 0,
            unreached: 0,
            work: 0,
        }
    }

    /// The list of fields, out or in. What comes in must pass [`Self::is_sound`].
    pub fn code<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        let (mut stage, mut row) = (self.stage.code(), self.row as u32);
        let mut marching = u32::from(self.marching);
        let mut reason = u32::from(self.reason == StopReason::Rest);
        let (mut least, mut greatest) = (self.gradient.least.bits(), self.gradient.greatest.bits());
        codec.word(&mut stage)?;
        codec.word(&mut self.pass)?;
        codec.word(&mut row)?;
        codec.real(&mut self.extremes.least)?;
        codec.real(&mut self.extremes.greatest)?;
        codec.word(&mut self.extremes.defined)?;
        self.select.code(codec)?;
        self.noise.code(codec)?;
        codec.real(&mut self.range.low)?;
        codec.real(&mut self.range.high)?;
        codec.real(&mut self.fill)?;
        codec.real(&mut self.tau)?;
        codec.word(&mut least)?;
        codec.word(&mut greatest)?;
        self.march.code(codec)?;
        codec.word(&mut marching)?;
        codec.long(&mut self.change.sum)?;
        codec.word(&mut self.change.crossings)?;
        self.change.regions.code(codec)?;
        self.regions.code(codec)?;
        codec.real(&mut self.last_change)?;
        codec.word(&mut reason)?;
        for count in [
            &mut self.steps,
            &mut self.mask_pixels,
            &mut self.labels,
            &mut self.numbered,
            &mut self.unlabelled,
            &mut self.unreached,
        ] {
            codec.word(count)?;
        }
        codec.long(&mut self.work)?;
        self.stage = Stage::from_code(stage);
        self.marching = marching != 0;
        self.row = row as usize;
        self.reason = if reason == 0 { StopReason::TimeLimit } else { StopReason::Rest };
        self.gradient = GradientRange { least: A::Real::from_bits(least), greatest: A::Real::from_bits(greatest) };
        Ok(())
    }

    /// Whether a run could have come to this state: every count within its bound, every number
    /// within its range.
    pub fn is_sound(&self, plan: Plan<'_>, (width, height): (usize, usize), bound: u64) -> bool {
        let config = plan.config();
        let pixels = width.saturating_mul(height);
        let in_frame = [self.extremes.defined, self.mask_pixels, self.labels, self.unlabelled, self.unreached]
            .iter()
            .all(|&count| count as usize <= pixels);
        let Extremes { least, greatest, defined } = self.extremes;
        let values = if defined == 0 {
            self.extremes == Extremes::NONE
        } else {
            least.is_finite() && greatest.is_finite() && least <= greatest
        };
        let numbers = [self.range.low, self.range.high, self.fill, self.tau, self.last_change];
        let step = plan.step(self.stage);
        let before_range = plan.is_before_image(self.stage);
        in_frame
            && values
            && numbers.iter().all(|number| number.is_finite())
            && (before_range || (defined > 0 && self.range.low < self.range.high))
            && (before_range || (0.0..=1.0).contains(&self.fill))
            && (0.0..=1.0).contains(&self.tau)
            && self.gradient.least >= A::Real::ZERO
            && self.gradient.greatest >= A::Real::ZERO
            && self.select.is_sound()
            && self.noise.is_sound(pixels)
            && self.march.is_sound(config.farthest(), pixels)
            && step.map_or(self.stage == Stage::Done, |step| self.row < height && self.pass < step.passes)
            && self.steps <= config.max_steps()
            && self.numbered <= self.labels
            && self.work <= bound
    }
}
