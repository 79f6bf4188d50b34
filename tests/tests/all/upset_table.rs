//! What single flipped bits do, by the place where they happen: the table of core/doc/evidence.md.

use skyfront::planes::Room;
use skyfront_core::arithmetic::F32;
use skyfront_core::arithmetic::digest::Digest;
use skyfront_core::config::Config;
use skyfront_core::config::bytes::length;
use skyfront_core::packet::{Cursor, Packet, stars};
use skyfront_core::plane::sweep::ring_len;
use skyfront_core::run::frame::SliceFrame;
use skyfront_core::run::memory::flags_len;
use skyfront_core::run::outcome::Progress;
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::run::snapshot;
use skyfront_core::simulate::Kind;
use skyfront_core::sky::otsu::BINS;
use skyfront_core::sources::catalog::Source;
use skyfront_core::track::{BadPixel, Camera, Raster, Star, Window, track};
use skyfront_tests::command::workspace;
use skyfront_tests::runs::sky;
use std::convert::Infallible;
use std::ops::Range;

/// Flips at each place.
const FLIPS: u32 = 1000;

/// What became of a flip.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fate {
    /// An error, a flag or a checksum told it.
    Detected,
    /// The result is right.
    Harmless,
    /// The result is wrong, and nothing told it.
    Wrong,
}

/// A row of the table: flips at random at one place, always the same ones.
fn row(place: &str, mut flip: impl FnMut(&mut dyn FnMut(usize) -> usize) -> Fate) -> String {
    let mut state = 0x5EED_u64;
    let mut draw = |limit: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        ((state >> 11) % limit as u64) as usize
    };
    let fates: Vec<Fate> = (0..FLIPS).map(|_| flip(&mut draw)).collect();
    let count = |wanted: Fate| fates.iter().filter(|&&fate| fate == wanted).count();
    let [detected, harmless, wrong] = [Fate::Detected, Fate::Harmless, Fate::Wrong].map(count);
    format!("| {place} | {FLIPS} | {detected} | {harmless} | {wrong} |")
}

/// Flips a bit of some bytes.
fn flipped(bytes: &mut [u8], draw: &mut dyn FnMut(usize) -> usize) {
    bytes[draw(bytes.len())] ^= 1 << draw(8);
}

/// The memory of a front between two polls.
mod front {
    use super::*;

    const WIDTH: usize = 24;
    const HEIGHT: usize = 18;
    const SOURCES: usize = 6;
    const ROWS: usize = 4;

    /// Labels and catalogue.
    type Result = (Vec<u32>, Vec<Source>);

    /// A run of one image with all snapshots between its polls.
    pub struct Calm {
        pixels: Vec<f32>,
        snapshots: Vec<Vec<u8>>,
        result: Result,
    }

    fn saved(segmenter: &mut Segmenter<'_, F32>) -> Vec<u8> {
        let mut bytes = Vec::new();
        let Ok(()) = segmenter.save::<Infallible>(|chunk| {
            bytes.extend_from_slice(chunk);
            Ok(())
        });
        bytes
    }

    fn result(segmenter: &Segmenter<'_, F32>) -> Result {
        let labels = segmenter.front().iter().map(|cell| cell.to_bits()).collect();
        (labels, segmenter.catalog().to_vec())
    }

    impl Calm {
        pub fn run() -> Calm {
            let pixels = sky(Kind::Bright, 7, WIDTH, HEIGHT);
            let mut room = Room::<F32>::new(&Config::PAPER_F160, WIDTH, HEIGHT, SOURCES);
            let run = Segmenter::<F32>::new(&Config::PAPER_F160, WIDTH, HEIGHT, room.memory());
            let (mut segmenter, mut snapshots) = (run.expect("a good configuration"), Vec::new());
            while let Progress::Working { .. } = segmenter.poll(ROWS, &mut SliceFrame(&pixels)).expect("a good image") {
                snapshots.push(saved(&mut segmenter));
            }
            let result = result(&segmenter);
            assert!(result.0.iter().any(|&label| label > 0) && snapshots.len() > 100, "a run with something in it");
            Calm { pixels, snapshots, result }
        }

        /// Names and bytes of a snapshot's parts, all but its header and its checksum.
        pub fn places(&self) -> Vec<(&'static str, Range<usize>)> {
            let state = snapshot::bytes(0, 0, 0, 1, 0) - 28 - 4 - 4 * (BINS + flags_len(0, 0));
            let lengths = [
                ("a front: state of the run", state),
                ("a front: counts of the histogram", 4 * BINS),
                ("a front: plane of the image", 4 * WIDTH * HEIGHT),
                ("a front: plane of the front", 4 * WIDTH * HEIGHT),
                ("a front: ring of rows", 4 * ring_len(WIDTH, 3)),
                ("a front: flags of tiles", 4 * flags_len(WIDTH, HEIGHT)),
                ("a front: catalogue", 100 * SOURCES),
            ];
            let mut from = 28;
            let places = lengths.map(|(name, length)| {
                from += length;
                (name, from - length..from)
            });
            assert_eq!(from + 4, self.snapshots[0].len(), "the parts are all of a snapshot");
            places.into()
        }

        /// A bit flips in a part of the memory between two polls, which no checksum guards.
        pub fn upset(&self, place: &Range<usize>, draw: &mut dyn FnMut(usize) -> usize) -> Fate {
            let mut snapshot = self.snapshots[draw(self.snapshots.len())].clone();
            flipped(&mut snapshot[place.clone()], draw);
            let (body, end) = snapshot.split_last_chunk_mut::<4>().expect("a checksum");
            let mut digest = Digest::default();
            digest.bytes(body);
            *end = digest.value().to_le_bytes();
            let mut room = Room::<F32>::new(&Config::PAPER_F160, WIDTH, HEIGHT, SOURCES);
            let run = Segmenter::<F32>::new(&Config::PAPER_F160, WIDTH, HEIGHT, room.memory());
            let (mut segmenter, mut rest) = (run.expect("a good configuration"), &snapshot[..]);
            let restored = segmenter.restore::<Infallible>(|chunk| {
                let (head, tail) = rest.split_at(chunk.len());
                chunk.copy_from_slice(head);
                rest = tail;
                Ok(())
            });
            if restored.is_err() {
                return Fate::Detected;
            }
            loop {
                match segmenter.poll(ROWS, &mut SliceFrame(&self.pixels)) {
                    Err(_) => return Fate::Detected,
                    Ok(Progress::Working { .. }) => {}
                    Ok(Progress::Done(_)) if result(&segmenter) == self.result => return Fate::Harmless,
                    Ok(Progress::Done(_)) => return Fate::Wrong,
                }
            }
        }
    }
}

/// What a call of `track` reads.
mod windows {
    use super::*;

    const SIDE: usize = 40;
    /// The light of a star on 5 x 5 pixels, in hundredths of its peak.
    const LIGHT: [[u16; 5]; 5] =
        [[2, 5, 7, 5, 2], [8, 24, 33, 24, 8], [15, 51, 84, 56, 19], [13, 45, 76, 51, 17], [5, 19, 31, 21, 7]];

    /// A frame with one star, and what is known of it.
    #[derive(Clone)]
    pub struct Scene {
        pixels: Vec<u16>,
        camera: Camera,
        window: Window,
        bad: BadPixel,
    }

    impl Scene {
        pub fn new() -> Scene {
            let mut state = 7u32;
            let mut noise = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 28) as u16
            };
            let mut pixels: Vec<u16> = (0..SIDE * SIDE).map(|_| 92 + noise()).collect();
            for (y, row) in LIGHT.iter().enumerate() {
                for (x, light) in row.iter().enumerate() {
                    pixels[(18 + y) * SIDE + 17 + x] += 12 * light;
                }
            }
            let camera = Camera { black: 64.0, gain: 2.0, read_noise: 7.0, saturation: 4095.0, psf_sigma: 1.1 };
            let window = Window { x: 19.0, y: 20.0, width: 15, height: 15 };
            Scene { pixels, camera, window, bad: BadPixel { x: 3, y: 4 } }
        }

        fn star(&self) -> Option<Star> {
            let raster = Raster::new(&self.pixels, SIDE, SIDE, SIDE).expect("a frame");
            let mut out = [Star::EMPTY];
            track::<F32, u16>(&raster, &[self.window], &self.camera, &[self.bad], &mut out).ok().map(|()| out[0])
        }

        /// A bit flips, and the star is no more than half of its error off, its errors and its flux a tenth.
        pub fn upset(&self, flip: impl FnOnce(&mut Scene)) -> Fate {
            let calm = self.star().expect("a star");
            assert_eq!(calm.flags, 0, "{calm:?}");
            let mut scene = self.clone();
            flip(&mut scene);
            let Some(star) = scene.star().filter(|star| star.flags == 0) else { return Fate::Detected };
            let off = (star.x - calm.x).hypot(star.y - calm.y) / calm.errx2.sqrt();
            let alike = |one: f32, other: f32| (one / other - 1.0).abs() < 0.1;
            let right = off < 0.5 && alike(star.flux, calm.flux) && alike(star.errx2.sqrt(), calm.errx2.sqrt());
            if right { Fate::Harmless } else { Fate::Wrong }
        }

        pub fn flip_pixel(&mut self, draw: &mut dyn FnMut(usize) -> usize) {
            // Of the window, which is all of the frame that is read.
            let (x, y) = (12 + draw(15), 13 + draw(15));
            self.pixels[y * SIDE + x] ^= 1 << draw(16);
        }

        pub fn flip_camera(&mut self, draw: &mut dyn FnMut(usize) -> usize) {
            let Camera { black, gain, read_noise, saturation, psf_sigma } = &mut self.camera;
            let field = [black, gain, read_noise, saturation, psf_sigma].into_iter().nth(draw(5)).expect("a field");
            *field = f32::from_bits(field.to_bits() ^ 1 << draw(32));
        }

        pub fn flip_window(&mut self, draw: &mut dyn FnMut(usize) -> usize) {
            let Window { x, y, width, height } = &mut self.window;
            match draw(96) {
                bit @ 0..32 => *x = f32::from_bits(x.to_bits() ^ 1 << bit),
                bit @ 32..64 => *y = f32::from_bits(y.to_bits() ^ 1 << (bit - 32)),
                bit @ 64..80 => *width ^= 1 << (bit - 64),
                bit => *height ^= 1 << (bit - 80),
            }
        }

        pub fn flip_bad(&mut self, draw: &mut dyn FnMut(usize) -> usize) {
            match draw(32) {
                bit @ 0..16 => self.bad.x ^= 1 << bit,
                bit => self.bad.y ^= 1 << (bit - 16),
            }
        }
    }
}

/// Flips in bytes that a checksum guards.
fn guarded(bytes: &[u8], is_taken: impl Fn(&[u8]) -> bool, draw: &mut dyn FnMut(usize) -> usize) -> Fate {
    let mut bytes = bytes.to_vec();
    flipped(&mut bytes, draw);
    if is_taken(&bytes) { Fate::Wrong } else { Fate::Detected }
}

fn table() -> Vec<String> {
    let scene = windows::Scene::new();
    let mut rows = vec![
        row("a window: pixels", |draw| scene.upset(|scene| scene.flip_pixel(draw))),
        row("a window: camera", |draw| scene.upset(|scene| scene.flip_camera(draw))),
        row("a window: place and size", |draw| scene.upset(|scene| scene.flip_window(draw))),
        row("a window: a bad pixel", |draw| scene.upset(|scene| scene.flip_bad(draw))),
    ];
    let calm = front::Calm::run();
    rows.extend(calm.places().iter().map(|(name, place)| row(name, |draw| calm.upset(place, draw))));
    let mut parameters = vec![0; length()];
    Config::PAPER_F160.to_bytes(&mut parameters).expect("room for a table");
    rows.push(row("a parameter table", |draw| guarded(&parameters, |bytes| Config::from_bytes(bytes).is_ok(), draw)));
    let mut packet = vec![0; 256];
    let written = stars(&mut Cursor::new(1), &[Star::EMPTY; 7], &mut packet).expect("room for a packet");
    packet.truncate(written.expect("a packet"));
    rows.push(row("a packet", |draw| guarded(&packet, |bytes| Packet::read(bytes).is_ok(), draw)));
    rows
}

#[test]
fn the_page_tells_what_flipped_bits_do() {
    let table = table().join("\n");
    println!("{table}");
    let page = std::fs::read_to_string(workspace().join("core/doc/evidence.md")).expect("a page");
    assert!(page.contains(&table), "the table of core/doc/evidence.md should be:\n{table}");
}
