// The default over a frame in memory: sky and noise measured, outlines by a front, blends divided.
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::plane::mask::mask_words;
use skyfront_core::plane::smooth::ROOM_ROWS;
use skyfront_core::run::extract::extract;
use skyfront_core::run::frame::Frame;
use skyfront_core::run::workspace::{Workspace, regions};
use skyfront_core::simulate::{Kind, Sky as Simulated};
use skyfront_core::sky::view::Known;
use skyfront_core::sky::{Sky, mesh_cells};
use skyfront_core::sources::tree::Region;

const W: usize = 96;
const H: usize = 64;
const N: usize = W * H;
const CELL: usize = Config::NOISE_AWARE.sky.cell();

fn main() -> Result<(), Error> {
    let mut sky = Simulated::new(Kind::Bright, 7, W, H);
    let mut pixels = [0.0; N];
    for (y, row) in pixels.chunks_exact_mut(W).enumerate() {
        let Ok(()) = sky.row(y, row);
    }
    let [mut signal, mut fine, mut smooth] = [[0.0; N]; 3];
    let (mut masked, mut rows) = ([0; mask_words(N)], [0.0; ROOM_ROWS * W]);
    let [mut parents, mut order, mut labels] = [[0; N]; 3];
    let mut mesh = [Sky::UNKNOWN; mesh_cells(W, H, CELL)];
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
    let found = extract(&Config::NOISE_AWARE, &pixels, W, Known::default(), work)?;
    println!("{} sources of {} pixels; the sky is {:.4}", found.sources, found.mask_pixels, mesh[0].level);
    assert!(found.sources > 0);
    assert_eq!(labels.iter().max(), Some(&found.sources));
    Ok(())
}
