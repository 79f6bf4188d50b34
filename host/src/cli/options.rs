//! The options of a run: files of settings, a preset, and what is given on top of it.

use super::choices::{ArithmeticOption, Preset};
use super::given::{Given, Setting};
use crate::input::StartMap;
use crate::read::Place;
use anyhow::Result;
use clap::Args;
use skyfront_core::config::{Config, Numbers};
use std::path::PathBuf;

/// What a run does; unset options take the preset's value.
#[derive(Clone, Debug, Default, Args)]
pub struct Options {
    /// Take settings from a TOML file whose keys are the names of these options; the command line
    /// goes before the file, the file before the preset.
    #[arg(long = "config", value_name = "FILE")]
    pub config_file: Option<PathBuf>,
    /// Print the effective settings as such a file, and do nothing else.
    #[arg(long)]
    pub dump_config: bool,
    /// Settings to start from: the choice of every step. Options that these steps do not use are
    /// refused.
    #[arg(long, value_enum, default_value_t)]
    pub preset: Preset,
    /// Numbers to compute in; q11 implies a band of 8 pixels.
    #[arg(long, value_enum, default_value_t)]
    pub arithmetic: ArithmeticOption,
    /// The parameters that are given.
    #[command(flatten)]
    pub given: Given,
}

impl Options {
    /// The configuration that the preset and the options amount to; not validated.
    ///
    /// # Errors
    /// An option that the chosen steps do not use, or a number that no configuration can hold.
    pub fn config(&self) -> Result<Config> {
        let config = self.given.apply(self.preset.config())?;
        Ok(self.arithmetic.adapted(config, self.given.get("band").is_some()))
    }

    /// The same for a frame: with time to cross it, unless the user's own is given.
    pub fn for_frame(&self, config: Config, width: usize, height: usize) -> Config {
        if self.given.get("t-max").is_some() { config } else { config.with_time_for(width, height) }
    }

    /// The map from which the front starts, and its margin in pixels.
    pub fn start_map(&self) -> Option<(Place, f32)> {
        let Some(Setting::Map(place)) = self.given.get("start") else { return None };
        let margin = match self.given.get("margin").map(|setting| setting.value().numbers) {
            Some(Numbers::One(margin)) => margin,
            _ => StartMap::MARGIN,
        };
        Some((place.clone(), margin))
    }
}
