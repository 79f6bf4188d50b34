//! What a run says on stderr.

use super::job::Done;
use crate::input::Input;
use crate::provenance::shortest;
use indicatif::{ProgressBar, ProgressStyle};
use skyfront_core::config::Config;
use skyfront_core::run::outcome::{Progress, StopReason};
use skyfront_core::run::stage::Stage;
use std::io::IsTerminal;

/// How much is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Volume {
    /// Errors only.
    Quiet,
    /// Warnings and results too.
    Normal,
    /// Also the effective parameters and the time of every stage.
    Verbose,
}

/// A bar of `length` on a terminal, nothing elsewhere.
pub fn progress_bar(length: u64, unit: &str, volume: Volume) -> ProgressBar {
    if volume == Volume::Quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let template = format!("{{msg:12}} {{bar:40}} {{pos}}/{{len}} {unit}");
    let style = ProgressStyle::with_template(&template).unwrap_or(ProgressStyle::default_bar());
    ProgressBar::new(length).with_style(style)
}

/// Moves the bar of one image.
pub fn show(bar: &ProgressBar, progress: &Progress) {
    if let Progress::Working { stage, pass, .. } = progress {
        bar.set_message(format!("{stage:?}").to_lowercase());
        if *stage == Stage::Evolve {
            bar.set_position(u64::from(*pass));
        }
    }
}

/// What was found in an image, and what is to be known about it.
pub fn report(config: &Config, name: &str, done: &Done, volume: Volume) -> Vec<String> {
    if volume == Volume::Quiet {
        return Vec::new();
    }
    let outcome = &done.outcome;
    let t = f64::from(outcome.steps) * shortest(config.dt);
    let reason = match outcome.reason {
        StopReason::Rest => "came to rest",
        StopReason::TimeLimit => "was given up",
    };
    let how = match config.detection {
        _ if done.given => "measured as given".to_owned(),
        Some(_) => "by their significance".to_owned(),
        None => format!("the front {reason} at t = {t:.4} after {} steps", outcome.steps),
    };
    let mut lines =
        vec![format!("{name}: {} x {} pixels, {} sources; {how}", done.width, done.height, outcome.sources)];
    lines.extend(warnings(name, done));
    if volume == Volume::Verbose {
        lines.extend(done.parts.iter().map(|(part, time)| format!("  {part:15} {:9.4} s", time.as_secs_f64())));
    }
    lines
}

/// What is to be known about the files of a run before it starts.
pub fn about_input(input: &Input, volume: Volume) -> Vec<String> {
    let observed = std::iter::once(&input.detected).chain(&input.bands);
    let warnings = observed.flat_map(|one| one.image.warnings.iter().map(move |text| (&one.name, text)));
    let mut lines: Vec<String> = warnings.map(|(name, text)| format!("warning: {name}: {text}")).collect();
    let (name, removed) = (&input.detected.name, input.removed);
    if removed > 0 {
        lines.push(format!("{name}: mask and weight map take {removed} pixels away"));
    }
    if volume == Volume::Quiet {
        lines.clear();
    }
    lines
}

/// What a user must know about a result.
pub fn warnings(name: &str, done: &Done) -> Vec<String> {
    done.warnings.iter().map(|text| format!("warning: {name}: {text}")).collect()
}
