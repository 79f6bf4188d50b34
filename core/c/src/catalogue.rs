//! What the sources of the default measure, in a block of the caller's memory: the numbers of the ground to the bit.

use crate::error::{
    SKYFRONT_ERROR_INDEX, SKYFRONT_ERROR_LENGTH, SKYFRONT_ERROR_NOT_DONE, SKYFRONT_ERROR_POINTER, SKYFRONT_OK, number,
};
use crate::memory::{ALIGNMENT, Block};
use crate::pointer::slice_mut;
use crate::search::{Search, skyfront_search};
use core::ffi::c_void;
use skyfront_core::run::extract::catalogue::Measuring;
use skyfront_core::sources::flags;
use skyfront_core::sources::measure::{Centroid, Levels, Sums};

/// The source touches the edge of the frame.
pub const SKYFRONT_SOURCE_TRUNCATED: u32 = 1;
/// A pixel reaches the camera's saturation.
pub const SKYFRONT_SOURCE_SATURATED: u32 = 2;
/// A pixel touches one that is listed as bad.
pub const SKYFRONT_SOURCE_MASKED: u32 = 4;
/// The source was divided from another one.
pub const SKYFRONT_SOURCE_BLENDED: u32 = 8;
/// No pixel stands above the sky: place and extent are those of the pixels.
pub const SKYFRONT_SOURCE_NO_FLUX: u32 = 64;
/// The source ends in a plateau, as a saturated star does.
pub const SKYFRONT_SOURCE_PLATEAU: u32 = 1024;

const _: () = assert!(
    SKYFRONT_SOURCE_TRUNCATED == flags::TRUNCATED
        && SKYFRONT_SOURCE_SATURATED == flags::SATURATED
        && SKYFRONT_SOURCE_MASKED == flags::MASKED
        && SKYFRONT_SOURCE_BLENDED == flags::BLENDED
        && SKYFRONT_SOURCE_NO_FLUX == flags::NO_FLUX
        && SKYFRONT_SOURCE_PLATEAU == flags::PLATEAU
);

/// The sums of all sources, and how far they are.
pub(crate) struct Catalogue {
    sums: &'static mut [Sums],
    so_far: Measuring,
    is_done: bool,
}

/// What a source of the default measures above the sky, in 144 bytes. Errors count the noise of its light where the
/// camera is known.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct skyfront_measured {
    /// Its label in the map, from 1.
    pub label: u32,
    /// Pixels.
    pub area: u32,
    /// Sum of SKYFRONT_SOURCE_....
    pub flags: u32,
    /// Its greatest pixel, counts; NaN where all are bad.
    pub peak: f32,
    /// Column and row of the first such pixel.
    pub peak_place: [u32; 2],
    /// First and last column.
    pub columns: [u32; 2],
    /// First and last row.
    pub rows: [u32; 2],
    /// Light above the sky, counts.
    pub flux: f64,
    /// Its standard deviation, counts.
    pub flux_error: f64,
    /// Column of the centre, pixels.
    pub x: f64,
    /// Row of the centre, pixels.
    pub y: f64,
    /// Variance of the column, pixels^2; NaN where nothing stands above the sky, as the next two.
    pub errx2: f64,
    /// Variance of the row, pixels^2.
    pub erry2: f64,
    /// Covariance of column and row, pixels^2.
    pub errxy: f64,
    /// Second moment along the columns, pixels^2.
    pub x2: f64,
    /// Second moment along the rows, pixels^2.
    pub y2: f64,
    /// The mixed second moment, pixels^2.
    pub xy: f64,
    /// Mean sky, counts.
    pub background: f64,
    /// Mean standard deviation of the sky, counts.
    pub noise: f64,
    /// Mean of the pixels along the outline above the sky, counts.
    pub threshold: f64,
}

const _: () = assert!(size_of::<skyfront_measured>() == 144);

/// Bytes that the catalogue of so many sources needs; 0 where they cannot be counted.
#[unsafe(no_mangle)]
pub extern "C" fn skyfront_catalogue_bytes(sources: usize) -> usize {
    let bytes = sources.checked_mul(size_of::<Sums>()).and_then(|bytes| bytes.checked_add(ALIGNMENT));
    bytes.filter(|&bytes| bytes <= isize::MAX as usize).unwrap_or(0)
}

/// Begins to measure the sources of a run of the default that has ended, in `memory` of at least
/// `skyfront_catalogue_bytes()` bytes for them, which belongs to the run until another catalogue is begun; a run that
/// takes up a snapshot has none.
///
/// # Safety
/// `search` was started; `memory` points to `bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_search_measure_start(
    search: *mut skyfront_search,
    memory: *mut c_void,
    bytes: usize,
) -> i32 {
    // SAFETY: the caller's promise.
    let Some(search) = (unsafe { search.as_mut() }) else { return SKYFRONT_ERROR_POINTER };
    if memory.is_null() {
        return SKYFRONT_ERROR_POINTER;
    }
    let Some(sources) = search.sources else { return SKYFRONT_ERROR_NOT_DONE };
    // SAFETY: the memory is the caller's to give, and stays with the run.
    let mut block = unsafe { Block::new(memory.cast(), bytes) };
    let Some(sums) = block.filled(sources as usize, Sums::EMPTY) else { return SKYFRONT_ERROR_LENGTH };
    search.catalogue = Some(Catalogue { sums, so_far: Measuring::default(), is_done: false });
    SKYFRONT_OK
}

/// Measures at most `rows` rows of the frame, or as many pieces of sources as these have pixels; `done` takes 1 when all
/// is measured, else 0, and may be null. The same numbers come out whatever the slices.
///
/// # Safety
/// `search` was started.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_search_measure(search: *mut skyfront_search, rows: usize, done: *mut u32) -> i32 {
    // SAFETY: the caller's promise.
    let (Some(search), done) = (unsafe { (search.as_mut(), done.as_mut()) }) else { return SKYFRONT_ERROR_POINTER };
    let Some(Catalogue { sums, so_far, is_done }) = &mut search.catalogue else { return SKYFRONT_ERROR_NOT_DONE };
    let measured = match &mut search.search {
        _ if *is_done => Ok(true),
        Search::Words(run) => run.measure(so_far, rows, sums),
        Search::Bytes(run) => run.measure(so_far, rows, sums),
    };
    match measured {
        Ok(all) => {
            *is_done = all;
            if let Some(done) = done {
                *done = u32::from(all);
            }
            SKYFRONT_OK
        }
        Err(error) => number(&error),
    }
}

/// Source `index`, from 0, of a catalogue that is measured: that of label `index + 1`.
///
/// # Safety
/// `search` was started; `source` points to a record.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_search_source(
    search: *const skyfront_search,
    index: usize,
    source: *mut skyfront_measured,
) -> i32 {
    // SAFETY: the caller's promise.
    let (Some(search), Some([source])) = (unsafe { (search.as_ref(), slice_mut(source, 1)) }) else {
        return SKYFRONT_ERROR_POINTER;
    };
    let Some(Catalogue { sums, is_done: true, .. }) = &search.catalogue else { return SKYFRONT_ERROR_NOT_DONE };
    let Some((sums, label)) = sums.get(index).zip(u32::try_from(index).ok()) else { return SKYFRONT_ERROR_INDEX };
    *source = record(sums, label.saturating_add(1), search.gain);
    SKYFRONT_OK
}

fn record(sums: &Sums, label: u32, gain: Option<f64>) -> skyfront_measured {
    let (flux, levels) = (sums.flux(gain), sums.levels());
    let Levels { background, noise, threshold } = levels;
    let Centroid { x, y, moments: (x2, y2, xy), errors: (errx2, erry2, errxy) } = sums.centroid();
    let (peak, place) = sums.peak.unwrap_or((f32::NAN, (0, 0)));
    skyfront_measured {
        label,
        area: sums.area,
        flags: sums.flags(),
        peak,
        peak_place: place.into(),
        columns: sums.columns.into(),
        rows: sums.rows.into(),
        flux: flux.value,
        flux_error: flux.error,
        x,
        y,
        errx2,
        erry2,
        errxy,
        x2,
        y2,
        xy,
        background,
        noise,
        threshold,
    }
}
