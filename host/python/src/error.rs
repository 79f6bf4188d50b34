//! Errors of a call as exceptions with the name of the option.

use pyo3::create_exception;
use pyo3::exceptions::{PyMemoryError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use skyfront::settings::{Refused, Unused};
use skyfront_core::error::Error;

create_exception!(
    _engine,
    OptionError,
    PyValueError,
    "An option has a value that it cannot have; its name is `option`."
);

/// Why a call failed.
#[derive(Debug)]
pub enum Failure {
    /// An option, and what is wrong with it.
    Option(&'static str, String),
    /// What the core or the table of parameters refuses.
    Refused(Refused),
    /// The image itself.
    Image(String),
    /// Memory that cannot be had.
    Memory(String),
    /// A fault of this program.
    Internal(String),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Failure {
        match error {
            Error::Parameter { .. } | Error::Together { .. } | Error::Arithmetic { .. } => {
                Failure::Refused(Refused::Value(error))
            }
            error => Failure::Image(error.to_string()),
        }
    }
}

impl From<Refused> for Failure {
    fn from(refused: Refused) -> Failure {
        Failure::Refused(refused)
    }
}

impl Failure {
    /// The exception.
    pub fn exception(self, py: Python<'_>) -> PyErr {
        match self {
            Failure::Option(name, reason) => option(py, name, &reason),
            Failure::Refused(Refused::Value(Error::Parameter { name, value, bound, limit })) => {
                option(py, name, &format!("{value} must be {bound} {limit}"))
            }
            Failure::Refused(Refused::Value(Error::Together { choice, value, other, wanted })) => {
                option(py, choice, &format!("'{value}' needs {} {wanted}", python(other)))
            }
            Failure::Refused(Refused::Value(Error::Arithmetic { name, reason })) => {
                option(py, "arithmetic", &format!("{name}: {reason}"))
            }
            Failure::Refused(Refused::Value(error)) => PyValueError::new_err(error.to_string()),
            Failure::Refused(Refused::Unused(unused)) => option(py, unused.name, &reason(&unused)),
            Failure::Image(reason) => PyValueError::new_err(reason),
            Failure::Memory(reason) => PyMemoryError::new_err(reason),
            Failure::Internal(reason) => PyRuntimeError::new_err(format!("internal error: {reason}")),
        }
    }
}

/// The exception for an option by its name in Python.
pub fn option(py: Python<'_>, name: &str, reason: &str) -> PyErr {
    let name = python(name);
    let error = OptionError::new_err(format!("{name}: {reason}"));
    match error.value(py).setattr("option", name) {
        Ok(()) => error,
        Err(other) => other,
    }
}

/// The name of an option as a keyword.
pub fn python(name: &str) -> String {
    name.replace('-', "_")
}

fn reason(unused: &Unused) -> String {
    let Unused { choice, chosen, wanted, preset, .. } = unused;
    let preset = preset.map(|name| format!(", as preset='{name}' has")).unwrap_or_default();
    let choice = python(choice);
    format!("not used by {choice}='{chosen}'; it needs {choice} {wanted}{preset}")
}
