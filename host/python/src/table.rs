//! What can be set and what can be had: the tables from which signatures, docstrings and stubs come.

use crate::error::python;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use skyfront::catalogue::{self, Setting};
use skyfront::choices::{ArithmeticOption, Preset};
use skyfront::input::{Combine, WeightType};
use skyfront::measure::Neighbours;
use skyfront::settings::{self, words};
use skyfront_core::config::{Config, Need, Numbers, PARAMETERS, Parameter};
use skyfront_core::sources::flags::FLAGS;

/// Every setting of a run, in the order of the steps.
#[pyfunction]
pub fn parameters(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let list = PyList::empty(py);
    for parameter in PARAMETERS {
        let dict = PyDict::new(py);
        dict.set_item("name", python(parameter.name))?;
        dict.set_item("option", parameter.name)?;
        dict.set_item("step", step(parameter))?;
        dict.set_item("unit", parameter.unit)?;
        dict.set_item("help", parameter.help)?;
        dict.set_item("forms", parameter.forms().to_string())?;
        dict.set_item("words", parameter.words.iter().map(|word| (word.name, word.help)).collect::<Vec<_>>())?;
        dict.set_item("numbers", numbers(parameter))?;
        dict.set_item("default", parameter.default().map(|value| value.to_string()))?;
        dict.set_item("range", range(parameter))?;
        let choice = |need: &Need| format!("{} {}", python(need.name), words(need.words));
        let needs = parameter.needs.iter().map(|need| need.choices().map(choice).collect::<Vec<_>>().join(", or "));
        dict.set_item("needs", needs.collect::<Vec<_>>())?;
        list.append(dict)?;
    }
    Ok(list)
}

/// The heading of a parameter's step, without the option that it may name.
fn step(parameter: &Parameter) -> &'static str {
    let title = parameter.step.title();
    title.split(" (--").next().unwrap_or(title)
}

/// How many numbers a value may have: of words, or alone.
fn numbers(parameter: &Parameter) -> &'static str {
    match parameter.bare {
        Numbers::None => "",
        Numbers::Whole(_) => "int",
        Numbers::One(_) => "float",
        Numbers::Two(..) => "pair",
    }
}

fn range(parameter: &Parameter) -> String {
    let config = parameter.at_work(&Config::NOISE_AWARE);
    let [first, second] = parameter.ranges(&config).map(|range| range.to_string());
    if first.is_empty() || first == second { first } else { format!("{first}; {second}") }
}

/// The words of what is no setting of the core: by the name of the keyword, the default first.
#[pyfunction]
pub fn choices(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("preset", Preset::ALL.map(Preset::name))?;
    dict.set_item("arithmetic", ArithmeticOption::ALL.map(ArithmeticOption::name))?;
    dict.set_item("weight_type", WeightType::ALL.map(WeightType::name))?;
    dict.set_item("combine", Combine::ALL.map(Combine::name))?;
    dict.set_item("neighbours", Neighbours::ALL.map(Neighbours::name))?;
    Ok(dict)
}

/// Name, unit and description of every column that a catalogue can have, and whether it is usual.
#[pyfunction]
pub fn columns() -> Vec<(String, String, String, bool)> {
    let setting = Setting { apertures: vec![3.0], zero_point: Some(0.0), ..Setting::default() };
    let all = catalogue::columns(&setting).into_iter();
    all.map(|column| (column.name.clone(), column.unit.clone(), column.description.clone(), column.is_usual()))
        .collect()
}

/// Bit, name and meaning of every flag.
#[pyfunction]
pub fn flags() -> Vec<(u32, &'static str, &'static str)> {
    FLAGS.iter().map(|flag| (flag.bit, flag.name, flag.meaning)).collect()
}

/// What a name of SExtractor, SEP or photutils is called here, where it is known.
#[pyfunction]
pub fn elsewhere(name: &str) -> Option<String> {
    settings::ours(name).map(python)
}
