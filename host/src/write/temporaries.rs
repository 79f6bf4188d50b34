//! The files that must not survive this process: a register for every way it can end.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

static REGISTER: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// The register; a thread that panicked while holding it leaves it usable.
fn register() -> MutexGuard<'static, Vec<PathBuf>> {
    REGISTER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Notes a file that is about to be written.
pub(super) fn add(path: PathBuf) {
    register().push(path);
}

/// Renames a complete file to its final name; from then on it stays.
pub(super) fn publish(temporary: &Path, product: &Path) -> io::Result<()> {
    let mut files = register();
    fs::rename(temporary, product)?;
    files.retain(|file| file != temporary);
    Ok(())
}

/// Removes one file that will not be completed.
pub(super) fn discard(temporary: &Path) {
    let mut files = register();
    // It may never have been created, or be gone: nothing is left to do then.
    let _ = fs::remove_file(temporary);
    files.retain(|file| file != temporary);
}

/// Removes every temporary file and ends the process with exit code 130, as after Ctrl-C.
///
/// For the interrupt handler, which runs on its own thread. The register stays locked until the end, so no other
/// thread can start or publish a product in between.
pub fn interrupted() -> ! {
    let files = register();
    for file in files.iter() {
        let _ = fs::remove_file(file);
    }
    std::process::exit(130)
}
