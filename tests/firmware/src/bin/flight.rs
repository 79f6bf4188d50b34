//! All that a flight computer needs: static memory, frame in, slices with a heartbeat, catalogue out.

#![no_std]
#![no_main]

use skyfront_core::config::Config;
use skyfront_core::hal::{Heartbeat, MapWriter, MemoryFrame, PixelFormat, SerialMemory};
use skyfront_core::run::memory::{Memory, bytes, flags_len, ring_cells};
use skyfront_core::run::outcome::Progress;
use skyfront_core::sky::otsu::Histogram;
use skyfront_core::sources::catalog::Source;
use skyfront_core::{arithmetic::F32, front::scheme::Fd, run::segmenter::Segmenter};
use skyfront_firmware::entry;
use skyfront_firmware::machine::{Console, Once};
use skyfront_machine::Processor;
use skyfront_workload::fram::{Failed, Pin, sky_in_fram};
use skyfront_workload::{bits, report};

type Number = F32<Processor>;
const W: usize = 48;
const H: usize = 36;
const MAP: u32 = 0x4000;
const _: () = assert!(bytes(W, H, 4, false, 16) < 18 * 1024, "more memory than this computer has");

static IMAGE: Once<[f32; W * H]> = Once::new([0.0; W * H]);
static FRONT: Once<[f32; W * H]> = Once::new([0.0; W * H]);
static RING: Once<[f32; ring_cells(W, false)]> = Once::new([0.0; ring_cells(W, false)]);
static TILES: Once<[u8; flags_len(W, H)]> = Once::new([0; flags_len(W, H)]);
static SAMPLES: Once<[f32; W]> = Once::new([0.0; W]);
static COUNTS: Once<Histogram> = Once::new(Histogram::EMPTY);
static SOURCES: Once<[Source; 16]> = Once::new([Source::empty(0); 16]);
static STORAGE: Once<[u8; 0x8000]> = Once::new([0; 0x8000]);

entry!(fly);

fn fly(mut line: Console) {
    if segment(&mut line).is_some() {
        report::done(&mut line);
    }
}

/// `None` when anything failed; a real computer logs what and tries again.
fn segment(line: &mut Console) -> Option<()> {
    let (image, front, ring, tiles) = (IMAGE.take(), FRONT.take(), RING.take(), TILES.take());
    let (samples, counts, sources) = (SAMPLES.take(), COUNTS.take(), SOURCES.take());
    let memory = Memory { image, front, ring, tiles, samples, counts, sources };
    let spi = sky_in_fram(STORAGE.take(), W, H); // On a real board: the SpiDevice of its own crate.
    let mut frame = MemoryFrame::new(SerialMemory::new(spi), 0, W, H, PixelFormat::U16Be).ok()?;
    let mut run = Segmenter::<Number, Fd<Number>>::new(&Config::PAPER_F160, W, H, memory).ok()?;
    let mut heartbeat = Heartbeat::new(Pin::default(), 4); // And its OutputPin: an edge every 4 rows.
    while let Progress::Working { .. } = heartbeat.poll(&mut run, &mut frame).ok()? {
        // Other tasks have their turn here.
    }
    let mut map = MapWriter::new::<Failed>(MAP, W * H, PixelFormat::U16Be).ok()?;
    while !map.poll(frame.memory(), run.front()).ok()? {
        heartbeat.beat().ok()?;
    }
    report::resource(line, &["sources"], run.catalog().len() as u32, "sources");
    report::digest(line, &["flight", "catalog"], bits::catalog_digest(run.catalog()));
    Some(())
}
