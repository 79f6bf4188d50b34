//! `skyfront presets`: what each preset is and sets.

use super::choices::Preset;
use super::say::{Stdout, Unwritten};
use crate::provenance::parameters;
use clap::ValueEnum;

/// Lists the presets.
pub fn run() -> Result<(), Unwritten> {
    for (index, preset) in Preset::value_variants().iter().enumerate() {
        let Some(value) = preset.to_possible_value() else { continue };
        let standard = if *preset == Preset::default() { " (default)" } else { "" };
        let blank = if index == 0 { "" } else { "\n" };
        writeln!(Stdout, "{blank}{}{standard}", value.get_name())?;
        if let Some(help) = value.get_help() {
            writeln!(Stdout, "    {help}")?;
        }
        for parameter in parameters(&preset.config()) {
            writeln!(Stdout, "    {:20}{}", parameter.name, parameter.value)?;
        }
    }
    Ok(())
}
