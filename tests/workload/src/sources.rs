//! The digests of the default, which must be the same on every processor.

use crate::bits::words;
use crate::case;
use skyfront_core::arithmetic::Level;
use skyfront_core::arithmetic::digest;
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::plane::mask::mask_words;
use skyfront_core::plane::smooth::ROOM_ROWS;
use skyfront_core::run::extract::{Extractor, Found, Progress};
use skyfront_core::run::frame::Frame;
use skyfront_core::run::stage::Stage;
use skyfront_core::run::workspace::{Workspace, regions};
use skyfront_core::sky::view::Known;
use skyfront_core::sky::{CELL, Sky, mesh_cells};
use skyfront_core::sources::tree::Region;

/// Columns of every sky: two cells of the mesh.
const WIDTH: usize = 100;
/// Rows of every sky.
const HEIGHT: usize = 72;
const PIXELS: usize = WIDTH * HEIGHT;

/// All memory of a run, some 0.3 megabytes.
#[derive(Debug)]
pub struct Room<L: Level> {
    pixels: [f32; PIXELS],
    levels: [[L; PIXELS]; 3],
    words: [[u32; PIXELS]; 3],
    masked: [u32; mask_words(PIXELS)],
    rows: [L; ROOM_ROWS * WIDTH],
    mesh: [Sky; mesh_cells(WIDTH, HEIGHT, CELL)],
    regions: [Region<L>; regions(WIDTH, HEIGHT)],
}

impl<L: Level> Room<L> {
    /// Memory of zeros, which costs no flash.
    pub const BLANK: Room<L> = Room {
        pixels: [0.0; PIXELS],
        levels: [[L::BLANK; PIXELS]; 3],
        words: [[0; PIXELS]; 3],
        masked: [0; mask_words(PIXELS)],
        rows: [L::BLANK; ROOM_ROWS * WIDTH],
        mesh: [Sky { level: 0.0, noise: 0.0 }; mesh_cells(WIDTH, HEIGHT, CELL)],
        regions: [Region::BLANK; regions(WIDTH, HEIGHT)],
    };

    /// Runs the default on every sky and gives `tell` each digest with its name.
    pub fn all(&mut self, mut tell: impl FnMut(&[&str], u32)) {
        for (sky, mut frame) in case::skies(WIDTH, HEIGHT) {
            for (y, row) in self.pixels.chunks_exact_mut(WIDTH).enumerate() {
                let Ok(()) = frame.row(y, row);
            }
            self.one(|what, crc| tell(&[L::NAME, sky, "default", what], crc));
        }
    }

    fn one(&mut self, mut tell: impl FnMut(&str, u32)) {
        let ([signal, fine, smooth], [parents, order, labels]) = (&mut self.levels, &mut self.words);
        let Room { pixels, masked, rows, mesh, regions, .. } = self;
        let work = Workspace { signal, fine, smooth, labels, parents, order, masked, rows, mesh, regions };
        let [smooth, front] = match run(pixels, work) {
            Ok((found, planes)) => {
                tell("found", found_digest(&found));
                planes
            }
            Err(_) => {
                tell("error", 0);
                [0; 2]
            }
        };
        let ([signal, ..], [.., labels]) = (&self.levels, &self.words);
        tell("mesh", words(self.mesh.iter().flat_map(|sky| [sky.level, sky.noise]).map(f32::to_bits)));
        tell("signal", digest::of_cells(signal));
        tell("smooth", smooth);
        tell("front", front);
        tell("labels", words(labels.iter().copied()));
    }
}

/// What a run found, and the digests of the image that its front starts from and of the front, whose place others take.
fn run<L: Level>(pixels: &[f32], work: Workspace<'_, L>) -> Result<(Found, [u32; 2]), Error> {
    let mut run = Extractor::new(&Config::NOISE_AWARE, pixels, WIDTH, Known::default(), work)?;
    let mut planes = [0; 2];
    loop {
        match run.poll(usize::MAX)? {
            Progress::Next(Stage::Tree) => {
                planes = [digest::of_cells(run.image()), words(run.work().labels.iter().copied())];
            }
            Progress::Done(found) => return Ok((found, planes)),
            _ => {}
        }
    }
}

fn found_digest(found: &Found) -> u32 {
    let Found { sources, mask_pixels, unlabelled, significance, photon, .. } = *found;
    words([sources, mask_pixels, unlabelled, significance.to_bits(), photon.to_bits()].into_iter())
}
