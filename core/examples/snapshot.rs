// A run that is saved between two polls and taken up by another: the bits are those of one left alone.
use skyfront_core::arithmetic::F32;
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::run::memory::{Memory, flags_len, ring_cells};
use skyfront_core::run::outcome::{Outcome, Progress};
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::simulate::{Kind, Sky};
use skyfront_core::sky::otsu::Histogram;
use skyfront_core::sources::catalog::Source;

const W: usize = 48;
const H: usize = 32;

/// The memory of a run.
struct Room {
    planes: [[f32; W * H]; 2],
    ring: [f32; ring_cells(W, false)],
    tiles: [u8; flags_len(W, H)],
    samples: [f32; W],
    counts: Histogram,
    sources: [Source; 8],
}

impl Room {
    fn new() -> Room {
        Room {
            planes: [[0.0; W * H]; 2],
            ring: [0.0; ring_cells(W, false)],
            tiles: [0; flags_len(W, H)],
            samples: [0.0; W],
            counts: Histogram::EMPTY,
            sources: [Source::empty(0); 8],
        }
    }

    fn run(&mut self) -> Result<Segmenter<'_, F32>, Error> {
        let [image, front] = &mut self.planes;
        let memory = Memory {
            image,
            front,
            ring: &mut self.ring,
            tiles: &mut self.tiles,
            samples: &mut self.samples,
            counts: &mut self.counts,
            sources: &mut self.sources,
        };
        Segmenter::new(&Config::PAPER_F160, W, H, memory)
    }
}

fn to_the_end(run: &mut Segmenter<'_, F32>) -> Result<Outcome, Error> {
    let mut frame = Sky::new(Kind::Bright, 7, W, H);
    loop {
        if let Progress::Done(outcome) = run.poll(H, &mut frame)? {
            return Ok(outcome);
        }
    }
}

fn main() -> Result<(), Error> {
    let (mut first, mut second, mut third) = (Room::new(), Room::new(), Room::new());
    let alone = to_the_end(&mut first.run()?)?;

    let mut snapshot = Vec::new();
    let mut interrupted = second.run()?;
    for _ in 0..100 {
        interrupted.poll(H, &mut Sky::new(Kind::Bright, 7, W, H))?;
    }
    let Ok(()) = interrupted.save(|bytes| {
        snapshot.extend_from_slice(bytes);
        Ok::<(), core::convert::Infallible>(())
    });

    let mut taken_up = third.run()?;
    let mut rest = snapshot.as_slice();
    let restored = taken_up.restore(|bytes| {
        let (head, tail) = rest.split_at_checked(bytes.len()).ok_or("the snapshot ends early")?;
        bytes.copy_from_slice(head);
        rest = tail;
        Ok(())
    });
    assert_eq!(restored, Ok::<(), skyfront_core::run::snapshot::SnapshotError<&str>>(()));
    assert_eq!(to_the_end(&mut taken_up)?, alone);
    println!("{} bytes of snapshot; {} sources either way", snapshot.len(), alone.sources);
    Ok(())
}
