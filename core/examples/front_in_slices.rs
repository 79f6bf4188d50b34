// The paper's front over a frame that comes row by row, eight rows of work a call, in memory fixed beforehand.
use skyfront_core::arithmetic::F32;
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::run::memory::{Memory, flags_len, ring_cells};
use skyfront_core::run::outcome::Progress;
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::simulate::{Kind, Sky};
use skyfront_core::sky::otsu::Histogram;
use skyfront_core::sources::catalog::Source;

const W: usize = 64;
const H: usize = 48;

fn main() -> Result<(), Error> {
    let (mut image, mut front) = ([0.0; W * H], [0.0; W * H]);
    let (mut ring, mut samples) = ([0.0; ring_cells(W, false)], [0.0; W]);
    let (mut tiles, mut counts) = ([0; flags_len(W, H)], Histogram::EMPTY);
    let mut sources = [Source::empty(0); 32];
    let memory = Memory {
        image: &mut image,
        front: &mut front,
        ring: &mut ring,
        tiles: &mut tiles,
        samples: &mut samples,
        counts: &mut counts,
        sources: &mut sources,
    };
    let mut frame = Sky::new(Kind::Bright, 7, W, H);
    let mut run = Segmenter::<F32>::new(&Config::PAPER_F160, W, H, memory)?;
    let outcome = loop {
        match run.poll(8, &mut frame)? {
            Progress::Working { .. } => {} // other tasks, the watchdog
            Progress::Done(outcome) => break outcome,
        }
    };
    println!("{} sources after {} steps of the front", outcome.sources, outcome.steps);
    for source in run.catalog() {
        let (x, y) = source.centroid();
        println!("label {}: {} pixels around ({x:.1}, {y:.1})", source.label, source.area);
    }
    assert!(outcome.sources > 0);
    Ok(())
}
