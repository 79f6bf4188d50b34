//! A run on signal-to-noise, and the parts of it that hosts call.

use skyfront_core::arithmetic::Fixed14;
use skyfront_core::config::Config;
use skyfront_core::run::extract::catalogue::Measuring;
use skyfront_core::image::normalize::Range;
use skyfront_core::run::extract::{Extractor, Found, Progress, extract};
use skyfront_core::run::workspace::{self, Workspace};
use skyfront_core::sky::view::Known;
use skyfront_core::error::Error;
use skyfront_core::sources::measure::Sums;
use skyfront_core::sky::{self, Mesh, Seen, Sky, Survey, Values};
use skyfront_core::plane::raster::Raster;
use skyfront_core::plane::sort::Keys;
use skyfront_core::run::snapshot::SnapshotError;
use core::sync::atomic::AtomicU16;

#[unsafe(export_name = "detect_f32")]
fn in_f32(pixels: &[f32], width: usize, known: Known<'_>, config: &Config, work: Workspace<'_, f32>) -> Result<Found, Error> {
    extract(config, pixels, width, known, work)
}

#[unsafe(export_name = "detect_q24")]
fn in_q24(pixels: &[f32], width: usize, known: Known<'_>, config: &Config, work: Workspace<'_, Fixed14>) -> Result<Found, Error> {
    extract(config, pixels, width, known, work)
}

#[unsafe(export_name = "sky")]
fn measure(pixels: &[f32], seen: &[Seen], size: (usize, usize), cell: usize, cells: &mut [Sky], mut keys: Keys<'_>, at: (usize, usize)) -> (Survey, Sky) {
    let values = Values::measure(pixels, size.0, |_| true, keys.again());
    let mut mesh = Mesh::blank(cells, size, cell);
    let survey = mesh.measure(pixels, |at| seen.get(at).copied().unwrap_or(Seen::Sky), &values, keys);
    (survey, mesh.at(at.0, at.1))
}

#[unsafe(export_name = "detection_room")]
fn room(width: usize, height: usize, cell: usize) -> [usize; 4] {
    [
        workspace::bytes(width, height, cell),
        workspace::regions(width, height),
        sky::mesh_cells(width, height, cell),
        sky::cell_pixels(width, height, cell),
    ]
}

#[unsafe(export_name = "extractor")]
fn with_a_front(run: &mut Extractor<'_, '_, f32>, inside: &[bool], rows: usize) -> Result<Progress, Error> {
    run.outline(|at| inside.get(at).copied().unwrap_or(false));
    let range = Range { low: -3.0, high: 30.0 };
    run.start_from(|at| range.pixel(f32::from(u8::from(inside.get(at).copied().unwrap_or(false)))));
    run.poll(rows)
}

#[unsafe(export_name = "extractor_of_counts")]
fn of_counts(config: &Config, frame: Raster<'_, AtomicU16>, known: Known<'_>, work: Workspace<'_, Fixed14>, rows: usize) -> Result<Found, Error> {
    let mut run = Extractor::over(config, frame, known, work)?;
    loop {
        if let Progress::Done(found) = run.poll(rows)? {
            return Ok(found);
        }
    }
}

#[unsafe(export_name = "extractor_measured")]
fn measured(run: &mut Extractor<'_, '_, Fixed14, AtomicU16>, rows: usize, sums: &mut [Sums]) -> Result<bool, Error> {
    let done = run.measure(&mut Measuring::default(), rows, sums)?;
    sums.iter_mut().for_each(|sums| sums.mark(sums.flags()));
    Ok(done && sums.first().is_none_or(|sums| sums.centroid().x < sums.flux(Some(2.0)).error + sums.levels().noise))
}

#[unsafe(export_name = "extractor_saved")]
fn saved(run: &mut Extractor<'_, '_, f32>, write: fn(&[u8]) -> Result<(), u8>) -> Result<(), u8> {
    run.save(write)
}

#[unsafe(export_name = "extractor_restored")]
fn restored(run: &mut Extractor<'_, '_, f32>, read: fn(&mut [u8]) -> Result<(), u8>) -> Result<(), SnapshotError<u8>> {
    run.restore(read)
}
