//! `segment` and `measure`: a run, and its result as Python objects.

use crate::array::rows;
use crate::error::Failure;
use crate::job::{Job, Task};
use crate::watch::{Wanted, watched};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use skyfront::catalogue::{Catalogue, Value};
use skyfront::given;
use skyfront::outputs::limits;
use skyfront::pipeline::{Drive, Segmentation};
use skyfront::planes::can_be_had;
use skyfront::summary::summary;
use skyfront_core::config::Connectivity;
use skyfront_core::outcome::Progress;

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
    /// Background and noise of every pixel: what was given, or else what was measured.
    sky: (Option<Vec<f32>>, Option<Vec<f32>>),
    columns: Vec<Column>,
    summary: String,
    warnings: Vec<String>,
    connectivity: Connectivity,
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
        let mut run = match input.is_given() {
            true => given::segment(&input, arithmetic.name(), stages),
            false => arithmetic.segment(&config, &input.detected.image, &mut drive)?,
        };
        wanted.or_end();
        // Values of a source and the text of its row, as the command line counts them.
        let need = run.sources.len() as u64 * 4096;
        if !can_be_had(need) {
            return Err(Failure::Memory(format!("{} sources need {need} bytes of memory", run.sources.len())));
        }
        let catalogue = Catalogue::of(&input, &run, &request);
        let columns = catalogue.columns.iter().map(|column| self::column(&catalogue, column)).collect();
        let parts: Vec<_> =
            run.seconds.iter().map(|(stage, time)| (format!("{stage:?}").to_lowercase(), *time)).collect();
        let mut summary = summary(&config, &input, &run, &parts);
        summary["measuring"] = catalogue.settings();
        let warnings: Vec<String> =
            run.remarks.iter().cloned().chain(catalogue.warnings()).chain(limits(&run.outcome)).collect();
        let (level, noise) = run.sky.take().map(|sky| (sky.level, sky.noise)).unzip();
        let sky = (input.detected.background.or(level), input.detected.noise.or(noise));
        let (summary, connectivity) = (summary.to_string(), config.connectivity);
        Ok(Done { run, sky, columns, summary, warnings, connectivity })
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
        let Done { run, sky, columns, summary, warnings, connectivity } = self;
        let width = run.width;
        let dict = PyDict::new(py);
        dict.set_item("labels", rows(py, run.labels, width)?)?;
        dict.set_item("front", rows(py, run.front, width)?)?;
        for (name, plane) in [("background", sky.0), ("noise", sky.1)] {
            dict.set_item(name, plane.map(|plane| rows(py, plane, width)).transpose()?)?;
        }
        if let Some(stages) = run.stages {
            let planes = PyDict::new(py);
            let all = [
                ("normalised", stages.normalised),
                ("rescaled", stages.rescaled),
                ("filtered", stages.filtered),
                ("edge", stages.edge),
            ];
            for (name, plane) in all.into_iter().filter(|(_, plane)| !plane.is_empty()) {
                planes.set_item(name, rows(py, plane, width)?)?;
            }
            dict.set_item("stages", planes)?;
        }
        dict.set_item("convergence", run.convergence.into_pyarray(py))?;
        dict.set_item("columns", list(py, columns)?)?;
        dict.set_item("summary", summary)?;
        dict.set_item("warnings", warnings)?;
        dict.set_item("connectivity", connectivity.neighbours())?;
        Ok(dict)
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
