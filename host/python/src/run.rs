//! `segment` and `measure`: a run, and its result as Python objects.

use crate::array::{Plane, plane, rows};
use crate::error::Failure;
use crate::job::{Array, Job, Task};
use crate::watch::{Wanted, watched};
use numpy::{IntoPyArray, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};
use serde_json::{Value, json};
use skyfront::background::SkyMaps;
use skyfront::catalogue::{self, Catalogue, Request};
use skyfront::given;
use skyfront::input::Input;
use skyfront::mosaic::{self, Asking, Seen, is_beyond};
use skyfront::outputs::limits;
use skyfront::pipeline::{Drive, Segmentation, StagePlanes};
use skyfront::planes::can_be_had;
use skyfront::summary::{label_digest, summary};
use skyfront_core::config::Connectivity;
use skyfront_core::error::Error;
use skyfront_core::plane::part::{Part, Whole};
use skyfront_core::run::outcome::Progress;
use std::mem::take;
use std::sync::Arc;
use std::time::Instant;

/// A column of the catalogue.
struct Column {
    name: String,
    unit: String,
    description: String,
    cells: Cells,
}

enum Cells {
    Integers(Vec<i64>),
    Reals(Vec<f64>),
}

/// A finished run.
struct Done {
    run: Segmentation,
    input: Input,
    request: Request,
    /// Where it lies in a mosaic.
    part: Option<Part>,
    summary: Value,
    warnings: Vec<String>,
    connectivity: Connectivity,
}

/// The sources of a run, which can still be measured: all of it but the planes that Python has.
#[pyclass(frozen)]
pub struct Unmeasured(Arc<Kept>);

struct Kept {
    run: Segmentation,
    input: Input,
    request: Request,
    part: Option<Part>,
    /// That of the labels, as the summary tells it.
    digest: Value,
}

/// What comes of a run.
enum Outcome {
    Done(Box<Done>),
    /// A part of a mosaic has asked: by the name of the question, what it contributes.
    Asked(Vec<(String, Vec<u8>)>),
}

/// Segments an image, or measures the sources of a label map, or segments a part of a mosaic as far as the answers go.
#[pyfunction]
pub fn segment<'py>(py: Python<'py>, job: Job<'py>) -> PyResult<Bound<'py, PyDict>> {
    let task = job.task()?.map_err(|failure| failure.exception(py))?;
    match watched(py, move |wanted| task.run(wanted))? {
        Outcome::Done(done) => done.into_dict(py),
        Outcome::Asked(asked) => {
            let dict = PyDict::new(py);
            let bytes = |own: &Vec<u8>| PyBytes::new(py, own);
            dict.set_item("asked", asked.iter().map(|(name, own)| (name, bytes(own))).collect::<Vec<_>>())?;
            Ok(dict)
        }
    }
}

/// The answer to a question of the parts of a mosaic, of what all of them contribute.
#[pyfunction]
pub fn answer<'py>(py: Python<'py>, name: &str, contributions: Vec<Vec<u8>>) -> Bound<'py, PyBytes> {
    PyBytes::new(py, &mosaic::answer(name, &contributions))
}

impl Task {
    fn run(self, wanted: &Wanted) -> Result<Outcome, Failure> {
        let Task { config, arithmetic, input, request, stages, part } = self;
        let asking = part.as_ref().map(|(part, answers)| Asking::new(part.clone(), answers));
        let mut watch = |_: &Progress| wanted.or_end();
        let bands: Vec<&[f32]> = input.with.iter().map(Vec::as_slice).collect();
        let mut drive = Drive {
            bands: &bands,
            background: input.detected.background.as_deref(),
            noise: input.detected.noise.as_deref(),
            relative: input.detected.relative,
            whole: asking.as_ref().map(|asking| asking as &dyn Whole),
            start: input.start.as_ref(),
            keep_stages: stages,
            threads: request.extras.threads,
            watch: Some(&mut watch),
            ..Drive::default()
        };
        let began = Instant::now();
        let run = match input.is_given() {
            true => Ok(given::segment(&input, arithmetic.name(), stages)),
            false => arithmetic.segment(&config, &input.detected.image, &mut drive),
        };
        let run = match (run, asking) {
            (Err(Error::Waiting), Some(asking)) => return Ok(Outcome::Asked(asking.contributions())),
            (run, _) => run?,
        };
        let took = began.elapsed();
        let part = part.map(|(part, _)| part);
        wanted.or_end();
        let parts: Vec<_> =
            run.seconds.iter().map(|(stage, time)| (format!("{stage:?}").to_lowercase(), *time)).collect();
        let mut summary = summary(&config, &input, &run, &parts);
        summary["engine_seconds"] = json!(took.as_secs_f64());
        let warnings = run.remarks.iter().cloned().chain(limits(&run.outcome)).collect();
        let connectivity = config.connectivity;
        Ok(Outcome::Done(Box::new(Done { run, input, request, part, summary, warnings, connectivity })))
    }
}

/// A column with the numbers that every format of the command line tells.
fn column(catalogue: &Catalogue, column: &skyfront::catalogue::Column) -> Column {
    let cells = match &column.value {
        catalogue::Value::Integer(value) => Cells::Integers(catalogue.rows.iter().map(value).collect()),
        catalogue::Value::Real(..) => {
            let real = |row| column.text(row).parse().unwrap_or(f64::NAN);
            Cells::Reals(catalogue.rows.iter().map(real).collect())
        }
    };
    let (name, unit, description) = (column.name.clone(), column.unit.clone(), column.description.clone());
    Column { name, unit, description, cells }
}

impl Done {
    /// All of it by name; planes take no copy.
    fn into_dict(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let Done { mut run, mut input, request, part, summary, warnings, connectivity } = self;
        let width = run.width;
        let dict = PyDict::new(py);
        if let Some(part) = &part {
            let seen = Seen::of(&run, part);
            let firsts: Vec<i64> = seen.firsts.iter().map(|first| first.map_or(-1, |first| first as i64)).collect();
            dict.set_item("firsts", firsts.into_pyarray(py))?;
            dict.set_item("clipped", seen.clipped.into_pyarray(py))?;
        }
        dict.set_item("labels", rows(py, take(&mut run.labels), width)?)?;
        dict.set_item("front", rows(py, take(&mut run.front), width)?)?;
        // What was given, or else what was measured.
        let (level, noise) = run.sky.take().map(|sky| (sky.level, sky.noise)).unzip();
        let sky = [input.detected.background.take().or(level), input.detected.noise.take().or(noise)];
        for (name, plane) in ["background", "noise"].into_iter().zip(sky) {
            dict.set_item(name, plane.map(|plane| rows(py, plane, width)).transpose()?)?;
        }
        let planes = PyDict::new(py);
        let StagePlanes { normalised, rescaled, filtered, edge } = run.stages.take().unwrap_or_default();
        let all = [("normalised", normalised), ("rescaled", rescaled), ("filtered", filtered), ("edge", edge)];
        for (name, plane) in all.into_iter().filter(|(_, plane)| !plane.is_empty()) {
            planes.set_item(name, rows(py, plane, width)?)?;
        }
        dict.set_item("stages", planes)?;
        dict.set_item("convergence", take(&mut run.convergence).into_pyarray(py))?;
        dict.set_item("summary", summary.to_string())?;
        dict.set_item("warnings", warnings)?;
        dict.set_item("connectivity", connectivity.neighbours())?;
        let digest = summary["labels_crc32"].clone();
        dict.set_item("sources", Unmeasured(Arc::new(Kept { run, input, request, part, digest })))?;
        Ok(dict)
    }
}

#[pymethods]
impl Unmeasured {
    /// Measures the sources on the planes that the run gave: columns, settings as JSON, and warnings.
    fn measure<'py>(
        &self,
        py: Python<'py>,
        labels: PyReadonlyArray2<'py, u32>,
        background: Option<Array<'py>>,
        noise: Option<Array<'py>>,
    ) -> PyResult<(Bound<'py, PyList>, String, Vec<String>)> {
        let labels = labels.as_slice()?.to_vec();
        let read = |array: Option<Array<'_>>| array.map(|(array, swapped)| plane(&array, swapped)).transpose();
        let (background, noise) = (read(background)?, read(noise)?);
        let kept = Arc::clone(&self.0);
        let (columns, settings, warnings) = watched(py, move |_| kept.measure(labels, background, noise))?;
        Ok((list(py, columns)?, settings, warnings))
    }
}

/// Columns, how they were measured, and what must be known about them.
type Told = (Vec<Column>, String, Vec<String>);

impl Kept {
    fn measure(&self, labels: Vec<u32>, level: Option<Plane>, noise: Option<Plane>) -> Result<Told, Failure> {
        if self.digest != label_digest(&labels) {
            let reason = "they were changed before the catalogue was asked for; measure(image, labels) takes any map";
            return Err(Failure::Option("labels", reason.to_owned()));
        }
        let run = &self.run;
        // The values of a source and the text of its row, at most.
        let need = run.sources.len() as u64 * 4096;
        if !can_be_had(need) {
            return Err(Failure::Memory(format!("{} sources need {need} bytes of memory", run.sources.len())));
        }
        let sky = level.zip(noise).map(|(level, noise)| SkyMaps { level: level.values, noise: noise.values });
        let run = Segmentation { labels, sky, ..run.clone() };
        let mut catalogue = Catalogue::of(&self.input, &run, &self.request);
        let origin = self.part.as_ref().map_or((0, 0), |part| part.origin);
        catalogue.rows.iter_mut().for_each(|row| row.shift(origin));
        let beyond = self.part.as_ref().map(|part| {
            let radii = self.request.extras.apertures.iter().copied();
            let reach = radii.fold(0.0, f64::max);
            catalogue.rows.iter().map(|row| i64::from(is_beyond(row, reach, part, (run.width, run.height)))).collect()
        });
        let mut columns: Vec<_> = catalogue.columns.iter().map(|column| self::column(&catalogue, column)).collect();
        columns.extend(beyond.map(|beyond| Column {
            name: "beyond_halo".to_owned(),
            unit: String::new(),
            description: "1 where the source, or an aperture around it, ends beyond the halo of its chunk".to_owned(),
            cells: Cells::Integers(beyond),
        }));
        Ok((columns, catalogue.settings().to_string(), catalogue.warnings().collect()))
    }
}

/// Columns as tuples of name, unit, description and array.
fn list(py: Python<'_>, columns: Vec<Column>) -> PyResult<Bound<'_, PyList>> {
    let list = PyList::empty(py);
    for Column { name, unit, description, cells } in columns {
        let array = match cells {
            Cells::Integers(values) => values.into_pyarray(py).into_any(),
            Cells::Reals(values) => values.into_pyarray(py).into_any(),
        };
        list.append((name, unit, description, array))?;
    }
    Ok(list)
}
