//! What the default costs on a star camera's frame: the costliest poll of one row, and the mean one, by stage.

use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::plane::mask::mask_words;
use skyfront_core::plane::raster::Raster;
use skyfront_core::plane::smooth::ROOM_ROWS;
use skyfront_core::run::extract::{Extractor, Progress};
use skyfront_core::run::stage::Stage;
use skyfront_core::run::workspace::Workspace;
use skyfront_core::sky::view::Known;
use skyfront_core::sky::{CELL, Sky, mesh_cells};
use skyfront_core::sources::tree::Region;

/// Columns and rows of the frame.
pub const SIDE: usize = 256;
/// Pixels of the frame.
pub const PIXELS: usize = SIDE * SIDE;
/// Regions: more than the noise of such a frame has.
const REGIONS: usize = 4096;
/// Pixels from one star to the next.
const PITCH: usize = 64;
/// Stars in the frame.
pub const STARS: usize = (SIDE / PITCH) * (SIDE / PITCH);
/// More than a run has kinds of stages.
const STAGES: usize = 16;

/// The frame and all memory of a run, some two megabytes.
#[derive(Debug)]
pub struct Room {
    frame: [u16; PIXELS],
    levels: [[f32; PIXELS]; 3],
    words: [[u32; PIXELS]; 3],
    masked: [u32; mask_words(PIXELS)],
    rows: [f32; ROOM_ROWS * SIDE],
    mesh: [Sky; mesh_cells(SIDE, SIDE, CELL)],
    regions: [Region<f32>; REGIONS],
}

/// The polls of a stage, in all its rounds.
#[derive(Clone, Copy, Debug)]
pub struct Polls {
    /// The stage.
    pub stage: Stage,
    /// How many polls of one row.
    pub count: u32,
    /// Instructions of all of them.
    pub total: u64,
    /// Instructions of the costliest.
    pub worst: u64,
}

impl Room {
    /// Memory of zeros, which costs no flash.
    pub const BLANK: Room = Room {
        frame: [0; PIXELS],
        levels: [[0.0; PIXELS]; 3],
        words: [[0; PIXELS]; 3],
        masked: [0; mask_words(PIXELS)],
        rows: [0.0; ROOM_ROWS * SIDE],
        mesh: [Sky { level: 0.0, noise: 0.0 }; mesh_cells(SIDE, SIDE, CELL)],
        regions: [Region::BLANK; REGIONS],
    };

    /// Draws a sky of 100 counts with a noise of 6, and a star in the middle of every 64 x 64 pixels, each brighter than the
    /// one before it.
    pub fn draw(&mut self) {
        let mut state = 1u32;
        for (at, pixel) in self.frame.iter_mut().enumerate() {
            let (x, y) = (at % SIDE, at / SIDE);
            let star = y / PITCH * (SIDE / PITCH) + x / PITCH;
            let from = |place: usize| (place % PITCH) as f32 - (PITCH / 2) as f32 - 0.1 * (star % 7) as f32;
            let light = 150.0 * (1 + star) as f32 * libm::expf(-0.4 * (from(x) * from(x) + from(y) * from(y)));
            // Four numbers uniform from -5 to 5.2: together nearly Gaussian.
            let noise: f32 = (0..4)
                .map(|_| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (state >> 24) as f32 / 25.0 - 5.0
                })
                .sum();
            *pixel = (100.5 + noise + light).clamp(0.0, 4095.0) as u16;
        }
    }

    /// Runs the default in polls of one row; gives `tell` the polls of every stage and returns the number of sources.
    /// `count` is a running number of instructions and returns those since it was last asked.
    ///
    /// # Errors
    /// What the core refuses.
    pub fn run(&mut self, mut count: impl FnMut() -> u64, mut tell: impl FnMut(&Polls)) -> Result<u32, Error> {
        let ([signal, fine, smooth], [parents, order, labels]) = (&mut self.levels, &mut self.words);
        let Room { frame, masked, rows, mesh, regions, .. } = self;
        let work = Workspace { signal, fine, smooth, labels, parents, order, masked, rows, mesh, regions };
        let frame = Raster::new(frame, SIDE, SIDE, SIDE)?;
        let mut run = Extractor::over(&Config::NOISE_AWARE, frame, Known::default(), work)?;
        let mut stages: [Option<Polls>; STAGES] = [None; STAGES];
        let sources = loop {
            let stage = match run.progress() {
                Progress::Next(stage) => stage,
                Progress::Done(found) => break found.sources,
                Progress::Filter | Progress::Front => return Err(Error::Waiting),
            };
            count();
            run.poll(1)?;
            let instructions = count();
            let same = |polls: &Option<Polls>| polls.is_none_or(|polls| polls.stage == stage);
            if let Some(place) = stages.iter_mut().find(|polls| same(polls)) {
                let polls = place.get_or_insert(Polls { stage, count: 0, total: 0, worst: 0 });
                polls.count += 1;
                polls.total += instructions;
                polls.worst = polls.worst.max(instructions);
            }
        };
        stages.iter().flatten().for_each(&mut tell);
        Ok(sources)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    #[test]
    fn all_stars_are_found_and_every_poll_is_counted() {
        let mut room = std::boxed::Box::new(Room::BLANK);
        room.draw();
        let (mut polls, mut counted) = (0u64, 0);
        let sources = room.run(
            || 1,
            |stage| {
                counted += 1;
                polls += stage.total;
                assert!(stage.total == u64::from(stage.count) && stage.worst == 1, "{stage:?}");
            },
        );
        assert_eq!(sources, Ok(STARS as u32));
        assert!(counted > 6 && polls > 10 * SIDE as u64, "{counted} stages, {polls} polls");
    }
}
