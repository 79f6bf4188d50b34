//! What a run says on stderr.

use super::job::Done;
use super::say::Stderr;
use crate::input::Input;
use crate::provenance::shortest;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::Value;
use skyfront_core::config::{Config, Scheme, Select};
use skyfront_core::run::outcome::{Progress, StopReason};
use skyfront_core::run::plan::Plan;
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

/// How far the run of one image is: its steps, and the passes of a front that moves.
pub struct Course {
    /// The stages of the plan, each with the units of work before it.
    steps: Vec<(Stage, u64)>,
    /// All units.
    pub length: u64,
    /// The step under way.
    at: usize,
}

impl Course {
    /// The steps of a configuration.
    pub fn of(config: &Config) -> Course {
        let mut length = 0;
        let steps = Plan::of(config).steps().map(|step| {
            let before = length;
            length += if step.stage == Stage::Evolve { u64::from(step.passes) } else { 1 };
            (step.stage, before)
        });
        Course { steps: steps.collect(), length, at: 0 }
    }

    /// The units done when a pass of a stage begins; stages come in their order, some more than once.
    pub fn position(&mut self, stage: Stage, pass: u32) -> u64 {
        let same = self.steps.get(self.at).is_some_and(|step| step.0 == stage);
        let from = self.at + usize::from(same);
        self.at = (from..self.steps.len()).find(|&at| self.steps[at].0 == stage).unwrap_or(self.at);
        let before = self.steps.get(self.at).map_or(0, |step| step.1);
        before + if stage == Stage::Evolve { u64::from(pass) } else { 0 }
    }
}

/// Moves the bar of one image.
pub fn show(bar: &ProgressBar, course: &mut Course, progress: &Progress) {
    if let Progress::Working { stage, pass, .. } = progress {
        bar.set_message(format!("{stage:?}").to_lowercase());
        bar.set_position(course.position(*stage, *pass));
    }
}

/// Says what was found, and where it is.
pub fn told(config: &Config, name: &str, done: &Done, volume: Volume) {
    for line in report(config, name, done, volume) {
        writeln!(Stderr, "{line}");
    }
    if let Some(folder) = done.files.first().and_then(|path| path.parent()).filter(|_| volume > Volume::Quiet) {
        writeln!(Stderr, "{} files in {}", done.files.len(), folder.display());
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
    let how = match config.scheme {
        _ if done.given => "measured as given".to_owned(),
        Scheme::Region if config.select == Select::Significance => "by their significance".to_owned(),
        Scheme::Region => "by their area".to_owned(),
        _ => format!("the front {reason} at t = {t:.4} after {} steps", outcome.steps),
    };
    let mut lines =
        vec![format!("{name}: {} x {} pixels, {} sources; {how}", done.width, done.height, outcome.sources)];
    lines.extend(warnings(name, done));
    if volume == Volume::Verbose {
        lines.extend(found(config, &done.summary));
        lines.extend(done.parts.iter().map(|(part, time)| format!("  {part:15} {:9.4} s", time.as_secs_f64())));
    }
    lines
}

/// Sky, noise, threshold and flags of a run, by its summary.
fn found(config: &Config, summary: &Value) -> Vec<String> {
    let mut lines = Vec::new();
    let line = |name: &str, text: String| format!("  {name:15} {text}");
    if let (Some(sky), Some(noise)) = (summary["background"].as_f64(), summary["noise"].as_f64()) {
        lines.push(line("sky", format!("{}, median over the image", rounded(sky))));
        lines.push(line("noise", format!("{}, standard deviation of a pixel of sky", rounded(noise))));
        let threshold = shortest(config.outline.threshold);
        let above = rounded(threshold * noise);
        lines.push(line("threshold", format!("{threshold} times the noise, {above} above the sky")));
    }
    if let Some(tau) = summary["tau"].as_f64() {
        lines.push(line("tau", format!("{tau}")));
    }
    let counts = summary["flags"].as_object().into_iter().flatten();
    let flags: Vec<String> = counts.map(|(flag, count)| format!("{count} {flag}")).collect();
    lines.push(line("flags", if flags.is_empty() { "none".to_owned() } else { flags.join(", ") }));
    lines
}

/// A number with six digits that count.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_goes_through_its_course_to_the_end() {
        let config = Config::NOISE_AWARE;
        let mut course = Course::of(&config);
        let stages: Vec<Stage> = Plan::of(&config).steps().map(|step| step.stage).collect();
        let positions: Vec<u64> = stages.iter().map(|&stage| course.position(stage, 0)).collect();
        assert_eq!(positions, (0..course.length).collect::<Vec<_>>(), "steps that come again count again");
    }

    #[test]
    fn passes_of_a_front_count_one_by_one() {
        let config = Config::PAPER_F160;
        let mut course = Course::of(&config);
        let start = course.position(Stage::Evolve, 0);
        assert!(start > 0 && course.length > u64::from(config.max_steps()));
        assert_eq!([1, 2, 7].map(|pass| course.position(Stage::Evolve, pass)), [1, 2, 7].map(|pass| start + pass));
        let after = course.position(Stage::Measure, 0);
        assert_eq!((course.position(Stage::Measure, 0), after), (after, course.length - 1));
    }
}
