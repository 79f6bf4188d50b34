//! The noise-aware segmentation, and the parts of it that hosts call.

use skyfront_core::arithmetic::Fixed14;
use skyfront_core::run::detect::{self, Found, Known, Workspace};
use skyfront_core::config::detection::Detection;
use skyfront_core::error::Error;
use skyfront_core::sky::{self, Mesh, Seen, Sky, Survey, Values};
use skyfront_core::plane::sort::Keys;

#[unsafe(export_name = "detect_f32")]
fn in_f32(pixels: &[f32], width: usize, known: &Known<'_>, setting: &Detection, work: &mut Workspace<'_, f32>) -> Result<Found, Error> {
    detect::detect(pixels, width, known, setting, work)
}

#[unsafe(export_name = "detect_q24")]
fn in_q24(pixels: &[f32], width: usize, known: &Known<'_>, setting: &Detection, work: &mut Workspace<'_, Fixed14>) -> Result<Found, Error> {
    detect::detect(pixels, width, known, setting, work)
}

#[unsafe(export_name = "sky")]
fn measure(pixels: &[f32], seen: &[Seen], size: (usize, usize), cells: &mut [Sky], mut keys: Keys<'_>, at: (usize, usize)) -> (Survey, Sky) {
    let values = Values::measure(pixels, size.0, |_| true, keys.again());
    let mut mesh = Mesh::blank(cells, size);
    let survey = mesh.measure(pixels, |at| seen.get(at).copied().unwrap_or(Seen::Sky), &values, keys);
    (survey, mesh.at(at.0, at.1))
}

#[unsafe(export_name = "detection_room")]
fn room(width: usize, height: usize) -> [usize; 4] {
    [detect::bytes(width, height), detect::regions(width, height), sky::mesh_cells(width, height), sky::cell_pixels(width, height)]
}
