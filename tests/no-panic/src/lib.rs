//! The public entries of the core, in every arithmetic, as exported functions of unknown arguments.
//!
//! The panic handler calls a function that does not exist. The optimiser drops the handler, and
//! with it the call, when it has proved that no panic can be reached; otherwise linking fails and
//! the linker names the functions that could panic.
#![no_std]

mod detection;
mod devices;
mod packets;
mod windows;

use skyfront_core::arithmetic::{Arithmetic, Cell, F32, Q11, Q24, Real};
use skyfront_core::run::budget;
use skyfront_core::sources::catalog::{Ellipse, Source, room_for};
use skyfront_core::config::Config;
use skyfront_core::arithmetic::digest;
use skyfront_core::error::Error;
use skyfront_core::front::bands::Bands;
use skyfront_core::run::frame::{BandFrame, Frame, SliceFrame};
use skyfront_core::run::memory::{self, Memory};
use skyfront_core::run::outcome::{Outcome, Progress};
use skyfront_core::run::plan::Plan;
use skyfront_core::front::scheme::{Evolve, Step};
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::simulate::{Conditions, Kind, Sky};
use skyfront_core::run::snapshot::{self, SnapshotError};
use skyfront_core::run::stage::Stage;
use skyfront_core::front::stop::{Change, StopRule};
use skyfront_core::plane::sweep::{Band, Halo};
use skyfront_core::plane::tiles::Tiles;

unsafe extern "C" {
    safe fn the_core_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    the_core_can_panic()
}

/// What unwinding would ask for; the library of the compiler mentions it.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

/// A medium, as a frame source, a sink and a source of snapshots.
pub trait Medium: Frame<Error = u8> {
    /// Takes a chunk.
    fn write(&mut self, chunk: &[u8]) -> Result<(), u8>;
    /// Fills a chunk.
    fn read(&mut self, chunk: &mut [u8]) -> Result<(), u8>;
}

/// A frame source behind a pointer.
struct Through<'a>(&'a mut dyn Medium);

impl Frame for Through<'_> {
    type Error = u8;

    fn row(&mut self, y: usize, out: &mut [f32]) -> Result<(), u8> {
        self.0.row(y, out)
    }
}

/// The functions of one arithmetic.
macro_rules! arithmetic {
    ($name:ident, $arithmetic:ty, $new:literal, $poll:literal, $save:literal, $restore:literal, $evolve:literal, $look:literal, $one:literal) => {
        mod $name {
            use super::*;

            type A = $arithmetic;

            #[unsafe(export_name = $new)]
            fn new<'m>(config: &Config, width: usize, height: usize, memory: Memory<'m, A>) -> Result<Segmenter<'m, A>, Error> {
                Segmenter::new(config, width, height, memory)
            }

            #[unsafe(export_name = $poll)]
            fn poll(segmenter: &mut Segmenter<'_, A>, rows: usize, medium: &mut dyn Medium) -> Result<Progress, Error<u8>> {
                segmenter.poll(rows, &mut Through(medium))
            }

            #[unsafe(export_name = $save)]
            fn save(segmenter: &mut Segmenter<'_, A>, medium: &mut dyn Medium) -> Result<(), u8> {
                segmenter.save(|chunk| medium.write(chunk))
            }

            #[unsafe(export_name = $restore)]
            fn restore(segmenter: &mut Segmenter<'_, A>, medium: &mut dyn Medium) -> Result<(), SnapshotError<u8>> {
                segmenter.restore(|chunk| medium.read(chunk))
            }

            /// The front moved by the caller's own means.
            #[unsafe(export_name = $evolve)]
            fn evolve(segmenter: &mut Segmenter<'_, A>, ring: &mut [<A as Arithmetic>::Cell], flags: &mut [u8]) -> Result<Progress, Error> {
                let Some(evolution) = segmenter.evolution() else { return segmenter.finish_evolution(0, Change::none(&StopRule::<A>::new(&Config::PAPER_F160, 1.0))) };
                let height = evolution.front.len() / evolution.width.max(1);
                let mut tiles = Tiles::new(flags, evolution.width, evolution.tile_rows);
                let mut band = Band { plane: evolution.front, aux: evolution.speed, ring, width: evolution.width, halo: Halo::NONE };
                let mut step = Step { settle: evolution.settle, change: Change::none(&evolution.rule), means: evolution.regions.means };
                tiles.wake();
                evolution.scheme.advance(&mut band, &mut tiles, 0..height, &mut step);
                tiles.turn(&[], &[]);
                let (change, runs) = (step.change, tiles.next_run(0, 0).map_or(0, |run| run.end));
                segmenter.finish_evolution(runs as u32, change)
            }

            #[unsafe(export_name = $look)]
            fn look(segmenter: &Segmenter<'_, A>, memory: &Memory<'_, A>) -> (u32, usize, Stage, (u64, u64), f32, usize) {
                let digest = digest::of_cells(segmenter.image()) ^ digest::of_cells(segmenter.front());
                let first = segmenter.image().first().map_or(0.0, |&cell| <A as Arithmetic>::pixel(cell).to_f32());
                let labels = segmenter.front().iter().map(|cell| cell.label() as usize).fold(0, usize::max);
                let sources = segmenter.catalog().len();
                (digest, sources.max(labels), segmenter.stage(), segmenter.work(), segmenter.unit() + first, memory.bytes())
            }

            #[unsafe(export_name = $one)]
            fn one_poll(config: &Config, size: (usize, usize), memory: Memory<'_, A>, pixels: &[f32]) -> Option<Outcome> {
                let mut segmenter = Segmenter::<A>::new(config, size.0, size.1, memory).ok()?;
                match segmenter.poll(usize::MAX, &mut SliceFrame(pixels)) {
                    Ok(Progress::Done(outcome)) => Some(outcome),
                    _ => None,
                }
            }
        }
    };
}

arithmetic!(f32_plain, F32, "f32_new", "f32_poll", "f32_save", "f32_restore", "f32_evolve", "f32_look", "f32_one");
arithmetic!(q24, Q24, "q24_new", "q24_poll", "q24_save", "q24_restore", "q24_evolve", "q24_look", "q24_one");
arithmetic!(q11, Q11, "q11_new", "q11_poll", "q11_save", "q11_restore", "q11_evolve", "q11_look", "q11_one");

#[unsafe(export_name = "plan")]
fn plan(config: &Config, width: usize, height: usize, cell: usize, wide: bool, sources: usize) -> (u64, usize, usize, usize) {
    let window = memory::window(wide);
    let bytes = memory::bytes(width, height, cell, wide, sources);
    let room = memory::catalogue_room(width, height, cell, wide);
    (budget::total_rows(config, height), bytes, room, snapshot::bytes(width, height, cell, window, sources))
}

#[unsafe(export_name = "of_bands")]
fn of_bands<'m>(
    config: &Config,
    size: (usize, usize),
    memory: Memory<'m, F32>,
    bands: Bands<'m, F32>,
) -> Result<Segmenter<'m, F32>, Error> {
    Segmenter::of_bands(config, size.0, size.1, memory, bands)
}

#[unsafe(export_name = "band_row")]
fn band_row(bands: &[&[f32]], y: usize, row: &mut [f32]) {
    let Ok(()) = BandFrame(bands).row(y, row);
}

#[unsafe(export_name = "band_plan")]
fn band_plan(config: &Config, bands: usize, width: usize, height: usize, cell: usize) -> (u64, usize, usize) {
    let bytes = memory::band_bytes(width, height, cell, bands);
    (Plan::of_bands(config, bands).total_rows(height), bytes, snapshot::band_bytes(width, height, cell, bands))
}

#[unsafe(export_name = "validate")]
fn validate(config: &Config) -> Result<(), Error> {
    config.validate::<F32>()?;
    config.validate::<Q24>()?;
    config.validate::<Q11>()
}

#[unsafe(export_name = "measure")]
fn measure(source: &Source) -> (f32, f32, (f32, f32), (f32, f32, f32), Ellipse) {
    (source.sum(), source.mean(), source.centroid(), source.second_moments(), source.ellipse())
}

#[unsafe(export_name = "room")]
fn room() -> usize {
    room_for::<16>().len()
}

#[unsafe(export_name = "simulate")]
fn simulate(kind: Kind, conditions: Conditions, seed: u32, size: (usize, usize), y: usize, row: &mut [f32]) -> u32 {
    let Ok(mut sky) = Sky::new(kind, seed, size.0, size.1).under(conditions) else { return 0 };
    let Ok(()) = sky.row(y, row);
    sky.objects()
}
