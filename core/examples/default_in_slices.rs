// The default over a camera's buffer: counts in rows a stride apart, a bad pixel, and a few rows of work per poll.
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::plane::camera::Camera;
use skyfront_core::plane::mask::mask_words;
use skyfront_core::plane::raster::{BadPixel, Raster};
use skyfront_core::plane::smooth::ROOM_ROWS;
use skyfront_core::run::extract::catalogue::Measuring;
use skyfront_core::run::extract::{Extractor, Found, Progress};
use skyfront_core::run::frame::Frame;
use skyfront_core::run::workspace::{Workspace, regions};
use skyfront_core::simulate::{Kind, Sky as Simulated};
use skyfront_core::sky::view::Known;
use skyfront_core::sky::{Sky, mesh_cells};
use skyfront_core::sources::measure::Sums;
use skyfront_core::sources::tree::Region;

const W: usize = 96;
const H: usize = 64;
const N: usize = W * H;
const STRIDE: usize = 128;
const CELL: usize = Config::NOISE_AWARE.sky.cell();
const REGIONS: usize = regions(W, H);
const SOURCES: usize = 32;
const CAMERA: Camera = Camera { black: 0.0, gain: 2.0, read_noise: 5.0, saturation: 16_383.0, psf_sigma: 1.0 };

/// The memory of a run: on board a static of zeros.
struct Room {
    levels: [[f32; N]; 3],
    words: [[u32; N]; 3],
    masked: [u32; mask_words(N)],
    rows: [f32; ROOM_ROWS * W],
    mesh: [Sky; mesh_cells(W, H, CELL)],
    regions: [Region<f32>; REGIONS],
}

fn find(buffer: &[u16], room: &mut Room, catalogue: &mut [Sums]) -> Result<Found, Error> {
    let ([signal, fine, smooth], [parents, order, labels]) = (&mut room.levels, &mut room.words);
    let Room { masked, rows, mesh, regions, .. } = room;
    let work = Workspace { signal, fine, smooth, labels, parents, order, masked, rows, mesh, regions };
    let known = Known { bad: &[BadPixel { x: 40, y: 7 }], camera: Some(&CAMERA), ..Known::default() };
    let mut run = Extractor::over(&Config::NOISE_AWARE, Raster::new(buffer, W, H, STRIDE)?, known, work)?;
    let found = loop {
        match run.poll(8)? {
            Progress::Done(found) => break found,
            _ => { /* other tasks, the watchdog */ }
        }
    };
    let mut so_far = Measuring::default();
    while !run.measure(&mut so_far, 8, catalogue)? { /* the same */ }
    Ok(found)
}

fn main() -> Result<(), Error> {
    let mut sky = Simulated::new(Kind::Bright, 7, W, H);
    let mut buffer = vec![0; STRIDE * H];
    for (y, counts) in buffer.chunks_exact_mut(STRIDE).enumerate() {
        let mut row = [0.0; W];
        let Ok(()) = sky.row(y, &mut row);
        counts.iter_mut().zip(row).for_each(|(count, value)| *count = (500.0 + 3000.0 * value) as u16);
    }
    let mut room = Box::new(Room {
        levels: [[0.0; N]; 3],
        words: [[0; N]; 3],
        masked: [0; mask_words(N)],
        rows: [0.0; ROOM_ROWS * W],
        mesh: [Sky::UNKNOWN; mesh_cells(W, H, CELL)],
        regions: [Region::BLANK; REGIONS],
    });
    let mut catalogue = [Sums::EMPTY; SOURCES];
    let found = find(&buffer, &mut room, &mut catalogue)?;
    println!("{} sources of {} pixels", found.sources, found.mask_pixels);
    for source in catalogue.iter().take(found.sources as usize) {
        let (place, flux) = (source.centroid(), source.flux(Some(CAMERA.gain.into())));
        println!("({:.2}, {:.2}): {:.0} +- {:.0} counts", place.x, place.y, flux.value, flux.error);
    }
    assert!(found.sources > 0);
    Ok(())
}
