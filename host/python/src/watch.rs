//! Work beside the interpreter, which Ctrl-C can end.

use crate::error::Failure;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread::Builder;
use std::time::Duration;

/// So often the calling thread looks for Ctrl-C.
const INTERVAL: Duration = Duration::from_millis(50);
/// As much as a main thread has.
const STACK: usize = 8 << 20;

/// Whether a result is still wanted.
#[derive(Clone, Default)]
pub struct Wanted(Arc<AtomicBool>);

/// What a run that is not wanted any more ends with.
struct Abandoned;

impl Wanted {
    /// Ends the work where its result is not wanted any more.
    pub fn or_end(&self) {
        if self.0.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Abandoned));
        }
    }
}

/// Does some work in a thread of its own, without the interpreter's lock. After an interrupt the call ends at
/// once, the work where it next asks whether it is wanted.
///
/// # Errors
/// What the work fails with, a panic in it, and what a signal raises.
pub fn watched<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Wanted) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let wanted = Wanted::default();
    let (send, mut receive) = sync_channel(1);
    let for_work = wanted.clone();
    let run = move || {
        let done = catch_unwind(AssertUnwindSafe(|| work(&for_work)));
        // Nobody listens any more after an interrupt.
        let _ = send.send(done);
    };
    if Builder::new().stack_size(STACK).spawn(run).is_err() {
        return Err(Failure::Memory("the system gives no thread".to_owned()).exception(py));
    }
    loop {
        let (back, got) = py.detach(move || {
            let got = receive.recv_timeout(INTERVAL);
            (receive, got)
        });
        receive = back;
        match got {
            Ok(Ok(done)) => return done.map_err(|failure| failure.exception(py)),
            Ok(Err(panic)) => return Err(Failure::Internal(words(&*panic)).exception(py)),
            Err(RecvTimeoutError::Disconnected) => {
                return Err(Failure::Internal("the work gave no result".to_owned()).exception(py));
            }
            Err(RecvTimeoutError::Timeout) => {
                if let Err(interrupt) = py.check_signals() {
                    wanted.0.store(true, Ordering::Relaxed);
                    return Err(interrupt);
                }
            }
        }
    }
}

fn words(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().or_else(|| panic.downcast_ref().map(String::as_str));
    text.unwrap_or("a panic without words").to_owned()
}
