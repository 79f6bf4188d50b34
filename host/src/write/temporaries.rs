//! The files that must not survive this process: a register for every way it can end.

use std::fs::{self, File};
use std::hash::{BuildHasher, RandomState};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A product that is not published yet.
#[derive(Debug)]
pub(super) struct Begun {
    /// Where it is.
    pub(super) temporary: PathBuf,
    /// Where it will be.
    pub(super) product: PathBuf,
}

/// Names of temporary files begin and end so.
const NAME: (&str, &str) = (".skyfront-", ".part");

static REGISTER: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// The register; a thread that panicked while holding it leaves it usable.
fn register() -> MutexGuard<'static, Vec<PathBuf>> {
    REGISTER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes an empty file of a name that no other run, on whatever machine, has or guesses.
pub(super) fn create(folder: &Path) -> io::Result<PathBuf> {
    let mut files = register();
    let path = make(folder, |path| File::create_new(path).map(|_| ()))?;
    files.push(path.clone());
    Ok(path)
}

/// Tries random names until `make` finds one free.
fn make(folder: &Path, make: impl Fn(&Path) -> io::Result<()>) -> io::Result<PathBuf> {
    const TRIALS: u32 = 100;
    let mut refused = ErrorKind::AlreadyExists.into();
    for trial in 0..TRIALS {
        // The hasher's keys are the system's random numbers.
        let path = folder.join(format!("{}{:016x}{}", NAME.0, RandomState::new().hash_one(trial), NAME.1));
        match make(&path) {
            Ok(()) => return Ok(path),
            Err(reason) if reason.kind() == ErrorKind::AlreadyExists => refused = reason,
            Err(reason) => return Err(reason),
        }
    }
    Err(refused)
}

/// Gives complete files their final names; from then on they stay. An interrupt comes before the first or after the
/// last of them, and where one fails, all is undone.
pub(super) fn publish(begun: &[Begun]) -> Result<(), (PathBuf, io::Error)> {
    let mut files = register();
    let mut before: Vec<Before> = Vec::new();
    for Begun { temporary, product } in begun {
        let before_it = Before::keep(product);
        if let Err(reason) = fs::rename(temporary, product) {
            before_it.forget();
            before.into_iter().rev().for_each(Before::restore);
            return Err((product.clone(), reason));
        }
        before.push(before_it);
    }
    before.iter().for_each(Before::forget);
    files.retain(|file| !begun.iter().any(|begun| begun.temporary == *file));
    Ok(())
}

/// What stood where a product is now, under a second name; an error where nothing did or there are no links.
struct Before<'a> {
    product: &'a Path,
    old: io::Result<PathBuf>,
}

impl<'a> Before<'a> {
    fn keep(product: &'a Path) -> Self {
        let folder = product.parent().unwrap_or(Path::new(""));
        Before { product, old: make(folder, |link| fs::hard_link(product, link)) }
    }

    fn forget(&self) {
        self.old.iter().for_each(|old| remove(old));
    }

    /// Puts it back. What cannot be put back leaves a whole new file.
    fn restore(self) {
        match self.old {
            Ok(old) => _ = fs::rename(old, self.product),
            Err(reason) if reason.kind() == ErrorKind::NotFound => remove(self.product),
            Err(_) => {}
        }
    }
}

/// Removes one file that will not be completed.
pub(super) fn discard(temporary: &Path) {
    let mut files = register();
    remove(temporary);
    files.retain(|file| file != temporary);
}

/// Removes what killed runs left in a folder, into which nobody else writes now.
pub(super) fn remove_stale(folder: &Path) {
    let files = register();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let stale = name.to_str().is_some_and(|name| name.starts_with(NAME.0) && name.ends_with(NAME.1));
        if stale && !files.contains(&entry.path()) {
            remove(&entry.path());
        }
    }
}

/// Removes a file. It may never have been created, or be gone: nothing is left to do then.
fn remove(path: &Path) {
    let _ = fs::remove_file(path);
}

/// Removes every temporary file and ends the process with exit code 130, as after Ctrl-C.
///
/// For the interrupt handler, which runs on its own thread. The register stays locked until the end, so no other
/// thread can start or publish a product in between.
pub fn interrupted() -> ! {
    let files = register();
    files.iter().for_each(|file| remove(file));
    std::process::exit(130)
}
