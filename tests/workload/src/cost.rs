//! What each stage costs a pixel: short runs that between them do everything a configuration can ask for.

use crate::case::Scene;
use crate::run::{self, run};
use skyfront_core::arithmetic::{Arithmetic, Real};
use skyfront_core::config::{
    Config, Connectivity, Diffusivity, Edge, Filter, Motion, Normalize, Order, Rescale, Scheme, Start, Tau,
};
use skyfront_core::front::scheme::AnyScheme;
use skyfront_core::run::budget;
use skyfront_core::run::frame::{Frame, SliceFrame};
use skyfront_core::run::memory::{flags_len, ring_cells};
use skyfront_core::run::stage::Stage;
use skyfront_core::simulate::{Kind, Sky};

/// Columns, as the paper's.
const WIDTH: usize = 300;
/// Rows: so few that no pixel lies beyond a band of 8 pixels at the start.
const HEIGHT: usize = 20;
/// Pixels of a pass.
pub const PIXELS: usize = WIDTH * HEIGHT;

/// The memory for every run.
pub type Planes<A> = run::Planes<A, WIDTH, PIXELS, { ring_cells(WIDTH, true) }, { flags_len(WIDTH, HEIGHT) }>;

/// The image in memory, so that only its reading is measured, not its making.
pub type Image = [f32; PIXELS];

/// Makes the image.
pub fn draw(image: &mut Image) {
    let mut scene = Scene { sky: Sky::new(Kind::Bright, 1, WIDTH, HEIGHT), holes: true };
    for (y, row) in image.chunks_exact_mut(WIDTH).enumerate() {
        let Ok(()) = scene.row(y, row);
    }
}

/// The band of fronts that are held in one.
const BAND: f32 = 8.0;

/// The steps before the front, each way of doing them once.
static IMAGE_STEPS: [Config; 4] = [
    BASE,
    Config {
        rescale: Rescale::R1 { alpha: 0.3 },
        filter: Filter::PeronaMalik { diffusivity: Diffusivity::F1, mu: 2.0 },
        edge: Edge::G1 { p: 3.0 },
        start: Start::Threshold { margin: 2.0 },
        ..BASE
    },
    Config {
        rescale: Rescale::R2 { alpha: 0.25 },
        filter: Filter::PeronaMalik { diffusivity: Diffusivity::F2, mu: 2.0 },
        edge: Edge::G1 { p: 2.0 },
        order: Order::FilterFirst,
        ..BASE
    },
    Config { normalize: Normalize::Noise { below: 1.0, above: 50.0 }, rescale: Rescale::R2 { alpha: 0.3 }, ..BASE },
];

/// Percentiles and holes for the statistics; a front of two steps.
const BASE: Config = Config {
    normalize: Normalize::Percentile { low: 1.0, high: 99.0 },
    filter_steps: 1,
    filter_dt: 1e-3,
    // Strong enough for 16-bit cells.
    nu: 0.01,
    ..Config::PAPER_F160
};

/// What the four above leave out of the rescaling.
const RESCALES: [Rescale; 5] = [
    Rescale::R1 { alpha: 0.25 },
    Rescale::R3 { beta: 3, tau: Tau::Otsu },
    Rescale::R3 { beta: 8, tau: Tau::Kapur },
    Rescale::R3 { beta: 8, tau: Tau::Rosin },
    Rescale::R3 { beta: 8, tau: Tau::Noise { k: 3.0 } },
];

/// Every scheme, with every number of directions.
const SCHEMES: [(Scheme, u8); 10] = [
    (Scheme::FastMarching, 16),
    (Scheme::ChanVese, 16),
    (Scheme::Multiphase, 16),
    (Scheme::Fd, 16),
    (Scheme::FdFiltered, 16),
    (Scheme::FdCurvature, 16),
    (Scheme::Sl, 16),
    (Scheme::Sl, 64),
    (Scheme::SlCurvature, 16),
    (Scheme::SlCurvature, 64),
];

/// The front that a run starts with, for the label passes.
#[derive(Clone, Copy, Debug)]
enum Mask {
    /// Every other pixel: as many labels as there can be.
    Checkers,
    /// Every pixel: as many pixels of a source as there can be.
    Full,
}

/// Work that was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Item {
    stage: Stage,
    variant: &'static str,
    /// Of the costliest pass.
    instructions: u64,
}

/// More than there are pairs of a stage and a variant.
const ITEMS: usize = 64;

/// The costliest pass of every kind of work.
struct Items([Option<Item>; ITEMS]);

impl Items {
    fn observe(&mut self, stage: Stage, variant: &'static str, instructions: u64) {
        let same = |item: &Option<Item>| item.is_none_or(|item| (item.stage, item.variant) == (stage, variant));
        if let Some(place) = self.0.iter_mut().find(|item| same(item)) {
            let most = place.map_or(0, |item| item.instructions).max(instructions);
            *place = Some(Item { stage, variant, instructions: most });
        }
    }
}

/// Measures every stage in arithmetic `A`: gives `tell` stage, variant and instructions of the
/// costliest pass over [`PIXELS`] pixels. `count` is a running number of instructions and returns
/// those since it was last asked.
pub fn all<A: Arithmetic>(
    planes: &mut Planes<A>,
    image: &Image,
    mut count: impl FnMut() -> u64,
    mut tell: impl FnMut(Stage, &'static str, u64),
) {
    let mut items = Items([None; ITEMS]);
    let mut one = |config: Config, mask| measure(planes, image, config, mask, &mut count, &mut items);
    IMAGE_STEPS.iter().for_each(|&config| one(config, None));
    RESCALES.iter().for_each(|&rescale| one(Config { rescale, ..BASE }, None));
    let by_steps = Filter::ALL.iter().filter(|filter| filter.is_stepped());
    by_steps.for_each(|&filter| one(Config { filter, ..BASE }, None));
    for (scheme, directions) in SCHEMES {
        for band in [None, Some(BAND)] {
            one(Config { directions, band, ..BASE.with_scheme(scheme) }, None);
        }
    }
    for mask in [Mask::Checkers, Mask::Full] {
        one(Config { start: Start::Given, connectivity: Connectivity::Four, dt: 1e-5, ..BASE }, Some(mask));
    }
    one(Config { start: Start::Given, motion: Motion::Outward, ..BASE }, Some(Mask::Full));
    items.0.into_iter().flatten().for_each(|item| tell(item.stage, item.variant, item.instructions));
}

/// One run; one that the arithmetic refuses adds nothing.
fn measure<A: Arithmetic>(
    planes: &mut Planes<A>,
    image: &Image,
    config: Config,
    mask: Option<Mask>,
    count: &mut impl FnMut() -> u64,
    items: &mut Items,
) {
    // Two steps of a front do all that a step can; a march has to come to the sources.
    let t_max = if config.scheme == Scheme::FastMarching { config.t_max } else { 2.0 * config.dt };
    let config = Config { t_max, band: config.band.or(A::NEEDS_BAND), ..config };
    let memory = planes.memory();
    if let Some(mask) = mask {
        give::<A>(mask, memory.front);
    }
    let mut frame = SliceFrame(image);
    count();
    let _refused = run::<A, AnyScheme<A>, _>(&config, (WIDTH, HEIGHT), &mut frame, memory, HEIGHT, |stage, _, _| {
        items.observe(stage, budget::variant(&config, stage), count());
        count();
    });
}

fn give<A: Arithmetic>(mask: Mask, front: &mut [A::Cell]) {
    for (i, cell) in front.iter_mut().enumerate() {
        let inside = match mask {
            Mask::Checkers => (i % WIDTH + i / WIDTH).is_multiple_of(2),
            Mask::Full => true,
        };
        *cell = A::to_level(if inside { A::Real::ONE } else { -A::Real::ONE });
    }
}
