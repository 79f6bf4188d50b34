//! What is computed everywhere: small skies, presets that use every step of the pipeline, all schemes.

use core::convert::Infallible;
use skyfront_core::arithmetic::Arithmetic;
use skyfront_core::config::{
    Config, Connectivity, Diffusivity, Edge, Filter, Normalize, Order, Rescale, Scheme, Start, Stop,
};
use skyfront_core::run::frame::Frame;
use skyfront_core::simulate::{Kind, Sky};

/// Columns of every scene.
pub const WIDTH: usize = 40;
/// Rows of every scene.
pub const HEIGHT: usize = 30;

/// One run: a scene and what to do with it.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    preset: &'static Preset,
    motion: Motion,
}

/// How a front moves.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// What it is called in a digest's name.
    pub name: &'static str,
    /// The scheme.
    pub scheme: Scheme,
    /// Where the front starts.
    pub start: Start,
}

/// A scene and the configuration for it, but for the scheme.
#[derive(Debug)]
struct Preset {
    name: &'static str,
    kind: Kind,
    seed: u32,
    holes: bool,
    config: Config,
}

impl Preset {
    fn scene(&self, width: usize, height: usize) -> Scene {
        Scene { sky: Sky::new(self.kind, self.seed, width, height), holes: self.holes }
    }
}

/// As most of the paper's Test 2, which filters before it rescales.
const FILTERED_FIRST: Config = Config { order: Order::FilterFirst, ..Config::PAPER_REAL };

/// Between them they take every branch of the configuration once.
static PRESETS: [Preset; 3] = [
    Preset { name: "bright", kind: Kind::Bright, seed: 1, holes: false, config: Config::PAPER_F160 },
    Preset { name: "noisy", kind: Kind::Noisy, seed: 2, holes: false, config: FILTERED_FIRST },
    Preset {
        name: "stars",
        kind: Kind::Stars,
        seed: 3,
        holes: true,
        config: Config {
            normalize: Normalize::Percentile { low: 1.0, high: 99.0 },
            rescale: Rescale::R2 { alpha: 0.3 },
            filter: Filter::PeronaMalik { diffusivity: Diffusivity::F1, mu: 2.0 },
            filter_steps: 4,
            filter_dt: 1e-3,
            order: Order::FilterFirst,
            edge: Edge::G1 { p: 3.0 },
            // Strong enough for 16-bit cells; they refuse the curvature of the other presets.
            nu: 0.01,
            stop: Stop::Rate,
            connectivity: Connectivity::Four,
            min_area: 3,
            t_max: 10.0,
            ..Config::PAPER_F160
        },
    },
];

/// A short run of the paper's front behind a filter that no preset has.
const fn behind(name: &'static str, filter: Filter, filter_steps: u16) -> Preset {
    let (rescale, order) = (Rescale::R1 { alpha: 0.25 }, Order::FilterFirst);
    let config = Config { rescale, order, filter, filter_steps, t_max: 1.0, ..Config::PAPER_F160 };
    Preset { name, kind: Kind::Noisy, seed: 4, holes: true, config }
}

/// The filters that the presets leave out, each once, by the first motion.
static FILTERS: [Preset; 5] = [
    behind("median", Filter::Median, 2),
    behind("median5", Filter::Median5, 1),
    behind("bilateral", Filter::Bilateral { contrast: 0.1 }, 1),
    behind("tv", Filter::TotalVariation { weight: 0.1 }, 8),
    behind("starlet", Filter::Starlet { significance: 3.0 }, 3),
];

/// Every motion there is: what stands here has golden digests, and is tried by the tests of snapshots, upsets,
/// budgets, memory and slices.
pub static MOTIONS: [Motion; 9] = [
    Motion { name: "fd", scheme: Scheme::Fd, start: Start::Frame },
    Motion { name: "fd-curvature", scheme: Scheme::FdCurvature, start: Start::Frame },
    Motion { name: "sl", scheme: Scheme::Sl, start: Start::Frame },
    Motion { name: "sl-curvature", scheme: Scheme::SlCurvature, start: Start::Frame },
    Motion { name: "fast-marching", scheme: Scheme::FastMarching, start: Start::Frame },
    Motion { name: "near", scheme: Scheme::Fd, start: Start::Threshold { margin: 3.0 } },
    Motion { name: "chan-vese", scheme: Scheme::ChanVese, start: Start::Threshold { margin: 1.0 } },
    Motion { name: "fd-filtered", scheme: Scheme::FdFiltered, start: Start::Frame },
    Motion { name: "multiphase", scheme: Scheme::Multiphase, start: Start::Frame },
];

impl Motion {
    /// The same run with this motion, at the paper's time step for it.
    #[must_use]
    pub fn of(&self, config: Config) -> Config {
        Config { start: self.start, ..config.with_scheme(self.scheme) }
    }
}

/// Every case, in the order of the report.
pub fn all() -> impl Iterator<Item = Case> {
    let presets = PRESETS.iter().flat_map(|preset| MOTIONS.iter().map(move |&motion| Case { preset, motion }));
    let [motion, ..] = MOTIONS;
    presets.chain(FILTERS.iter().map(move |preset| Case { preset, motion }))
}

/// Every scene, with its name, in another size.
pub fn skies(width: usize, height: usize) -> impl Iterator<Item = (&'static str, Scene)> {
    PRESETS.iter().map(move |preset| (preset.name, preset.scene(width, height)))
}

impl Case {
    /// The paper's best setting, for measurements.
    #[must_use]
    pub const fn paper(scheme: Scheme) -> Case {
        Case { preset: &PRESETS[0], motion: Motion { name: "paper", scheme, start: Start::Frame } }
    }

    /// The configuration for an arithmetic: as the preset has it, in a band where the arithmetic needs one.
    #[must_use]
    pub fn config<A: Arithmetic>(&self) -> Config {
        let config = self.motion.of(self.preset.config);
        Config { band: A::NEEDS_BAND.or(config.band), ..config }
    }

    /// The preset's name and the motion's.
    #[must_use]
    pub fn name(&self) -> [&'static str; 2] {
        [self.preset.name, self.motion.name]
    }

    /// The scene.
    #[must_use]
    pub fn frame(&self) -> Scene {
        self.preset.scene(WIDTH, HEIGHT)
    }
}

/// A simulated sky, with undefined pixels where asked for.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    pub(crate) sky: Sky,
    pub(crate) holes: bool,
}

impl Frame for Scene {
    type Error = Infallible;

    fn row(&mut self, y: usize, out: &mut [f32]) -> Result<(), Infallible> {
        self.sky.row(y, out)?;
        if self.holes {
            // One pixel in 31, in a pattern that no row or column repeats.
            out.iter_mut().skip(y * 7 % 31).step_by(31).for_each(|pixel| *pixel = f32::NAN);
        }
        Ok(())
    }
}
