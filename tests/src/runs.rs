//! Small runs for tests: skies, and configurations of every kind.

use skyfront::pipeline::Segmentation;
use skyfront_core::arithmetic::Arithmetic;
use skyfront_core::config::{
    Config, Diffusivity, Edge, Filter, Motion, Normalize, Order, Rescale, Scheme, Start, Stop, Tau,
};
use skyfront_core::error::Error;
use skyfront_core::run::frame::Frame;
use skyfront_core::simulate::{Kind, Sky};
use skyfront_workload::case::MOTIONS;

/// The pixels of a simulated sky.
pub fn sky(kind: Kind, seed: u32, width: usize, height: usize) -> Vec<f32> {
    let mut sky = Sky::new(kind, seed, width, height);
    let mut pixels = vec![0.0; width * height];
    for (y, row) in pixels.chunks_exact_mut(width).enumerate() {
        let Ok(()) = sky.row(y, row);
    }
    pixels
}

/// By how many sources, and by how many pixels of the mask, two runs over one image are apart.
pub fn apart([one, other]: &[Segmentation; 2]) -> [usize; 2] {
    let differing = one.labels.iter().zip(&other.labels).filter(|(one, other)| (**one > 0) != (**other > 0));
    [one.sources.len().abs_diff(other.sources.len()), differing.count()]
}

/// Every motion of the front that arithmetic `A` serves, with image steps that between them use every stage and kind
/// of step; a band and a curvature that every arithmetic can serve, and few time steps.
pub fn every_kind<A: Arithmetic>() -> Vec<Config> {
    let base = Config { band: Some(8.0), nu: 0.04, ..Config::PAPER_F160 };
    let percentile = Normalize::Percentile { low: 1.0, high: 99.0 };
    let pm = |diffusivity| Filter::PeronaMalik { diffusivity, mu: 2.0 };
    let r1 = Rescale::R1 { alpha: 0.3 };
    let steps = [
        base,
        Config {
            rescale: Rescale::R2 { alpha: 0.25 },
            filter: pm(Diffusivity::F1),
            edge: Edge::G1 { p: 5000.0 },
            ..base
        },
        Config { normalize: percentile, rescale: r1, filter: Filter::None, edge: Edge::G2, ..base },
        Config { filter: pm(Diffusivity::F2), order: Order::FilterFirst, filter_steps: 2, ..base },
        Config {
            rescale: Rescale::R3 { beta: 3, tau: Tau::Value(0.3) },
            filter: Filter::TotalVariation { weight: 0.1 },
            ..base
        },
        Config { rescale: r1, filter: Filter::Starlet { significance: 3.0 }, filter_steps: 3, ..base },
    ];
    let motions = MOTIONS.iter().zip(steps.iter().cycle()).map(|(motion, steps)| motion.of(*steps));
    let fine = Config { directions: 64, stop: Stop::Rate, ..base }.with_scheme(Scheme::Sl);
    let noise = Config {
        normalize: Normalize::Noise { below: 3.0, above: 20.0 },
        rescale: Rescale::R3 { beta: 4, tau: Tau::Noise { k: 4.0 } },
        filter: Filter::Bilateral { contrast: 0.1 },
        filter_steps: 2,
        order: Order::FilterFirst,
        start: Start::Threshold { margin: 3.0 },
        ..base
    };
    let grown = Config { start: Start::Given, motion: Motion::Outward, ..base };
    let short = |config: Config| Config { t_max: 24.5 * config.dt, ..config };
    let served = |config: &Config| !matches!(config.validate::<A>(), Err(Error::Arithmetic { .. }));
    motions.chain([fine, noise, grown]).map(short).filter(served).collect()
}
