//! What is set on top of a preset, and what the table of parameters tells of a setting.

use crate::choices::Preset;
use skyfront_core::config::{Config, Need, Parameter, Value};
use skyfront_core::error::Error;

/// Why a setting was refused.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// A number that the configuration cannot hold.
    #[error(transparent)]
    Value(#[from] Error),
    /// What the chosen steps do not use.
    #[error(transparent)]
    Unused(#[from] Unused),
}

/// `config` with what is given, in the order of the table.
///
/// # Errors
/// [`Refused`] names the first setting that cannot be had.
pub fn apply(mut config: Config, given: &[(&'static Parameter, Value)]) -> Result<Config, Refused> {
    for (parameter, value) in given {
        parameter.set(&mut config, *value)?;
    }
    for (parameter, _) in given {
        if let Some(need) = parameter.unmet(&config) {
            return Err(Unused::new(parameter, need, &config).into());
        }
    }
    Ok(config)
}

/// An option that the chosen steps do not use.
#[derive(Debug, thiserror::Error)]
#[error("--{name} is not used by --{choice} {chosen}; it needs {wanted}{}", has(.preset))]
pub struct Unused {
    /// The option.
    pub name: &'static str,
    /// The choice that leaves it unused.
    pub choice: &'static str,
    /// What was chosen there.
    pub chosen: String,
    /// The choices that would use it, as text.
    pub wanted: String,
    /// The first preset that uses it.
    pub preset: Option<&'static str>,
}

impl Unused {
    fn new(parameter: &Parameter, need: &Need, config: &Config) -> Unused {
        let chosen = Parameter::named(need.name).and_then(|choice| choice.get(config));
        Unused {
            name: parameter.name,
            choice: need.name,
            chosen: chosen.and_then(|value| value.word).unwrap_or_default().to_owned(),
            wanted: choices(need),
            preset: preset_with(parameter),
        }
    }
}

/// The name of the first preset that uses a parameter.
fn preset_with(parameter: &Parameter) -> Option<&'static str> {
    Preset::ALL.into_iter().find(|preset| parameter.unmet(&preset.config()).is_none()).map(Preset::name)
}

fn has(preset: &Option<&str>) -> String {
    preset.map(|name| format!(", as --preset {name} has")).unwrap_or_default()
}

/// The choices of which each is enough.
fn choices(need: &Need) -> String {
    let choices: Vec<String> = need.choices().map(|need| format!("--{} {}", need.name, wanted(need))).collect();
    choices.join(", or ")
}

/// The words of a choice that serve; where all do but one, that one.
fn wanted(need: &Need) -> String {
    let all = Parameter::named(need.name).map_or(&[][..], |choice| choice.words);
    let mut others = all.iter().map(|word| word.name).filter(|word| !need.words.contains(word));
    match (others.next(), others.next()) {
        (Some(other), None) if need.words.len() > 2 => format!("other than {other}"),
        _ => words(need.words),
    }
}

/// `a, b or c`.
pub fn words(words: &[&str]) -> String {
    match words.split_last() {
        Some((last, [])) => (*last).to_owned(),
        Some((last, before)) => format!("{} or {last}", before.join(", ")),
        None => String::new(),
    }
}

/// Unit, bounds, default and what uses a parameter.
pub fn notes(parameter: &Parameter) -> Vec<String> {
    let config = parameter.at_work(&Config::NOISE_AWARE);
    let [range, second] = parameter.ranges(&config).map(|range| range.to_string());
    let mut notes = Vec::new();
    if !parameter.unit.is_empty() {
        notes.push(format!("in {}", parameter.unit));
    }
    notes.extend((!range.is_empty()).then(|| if second == range { range } else { format!("{range}; {second}") }));
    notes.extend(parameter.default().map(|value| format!("default: {value}")));
    notes.extend(uses(parameter));
    notes
}

/// With which choice a parameter is used.
fn uses(parameter: &Parameter) -> Option<String> {
    let needs: Vec<String> = parameter.needs.iter().map(choices).collect();
    (!needs.is_empty()).then(|| format!("with {}", needs.join(" and ")))
}

/// A name elsewhere, in small letters, and ours.
pub(crate) const NAMES: [(&str, &str); 26] = [
    ("detect-thresh", "threshold"),
    ("analysis-thresh", "threshold"),
    ("thresh", "threshold"),
    ("detection-threshold", "threshold"),
    ("nsigma", "threshold"),
    ("sigma", "threshold"),
    ("detect-minarea", "min-area"),
    ("minarea", "min-area"),
    ("npixels", "min-area"),
    ("deblend-mincont", "deblend-contrast"),
    ("deblend-cont", "deblend-contrast"),
    ("contrast", "deblend-contrast"),
    ("flag-image", "mask"),
    ("weight-image", "weight"),
    ("back-value", "background"),
    ("mag-zeropoint", "zero-point"),
    ("zeropoint", "zero-point"),
    ("satur-level", "saturation"),
    ("phot-apertures", "apertures"),
    ("checkimage-type", "sky-maps"),
    ("catalog-type", "catalog-format"),
    ("catalog-name", "out"),
    ("parameters-name", "config"),
    ("nthreads", "threads"),
    ("verbose-type", "verbose"),
    ("output", "out"),
];

/// What a name of another program is called here.
pub fn ours(name: &str) -> Option<&'static str> {
    let name = name.trim_start_matches('-').to_lowercase().replace('_', "-");
    NAMES.iter().find(|(foreign, _)| *foreign == name).map(|(_, ours)| *ours)
}
