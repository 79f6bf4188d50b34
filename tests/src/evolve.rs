//! The core's front alone, on a front and a speed of the test's own.

use skyfront_core::arithmetic::F32;
use skyfront_core::config::Config;
use skyfront_core::front::region::Regions;
use skyfront_core::front::scheme::{AnyScheme, Evolve, Step};
use skyfront_core::front::settle::Settle;
use skyfront_core::front::stop::{Change, StopRule};
use skyfront_core::plane::sweep::{Band, Halo};
use skyfront_core::plane::tiles::{Tiles, flags_len, rows_of_tile};
use skyfront_core::run::memory::ring_cells;

/// A front on its way.
pub struct Front {
    config: Config,
    /// Its values, row-major.
    pub values: Vec<f32>,
    /// The edge detector.
    pub speed: Vec<f32>,
    /// Columns.
    pub width: usize,
}

impl Front {
    /// A front of `width` x `height` nodes with speed 1 everywhere; `value(x, y)` with the origin in the middle, in
    /// units of length.
    pub fn new(config: Config, width: usize, height: usize, value: impl Fn(f64, f64) -> f64) -> Front {
        let dx = f64::from(config.dx);
        let middle = |i: usize, n: usize| (i as f64 - (n as f64 - 1.0) / 2.0) * dx;
        let rows = (0..height).flat_map(|j| (0..width).map(move |i| (i, j)));
        let values = rows.map(|(i, j)| value(middle(i, width), middle(j, height)) as f32).collect();
        Front { config, values, speed: vec![1.0; width * height], width }
    }

    /// One step; whether the stopping rule says that the front is at rest.
    pub fn step(&mut self) -> bool {
        let rule = StopRule::<F32>::new(&self.config, 1.0);
        let mut step =
            Step { settle: Settle::new(self.config.band), change: Change::none(&rule), means: Regions::NONE.means };
        let scheme = AnyScheme::<F32>::new(&self.config, 1.0).expect("a scheme for every configuration");
        let mut ring = vec![0.0; ring_cells(self.width, true)];
        let height = self.values.len() / self.width;
        let mut flags = vec![0; flags_len(self.width, height)];
        let mut tiles = Tiles::new(&mut flags, self.width, rows_of_tile(height));
        tiles.wake();
        let mut band =
            Band { plane: &mut self.values, aux: &self.speed, ring: &mut ring, width: self.width, halo: Halo::NONE };
        scheme.advance(&mut band, &mut tiles, 0..height, &mut step);
        rule.at_rest(&step.change)
    }

    /// Steps until time `t`.
    pub fn until(&mut self, t: f64) {
        for _ in 0..(t / f64::from(self.config.dt)).round() as usize {
            self.step();
        }
    }

    /// Where the front crosses zero from the middle outwards, along (1, 0) or (1, 1), in units of length.
    pub fn radius(&self, diagonal: bool) -> f64 {
        let middle = self.values.len() / 2;
        let stride = if diagonal { self.width + 1 } else { 1 };
        let at = |k: usize| f64::from(self.values[middle + k * stride]);
        let k = (0..self.width / 2 - 1).find(|&k| (at(k) > 0.0) != (at(k + 1) > 0.0)).expect("a front on this ray");
        let nodes = k as f64 + at(k) / (at(k) - at(k + 1));
        nodes * f64::from(self.config.dx) * if diagonal { std::f64::consts::SQRT_2 } else { 1.0 }
    }
}
