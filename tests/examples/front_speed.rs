//! What `tests/peers/speed` needs from inside: a simulated sky as a file, and the time that the
//! front alone takes on an image, with the edge detector it moved on.
//!
//! `front_speed sky SIDE FILE`; `front_speed front IMAGE EDGE DT [BAND]` writes the edge detector as
//! little-endian f32 and prints seconds of processor time, steps, width and height.

use skyfront::machine::Native;
use skyfront::read;
use skyfront::write::fits::Writer;
use skyfront_core::arithmetic::F32;
use skyfront_core::config::Config;
use skyfront_core::run::frame::{Frame, SliceFrame};
use skyfront_core::run::memory::{Memory, flags_len, ring_cells};
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::stage::Stage;
use skyfront_core::simulate::{Kind, Sky};
use skyfront_core::sky::otsu::Histogram;
use skyfront_core::sources::catalog::Source;
use std::error::Error;
use std::path::Path;

/// The system counts a thread's time in ticks of some milliseconds: the mean of several runs is told.
const ROUNDS: u32 = 10;

/// Seconds of processor time of this thread.
fn now() -> Result<f64, Box<dyn Error>> {
    let spent = std::fs::read_to_string("/proc/thread-self/schedstat")?;
    Ok(spent.split(' ').next().unwrap_or_default().parse::<f64>()? * 1e-9)
}

fn sky(side: usize, file: &Path) -> Result<(), Box<dyn Error>> {
    let mut sky = Sky::new(Kind::Bright, 1, side, side);
    let mut writer = Writer::create(file)?;
    writer.image((side, side), &[], |y, row: &mut [f32]| {
        let Ok(()) = sky.row(y, row);
    })?;
    Ok(writer.finish()?)
}

fn front(image: &Path, edge: &Path, dt: f32, band: Option<f32>) -> Result<(), Box<dyn Error>> {
    let image = read::image(image, None)?;
    let (width, height) = (image.width, image.height);
    let count = width * height;
    let (mut plane, mut front) = (vec![0.0; count], vec![0.0; count]);
    let (mut ring, mut tiles) = (vec![0.0; ring_cells(width, false)], vec![0; flags_len(width, height)]);
    let (mut samples, mut counts, mut sources) = (vec![0.0; width], Histogram::EMPTY, vec![Source::empty(0); 10_000]);
    let config = Config { dt, band, ..Config::PAPER_F160 };
    let frame = &mut SliceFrame(&image.pixels);
    let (mut seconds, mut steps) = (0.0, 0);
    for _ in 0..ROUNDS {
        let memory = Memory {
            image: &mut plane,
            front: &mut front,
            ring: &mut ring,
            tiles: &mut tiles,
            samples: &mut samples,
            counts: &mut counts,
            sources: &mut sources,
        };
        let mut segmenter = Segmenter::<F32<Native>>::new(&config, width, height, memory)?;
        while segmenter.stage() != Stage::Evolve {
            segmenter.poll(usize::MAX, frame)?;
        }
        let bytes: Vec<u8> = segmenter.image().iter().flat_map(|g| g.to_le_bytes()).collect();
        std::fs::write(edge, bytes)?;
        let before = now()?;
        steps = 0;
        while segmenter.stage() == Stage::Evolve {
            segmenter.poll(usize::MAX, frame)?;
            steps += 1;
        }
        seconds += now()? - before;
    }
    println!("{} {steps} {width} {height}", seconds / f64::from(ROUNDS));
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["sky", side, file] => sky(side.parse()?, Path::new(file)),
        ["front", image, edge, dt] => front(Path::new(image), Path::new(edge), dt.parse()?, None),
        ["front", image, edge, dt, band] => front(Path::new(image), Path::new(edge), dt.parse()?, Some(band.parse()?)),
        _ => Err("front_speed sky SIDE FILE, or front_speed front IMAGE EDGE DT [BAND]".into()),
    }
}
