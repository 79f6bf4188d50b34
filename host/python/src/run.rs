//! `segment` and `measure`: a run, and its result as Python objects.

use crate::array::{Plane, plane, rows};
use crate::error::Failure;
use crate::job::{Array, Job, Task};
use crate::watch::{Wanted, watched};
use numpy::{IntoPyArray, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use skyfront::background::SkyMaps;
use skyfront::catalogue::{Catalogue, Request, Value};
use skyfront::given;
use skyfront::input::Input;
use skyfront::outputs::limits;
use skyfront::pipeline::{Drive, Segmentation, StagePlanes};
use skyfront::planes::can_be_had;
use skyfront::summary::{label_digest, summary};
use skyfront_core::config::Connectivity;
use skyfront_core::run::outcome::Progress;
use std::mem::take;
use std::sync::Arc;

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
    summary: String,
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
    digest: u32,
}

/// Segments an image, or measures the sources of a label map.
#[pyfunction]
pub fn segment<'py>(py: Python<'py>, job: Job<'py>) -> PyResult<Bound<'py, PyDict>> {
    let task = job.task()?.map_err(|failure| failure.exception(py))?;
    let done = watched(py, move |wanted| task.run(wanted))?;
    done.into_dict(py)
}

impl Task {
    fn run(self, wanted: &Wanted) -> Result<Done, Failure> {
        let Task { config, arithmetic, input, request, stages } = self;
        let mut watch = |_: &Progress| wanted.or_end();
        let mut drive = Drive {
            background: input.detected.background.as_deref(),
            noise: input.detected.noise.as_deref(),
            relative: input.detected.relative,
            start: input.start.as_ref(),
            keep_stages: stages,
            threads: request.extras.threads,
            watch: Some(&mut watch),
            ..Drive::default()
        };
        let run = match input.is_given() {
            true => given::segment(&input, arithmetic.name(), stages),
            false => arithmetic.segment(&config, &input.detected.image, &mut drive)?,
        };
        wanted.or_end();
        let parts: Vec<_> =
            run.seconds.iter().map(|(stage, time)| (format!("{stage:?}").to_lowercase(), *time)).collect();
        let summary = summary(&config, &input, &run, &parts);
        let warnings = run.remarks.iter().cloned().chain(limits(&run.outcome)).collect();
        let connectivity = config.connectivity;
        Ok(Done { run, input, request, summary: summary.to_string(), warnings, connectivity })
    }
}

/// A column with the numbers that every format of the command line tells.
fn column(catalogue: &Catalogue, column: &skyfront::catalogue::Column) -> Column {
    let cells = match &column.value {
        Value::Integer(value) => Cells::Integers(catalogue.rows.iter().map(value).collect()),
        Value::Real(..) => {
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
        let Done { mut run, mut input, request, summary, warnings, connectivity } = self;
        let width = run.width;
        let dict = PyDict::new(py);
        let digest = label_digest(&run.labels);
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
        dict.set_item("summary", summary)?;
        dict.set_item("warnings", warnings)?;
        dict.set_item("connectivity", connectivity.neighbours())?;
        dict.set_item("sources", Unmeasured(Arc::new(Kept { run, input, request, digest })))?;
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
type Measured = (Vec<Column>, String, Vec<String>);

impl Kept {
    fn measure(&self, labels: Vec<u32>, level: Option<Plane>, noise: Option<Plane>) -> Result<Measured, Failure> {
        if label_digest(&labels) != self.digest {
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
        let catalogue = Catalogue::of(&self.input, &run, &self.request);
        let columns = catalogue.columns.iter().map(|column| self::column(&catalogue, column)).collect();
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
