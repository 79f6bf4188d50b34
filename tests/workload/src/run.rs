//! One run in fixed memory, watched poll by poll.

use skyfront_core::arithmetic::{Arithmetic, Cell};
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::front::scheme::Evolve;
use skyfront_core::run::frame::Frame;
use skyfront_core::run::memory::Memory;
use skyfront_core::run::outcome::{Outcome, Progress};
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::stage::Stage;
use skyfront_core::sky::otsu::Histogram;
use skyfront_core::sources::catalog::Source;

/// All memory of a run: `PIXELS` = width x height, `RING` and `FLAGS` as [`skyfront_core::run::memory::ring_cells`]
/// and [`skyfront_core::run::memory::flags_len`] tell.
#[derive(Debug)]
pub struct Planes<A: Arithmetic, const WIDTH: usize, const PIXELS: usize, const RING: usize, const FLAGS: usize> {
    image: [A::Cell; PIXELS],
    front: [A::Cell; PIXELS],
    ring: [A::Cell; RING],
    tiles: [u8; FLAGS],
    samples: [f32; WIDTH],
    counts: Histogram,
    sources: [Source; 16],
}

impl<A: Arithmetic, const WIDTH: usize, const PIXELS: usize, const RING: usize, const FLAGS: usize>
    Planes<A, WIDTH, PIXELS, RING, FLAGS>
{
    /// Memory of zeros, which costs no flash.
    pub const ZERO: Self = Planes {
        image: [A::Cell::BLANK; PIXELS],
        front: [A::Cell::BLANK; PIXELS],
        ring: [A::Cell::BLANK; RING],
        tiles: [0; FLAGS],
        samples: [0.0; WIDTH],
        counts: Histogram::EMPTY,
        sources: [Source::empty(0); 16],
    };

    /// The memory, as a run wants it.
    pub fn memory(&mut self) -> Memory<'_, A> {
        Memory {
            image: &mut self.image,
            front: &mut self.front,
            ring: &mut self.ring,
            tiles: &mut self.tiles,
            samples: &mut self.samples,
            counts: &mut self.counts,
            sources: &mut self.sources,
        }
    }
}

/// Runs to the end in slices of `rows` rows.
///
/// After every poll `watch` sees the stage that the poll worked on, whether that stage is over, and the run.
///
/// # Errors
/// Those of the segmenter: none is expected here.
pub fn run<A: Arithmetic, S: Evolve<A>, F: Frame>(
    config: &Config,
    (width, height): (usize, usize),
    frame: &mut F,
    memory: Memory<'_, A>,
    rows: usize,
    watch: impl FnMut(Stage, bool, &Segmenter<'_, A, S>),
) -> Result<Outcome, Error<F::Error>> {
    to_the_end(Segmenter::<A, S>::new(config, width, height, memory), frame, rows, watch)
}

/// The same with a run that is set up, or could not be.
///
/// # Errors
/// Those of [`run`].
pub fn to_the_end<A: Arithmetic, S: Evolve<A>, F: Frame>(
    run: Result<Segmenter<'_, A, S>, Error>,
    frame: &mut F,
    rows: usize,
    mut watch: impl FnMut(Stage, bool, &Segmenter<'_, A, S>),
) -> Result<Outcome, Error<F::Error>> {
    let mut run = run.map_err(|error| error.map_frame(|never| match never {}))?;
    loop {
        let stage = run.stage();
        let progress = run.poll(rows, frame)?;
        watch(stage, run.stage() != stage, &run);
        if let Progress::Done(outcome) = progress {
            return Ok(outcome);
        }
    }
}
