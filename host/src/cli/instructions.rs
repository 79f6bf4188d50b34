//! The instructions that a run takes at most on the processors of `resources.txt`.

use skyfront_core::config::Config;
use skyfront_core::run::budget::{passes, variant};
use skyfront_core::run::stage::Stage;
use std::collections::BTreeSet;

/// Lines `cost MACHINE ARITHMETIC STAGE VARIANT INSTRUCTIONS`, the instructions those of a pixel of one pass.
const TABLE: &str = include_str!("resources.txt");

/// What a machine takes at most for a run over `pixels`.
#[derive(Debug, PartialEq)]
pub struct Need {
    /// The machine.
    pub machine: &'static str,
    /// Instructions of all stages that the table has.
    pub instructions: f64,
    /// Stages of the run that it lacks.
    pub unknown: Vec<String>,
}

/// The needs of every machine that runs the arithmetic of that name.
pub fn needs(config: &Config, arithmetic: &str, pixels: usize) -> Vec<Need> {
    let rows: Vec<[&str; 5]> = TABLE
        .lines()
        .filter_map(|line| line.strip_prefix("cost "))
        .filter_map(|line| line.split(' ').collect::<Vec<_>>().try_into().ok())
        .filter(|&[_, name, ..]: &[&str; 5]| name == arithmetic)
        .collect();
    let machines: BTreeSet<&'static str> = rows.iter().map(|&[machine, ..]| machine).collect();
    let need = |machine| {
        let mut need = Need { machine, instructions: 0.0, unknown: Vec::new() };
        for stage in Stage::ALL {
            let (times, name) = (passes(config, stage), format!("{stage:?}").to_lowercase());
            let cost = rows.iter().find(|row| row[0] == machine && row[2] == name && row[3] == variant(config, stage));
            match cost.and_then(|row| row[4].parse::<f64>().ok()) {
                Some(cost) => need.instructions += f64::from(times) * pixels as f64 * cost,
                None if times > 0 => need.unknown.push(name),
                None => {}
            }
        }
        need
    };
    machines.into_iter().map(need).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use skyfront_core::config::{Rescale, Scheme, Start};

    #[test]
    fn every_scheme_and_start_has_its_costs() {
        for scheme in [
            Scheme::Fd,
            Scheme::FdFiltered,
            Scheme::FdCurvature,
            Scheme::Sl,
            Scheme::SlCurvature,
            Scheme::FastMarching,
            Scheme::ChanVese,
        ] {
            for start in [Start::Frame, Start::Threshold { margin: 2.0 }] {
                let config = Config { start, rescale: Rescale::None, ..Config::PAPER_F160.with_scheme(scheme) };
                for need in needs(&config, "f32", 300 * 300) {
                    assert!(need.unknown.is_empty(), "{scheme:?}: {need:?}");
                }
            }
        }
    }

    #[test]
    fn the_papers_frame_on_every_machine_that_counts() {
        let pixels = 300 * 300;
        let steps = needs(&Config::PAPER_F160, "f32", pixels);
        assert_eq!(steps.iter().map(|need| need.machine).collect::<Vec<_>>(), ["cortex-m7", "rv32imac"]);
        for need in &steps {
            // 2000 steps of the front are by far the most of it: 50 instructions or more a pixel.
            assert!(need.unknown.is_empty() && need.instructions > 2000.0 * 50.0 * pixels as f64, "{need:?}");
        }
    }
}
