//! The digests of the default, which must be the same on every processor.

use crate::bits::words;
use crate::case;
use skyfront_core::arithmetic::Level;
use skyfront_core::arithmetic::digest;
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::plane::camera::Camera;
use skyfront_core::plane::mask::mask_words;
use skyfront_core::plane::raster::{BadPixel, Raster, Sample};
use skyfront_core::plane::smooth::ROOM_ROWS;
use skyfront_core::run::extract::catalogue::Measuring;
use skyfront_core::run::extract::{Extractor, Found, Progress};
use skyfront_core::run::frame::Frame;
use skyfront_core::run::stage::Stage;
use skyfront_core::run::workspace::{Workspace, regions};
use skyfront_core::simulate::{Kind, Sky as Simulated};
use skyfront_core::sky::view::Known;
use skyfront_core::sky::{CELL, Sky, mesh_cells};
use skyfront_core::sources::measure::{Centroid, Sums};
use skyfront_core::sources::tree::Region;

/// Columns of every sky: two cells of the mesh.
pub const WIDTH: usize = 100;
/// Rows of every sky.
pub const HEIGHT: usize = 72;
const PIXELS: usize = WIDTH * HEIGHT;
/// Pixels from a row of a camera's buffer to the next.
const STRIDE: usize = WIDTH + 12;
/// Room for the sources of a sky.
const SOURCES: usize = 64;
/// Seeds of the skies whose stars are laid over each other in a crowd.
const CROWD: core::ops::Range<u32> = 2..48;
/// Rows of a poll, which have no part in the digests.
const ROWS: usize = 7;

/// All memory of a run, some 0.3 megabytes.
#[derive(Debug)]
pub struct Room<L: Level> {
    pixels: [f32; PIXELS],
    counts: [u16; STRIDE * HEIGHT],
    levels: [[L; PIXELS]; 3],
    words: [[u32; PIXELS]; 3],
    masked: [u32; mask_words(PIXELS)],
    rows: [L; ROOM_ROWS * WIDTH],
    mesh: [Sky; mesh_cells(WIDTH, HEIGHT, CELL)],
    regions: [Region<L>; regions(WIDTH, HEIGHT)],
    sums: [Sums; SOURCES],
}

type Parts<'r, L> = (&'r [f32; PIXELS], &'r mut [u16; STRIDE * HEIGHT], Workspace<'r, L>, &'r mut [Sums; SOURCES]);

impl<L: Level> Room<L> {
    /// Memory of zeros, which costs no flash.
    pub const BLANK: Room<L> = Room {
        pixels: [0.0; PIXELS],
        counts: [0; STRIDE * HEIGHT],
        levels: [[L::BLANK; PIXELS]; 3],
        words: [[0; PIXELS]; 3],
        masked: [0; mask_words(PIXELS)],
        rows: [L::BLANK; ROOM_ROWS * WIDTH],
        mesh: [Sky { level: 0.0, noise: 0.0 }; mesh_cells(WIDTH, HEIGHT, CELL)],
        regions: [Region::BLANK; regions(WIDTH, HEIGHT)],
        sums: [Sums::EMPTY; SOURCES],
    };

    /// Runs the default on every sky and gives `tell` each digest with its name.
    pub fn all(&mut self, mut tell: impl FnMut(&[&str], u32)) {
        for (sky, mut frame) in case::skies(WIDTH, HEIGHT) {
            for (y, row) in self.pixels.chunks_exact_mut(WIDTH).enumerate() {
                let Ok(()) = frame.row(y, row);
            }
            self.one(|what, crc| tell(&[L::NAME, sky, "default", what], crc));
            self.counts(|what, crc| tell(&[L::NAME, sky, "counts", what], crc));
        }
        self.draw_crowd();
        self.one(|what, crc| tell(&[L::NAME, "crowd", "default", what], crc));
    }

    /// Lays the stars of many skies over the noise of one, so that no cell of the mesh has enough sky.
    pub fn draw_crowd(&mut self) {
        let mut first = Simulated::new(Kind::Stars, 1, WIDTH, HEIGHT);
        for (y, row) in self.pixels.chunks_exact_mut(WIDTH).enumerate() {
            let Ok(()) = first.row(y, row);
            for seed in CROWD {
                let sky = Simulated::new(Kind::Stars, seed, WIDTH, HEIGHT);
                (0..sky.objects()).for_each(|index| {
                    sky.add_light(index, y, row);
                });
            }
        }
    }

    /// The pixels, the buffer of a camera, and what a run works in.
    pub fn work(&mut self) -> (&[f32; PIXELS], &mut [u16; STRIDE * HEIGHT], Workspace<'_, L>) {
        let (pixels, counts, work, _) = self.parts();
        (pixels, counts, work)
    }

    /// The same and the catalogue.
    fn parts(&mut self) -> Parts<'_, L> {
        let ([signal, fine, smooth], [parents, order, labels]) = (&mut self.levels, &mut self.words);
        let Room { pixels, counts, masked, rows, mesh, regions, sums, .. } = self;
        let work = Workspace { signal, fine, smooth, labels, parents, order, masked, rows, mesh, regions };
        (pixels, counts, work, sums)
    }

    /// The same sky as a camera has it in its buffer, with two bad pixels.
    fn counts(&mut self, mut tell: impl FnMut(&str, u32)) {
        let (pixels, counts, work, sums) = self.parts();
        for (counts, pixels) in counts.chunks_exact_mut(STRIDE).zip(pixels.chunks_exact(WIDTH)) {
            counts.iter_mut().zip(pixels).for_each(|(count, pixel)| *count = (500.0 + 3000.0 * pixel) as u16);
        }
        let camera = Camera { black: 0.0, gain: 2.0, read_noise: 5.0, saturation: 2500.0, psf_sigma: 1.0 };
        let bad = [BadPixel { x: 9, y: 3 }, BadPixel { x: 70, y: 50 }];
        let known = Known { bad: &bad, camera: Some(&camera), ..Known::default() };
        let frame = Raster::new(counts, WIDTH, HEIGHT, STRIDE);
        let found = frame.and_then(|frame| {
            let mut extractor = Extractor::over(&Config::NOISE_AWARE, frame, known, work)?;
            let (found, _) = run(&mut extractor)?;
            Ok((found, catalogue_digest(&mut extractor, found.sources as usize, sums)?))
        });
        match found {
            Ok((found, catalogue)) => {
                tell("found", found_digest(&found));
                tell("catalogue", catalogue);
            }
            Err(_) => tell("error", 0),
        }
        let [.., labels] = &self.words;
        tell("labels", words(labels.iter().copied()));
    }

    fn one(&mut self, mut tell: impl FnMut(&str, u32)) {
        let (pixels, _, work) = self.work();
        let extractor = Extractor::new(&Config::NOISE_AWARE, pixels, WIDTH, Known::default(), work);
        let [smooth, front] = match extractor.and_then(|mut extractor| run(&mut extractor)) {
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
fn run<L: Level, P: Sample>(run: &mut Extractor<'_, '_, L, P>) -> Result<(Found, [u32; 2]), Error> {
    let mut planes = None;
    loop {
        match run.poll(ROWS)? {
            Progress::Next(Stage::Tree) if planes.is_none() => {
                planes = Some([digest::of_cells(run.image()), words(run.work().labels.iter().copied())]);
            }
            Progress::Done(found) => return Ok((found, planes.unwrap_or_default())),
            _ => {}
        }
    }
}

/// What the sources measure, a few rows at a time.
fn catalogue_digest<L: Level, P: Sample>(
    run: &mut Extractor<'_, '_, L, P>,
    sources: usize,
    sums: &mut [Sums],
) -> Result<u32, Error> {
    let mut so_far = Measuring::default();
    sums.fill(Sums::EMPTY);
    while !run.measure(&mut so_far, ROWS, sums)? {}
    let numbers = sums.iter().take(sources).flat_map(|sums| {
        let (Centroid { x, y, moments, errors }, flux) = (sums.centroid(), sums.flux(Some(2.0)));
        let levels = sums.levels();
        [x, y, moments.0, moments.1, moments.2, errors.0, errors.1, errors.2, flux.value, flux.error]
            .into_iter()
            .chain([levels.background, levels.noise, levels.threshold, f64::from(sums.flags()), f64::from(sums.area)])
    });
    Ok(words(numbers.map(f64::to_bits).flat_map(|bits| [bits as u32, (bits >> 32) as u32])))
}

fn found_digest(found: &Found) -> u32 {
    let Found { sources, mask_pixels, unlabelled, significance, photon, .. } = *found;
    words([sources, mask_pixels, unlabelled, significance.to_bits(), photon.to_bits()].into_iter())
}
