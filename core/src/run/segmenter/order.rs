//! What follows from a pass that is over: the next pass, or the next stage.

use super::{Segmenter, corrupted};
use crate::arithmetic::Arithmetic;
use crate::config::{Filter, Normalize, Rescale, Tau};
use crate::error::Error;
use crate::front::region::{Means, Moments};
use crate::front::scheme::Evolve;
use crate::front::stop::Change;
use crate::image::filter::starlet::Starlet;
use crate::image::normalize::Range;
use crate::image::rescale;
use crate::plane::tiles::{Tiles, rows_of_tile};
use crate::run::outcome::StopReason;
use crate::run::stage::Stage;
use crate::run::state::State;
use crate::sky::noise::Estimate;
use crate::sky::select::Select;
use crate::sources::catalog::Source;

impl<A: Arithmetic, S: Evolve<A>> Segmenter<'_, A, S> {
    /// The last row of a pass is done: what follows from it, and the next pass.
    pub(super) fn end_pass(&mut self) -> Result<(), Error> {
        let has_bands = self.has_bands();
        let (state, counts) = (&mut self.state, &mut *self.memory.counts);
        state.row = 0;
        state.pass = state.pass.saturating_add(1);
        match state.stage {
            Stage::Extremes => {
                if state.extremes.defined == 0 {
                    return Err(Error::NothingDefined { pixels: self.width.saturating_mul(self.height) });
                }
                state.range = match self.config.normalize {
                    // Of signal-to-noise, which has a sky of 0 and a noise of 1.
                    Normalize::Noise { below, above } if self.config.sky.is_known() => {
                        Range { low: -below, high: above }
                    }
                    _ => Range { low: state.extremes.least, high: state.extremes.greatest },
                };
            }
            Stage::LowPercentile | Stage::HighPercentile | Stage::Median => {
                let Some(value) = state.select.end_pass(counts) else { return Ok(()) };
                match state.stage {
                    Stage::LowPercentile => state.range.low = value,
                    Stage::HighPercentile => state.range.high = value,
                    _ => state.fill = value,
                }
            }
            Stage::Sky => {
                // Asked first: a program of one setting leaves out what its setting does not need.
                if let Normalize::Noise { below, above } = self.config.normalize {
                    if !state.noise.end_pass(&mut state.select, counts) {
                        return Ok(());
                    }
                    state.range = Range::around(&state.noise, below, above, state.range);
                }
            }
            Stage::Threshold => match self.config.rescale {
                Rescale::R3 { tau: Tau::Noise { k }, .. } => {
                    if !state.noise.end_pass(&mut state.select, counts) {
                        return Ok(());
                    }
                    state.tau = rescale::noise_threshold(&state.noise, k);
                }
                Rescale::R3 { tau, .. } => state.tau = counts.threshold(tau),
                _ => {}
            },
            Stage::StartLevel if self.config.scheme.has_two_fronts() => {
                state.regions.means = Means::of(counts.four_classes());
            }
            Stage::StartLevel => {
                state.tau = counts.otsu();
                if has_bands {
                    let left = self.bands.each.len().saturating_sub(state.pass as usize);
                    self.bands.each.get_mut(left).into_iter().for_each(|band| band.tau = state.tau);
                    counts.clear();
                    if left > 0 {
                        return Ok(());
                    }
                }
            }
            Stage::March if state.marching => {
                // A march that was left alone ends before its bound.
                let in_time = state.pass < self.plan().passes(Stage::March);
                return if in_time { Ok(()) } else { Err(corrupted("the lists of the march")) };
            }
            Stage::March => {
                // The time of the last arrival, in steps; some arrivals are known before their time.
                let steps = (state.march.latest() * self.config.dx / self.config.dt) as u32;
                let most = self.config.max_steps();
                let late = state.march.is_cut() || steps > most;
                state.reason = if late { StopReason::TimeLimit } else { StopReason::Rest };
                state.steps = steps.min(most);
            }
            Stage::Filter => {
                // A filter that measures does so first.
                if let Filter::Starlet { .. } = self.config.filter
                    && Starlet::measures(state.pass.saturating_sub(1))
                    && let Some(median) = state.select.end_pass(counts)
                {
                    (state.noise, state.noise.noise) = (Estimate::NONE, median);
                }
                if state.pass < self.config.filter.passes(self.config.filter_steps) {
                    return Ok(());
                }
            }
            Stage::Evolve => {
                state.steps = state.pass;
                state.last_change = self.rule.norm(&state.change);
                let at_rest = self.rule.at_rest(&state.change);
                let moved = state.change.regions;
                state.change = Change::none(&self.rule);
                let turned = if has_bands {
                    self.bands.turn()
                } else {
                    self.config.scheme.is_by_regions() && state.regions.turn(&moved)
                };
                if turned {
                    Tiles::new(self.memory.tiles, self.width, rows_of_tile(self.height)).wake();
                }
                if at_rest {
                    state.reason = StopReason::Rest;
                } else if state.steps < self.config.max_steps() {
                    return Ok(());
                }
            }
            Stage::Turn if self.config.scheme.has_two_fronts() && state.pass < 2 => {
                state.regions.turn(&Moments::default());
                return Ok(());
            }
            _ => {}
        }
        let next = self.stage_after(self.state.stage);
        if self.has_bands() && self.state.stage.is_of_band() && !next.is_of_band() && self.bands.go_on(self.state.tau) {
            let work = self.state.work;
            self.state = State { work, ..State::new(&self.config, &self.rule) };
            return self.begin_stage(Stage::Extremes);
        }
        self.begin_stage(next)
    }

    fn begin_stage(&mut self, stage: Stage) -> Result<(), Error> {
        let state = &mut self.state;
        (state.stage, state.pass) = (stage, 0);
        self.memory.counts.clear();
        let defined = state.extremes.defined;
        match (stage, self.config.normalize) {
            (Stage::LowPercentile, Normalize::Percentile { low, .. }) => {
                state.select = Select::percentile(low, defined)
            }
            (Stage::HighPercentile, Normalize::Percentile { high, .. }) => {
                state.select = Select::percentile(high, defined);
            }
            (Stage::Sky | Stage::Threshold, _) => state.noise = Estimate::new(defined, &mut state.select),
            (Stage::Median, _) => state.select = Select::percentile(50.0, defined),
            (Stage::Filter, _) => {
                let pixels = self.width.saturating_mul(self.height);
                state.select = Select::percentile(50.0, u32::try_from(pixels).unwrap_or(u32::MAX));
            }
            (Stage::Normalize, _) => {
                if state.range.low >= state.range.high {
                    return Err(Error::Constant { value: state.range.low });
                }
                state.fill = state.range.apply(state.fill, 0.0);
            }
            (Stage::Front | Stage::Turn, _) => state.regions = state.regions.anew(),
            (Stage::Evolve, _) => {
                if self.config.scheme.is_by_regions() {
                    state.regions.turn(&Moments::default());
                }
                if S::FOLLOWS {
                    self.bands.turn();
                }
                Tiles::new(self.memory.tiles, self.width, rows_of_tile(self.height)).wake();
            }
            (Stage::Measure, _) => {
                for (label, source) in (1..=state.numbered).zip(self.memory.sources.iter_mut()) {
                    *source = Source::empty(label);
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// The next stage; no median is wanted where all pixels are defined.
    fn stage_after(&self, stage: Stage) -> Stage {
        let complete = self.state.extremes.defined as usize >= self.width.saturating_mul(self.height);
        self.plan().after(stage, |next| next == Stage::Median && complete)
    }
}
