//! The Python package's engine: numpy arrays in, numpy arrays out.
//!
//! What a user calls is in the Python modules beside this crate, which bring images of all kinds to
//! plain arrays and give results their final form. Here arrays become runs: each in a thread of its
//! own, without the interpreter's lock, while the calling thread listens for Ctrl-C.
#![deny(missing_docs)]

mod array;
mod error;
mod job;
mod more;
mod run;
mod table;
mod watch;

use pyo3::prelude::*;

/// The module `skyfront._engine`.
#[pymodule]
mod _engine {
    #[pymodule_export]
    use super::error::OptionError;
    #[pymodule_export]
    use super::more::{outlines, picture, score, simulate};
    #[pymodule_export]
    use super::run::{Unmeasured, answer, segment};
    #[pymodule_export]
    use super::table::{choices, columns, elsewhere, flags, parameters};
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
