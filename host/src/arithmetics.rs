//! Every arithmetic of the core, for what is to be done in each of them.

use crate::machine::Native;
use skyfront_core::arithmetic::{Arithmetic, F32, Q11, Q24};
use skyfront_core::config::Config;

/// Something to do in an arithmetic.
pub trait Task {
    /// What comes of it.
    type Output;

    /// Does it in `A`.
    fn run<A: Arithmetic>(&mut self) -> Self::Output;
}

/// Does the task in every arithmetic.
pub fn each<T: Task>(task: &mut T) -> Vec<T::Output> {
    vec![task.run::<F32<Native>>(), task.run::<Q24>(), task.run::<Q11>()]
}

/// Does the task in the arithmetic of that name, if there is one.
pub fn named<T: Task>(name: &str, task: &mut T) -> Option<T::Output> {
    match name {
        _ if name == F32::<Native>::NAME => Some(task.run::<F32<Native>>()),
        _ if name == Q24::NAME => Some(task.run::<Q24>()),
        _ if name == Q11::NAME => Some(task.run::<Q11>()),
        _ => None,
    }
}

/// The configuration, in a band where the arithmetic cannot do without.
pub fn adapted<A: Arithmetic>(config: &Config) -> Config {
    Config { band: config.band.or(A::NEEDS_BAND), ..*config }
}
