//! The default in slices of bounded work, in one block of the caller's memory: what finds most.

use crate::catalogue::Catalogue;
use crate::error::{
    Message, SKYFRONT_ERROR_FRAME, SKYFRONT_ERROR_FRONT, SKYFRONT_ERROR_INDEX, SKYFRONT_ERROR_LENGTH,
    SKYFRONT_ERROR_NOT_DONE, SKYFRONT_ERROR_NOT_RESTORED, SKYFRONT_ERROR_POINTER, SKYFRONT_OK, number,
};
use crate::memory::{ALIGNMENT, Block};
use crate::pointer::{pixels_of, slice, slice_mut};
use crate::run::{begin, set, skyfront_setting, tell};
use crate::track::{skyfront_bad_pixel, skyfront_camera};
use core::ffi::{c_char, c_void};
use core::sync::atomic::{AtomicU8, AtomicU16};
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::plane::camera::Camera;
use skyfront_core::plane::mask::mask_words;
use skyfront_core::plane::raster::{BadPixel, Raster, Sample};
use skyfront_core::plane::smooth::ROOM_ROWS;
use skyfront_core::run::extract::{Extractor, Found, Progress};
use skyfront_core::run::workspace::{Workspace, regions};
use skyfront_core::sky::view::Known;
use skyfront_core::sky::{Sky, mesh_cells};
use skyfront_core::sources::tree::Region;

/// The two widths of pixels.
pub(crate) enum Search {
    Words(Extractor<'static, 'static, f32, AtomicU16>),
    Bytes(Extractor<'static, 'static, f32, AtomicU8>),
}

/// A run of the default, in the caller's memory.
pub struct skyfront_search {
    pub(crate) search: Search,
    pub(crate) size: (usize, usize),
    /// How many sources there are, once the run has ended.
    pub(crate) sources: Option<u32>,
    pub(crate) gain: Option<f64>,
    pub(crate) catalogue: Option<Catalogue>,
}

/// What a run of the default is to work on.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct skyfront_search_setup {
    /// The frame, 16 bits per pixel in the processor's byte order; null where it has 8.
    pub pixels_u16: *const u16,
    /// The frame, 8 bits per pixel; null where it has 16.
    pub pixels_u8: *const u8,
    /// Columns, 8 to 65535.
    pub width: usize,
    /// Rows, 8 to 65535.
    pub height: usize,
    /// Pixels from one row to the next.
    pub stride: usize,
    /// Peaks that there is room for; 0 for as many as there can be. Pixels of more are in no source, and counted.
    pub regions: usize,
    /// Pixels that are never to be used, row by row and along these; null for none.
    pub bad_pixels: *const skyfront_bad_pixel,
    /// How many.
    pub bad_pixel_count: usize,
    /// Settings other than the default's; null for none.
    pub settings: *const skyfront_setting,
    /// How many.
    pub setting_count: usize,
    /// What is known of the camera, copied: its gain counts in the errors of sources, its saturation in their flags; the
    /// sky, its noise and the width of stars are measured. Null where nothing is.
    pub camera: *const skyfront_camera,
}

/// How far a run of the default is, and at its end what it found.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct skyfront_search_progress {
    /// Work done, in pixels of a pass.
    pub work: u64,
    /// The most work that there can be.
    pub most_work: u64,
    /// 1 when all is done, else 0.
    pub done: u32,
    /// Sources; 0 before the end, as all that follows. Labels run from 1 to this.
    pub sources: u32,
    /// Pixels of sources.
    pub mask_pixels: u32,
    /// Peaks for which there was no room.
    pub unlabelled: u32,
}

/// Takes `count` bytes of a snapshot and returns 0; another number stops the call.
pub type skyfront_write = Option<unsafe extern "C" fn(context: *mut c_void, bytes: *const u8, count: usize) -> i32>;
/// Gives the next `count` bytes of a snapshot and returns 0; another number stops the call.
pub type skyfront_read = Option<unsafe extern "C" fn(context: *mut c_void, bytes: *mut u8, count: usize) -> i32>;

/// Bytes that a run of the default needs, whatever its settings; 0 where they cannot be counted.
#[unsafe(no_mangle)]
pub extern "C" fn skyfront_search_bytes(width: usize, height: usize, regions: usize) -> usize {
    const MOST: usize = u16::MAX as usize;
    /// What the alignment of twelve pieces may cost.
    const PADDING: u128 = 13 * ALIGNMENT as u128;
    if width > MOST || height > MOST {
        return 0;
    }
    let pixels = width.saturating_mul(height);
    let words = (mask_words(pixels) as u128).saturating_add((ROOM_ROWS as u128).saturating_mul(width as u128));
    let words = words.saturating_add((pixels as u128).saturating_mul(6));
    let mesh = (mesh_cells(width, height, 1) as u128).saturating_mul(size_of::<Sky>() as u128);
    let table = (room_for(width, height, regions) as u128).saturating_mul(size_of::<Region<f32>>() as u128);
    let bytes = words.saturating_mul(4).saturating_add(mesh).saturating_add(table);
    let once = (size_of::<skyfront_search>() as u128).saturating_add(size_of::<Camera>() as u128);
    let bytes = bytes.saturating_add(once).saturating_add(PADDING);
    if bytes > isize::MAX as u128 { 0 } else { bytes as usize }
}

/// Regions in the table.
fn room_for(width: usize, height: usize, wanted: usize) -> usize {
    if wanted == 0 { regions(width, height) } else { wanted }
}

/// Sets up a run of the default in `memory` of at least `skyfront_search_bytes()` bytes, which belongs to the run
/// from now on and must not be moved; there is nothing to be freed. The frame must stay where it is, and what it
/// is, until the run has ended: one that others have written to is SKYFRONT_ERROR_FRAME_CHANGED. `search` takes
/// the run, `message` as for `skyfront_run_start`.
///
/// # Safety
/// `memory` points to `bytes` bytes, `setup` to a setup whose frame has `stride * (height - 1) + width` pixels and
/// whose settings are texts that end with a zero, `search` to a pointer, `message` to `message_bytes` bytes. Frame
/// and bad pixels outlive the run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_search_start(
    memory: *mut c_void,
    bytes: usize,
    setup: *const skyfront_search_setup,
    search: *mut *mut skyfront_search,
    message: *mut c_char,
    message_bytes: usize,
) -> i32 {
    // SAFETY: the caller's promise; the setup is as the caller promised.
    unsafe {
        begin((memory, bytes), setup, search, (message, message_bytes), |block, setup, message| {
            start(block, setup, message)
        })
    }
}

/// # Safety
/// As for [`skyfront_search_start`].
unsafe fn start(
    mut block: Block,
    setup: &skyfront_search_setup,
    message: &mut Message<'_>,
) -> Result<*mut skyfront_search, i32> {
    let &skyfront_search_setup { width, height, stride, .. } = setup;
    let mut config = Config::NOISE_AWARE;
    let count = pixels_of(width, height, stride);
    // SAFETY: the caller's promise; atomic counts have the layout of plain ones, and records are the core's own.
    let given = unsafe {
        set(&mut config, setup.settings, setup.setting_count, message)?;
        (
            slice(setup.pixels_u16.cast::<AtomicU16>(), count),
            slice(setup.pixels_u8.cast::<AtomicU8>(), count),
            slice(setup.bad_pixels.cast::<BadPixel>(), setup.bad_pixel_count),
            slice(setup.camera.cast::<Camera>(), usize::from(!setup.camera.is_null())),
        )
    };
    if config.needs_segmenter() {
        tell(message, &"fronts but the region's, and filters in steps, go over signal-to-noise in Rust only");
        return Err(SKYFRONT_ERROR_FRONT);
    }
    let (words, bytes, bad, Some(camera)) = given else { return Err(SKYFRONT_ERROR_POINTER) };
    let gain = camera.first().map(|camera| f64::from(camera.gain));
    let place = block.take::<skyfront_search>(1);
    let camera = camera.first().map_or(Some(None), |camera| block.filled(1, *camera).map(|copy| copy.first()));
    let work = workspace(&mut block, setup, config.sky.cell());
    let (Some(place), Some(camera), Some(work)) = (place, camera, work) else {
        let needed = skyfront_search_bytes(width, height, setup.regions);
        tell(message, &format_args!("{needed} bytes are needed"));
        return Err(SKYFRONT_ERROR_LENGTH);
    };
    let over = |error: Error| number(&error);
    let known = |bad| Known { bad, camera, ..Known::default() };
    let search = match (words, bytes, bad) {
        (Some(words), None, Some(bad)) => searched(&config, words, setup, known(bad), work).map(Search::Words),
        (None, Some(bytes), Some(bad)) => searched(&config, bytes, setup, known(bad), work).map(Search::Bytes),
        _ => return Err(SKYFRONT_ERROR_POINTER),
    };
    let search = search.inspect_err(|error| tell(message, error)).map_err(over)?;
    // SAFETY: the place is aligned and has room for one run.
    unsafe { place.write(skyfront_search { search, size: (width, height), sources: None, gain, catalogue: None }) };
    Ok(place)
}

fn searched<P: Sample>(
    config: &Config,
    pixels: &'static [P],
    setup: &skyfront_search_setup,
    known: Known<'static>,
    work: Workspace<'static, f32>,
) -> Result<Extractor<'static, 'static, f32, P>, Error> {
    let frame = Raster::new(pixels, setup.width, setup.height, setup.stride)?;
    Extractor::over(config, frame, known, work)
}

/// The memory of a run; none where the block is too small.
fn workspace(block: &mut Block, setup: &skyfront_search_setup, cell: usize) -> Option<Workspace<'static, f32>> {
    let (width, height) = (setup.width, setup.height);
    let pixels = width.checked_mul(height)?;
    if skyfront_search_bytes(width, height, setup.regions) == 0 {
        return None;
    }
    Some(Workspace {
        signal: block.filled(pixels, 0.0)?,
        fine: block.filled(pixels, 0.0)?,
        smooth: block.filled(pixels, 0.0)?,
        labels: block.filled(pixels, 0)?,
        parents: block.filled(pixels, 0)?,
        order: block.filled(pixels, 0)?,
        masked: block.filled(mask_words(pixels), 0)?,
        rows: block.filled(ROOM_ROWS.checked_mul(width)?, 0.0)?,
        mesh: block.filled(mesh_cells(width, height, cell), Sky::UNKNOWN)?,
        regions: block.filled(room_for(width, height, setup.regions), Region::BLANK)?,
    })
}

/// Does at most `rows` rows of the step under way. The same results come out whatever the slices. `progress` may be
/// null. After an error every further call returns the same.
///
/// # Safety
/// `search` was started.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_search_poll(
    search: *mut skyfront_search,
    rows: usize,
    progress: *mut skyfront_search_progress,
) -> i32 {
    // SAFETY: the caller's promise.
    let (Some(search), progress) = (unsafe { (search.as_mut(), progress.as_mut()) }) else {
        return SKYFRONT_ERROR_POINTER;
    };
    let (polled, (work, most_work)) = match &mut search.search {
        Search::Words(run) => (run.poll(rows), run.work_done()),
        Search::Bytes(run) => (run.poll(rows), run.work_done()),
    };
    let mut now = skyfront_search_progress { work, most_work, ..skyfront_search_progress::default() };
    match polled {
        Err(error) => return number(&error),
        Ok(Progress::Done(Found { sources, mask_pixels, unlabelled, .. })) => {
            search.sources = Some(sources);
            now = skyfront_search_progress { done: 1, sources, mask_pixels, unlabelled, ..now };
        }
        Ok(_) => {}
    }
    if let Some(progress) = progress {
        *progress = now;
    }
    SKYFRONT_OK
}

/// Row `y` of the map of labels of a run of the default that has ended, `width` of them; 0 is the background.
///
/// # Safety
/// `search` was started; `labels` points to as many numbers as the frame has columns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_search_labels(search: *const skyfront_search, y: usize, labels: *mut u32) -> i32 {
    // SAFETY: the caller's promise.
    let Some(search) = (unsafe { search.as_ref() }) else { return SKYFRONT_ERROR_POINTER };
    if search.sources.is_none() {
        return SKYFRONT_ERROR_NOT_DONE;
    }
    let width = search.size.0;
    // SAFETY: the caller's promise.
    let Some(to) = (unsafe { slice_mut(labels, width) }) else { return SKYFRONT_ERROR_POINTER };
    let all: &[u32] = match &search.search {
        Search::Words(run) => run.work().labels,
        Search::Bytes(run) => run.work().labels,
    };
    let start = y.saturating_mul(width);
    match all.get(start..start.saturating_add(width)) {
        Some(row) => {
            to.iter_mut().zip(row).for_each(|(label, own)| *label = *own);
            SKYFRONT_OK
        }
        None => SKYFRONT_ERROR_INDEX,
    }
}

/// Writes a run of the default out as a snapshot, in pieces of at most 64 bytes; `context` is passed on to `write`.
/// When that returns another number than 0 the result is SKYFRONT_ERROR_FRAME, and the run goes on.
///
/// # Safety
/// `search` was started; `write` reads no more than it is given.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_search_save(
    search: *mut skyfront_search,
    write: skyfront_write,
    context: *mut c_void,
) -> i32 {
    // SAFETY: the caller's promise.
    let (Some(search), Some(write)) = (unsafe { search.as_mut() }, write) else { return SKYFRONT_ERROR_POINTER };
    let to = |bytes: &[u8]| {
        // SAFETY: the caller's function reads these bytes only.
        if unsafe { write(context, bytes.as_ptr(), bytes.len()) } == 0 { Ok(()) } else { Err(SKYFRONT_ERROR_FRAME) }
    };
    let saved = match &mut search.search {
        Search::Words(run) => run.save(to),
        Search::Bytes(run) => run.save(to),
    };
    saved.map_or_else(|error| error, |()| SKYFRONT_OK)
}

/// Takes up the run of a snapshot in the place of this one, which has the same setup and the same frame.
/// SKYFRONT_ERROR_NOT_RESTORED where it is damaged, foreign or ends early: this run is lost then, until a snapshot
/// is taken up.
///
/// # Safety
/// `search` was started; `read` writes no more than it is asked for.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_search_restore(
    search: *mut skyfront_search,
    read: skyfront_read,
    context: *mut c_void,
) -> i32 {
    // SAFETY: the caller's promise.
    let (Some(search), Some(read)) = (unsafe { search.as_mut() }, read) else { return SKYFRONT_ERROR_POINTER };
    let from = |bytes: &mut [u8]| {
        // SAFETY: the caller's function writes these bytes only.
        if unsafe { read(context, bytes.as_mut_ptr(), bytes.len()) } == 0 { Ok(()) } else { Err(()) }
    };
    let restored = match &mut search.search {
        Search::Words(run) => run.restore(from).is_ok(),
        Search::Bytes(run) => run.restore(from).is_ok(),
    };
    (search.sources, search.catalogue) = (None, None);
    if restored { SKYFRONT_OK } else { SKYFRONT_ERROR_NOT_RESTORED }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::arithmetic_side_effects, clippy::expect_used, clippy::indexing_slicing)]

    extern crate std;
    use super::*;
    use crate::catalogue::*;
    use crate::error::SKYFRONT_ERROR_FRAME_CHANGED;
    use core::ptr::{null, null_mut};
    use skyfront_core::run::extract::catalogue::Measuring;
    use skyfront_core::run::frame::Frame;
    use skyfront_core::simulate::{Kind, Sky as Simulated};
    use skyfront_core::sources::measure::Sums;
    use std::vec;
    use std::vec::Vec;

    const WIDTH: usize = 64;
    const HEIGHT: usize = 48;
    const STRIDE: usize = 70;

    fn counts() -> Vec<u16> {
        let (mut sky, mut counts) = (Simulated::new(Kind::Bright, 7, WIDTH, HEIGHT), vec![0; STRIDE * HEIGHT]);
        for (y, counts) in counts.chunks_exact_mut(STRIDE).enumerate() {
            let mut row = [0.0; WIDTH];
            let Ok(()) = sky.row(y, &mut row);
            counts.iter_mut().zip(row).for_each(|(count, value)| *count = (20.0 + 200.0 * value) as u16);
        }
        counts
    }

    const BAD: [skyfront_bad_pixel; 1] = [skyfront_bad_pixel { x: 9, y: 3 }];
    const SETUP: skyfront_search_setup = skyfront_search_setup {
        pixels_u16: null(),
        pixels_u8: null(),
        width: WIDTH,
        height: HEIGHT,
        stride: STRIDE,
        regions: 0,
        bad_pixels: BAD.as_ptr(),
        bad_pixel_count: 1,
        settings: null(),
        setting_count: 0,
        camera: null(),
    };

    /// Memory of a run, aligned as memory for anything is.
    fn memory() -> Vec<u64> {
        vec![0; skyfront_search_bytes(WIDTH, HEIGHT, 0) / 8 + 1]
    }

    fn started(memory: &mut [u64], setup: &skyfront_search_setup) -> Result<*mut skyfront_search, i32> {
        let (mut search, mut message) = (null_mut(), [0u8; 80]);
        let bytes = size_of_val(memory);
        // SAFETY: every pointer is to what its length says.
        let result = unsafe {
            let text = message.as_mut_ptr().cast();
            skyfront_search_start(memory.as_mut_ptr().cast(), bytes, setup, &mut search, text, message.len())
        };
        if result == SKYFRONT_OK { Ok(search) } else { Err(result) }
    }

    /// The labels, or the error.
    fn labels(search: *mut skyfront_search, rows: usize) -> Result<Vec<u32>, i32> {
        let mut progress = skyfront_search_progress::default();
        while progress.done == 0 {
            // SAFETY: the run was started.
            match unsafe { skyfront_search_poll(search, rows, &mut progress) } {
                SKYFRONT_OK => assert!(progress.work <= progress.most_work),
                error => return Err(error),
            }
        }
        let mut labels = vec![0; WIDTH * HEIGHT];
        for (y, row) in labels.chunks_exact_mut(WIDTH).enumerate() {
            // SAFETY: a row has room for as many labels as there are columns.
            assert_eq!(unsafe { skyfront_search_labels(search, y, row.as_mut_ptr()) }, SKYFRONT_OK);
        }
        assert_eq!(labels.iter().max(), Some(&progress.sources));
        Ok(labels)
    }

    #[test]
    fn both_widths_of_pixels_give_the_same_labels_in_slices_of_any_size() {
        let (words, mut memory) = (counts(), memory());
        let bytes: Vec<u8> = words.iter().map(|&count| count as u8).collect();
        let setup = skyfront_search_setup { pixels_u16: words.as_ptr(), ..SETUP };
        let expected = started(&mut memory, &setup).and_then(|search| labels(search, 1)).expect("sources");
        assert!(expected.iter().any(|&label| label > 1));
        let setup = skyfront_search_setup { pixels_u8: bytes.as_ptr(), ..SETUP };
        let found = started(&mut memory, &setup).and_then(|search| labels(search, 100)).expect("sources");
        assert!(found == expected);
    }

    const CAMERA: skyfront_camera =
        skyfront_camera { black: 10.0, gain: 2.0, read_noise: 5.0, saturation: 100.0, psf_sigma: 1.0 };

    /// The catalogue in slices of so many rows, in memory for so many sources.
    fn catalogue(search: *mut skyfront_search, rows: usize, room: usize) -> Result<Vec<skyfront_measured>, i32> {
        let (mut memory, mut done) = (vec![0u64; skyfront_catalogue_bytes(room) / 8 + 1], 0);
        let (mut source, mut sources) = (skyfront_measured::default(), Vec::new());
        let bytes = size_of_val(&memory[..]);
        // SAFETY: the run was started, and the memory lives until the last source is told.
        unsafe {
            let ok = |result: i32| if result == SKYFRONT_OK { Ok(()) } else { Err(result) };
            ok(skyfront_search_measure_start(search, memory.as_mut_ptr().cast(), bytes))?;
            assert_eq!(skyfront_search_source(search, 0, &mut source), SKYFRONT_ERROR_NOT_DONE);
            while done == 0 {
                ok(skyfront_search_measure(search, rows, &mut done))?;
            }
            assert_eq!(skyfront_search_measure(search, rows, null_mut()), SKYFRONT_OK, "again");
            for index in 0.. {
                match skyfront_search_source(search, index, &mut source) {
                    SKYFRONT_OK => sources.push(source),
                    error => {
                        assert_eq!(error, SKYFRONT_ERROR_INDEX);
                        break;
                    }
                }
            }
        }
        Ok(sources)
    }

    /// The catalogue that the core has of the same frame.
    fn expected(words: &[u16], camera: &Camera) -> Vec<Sums> {
        let memory = vec![0u64; skyfront_search_bytes(WIDTH, HEIGHT, 0) / 8 + 1].leak();
        // SAFETY: the memory is this run's alone.
        let mut block = unsafe { Block::new(memory.as_mut_ptr().cast(), size_of_val(memory)) };
        let work = workspace(&mut block, &SETUP, Config::NOISE_AWARE.sky.cell()).expect("room");
        let frame = Raster::new(words, WIDTH, HEIGHT, STRIDE).expect("a frame");
        let bad = [BadPixel { x: 9, y: 3 }];
        let known = Known { bad: &bad, camera: Some(camera), ..Known::default() };
        let mut run = Extractor::over(&Config::NOISE_AWARE, frame, known, work).expect("room");
        let found = loop {
            if let Progress::Done(found) = run.poll(usize::MAX).expect("a sky with noise") {
                break found;
            }
        };
        let mut sums = vec![Sums::EMPTY; found.sources as usize];
        assert_eq!(run.measure(&mut Measuring::default(), usize::MAX, &mut sums), Ok(true));
        sums
    }

    #[test]
    fn the_catalogue_is_the_core_s_in_slices_of_any_size() {
        let (words, mut memory) = (counts(), memory());
        let setup = skyfront_search_setup { pixels_u16: words.as_ptr(), camera: &CAMERA, ..SETUP };
        let search = started(&mut memory, &setup).expect("memory enough");
        assert_eq!(catalogue(search, 1, 100), Err(SKYFRONT_ERROR_NOT_DONE));
        let all = labels(search, 100).expect("sources");
        let skyfront_camera { black, gain, read_noise, saturation, psf_sigma } = CAMERA;
        let expected = expected(&words, &Camera { black, gain, read_noise, saturation, psf_sigma });
        for rows in [1, 7, 1000] {
            let found = catalogue(search, rows, 100).expect("sources");
            assert_eq!(found.len(), expected.len());
            for (label, (source, sums)) in (1u32..).zip(found.iter().zip(&expected)) {
                let (centre, flux, levels) = (sums.centroid(), sums.flux(Some(2.0)), sums.levels());
                assert_eq!((source.label, source.area, source.flags), (label, sums.area, sums.flags()));
                assert_eq!(source.area as usize, all.iter().filter(|&&other| other == label).count());
                assert_eq!((source.columns, source.rows), (sums.columns.into(), sums.rows.into()));
                assert_eq!(Some((source.peak, source.peak_place.into())), sums.peak);
                assert_eq!(
                    (source.flux, source.flux_error, source.x, source.y),
                    (flux.value, flux.error, centre.x, centre.y)
                );
                assert_eq!((source.errx2, source.erry2, source.errxy), centre.errors);
                assert_eq!((source.x2, source.y2, source.xy), centre.moments);
                assert_eq!(
                    (source.background, source.noise, source.threshold),
                    (levels.background, levels.noise, levels.threshold)
                );
            }
        }
        // The camera is heard: without one nothing is saturated, and light has no noise of its own.
        let with = catalogue(search, 9, 100).expect("sources");
        let setup = skyfront_search_setup { camera: null(), ..setup };
        let search = started(&mut memory, &setup).expect("memory enough");
        assert_eq!(labels(search, 9), Ok(all));
        let without = catalogue(search, 9, 100).expect("sources");
        let saturated = |sources: &[skyfront_measured]| {
            sources.iter().filter(|source| source.flags & SKYFRONT_SOURCE_SATURATED != 0).count()
        };
        assert!(saturated(&without) == 0 && saturated(&with) > 0);
        let quieter = |(without, with): (&skyfront_measured, &skyfront_measured)| without.flux_error < with.flux_error;
        assert!(without.iter().zip(&with).all(quieter));
    }

    #[test]
    fn what_cannot_be_measured_is_a_number() {
        let (words, mut memory) = (counts(), memory());
        let dark = skyfront_camera { gain: 0.0, ..CAMERA };
        let setup = skyfront_search_setup { pixels_u16: words.as_ptr(), camera: &dark, ..SETUP };
        assert_eq!(started(&mut memory, &setup), Err(crate::error::SKYFRONT_ERROR_PARAMETER));
        let setup = skyfront_search_setup { camera: &CAMERA, ..setup };
        let search = started(&mut memory, &setup).expect("memory enough");
        let sources = labels(search, 100).expect("sources").into_iter().max().unwrap_or(0) as usize;
        assert!(sources > 1);
        assert_eq!(catalogue(search, 1, sources - 1), Err(SKYFRONT_ERROR_LENGTH));
        assert_eq!(catalogue(search, 1, sources).map(|all| all.len()), Ok(sources));
        let mut bytes: Vec<u8> = Vec::new();
        let (context, mut source): (*mut c_void, _) = ((&raw mut bytes).cast(), skyfront_measured::default());
        // SAFETY: the run was started, and the functions know their context.
        unsafe {
            assert_eq!(skyfront_search_measure_start(search, null_mut(), 0), SKYFRONT_ERROR_POINTER);
            assert_eq!(skyfront_search_measure_start(null_mut(), context, 0), SKYFRONT_ERROR_POINTER);
            assert_eq!(skyfront_search_measure(null_mut(), 1, null_mut()), SKYFRONT_ERROR_POINTER);
            assert_eq!(skyfront_search_source(search, 0, null_mut()), SKYFRONT_ERROR_POINTER);
            assert_eq!(skyfront_search_save(search, Some(write), context), SKYFRONT_OK);
            assert_eq!(skyfront_search_restore(search, Some(read), context), SKYFRONT_OK);
            assert_eq!(skyfront_search_source(search, 0, &mut source), SKYFRONT_ERROR_NOT_DONE, "it is another run");
        }
        assert_eq!(skyfront_catalogue_bytes(usize::MAX), 0);
    }

    #[test]
    fn what_takes_a_segmenter_is_refused() {
        let (words, mut memory) = (counts(), memory());
        for (name, value) in [(c"filter", c"median"), (c"scheme", c"fd")] {
            let setting = skyfront_setting { name: name.as_ptr(), value: value.as_ptr() };
            let setup =
                skyfront_search_setup { pixels_u16: words.as_ptr(), settings: &setting, setting_count: 1, ..SETUP };
            assert_eq!(started(&mut memory, &setup), Err(SKYFRONT_ERROR_FRONT), "{value:?}");
        }
    }

    unsafe extern "C" fn write(context: *mut c_void, bytes: *const u8, count: usize) -> i32 {
        // SAFETY: the tests give a vector as their context.
        let (to, bytes) = unsafe { (&mut *context.cast::<Vec<u8>>(), core::slice::from_raw_parts(bytes, count)) };
        to.extend_from_slice(bytes);
        0
    }

    unsafe extern "C" fn read(context: *mut c_void, bytes: *mut u8, count: usize) -> i32 {
        // SAFETY: as above.
        let (from, bytes) = unsafe { (&mut *context.cast::<Vec<u8>>(), core::slice::from_raw_parts_mut(bytes, count)) };
        if from.len() < count {
            return 1;
        }
        from.drain(..count).zip(bytes).for_each(|(from, to)| *to = from);
        0
    }

    #[test]
    fn a_run_is_saved_and_taken_up_again() {
        let (words, mut first, mut second) = (counts(), memory(), memory());
        let setup = skyfront_search_setup { pixels_u16: words.as_ptr(), ..SETUP };
        let search = started(&mut first, &setup).expect("memory enough");
        let mut bytes: Vec<u8> = Vec::new();
        let context: *mut c_void = (&raw mut bytes).cast();
        // SAFETY: the run was started, and the functions know their context.
        unsafe {
            (0..150).for_each(|_| assert_eq!(skyfront_search_poll(search, 3, null_mut()), SKYFRONT_OK));
            assert_eq!(skyfront_search_labels(search, 0, null_mut()), SKYFRONT_ERROR_NOT_DONE);
            assert_eq!(skyfront_search_save(search, Some(write), context), SKYFRONT_OK);
        }
        let expected = labels(search, 3);
        let search = started(&mut second, &setup).expect("memory enough");
        // SAFETY: the same.
        unsafe {
            assert_eq!(skyfront_search_restore(search, Some(read), context), SKYFRONT_OK);
            assert_eq!(labels(search, 7), expected);
            // Nothing is left to read.
            assert_eq!(skyfront_search_restore(search, Some(read), context), SKYFRONT_ERROR_NOT_RESTORED);
        }
        assert_eq!(labels(search, 7), Err(SKYFRONT_ERROR_NOT_RESTORED));
    }

    #[test]
    fn wrong_setups_and_overwritten_frames_are_numbers() {
        let (words, mut memory) = (counts(), memory());
        let setup = skyfront_search_setup { pixels_u16: words.as_ptr(), ..SETUP };
        assert_eq!(started(&mut memory[..100], &setup), Err(SKYFRONT_ERROR_LENGTH));
        assert_eq!(started(&mut memory, &SETUP), Err(SKYFRONT_ERROR_POINTER));
        let both = skyfront_search_setup { pixels_u8: words.as_ptr().cast(), ..setup };
        assert_eq!(started(&mut memory, &both), Err(SKYFRONT_ERROR_POINTER));
        let narrow = skyfront_search_setup { width: 7, ..setup };
        assert_eq!(started(&mut memory, &narrow), Err(crate::error::SKYFRONT_ERROR_SIZE));
        let frame: Vec<AtomicU16> = words.iter().map(|&count| AtomicU16::new(count)).collect();
        let setup = skyfront_search_setup { pixels_u16: frame.as_ptr().cast(), ..SETUP };
        let search = started(&mut memory, &setup).expect("memory enough");
        // SAFETY: the run was started.
        unsafe { (0..60).for_each(|_| assert_eq!(skyfront_search_poll(search, 9, null_mut()), SKYFRONT_OK)) };
        frame[5 * STRIDE].fetch_xor(1, core::sync::atomic::Ordering::Relaxed);
        assert_eq!(labels(search, 9), Err(SKYFRONT_ERROR_FRAME_CHANGED));
    }
}
