//! A run on signal-to-noise written out between two polls, and taken up again, perhaps elsewhere.
//!
//! All words are little-endian, 32 bits. In order: the header (magic, version, code of the arithmetic, columns, rows,
//! regions that there is room for, which maps and how many bad pixels are known, CRC-32 of the configuration), the state,
//! the levels (signal, fine, smooth), the rows, labels, parents and order, the mask, the mesh, the regions in use, and the
//! CRC-32 of everything before. Nothing is buffered beyond 64 bytes. The frame and the maps are not in it: whoever takes
//! the run up lays them before it again.

use super::Extractor;
use super::state::State;
use crate::arithmetic::Level;
use crate::arithmetic::codec::Codec;
use crate::plane::mask::mask_words;
use crate::plane::raster::Sample;
use crate::plane::smooth::ROOM_ROWS;
use crate::run::plan::Plan;
use crate::run::snapshot::{SnapshotError, read_back, write_out};
use crate::run::workspace::Workspace;
use crate::sky::mesh_cells;

/// "SkyE", little-endian.
const MAGIC: u32 = 0x4579_6B53;
/// Changes with the format.
const VERSION: u32 = 1;
/// Words of the header, of the state and of a region.
const HEADER_WORDS: usize = 8;
const STATE_WORDS: usize = 352;
const REGION_WORDS: usize = 12;

/// The most bytes of a snapshot of a run over a frame with mesh cells `cell` pixels wide, with so many `regions`.
pub const fn bytes(width: usize, height: usize, cell: usize, regions: usize) -> usize {
    let pixels = width * height;
    let planes = 6 * pixels + mask_words(pixels) + ROOM_ROWS * width + 2 * mesh_cells(width, height, cell);
    4 * (HEADER_WORDS + STATE_WORDS + planes + REGION_WORDS * regions + 1)
}

impl<L: Level, P: Sample> Extractor<'_, '_, L, P> {
    fn header(&self) -> [(u32, &'static str); HEADER_WORDS] {
        let (grid, known) = (self.grid, self.view.known);
        let maps = [known.background.is_some(), known.noise.is_some(), known.relative];
        let maps = maps.iter().fold(known.bad.len() as u32, |bits, &is_known| bits << 1 | u32::from(is_known));
        [
            (MAGIC, "kind of contents"),
            (VERSION, "format version"),
            (L::CODE, "arithmetic"),
            (grid.width.get() as u32, "width"),
            (grid.height as u32, "height"),
            (self.work.regions.len() as u32, "number of regions"),
            (maps, "set of maps and bad pixels"),
            (self.config.digest(), "configuration"),
        ]
    }

    /// Everything after the header, out or in.
    fn body<C: Codec>(&mut self, codec: &mut C) -> Result<(), C::Error> {
        let (grid, cell) = (self.grid, self.config.sky.cell());
        let Workspace { signal, fine, smooth, labels, parents, order, masked, rows, mesh, regions } = &mut self.work;
        self.state.code(codec)?;
        for levels in [signal, fine, smooth] {
            codec.cells(levels)?;
        }
        codec.cells(rows.get_mut(..ROOM_ROWS.saturating_mul(grid.width.get())).unwrap_or(&mut []))?;
        for words in [labels, parents, order] {
            codec.words(words)?;
        }
        codec.words(masked.get_mut(..mask_words(grid.cells())).unwrap_or(&mut []))?;
        for sky in mesh.iter_mut().take(mesh_cells(grid.width.get(), grid.height, cell)) {
            codec.real(&mut sky.level)?;
            codec.real(&mut sky.noise)?;
        }
        regions.iter_mut().take(self.state.regions()).try_for_each(|region| region.code(codec))
    }

    /// Writes the run out as a snapshot, in chunks of at most 64 bytes. The front that [`Extractor::outline`] takes is
    /// in it, one that is still moved by others is not.
    ///
    /// # Errors
    /// The first error of `write`; the run goes on as if nothing had been asked.
    pub fn save<E>(&mut self, write: impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        write_out(write, &self.header(), |writer| self.body(writer))
    }

    /// Takes up the run of a snapshot in the place of this one, which must have the same configuration, size, maps and
    /// table of regions, and the same frame before it. `read` fills the whole slice or fails.
    ///
    /// # Errors
    /// [`SnapshotError`]; this run is then lost, and every poll reports [`Error::NotRestored`](crate::error::Error),
    /// until a snapshot is taken up.
    pub fn restore<E>(&mut self, read: impl FnMut(&mut [u8]) -> Result<(), E>) -> Result<(), SnapshotError<E>> {
        let result = read_back(read, &self.header(), |reader| self.body(reader)).and_then(|()| {
            let steps = Plan::of(&self.config).steps().count();
            let is_sound = self.state.is_sound(steps, self.work.regions.len(), self.bound);
            if is_sound { Ok(()) } else { Err(SnapshotError::Damaged) }
        });
        self.take_up(result.is_ok());
        result
    }

    fn take_up(&mut self, is_restored: bool) {
        if !is_restored {
            self.state = State::NEW;
        }
        self.view.values = self.state.look.values;
        self.ended = if is_restored { None } else { Some(crate::error::Error::NotRestored) };
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{BAD, COUNT, HEIGHT, Left, Room, WIDTH, counts, filter, left, told};
    use super::super::{Error, Progress};
    use super::*;
    use crate::arithmetic::Fixed14;
    use crate::arithmetic::digest::Digest;
    use crate::config::{Config, Separate};
    use crate::sky::view::Known;

    extern crate std;
    use std::vec::Vec;

    #[derive(Debug, PartialEq)]
    struct Ended;

    fn saved<L: Level>(run: &mut Extractor<'_, '_, L>) -> Vec<u8> {
        let mut bytes = Vec::new();
        let saved: Result<(), Ended> = run.save(|chunk| {
            assert!(chunk.len() <= 64);
            bytes.extend_from_slice(chunk);
            Ok(())
        });
        saved.expect("memory does not fail");
        bytes
    }

    fn restored<L: Level>(run: &mut Extractor<'_, '_, L>, mut bytes: &[u8]) -> Result<(), SnapshotError<Ended>> {
        run.restore(|chunk| {
            let (head, rest) = bytes.split_at_checked(chunk.len()).ok_or(Ended)?;
            chunk.copy_from_slice(head);
            bytes = rest;
            Ok(())
        })
    }

    /// What a run leaves that is saved after every poll of so many rows, and taken up in memory full of something else.
    fn restless<L: Level>(config: &Config, pixels: &[f32], known: Known<'_>, rows: usize) -> Left {
        let mut bytes: Option<Vec<u8>> = None;
        for pattern in 1.. {
            let mut room = Room::<L>::full_of(pattern);
            let mut run = Extractor::new(config, pixels, WIDTH, known, room.work()).expect("room enough");
            if let Some(bytes) = bytes.take() {
                restored(&mut run, &bytes).expect("the snapshot that was just made");
            }
            match run.poll(rows).expect("a sky with noise") {
                Progress::Done(found) => return room.left(told(found), found.regions, pattern as usize),
                Progress::Filter => filter(config, &mut run, rows),
                _ => {}
            }
            bytes = Some(saved(&mut run));
        }
        unreachable!("a run ends")
    }

    fn resumed_runs_are_alike<L: Level>(config: &Config, pixels: &[f32], known: Known<'_>) {
        for rows in [1, 2, 11, HEIGHT] {
            let (found, expected) =
                (restless::<L>(config, pixels, known, rows), left::<L>(config, pixels, known, rows));
            assert_eq!(found.end, expected.end, "{}, polls of {rows} rows", L::NAME);
            assert!(found == expected, "{}, polls of {rows} rows", L::NAME);
        }
    }

    fn pixels() -> Vec<f32> {
        counts(4000.0, WIDTH).iter().map(|&count| f32::from(count)).collect()
    }

    #[test]
    fn resumed_runs_have_the_bits_of_undisturbed_ones() {
        let (pixels, default) = (pixels(), Config::NOISE_AWARE);
        resumed_runs_are_alike::<f32>(&default, &pixels, Known::default());
        resumed_runs_are_alike::<Fixed14>(&default, &pixels, Known::default());
        let filtered = Config { filter: crate::config::Filter::Median5, ..default };
        resumed_runs_are_alike::<f32>(&filtered, &pixels, Known::default());
        let components = Config { separate: Separate::Components, ..default };
        let noise: Vec<f32> = (0..COUNT).map(|at| 1.0 + (at % 7) as f32).collect();
        let known = Known { noise: Some(&noise), relative: true, bad: &BAD, ..Known::default() };
        resumed_runs_are_alike::<f32>(&components, &pixels, known);
        let cut: Vec<f32> = pixels.iter().map(|&pixel| if pixel < 401.0 { 401.0 } else { pixel }).collect();
        resumed_runs_are_alike::<f32>(&default, &cut, Known::default());
    }

    /// A snapshot after so many polls of three rows.
    fn after<L: Level>(polls: usize) -> (Vec<u8>, usize) {
        let (pixels, mut room) = (pixels(), Room::<L>::full_of(0));
        let mut run =
            Extractor::new(&Config::NOISE_AWARE, &pixels, WIDTH, Known::default(), room.work()).expect("room");
        for _ in 0..polls {
            let _ = run.poll(3);
        }
        let regions = run.state.regions();
        (saved(&mut run), regions)
    }

    /// What a fresh run says to a snapshot.
    fn offered<L: Level>(config: &Config, known: Known<'_>, bytes: &[u8]) -> SnapshotError<Ended> {
        let (pixels, mut room) = (pixels(), Room::<L>::full_of(5));
        let mut run = Extractor::new(config, &pixels, WIDTH, known, room.work()).expect("room enough");
        let error = restored(&mut run, bytes).expect_err("not this run's snapshot");
        assert_eq!([run.poll(1), run.poll(HEIGHT)], [Err(Error::NotRestored); 2]);
        let (bytes, _) = after::<L>(9);
        if (config, known.bad) == (&Config::NOISE_AWARE, &[]) {
            restored(&mut run, &bytes).expect("another snapshot is taken up");
            assert!(run.poll(1).is_ok());
        }
        error
    }

    #[test]
    fn the_length_is_the_one_stated() {
        for polls in [0, 100, 300, 100_000] {
            let cell = Config::NOISE_AWARE.sky.cell();
            let (found, regions) = after::<f32>(polls);
            assert_eq!(found.len(), bytes(WIDTH, HEIGHT, cell, regions), "{regions} regions");
            assert_eq!(after::<Fixed14>(polls).0.len(), found.len());
            assert_eq!(regions > 0, polls > 300);
        }
    }

    #[test]
    fn damaged_and_foreign_snapshots_are_refused() {
        let (default, known) = (Config::NOISE_AWARE, Known::default());
        let (bytes, _) = after::<f32>(250);
        for index in (0..bytes.len()).step_by(61) {
            let mut damaged = bytes.clone();
            damaged[index] ^= 1 << (index % 8);
            let error = offered::<f32>(&default, known, &damaged);
            // More regions than there are end early.
            let is_found = matches!(error, SnapshotError::Damaged | SnapshotError::Foreign { .. });
            assert!(is_found || error == SnapshotError::Read(Ended), "byte {index}: {error:?}");
        }
        for length in [0, 3, 500, bytes.len() - 1] {
            assert_eq!(offered::<f32>(&default, known, &bytes[..length]), SnapshotError::Read(Ended));
        }
        let foreign = |what| SnapshotError::Foreign { what };
        assert_eq!(offered::<Fixed14>(&default, known, &bytes), foreign("arithmetic"));
        assert_eq!(offered::<f32>(&Config { min_area: 9, ..default }, known, &bytes), foreign("configuration"));
        let known = Known { bad: &BAD, ..known };
        assert_eq!(offered::<f32>(&default, known, &bytes), foreign("set of maps and bad pixels"));
        assert_eq!(offered::<f32>(&default, Known::default(), &bytes[4..]), foreign("kind of contents"));
    }

    /// Numbers that are as good as drawn.
    struct Draw(u32);

    impl Draw {
        fn below(&mut self, end: usize) -> usize {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            ((u64::from(self.0) * end as u64) >> 32) as usize
        }
    }

    /// Flips bits of the state, or of the planes and tables, and makes the checksum right again.
    fn upset(snapshot: &mut [u8], draw: &mut Draw) -> usize {
        const STATE: usize = 4 * (HEADER_WORDS + STATE_WORDS);
        let body = snapshot.len() - 4;
        let (from, to, flips) = match draw.below(4) {
            0 => (4 * HEADER_WORDS, STATE, 1),
            1 => (body - 4 * REGION_WORDS * 4, body, 1),
            _ => (STATE, body, 1 + draw.below(48)),
        };
        for _ in 0..flips {
            snapshot[from + draw.below(to - from)] ^= 1 << draw.below(8);
        }
        let mut digest = Digest::default();
        digest.bytes(&snapshot[..body]);
        snapshot[body..].copy_from_slice(&digest.value().to_le_bytes());
        flips
    }

    fn upset_run<L: Level>(pixels: &[f32], most: usize, draw: &mut Draw) -> usize {
        let (mut room, mut flips, mut upsets) = (Room::<L>::full_of(0), 0, 1 + draw.below(6));
        let mut run =
            Extractor::new(&Config::NOISE_AWARE, pixels, WIDTH, Known::default(), room.work()).expect("room enough");
        let (mut polls, mut calm) = (0, draw.below(most));
        loop {
            match run.poll(4) {
                Ok(Progress::Done(_)) | Err(_) => return flips,
                Ok(_) => polls += 1,
            }
            assert!(polls <= 4 * most, "{}: it does not end", L::NAME);
            if upsets > 0 && polls >= calm {
                (upsets, polls, calm) = (upsets - 1, 0, draw.below(most));
                let mut bytes = saved(&mut run);
                flips += upset(&mut bytes, draw);
                if restored(&mut run, &bytes).is_err() {
                    return flips;
                }
            }
        }
    }

    #[test]
    fn flipped_bits_never_panic_hang_or_overrun() {
        let (pixels, mut draw, mut flips) = (pixels(), Draw(77), 0);
        let most = left::<f32>(&Config::NOISE_AWARE, &pixels, Known::default(), 4).polls;
        while flips < 20_000 {
            flips += upset_run::<f32>(&pixels, most, &mut draw) + upset_run::<Fixed14>(&pixels, most, &mut draw);
        }
    }
}
