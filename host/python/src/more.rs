//! What is asked beside runs: scores, simulated skies, outlines, pictures.

use crate::array::{plane, rows, size};
use crate::error::{Failure, option};
use crate::job::Array;
use crate::watch::watched;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList};
use skyfront::outline::rings;
use skyfront::picture::overlay;
use skyfront::settings::Refused;
use skyfront::{score as measures, truth};
use skyfront_core::config::Connectivity;
use skyfront_core::simulate::{Conditions, Kind, Optics};
use skyfront_core::sources::catalog::Source;

/// The measures of a label map against the truth, as JSON.
#[pyfunction]
pub fn score(
    py: Python<'_>,
    truth: PyReadonlyArray1<'_, i64>,
    map: PyReadonlyArray1<'_, i64>,
    image: Array<'_>,
) -> PyResult<String> {
    let (truth, map, image) = (truth.as_slice()?.to_vec(), map.as_slice()?.to_vec(), plane(&image.0, image.1)?);
    watched(py, move |_| Ok(measures::score(&truth, &map, &image.values).json().to_string()))
}

/// An image and the labels of its objects.
type Sky<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<u32>>);

/// What a telescope and a camera make of a sky, as Python says it.
#[derive(FromPyObject)]
pub struct Seen {
    optics: String,
    lopsided: bool,
    gradient: f32,
    full_well: Option<f32>,
    step: Option<f32>,
}

impl Seen {
    fn conditions(&self, py: Python<'_>) -> PyResult<Conditions> {
        let optics = match self.optics.as_str() {
            "round" => Optics::Round,
            "coma" => Optics::Coma,
            "trail" => Optics::Trail,
            "ring" => Optics::Ring,
            _ => return Err(option(py, "optics", &format!("{:?} is none of round, coma, trail, ring", self.optics))),
        };
        Ok(Conditions {
            optics,
            lopsided: self.lopsided,
            gradient: self.gradient,
            full_well: self.full_well.unwrap_or(Conditions::PERFECT.full_well),
            step: self.step.unwrap_or(Conditions::PERFECT.step),
        })
    }
}

/// A simulated sky and its truth.
#[pyfunction]
pub fn simulate<'py>(py: Python<'py>, kind: &str, seed: u32, shape: (usize, usize), seen: Seen) -> PyResult<Sky<'py>> {
    let ((height, width), conditions) = (shape, seen.conditions(py)?);
    let kind = match kind {
        "bright" => Kind::Bright,
        "noisy" => Kind::Noisy,
        "stars" => Kind::Stars,
        _ => return Err(option(py, "kind", &format!("{kind:?} is none of bright, noisy, stars"))),
    };
    const SIDES: std::ops::RangeInclusive<usize> = 8..=8192;
    if !SIDES.contains(&width) || !SIDES.contains(&height) {
        return Err(option(py, "shape", &format!("{shape:?} must be 8 to 8192 along both axes")));
    }
    let (image, labels) = watched(py, move |_| {
        let sky = skyfront_core::simulate::Sky::new(kind, seed, width, height).under(conditions);
        let sky = sky.map_err(|error| Failure::from(Refused::Value(error)))?;
        Ok((truth::observed(sky, width, height).pixels, truth::labels(&sky, width, height)))
    })?;
    Ok((rows(py, image, width)?, rows(py, labels, width)?))
}

/// Label, whether it bounds a hole, and corners (x, y) of every outline; the first pixel's centre is (0, 0).
#[pyfunction]
pub fn outlines<'py>(
    py: Python<'py>,
    labels: PyReadonlyArray2<'py, u32>,
    front: PyReadonlyArray2<'py, f32>,
    neighbours: usize,
) -> PyResult<Bound<'py, PyList>> {
    let (width, height) = size(&labels);
    let connectivity = if neighbours == 4 { Connectivity::Four } else { Connectivity::Eight };
    let (labels, front) = (labels.as_slice()?.to_vec(), front.as_slice()?.to_vec());
    let rings = watched(py, move |_| Ok(rings(&labels, &front, width, height, connectivity)))?;
    let list = PyList::empty(py);
    for ring in rings {
        let points: Vec<f64> = ring.points.iter().flat_map(|&(x, y)| [x, y]).collect();
        let corners = Array2::from_shape_vec((ring.points.len(), 2), points)
            .map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        list.append((ring.label, ring.hole, corners.into_pyarray(py)))?;
    }
    Ok(list)
}

/// The image with the outlines of its sources, as a PNG.
#[pyfunction]
pub fn picture<'py>(
    py: Python<'py>,
    pixels: Array<'py>,
    labels: PyReadonlyArray2<'py, u32>,
) -> PyResult<Bound<'py, PyBytes>> {
    let (width, height) = size(&labels);
    let (pixels, labels) = (plane(&pixels.0, pixels.1)?, labels.as_slice()?.to_vec());
    let png = watched(py, move |_| {
        let canvas = overlay(&pixels.values, &labels, width, height, &boxes(&labels, width));
        let mut png = Vec::new();
        canvas.write_png(&mut png).map_err(|error| Failure::Internal(error.to_string()))?;
        Ok(png)
    })?;
    Ok(PyBytes::new(py, &png))
}

/// The sources of a label map with their bounding boxes.
fn boxes(labels: &[u32], width: usize) -> Vec<Source> {
    let most = labels.iter().copied().max().unwrap_or(0);
    let mut sources: Vec<Source> = (1..=most).map(Source::empty).collect();
    for (at, &label) in labels.iter().enumerate() {
        if let Some(source) = (label as usize).checked_sub(1).and_then(|index| sources.get_mut(index)) {
            source.add((at % width) as u32, (at / width) as u32, 1.0, 0.0);
        }
    }
    sources
}
