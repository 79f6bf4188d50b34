//! One run in fixed memory, watched stage by stage.

use crate::case::{Case, HEIGHT, WIDTH};
use core::convert::Infallible;
use skyfront_core::arithmetic::Arithmetic;
use skyfront_core::catalog::Source;
use skyfront_core::error::Error;
use skyfront_core::memory::{Memory, ring_cells};
use skyfront_core::outcome::{Outcome, Progress};
use skyfront_core::segmenter::Segmenter;
use skyfront_core::stage::Stage;

const PIXELS: usize = WIDTH * HEIGHT;
const RING: usize = ring_cells(WIDTH, true);
const SOURCES: usize = 16;

/// All memory of a run, for any scheme.
#[derive(Debug)]
pub struct Planes<A: Arithmetic> {
    image: [A::Cell; PIXELS],
    front: [A::Cell; PIXELS],
    ring: [A::Cell; RING],
    samples: [f32; WIDTH],
    sources: [Source; SOURCES],
}

impl<A: Arithmetic> Default for Planes<A> {
    fn default() -> Self {
        let cell = A::Cell::default();
        Planes {
            image: [cell; PIXELS],
            front: [cell; PIXELS],
            ring: [cell; RING],
            samples: [0.0; WIDTH],
            sources: [Source::empty(0); SOURCES],
        }
    }
}

impl<A: Arithmetic> Planes<A> {
    fn memory(&mut self) -> Memory<'_, A> {
        Memory {
            image: &mut self.image,
            front: &mut self.front,
            ring: &mut self.ring,
            samples: &mut self.samples,
            sources: &mut self.sources,
        }
    }
}

/// Runs a case in slices of `rows` rows.
///
/// After every poll `watch` sees the stage that the poll worked on, whether that stage is over, and the run.
///
/// # Errors
/// Those of the segmenter: none is expected of these cases.
pub fn run<A: Arithmetic>(
    case: &Case,
    planes: &mut Planes<A>,
    rows: usize,
    mut watch: impl FnMut(Stage, bool, &Segmenter<'_, A>),
) -> Result<Outcome, Error<Infallible>> {
    let mut frame = case.frame();
    let mut run = Segmenter::<A>::new(&case.config::<A>(), WIDTH, HEIGHT, planes.memory())?;
    loop {
        let stage = run.stage();
        let progress = run.poll(rows, &mut frame)?;
        watch(stage, run.stage() != stage, &run);
        if let Progress::Done(outcome) = progress {
            return Ok(outcome);
        }
    }
}
