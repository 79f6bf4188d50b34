// The paper's front with all that the default knows: it moves over the signal-to-noise that an extractor made,
// and the extractor divides and selects what the front outlined.
use skyfront_core::arithmetic::F32;
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::plane::mask::mask_words;
use skyfront_core::plane::smooth::ROOM_ROWS;
use skyfront_core::run::extract::{Extractor, Progress};
use skyfront_core::run::frame::{Frame, SliceFrame};
use skyfront_core::run::memory::{Memory, flags_len, ring_cells};
use skyfront_core::run::outcome::Progress as Moved;
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::workspace::{Workspace, regions};
use skyfront_core::simulate::{Kind, Sky as Simulated};
use skyfront_core::sky::otsu::Histogram;
use skyfront_core::sky::view::Known;
use skyfront_core::sky::{Sky, mesh_cells};
use skyfront_core::sources::tree::Region;

const W: usize = 96;
const H: usize = 64;
const N: usize = W * H;
const CONFIG: Config = Config::RSA;

/// Moves the front over an image until it stops; whether each pixel is inside.
fn outline(image: &[f32]) -> Result<[bool; N], Error> {
    let (mut plane, mut front) = ([0.0; N], [0.0; N]);
    let (mut ring, mut samples) = ([0.0; ring_cells(W, false)], [0.0; W]);
    let (mut tiles, mut counts) = ([0; flags_len(W, H)], Histogram::EMPTY);
    let memory = Memory {
        image: &mut plane,
        front: &mut front,
        ring: &mut ring,
        tiles: &mut tiles,
        samples: &mut samples,
        counts: &mut counts,
        sources: &mut [],
    };
    let mut mover = Segmenter::<F32>::new(&CONFIG, W, H, memory)?;
    while !matches!(mover.poll(H, &mut SliceFrame(image))?, Moved::Done(_)) {}
    Ok(core::array::from_fn(|at| mover.front()[at] > 0.0))
}

fn main() -> Result<(), Error> {
    let mut sky = Simulated::new(Kind::Bright, 7, W, H);
    let mut pixels = [0.0; N];
    for (y, row) in pixels.chunks_exact_mut(W).enumerate() {
        let Ok(()) = sky.row(y, row);
    }
    let [mut signal, mut fine, mut smooth] = [[0.0; N]; 3];
    let (mut masked, mut rows) = ([0; mask_words(N)], [0.0; ROOM_ROWS * W]);
    let [mut parents, mut order, mut labels] = [[0; N]; 3];
    let mut mesh = [Sky::UNKNOWN; mesh_cells(W, H, CONFIG.sky.cell())];
    let mut table = [Region::BLANK; regions(W, H)];
    let work = Workspace {
        signal: &mut signal,
        fine: &mut fine,
        smooth: &mut smooth,
        parents: &mut parents,
        order: &mut order,
        labels: &mut labels,
        masked: &mut masked,
        rows: &mut rows,
        mesh: &mut mesh,
        regions: &mut table,
    };
    let mut run = Extractor::new(&CONFIG, &pixels, W, Known::default(), work)?;
    let found = loop {
        match run.progress() {
            Progress::Next(_) => {
                run.poll(usize::MAX)?;
            }
            Progress::Front => {
                let inside = outline(run.image())?;
                run.outline(|at| inside[at]);
            }
            // Where a filter in steps is to smooth for the default's own front, the segmenter ends with the image
            // that `start_from` takes.
            Progress::Filter => unreachable!("this front is the paper's"),
            Progress::Done(found) => break found,
        }
    };
    println!("{} sources of {} pixels", found.sources, found.mask_pixels);
    assert!(found.sources > 0);
    Ok(())
}
