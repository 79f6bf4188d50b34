//! The digests that must be the same on every processor.

use crate::case::{self, HEIGHT, Scene, WIDTH};
use crate::run::{self, to_the_end};
use core::convert::Infallible;
use skyfront_core::arithmetic::digest::{self, Digest};
use skyfront_core::arithmetic::machine::Machine;
use skyfront_core::arithmetic::{Arithmetic, Cell};
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::front::bands::{Band, Bands};
use skyfront_core::front::scheme::AnyScheme;
use skyfront_core::run::frame::Frame;
use skyfront_core::run::memory::{Memory, flags_len, ring_cells};
use skyfront_core::run::outcome::{Outcome, StopReason};
use skyfront_core::run::plan::{Plane, leaves};
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::stage::Stage;
use skyfront_core::sources::catalog::Source;

/// The memory for every case.
pub type Planes<A> =
    run::Planes<A, WIDTH, { WIDTH * HEIGHT }, { ring_cells(WIDTH, true) }, { flags_len(WIDTH, HEIGHT) }>;

/// Rows of one poll: a number that divides no height, so that slices end anywhere.
const SLICE: usize = 7;

/// CRC-32 of the little-endian bytes of 100 `powf` values: the smallest proof that two processors agree.
#[must_use]
pub fn powers() -> u32 {
    let mut digest = Digest::default();
    for i in 1..=100u16 {
        let value = libm::powf(f32::from(i) / 101.0, 0.25 + f32::from(i) / 64.0);
        digest.bytes(&value.to_le_bytes());
    }
    digest.value()
}

/// CRC-32 of square roots as a machine takes them, of every exponent and of mantissas that end anywhere.
#[must_use]
pub fn roots<M: Machine>() -> u32 {
    let mut digest = Digest::default();
    let mut state = 1u32;
    for exponent in 0..255u32 {
        for _ in 0..64 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let root = M::sqrt(f32::from_bits(exponent << 23 | state >> 9));
            digest.bytes(&root.to_le_bytes());
        }
    }
    digest.value()
}

/// Runs every case in an arithmetic and gives `tell` each digest with its name.
pub fn all<A: Arithmetic>(planes: &mut Planes<A>, mut tell: impl FnMut(&[&str], u32)) {
    for case in case::all() {
        let [preset, scheme] = case.name();
        let (config, mut frame) = (case.config::<A>(), case.frame());
        one(&config, (WIDTH, HEIGHT), &mut frame, planes.memory(), |what, crc| {
            tell(&[A::NAME, preset, scheme, what], crc);
        });
    }
    bands(planes.memory(), |what, crc| tell(&[A::NAME, "bands", "chan-vese", what], crc));
}

/// Columns and rows of a frame of two bands: its planes lie on the stack.
const OF_BANDS: (usize, usize) = (20, 15);
const BAND: usize = OF_BANDS.0 * OF_BANDS.1;

/// The rows of the one after those of the other.
struct Two(Scene, Scene);

impl Frame for Two {
    type Error = Infallible;

    fn row(&mut self, y: usize, out: &mut [f32]) -> Result<(), Infallible> {
        match y.checked_sub(OF_BANDS.1) {
            None => self.0.row(y, out),
            Some(y) => self.1.row(y, out),
        }
    }
}

/// Runs one front over two bands.
fn bands<A: Arithmetic>(memory: Memory<'_, A>, mut tell: impl FnMut(&str, u32)) {
    let (width, height) = OF_BANDS;
    let mut scenes = case::skies(width, height).map(|(_, scene)| scene);
    let (Some(first), Some(second)) = (scenes.next(), scenes.next()) else { return };
    let config = Config { band: A::NEEDS_BAND, ..Config::CHAN_VESE };
    let (mut planes, mut each) = ([A::Cell::BLANK; 2 * BAND], [Band::NEW; 2]);
    let bands = Bands { planes: &mut planes, each: &mut each };
    let run = Segmenter::of_bands(&config, width, height, memory, bands);
    watched::<A, _>(run, &mut Two(first, second), |what, crc| {
        // What comes before the front comes once for each band.
        if !matches!(what, "normalize" | "rescale" | "filter") {
            tell(what, crc);
        }
    });
}

/// Runs one frame and gives `tell` what was digested and the digest: planes, catalogue, outcome.
///
/// A run that fails tells `error` in place of what is missing.
pub fn one<A: Arithmetic, F: Frame>(
    config: &Config,
    size: (usize, usize),
    frame: &mut F,
    memory: Memory<'_, A>,
    tell: impl FnMut(&str, u32),
) {
    watched(Segmenter::new(config, size.0, size.1, memory), frame, tell);
}

/// Tells the digests of a run.
fn watched<A: Arithmetic, F: Frame>(
    run: Result<Segmenter<'_, A>, Error>,
    frame: &mut F,
    mut tell: impl FnMut(&str, u32),
) {
    let outcome = to_the_end::<A, AnyScheme<A>, F>(run, frame, SLICE, |stage, over, run| {
        if !over {
            return;
        }
        if let Some(name) = name_of_plane(stage) {
            tell(name, digest::of_cells(if leaves(stage) == Some(Plane::Image) { run.image() } else { run.front() }));
        }
        if stage == Stage::Measure {
            tell("catalog", catalog_digest(run.catalog()));
        }
    });
    match outcome {
        Ok(outcome) => tell("outcome", outcome_digest(&outcome)),
        // An arithmetic may refuse a setting that its cells cannot hold: then all processors must.
        Err(Error::Arithmetic { .. }) => tell("refused", 0),
        Err(_) => tell("error", 0),
    }
}

/// What the plane is called that a stage leaves behind.
fn name_of_plane(stage: Stage) -> Option<&'static str> {
    match stage {
        Stage::Normalize => Some("normalize"),
        Stage::Rescale => Some("rescale"),
        Stage::Filter => Some("filter"),
        Stage::Edge => Some("edge"),
        Stage::Front => Some("front"),
        Stage::Evolve => Some("evolve"),
        Stage::Arrive => Some("arrive"),
        Stage::Turn => Some("turn"),
        Stage::Measure => Some("labels"),
        _ => None,
    }
}

fn outcome_digest(outcome: &Outcome) -> u32 {
    let Outcome { steps, mask_pixels, sources, catalogued, unlabelled, .. } = *outcome;
    let reason = u32::from(outcome.reason == StopReason::Rest);
    let (least, greatest) = outcome.gradient;
    let reals = [outcome.last_change, outcome.range.low, outcome.range.high, outcome.tau, least, greatest];
    words([reason, steps, mask_pixels, sources, catalogued, unlabelled].into_iter().chain(reals.map(f32::to_bits)))
}

/// The digest of a catalogue: everything a source can be asked.
#[must_use]
pub fn catalog_digest(sources: &[Source]) -> u32 {
    words(sources.iter().flat_map(|source| {
        let Source { label, area, x0, y0, columns, rows, peak, peak_at, .. } = *source;
        let ((x, y), ellipse) = (source.centroid(), source.ellipse());
        let counts = [label, area, x0, y0, columns.0, columns.1, rows.0, rows.1, peak_at.0, peak_at.1];
        let reals = [peak, source.sum(), x, y, ellipse.a, ellipse.b, ellipse.theta];
        counts.into_iter().chain(reals.map(f32::to_bits))
    }))
}

/// The digest of words, each as its little-endian bytes.
pub(crate) fn words(words: impl Iterator<Item = u32>) -> u32 {
    let mut digest = Digest::default();
    words.for_each(|word| digest.bytes(&word.to_le_bytes()));
    digest.value()
}
