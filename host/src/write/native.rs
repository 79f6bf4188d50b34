//! The only unsafe code of this crate: calls of cfitsio that create FITS files.
//!
//! Every function takes safe Rust values whose lengths it checks, keeps no pointer beyond the call, and turns the
//! library's status into an error. The library is built re-entrant, so files on different threads do not meet.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_long, c_void};
use std::path::Path;
use std::ptr;

use fitsio::sys;

/// Why a call failed.
#[derive(Debug)]
pub(super) enum Failure {
    /// The system refused, for instance because the disk is full.
    System(std::io::Error),
    /// The library refused, in one line.
    Library(String),
}

/// An open FITS file that is being written.
pub(super) struct Handle(*mut sys::fitsfile);

/// A sample type that cfitsio knows: its constant for memory, and its `BITPIX` in the file.
///
/// # Safety
/// `TYPE` must be cfitsio's constant for exactly this type: the library reads memory by it.
pub(super) unsafe trait Native: Copy {
    const TYPE: c_int;
}

// SAFETY (all four): cfitsio's TFLOAT, TDOUBLE, TINT and TLONGLONG are C's float, double, int and a 64-bit integer.
unsafe impl Native for f32 {
    const TYPE: c_int = 42;
}
unsafe impl Native for f64 {
    const TYPE: c_int = 82;
}
unsafe impl Native for i32 {
    const TYPE: c_int = 31;
}
unsafe impl Native for i64 {
    const TYPE: c_int = 81;
}

/// Name, format and unit of a table column.
pub(super) struct Field<'a> {
    pub(super) name: &'a str,
    pub(super) format: &'a str,
    pub(super) unit: &'a str,
}

impl Handle {
    /// Creates a file; the name is taken literally. An existing file is an error.
    pub(super) fn create(path: &Path) -> Result<Self, Failure> {
        let name = c_path(path)?;
        let mut file = ptr::null_mut();
        // SAFETY: `name` ends in NUL and outlives the call; `file` is valid for one pointer.
        call(|status| unsafe { sys::ffdkinit(&mut file, name.as_ptr(), status) })?;
        Ok(Self(file))
    }

    /// Begins an image HDU.
    pub(super) fn image(&mut self, bitpix: c_int, width: usize, height: usize) -> Result<(), Failure> {
        let length = |n: usize| c_long::try_from(n).map_err(|_| Failure::Library(format!("{n} pixels on one axis")));
        let mut axes = [length(width)?, length(height)?];
        // SAFETY: the handle is open, and `axes` holds the two lengths that are announced.
        call(|status| unsafe { sys::ffcrim(self.0, bitpix, 2, axes.as_mut_ptr(), status) })
    }

    /// Writes samples of the current image; `first` counts from 1.
    pub(super) fn samples<T: Native>(&mut self, first: i64, samples: &[T]) -> Result<(), Failure> {
        let data = samples.as_ptr().cast::<c_void>().cast_mut();
        // SAFETY: `data` points to `samples.len()` values of the type that TYPE names; the library only reads them.
        call(|status| unsafe { sys::ffppr(self.0, T::TYPE, first, samples.len() as i64, data, status) })
    }

    /// Begins a binary table HDU.
    pub(super) fn table(&mut self, name: &str, rows: usize, fields: &[Field<'_>]) -> Result<(), Failure> {
        const BINARY_TABLE: c_int = 2;
        let texts = |pick: for<'f> fn(&'f Field<'f>) -> &'f str| -> Result<Vec<CString>, Failure> {
            fields.iter().map(|field| c_text(pick(field))).collect()
        };
        let (names, formats, units) = (texts(|f| f.name)?, texts(|f| f.format)?, texts(|f| f.unit)?);
        let (mut names, mut formats, mut units) = (pointers(&names), pointers(&formats), pointers(&units));
        let count = c_int::try_from(fields.len()).map_err(|_| Failure::Library("too many columns".to_owned()))?;
        let name = c_text(name)?;
        // SAFETY: the three lists hold `count` pointers to NUL-terminated text that outlives the call.
        call(|status| unsafe {
            sys::ffcrtb(
                self.0,
                BINARY_TABLE,
                rows as i64,
                count,
                names.as_mut_ptr(),
                formats.as_mut_ptr(),
                units.as_mut_ptr(),
                name.as_ptr(),
                status,
            )
        })
    }

    /// Writes a whole column of the current table; `number` counts from 1.
    pub(super) fn column<T: Native>(&mut self, number: usize, values: &[T]) -> Result<(), Failure> {
        let data = values.as_ptr().cast::<c_void>().cast_mut();
        let (number, count) = (number as c_int, values.len() as i64);
        // SAFETY: `data` points to `count` values of the type that TYPE names; the library only reads them.
        call(|status| unsafe { sys::ffpcl(self.0, T::TYPE, number, 1, 1, count, data, status) })
    }

    /// Appends a card as it is.
    pub(super) fn card(&mut self, card: &str) -> Result<(), Failure> {
        let card = c_text(card)?;
        // SAFETY: the handle is open and `card` ends in NUL.
        call(|status| unsafe { sys::ffprec(self.0, card.as_ptr(), status) })
    }

    /// Appends a text value, continued over several cards if it is long.
    pub(super) fn text(&mut self, keyword: &str, value: &str, comment: &str) -> Result<(), Failure> {
        let (keyword, value, comment) = (c_text(keyword)?, c_text(value)?, c_text(comment)?);
        // SAFETY: the handle is open and the three texts end in NUL.
        call(|status| unsafe { sys::ffpkls(self.0, keyword.as_ptr(), value.as_ptr(), comment.as_ptr(), status) })
    }

    /// Completes and closes the file.
    pub(super) fn close(self) -> Result<(), Failure> {
        let file = self.0;
        std::mem::forget(self);
        // SAFETY: the handle is open, and `self` is gone, so it is closed once.
        call(|status| unsafe { sys::ffclos(file, status) })
    }
}

impl Drop for Handle {
    /// Closes a file that was given up; it is a temporary one that its owner removes.
    fn drop(&mut self) {
        // SAFETY: the handle is open; `close` forgets the value before it closes, so this happens once.
        let _ = call(|status| unsafe { sys::ffclos(self.0, status) });
    }
}

/// Runs a call of the library and looks at its status.
fn call(function: impl FnOnce(*mut c_int) -> c_int) -> Result<(), Failure> {
    /// Statuses that stand for a refusal by the system: not created, not written, not closed.
    const BY_THE_SYSTEM: [c_int; 3] = [105, 106, 110];
    let mut status = 0;
    function(&mut status);
    // The library does not keep the system's reason, but nothing has replaced it yet.
    let reason = std::io::Error::last_os_error();
    if status == 0 {
        return Ok(());
    }
    let mut text = [0 as c_char; 31];
    // SAFETY: the library writes at most 30 characters and NUL.
    unsafe { sys::ffgerr(status, text.as_mut_ptr()) };
    // SAFETY: the last element is never written, so the text ends in NUL inside the array.
    let text = unsafe { CStr::from_ptr(text.as_ptr()) }.to_string_lossy().into_owned();
    // SAFETY: no arguments; empties the library's list of messages, which would otherwise grow with every error.
    unsafe { sys::ffcmsg() };
    match reason.raw_os_error() {
        Some(1..) if BY_THE_SYSTEM.contains(&status) => Err(Failure::System(reason)),
        _ => Err(Failure::Library(format!("{text} (cfitsio status {status})"))),
    }
}

fn c_text(text: &str) -> Result<CString, Failure> {
    CString::new(text).map_err(|_| Failure::Library("text with a NUL character".to_owned()))
}

#[cfg(unix)]
fn c_path(path: &Path) -> Result<CString, Failure> {
    use std::os::unix::ffi::OsStrExt;
    CString::new(path.as_os_str().as_bytes()).map_err(|_| Failure::Library("file name with a NUL character".to_owned()))
}

#[cfg(not(unix))]
fn c_path(path: &Path) -> Result<CString, Failure> {
    c_text(path.to_str().ok_or_else(|| Failure::Library("file name that is not Unicode".to_owned()))?)
}

fn pointers(texts: &[CString]) -> Vec<*mut c_char> {
    texts.iter().map(|text| text.as_ptr().cast_mut()).collect()
}
