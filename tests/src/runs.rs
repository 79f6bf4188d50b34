//! Small runs for tests: memory of exactly the stated size, and configurations of every kind.

use skyfront_core::arithmetic::{Arithmetic, Cell};
use skyfront_core::catalog::Source;
use skyfront_core::config::{Config, Diffusivity, Edge, Filter, Normalize, Order, Rescale, Scheme, Start, Stop, Tau};
use skyfront_core::frame::Frame;
use skyfront_core::memory::{Memory, flags_len, ring_cells};
use skyfront_core::simulate::{Kind, Sky};

/// The planes and rows of one run.
pub struct Room<A: Arithmetic> {
    image: Vec<A::Cell>,
    front: Vec<A::Cell>,
    ring: Vec<A::Cell>,
    tiles: Vec<u8>,
    samples: Vec<f32>,
    sources: Vec<Source>,
}

impl<A: Arithmetic> Room<A> {
    /// As many elements as the core asks for, and not one more; all of them hold `pattern`.
    pub fn new(config: &Config, width: usize, height: usize, sources: usize, pattern: u32) -> Self {
        let cell = A::Cell::from_bits(pattern);
        let ring = ring_cells(width, config.scheme == Scheme::SlCurvature);
        Room {
            image: vec![cell; width * height],
            front: vec![cell; width * height],
            ring: vec![cell; ring],
            tiles: vec![pattern as u8; flags_len(width, height)],
            samples: vec![0.0; width],
            sources: vec![Source::empty(pattern); sources],
        }
    }

    /// The slices for a segmenter.
    pub fn memory(&mut self) -> Memory<'_, A> {
        Memory {
            image: &mut self.image,
            front: &mut self.front,
            ring: &mut self.ring,
            tiles: &mut self.tiles,
            samples: &mut self.samples,
            sources: &mut self.sources,
        }
    }
}

/// The pixels of a simulated sky.
pub fn sky(kind: Kind, seed: u32, width: usize, height: usize) -> Vec<f32> {
    let mut sky = Sky::new(kind, seed, width, height);
    let mut pixels = vec![0.0; width * height];
    for (y, row) in pixels.chunks_exact_mut(width).enumerate() {
        let Ok(()) = sky.row(y, row);
    }
    pixels
}

/// Configurations that between them use every stage, scheme and kind of step, all with a band and
/// a curvature that every arithmetic can serve, and few time steps.
pub fn every_kind() -> Vec<Config> {
    let base = Config { band: Some(8.0), nu: 0.05, ..Config::PAPER_F160 };
    let percentile = Normalize::Percentile { low: 1.0, high: 99.0 };
    let pm = |diffusivity| Filter::PeronaMalik { diffusivity, mu: 2.0 };
    let r1 = Rescale::R1 { alpha: 0.3 };
    let configs = [
        base,
        Config { normalize: percentile, rescale: r1, filter: Filter::None, edge: Edge::G2, ..base }
            .with_scheme(Scheme::Sl),
        Config {
            rescale: Rescale::R2 { alpha: 0.25 },
            filter: pm(Diffusivity::F1),
            edge: Edge::G1 { p: 5000.0 },
            ..base
        }
        .with_scheme(Scheme::FdCurvature),
        Config { filter: pm(Diffusivity::F2), order: Order::FilterFirst, filter_steps: 2, ..base }
            .with_scheme(Scheme::SlCurvature),
        Config { rescale: Rescale::R3 { beta: 3, tau: Tau::Value(0.3) }, directions: 64, stop: Stop::Rate, ..base }
            .with_scheme(Scheme::Sl),
        Config {
            normalize: Normalize::Noise { below: 3.0, above: 20.0 },
            rescale: Rescale::R3 { beta: 4, tau: Tau::Noise { k: 4.0 } },
            order: Order::FilterFirst,
            start: Start::Threshold { margin: 3.0 },
            ..base
        },
    ];
    configs.map(|config| Config { t_max: 24.5 * config.dt, ..config }).to_vec()
}
