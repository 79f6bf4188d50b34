//! Segmentation in slices of bounded work, in one block of the caller's memory.

use crate::error::{
    Message, SKYFRONT_ERROR_INDEX, SKYFRONT_ERROR_LENGTH, SKYFRONT_ERROR_NOT_DONE, SKYFRONT_ERROR_POINTER,
    SKYFRONT_ERROR_PRESET, SKYFRONT_ERROR_SETTING, SKYFRONT_ERROR_TABLE, SKYFRONT_OK, number,
};
use crate::memory::{ALIGNMENT, Block, slices};
use crate::pointer::{pixels_of, slice, slice_mut, text};
use core::ffi::{c_char, c_void};
use core::fmt::{Display, Write};
use skyfront_core::arithmetic::{Cell, F32};
use skyfront_core::config::bytes::{TableError, length};
use skyfront_core::config::{Config, Parameter};
use skyfront_core::run::frame::Frame;
use skyfront_core::run::memory::{Memory, SEGMENTER_BYTES, flags_len, ring_cells};
use skyfront_core::run::outcome::{Outcome, Progress};
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::sky::otsu::Histogram;
use skyfront_core::sources::catalog::Source;
use skyfront_core::track::Pixel;
use skyfront_machine::Processor;

/// The parameter table of the setup.
pub const SKYFRONT_PRESET_TABLE: u32 = 0;
/// The paper's setting for frames that are nearly noiseless.
pub const SKYFRONT_PRESET_PAPER_F160: u32 = 1;
/// The paper's setting for real frames.
pub const SKYFRONT_PRESET_PAPER_REAL: u32 = 2;

/// Bytes of a run beside its planes, rows and sources, at most.
pub const SKYFRONT_RUN_FIXED_BYTES: usize = 4096;
/// Bytes of a source in a run's memory, at most.
pub const SKYFRONT_SOURCE_BYTES: usize = 112;

const _: () = assert!(size_of::<Source>() <= SKYFRONT_SOURCE_BYTES);
const _: () = assert!(size_of::<skyfront_run>() <= SEGMENTER_BYTES + size_of::<Outcome>() + 64);

/// A run, in the caller's memory.
pub struct skyfront_run {
    segmenter: Segmenter<'static, F32<Processor>>,
    size: (usize, usize),
    outcome: Option<Outcome>,
}

/// A setting by its name, as `skyfront parameters` lists them: {"t-max", "30"}.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct skyfront_setting {
    /// The name.
    pub name: *const c_char,
    /// The value.
    pub value: *const c_char,
}

/// What a run is to do.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct skyfront_setup {
    /// SKYFRONT_PRESET_...
    pub preset: u32,
    /// Columns of the frame.
    pub width: usize,
    /// Rows of the frame.
    pub height: usize,
    /// The most sources that are catalogued; more are counted.
    pub sources: usize,
    /// Settings other than the preset's; null for none.
    pub settings: *const skyfront_setting,
    /// How many.
    pub setting_count: usize,
    /// A parameter table, for SKYFRONT_PRESET_TABLE; else null.
    pub table: *const u8,
    /// Its bytes.
    pub table_bytes: usize,
}

/// How far a run is, and at its end what it found.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct skyfront_progress {
    /// 1 when all is done, else 0.
    pub done: u32,
    /// Rows of work done.
    pub rows: u32,
    /// The most rows of work that there can be.
    pub most_rows: u32,
    /// Steps that the front took; 0 before the end, as all that follows.
    pub steps: u32,
    /// Sources.
    pub sources: u32,
    /// Sources in the catalogue; fewer where it was too short.
    pub catalogued: u32,
    /// Pixels inside the outlines.
    pub mask_pixels: u32,
    /// Pixels inside the outlines without a label, because the table of labels was full.
    pub unlabelled: u32,
}

/// A source: the mean of its pixels' places weighted by their light, and its ellipse.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct skyfront_source {
    /// Its label in the map, from 1.
    pub label: u32,
    /// Pixels.
    pub area: u32,
    /// Column of the centre, pixels.
    pub x: f32,
    /// Row of the centre, pixels.
    pub y: f32,
    /// Sum of its pixels, counts.
    pub sum: f32,
    /// Its greatest pixel, counts.
    pub peak: f32,
    /// Root mean square along the major axis, pixels.
    pub a: f32,
    /// Root mean square along the minor axis, pixels.
    pub b: f32,
    /// From the x axis to the major axis, radians.
    pub theta: f32,
    /// First and last column.
    pub columns: [u32; 2],
    /// First and last row.
    pub rows: [u32; 2],
}

/// Writes row `y` of the frame, `width` pixels, to `out` and returns 0; another number stops the call, which can
/// be made again. A pixel that is not finite is undefined.
pub type skyfront_row =
    Option<unsafe extern "C" fn(context: *mut c_void, y: usize, out: *mut f32, width: usize) -> i32>;

/// Bytes that a run needs; 0 where they cannot be counted.
#[unsafe(no_mangle)]
pub extern "C" fn skyfront_run_bytes(width: usize, height: usize, sources: usize) -> usize {
    match slices(width, height, sources) {
        0 => 0,
        bytes => bytes.saturating_add(size_of::<skyfront_run>()).saturating_add(ALIGNMENT),
    }
}

/// Sets up a run in `memory` of at least `skyfront_run_bytes()` bytes, which belongs to the run from now on and
/// must not be moved; there is nothing to be freed. `run` takes the run, `message` (null for none) what is wrong
/// in words, cut to `message_bytes`.
///
/// # Safety
/// `memory` points to `bytes` bytes, `setup` to a setup whose settings are texts that end with a zero, `run` to a
/// pointer, `message` to `message_bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_run_start(
    memory: *mut c_void,
    bytes: usize,
    setup: *const skyfront_setup,
    run: *mut *mut skyfront_run,
    message: *mut c_char,
    message_bytes: usize,
) -> i32 {
    // SAFETY: the caller's promise; the setup's settings are as the caller promised.
    unsafe {
        begin((memory, bytes), setup, run, (message, message_bytes), |block, setup, message| {
            start(block, setup, message)
        })
    }
}

/// Starts in the caller's memory what a setup asks for, gives it to `started` and says in words what is wrong.
///
/// # Safety
/// `memory` points to so many bytes, which stay with what is started; `setup` to a setup, `started` to a pointer and
/// `message`, if not null, to so many bytes.
pub(crate) unsafe fn begin<S, R>(
    (memory, bytes): (*mut c_void, usize),
    setup: *const S,
    started: *mut *mut R,
    (message, message_bytes): (*mut c_char, usize),
    start: impl FnOnce(Block, &S, &mut Message<'_>) -> Result<*mut R, i32>,
) -> i32 {
    // SAFETY: the caller's promise.
    let given = unsafe { (slice(setup, 1), slice_mut(started, 1), buffer(message, message_bytes)) };
    let (Some([setup]), Some([started]), Some(buffer)) = given else { return SKYFRONT_ERROR_POINTER };
    if memory.is_null() {
        return SKYFRONT_ERROR_POINTER;
    }
    // SAFETY: the memory is the caller's to give, and stays with the run.
    let block = unsafe { Block::new(memory.cast(), bytes) };
    match start(block, setup, &mut Message { buffer, length: 0 }) {
        Ok(run) => {
            *started = run;
            SKYFRONT_OK
        }
        Err(error) => error,
    }
}

/// Says in words what is wrong.
pub(crate) fn tell(message: &mut Message<'_>, what: &dyn Display) {
    // A message that has no room is cut.
    let _ = write!(message, "{what}");
}

/// # Safety
/// The settings are texts that end with a zero.
unsafe fn start(mut block: Block, setup: &skyfront_setup, message: &mut Message<'_>) -> Result<*mut skyfront_run, i32> {
    // SAFETY: the caller's promise.
    let config = unsafe { config(setup, message)? };
    let (width, height) = (setup.width, setup.height);
    let place = block.take::<skyfront_run>(1);
    let (Some(place), Some(memory)) = (place, memory(&mut block, setup)) else {
        tell(message, &format_args!("{} bytes are needed", skyfront_run_bytes(width, height, setup.sources)));
        return Err(SKYFRONT_ERROR_LENGTH);
    };
    let segmenter = Segmenter::new(&config, width, height, memory).map_err(|error| {
        tell(message, &error);
        number(&error)
    })?;
    // SAFETY: the place is aligned and has room for one run.
    unsafe { place.write(skyfront_run { segmenter, size: (width, height), outcome: None }) };
    Ok(place)
}

/// The slices of a run; none where the block is too small.
fn memory(block: &mut Block, setup: &skyfront_setup) -> Option<Memory<'static, F32<Processor>>> {
    let (width, height) = (setup.width, setup.height);
    if slices(width, height, setup.sources) == 0 {
        return None;
    }
    let pixels = width.checked_mul(height)?;
    let [counts] = block.filled(1, Histogram::EMPTY)? else { return None };
    Some(Memory {
        image: block.filled(pixels, 0.0)?,
        front: block.filled(pixels, 0.0)?,
        ring: block.filled(ring_cells(width, true), 0.0)?,
        tiles: block.filled(flags_len(width, height), 0)?,
        samples: block.filled(width, 0.0)?,
        counts,
        sources: block.filled(setup.sources, Source::empty(0))?,
    })
}

/// The preset with the settings.
///
/// # Safety
/// The settings are texts that end with a zero.
unsafe fn config(setup: &skyfront_setup, message: &mut Message<'_>) -> Result<Config, i32> {
    let mut config = match setup.preset {
        // SAFETY: the caller's promise.
        SKYFRONT_PRESET_TABLE => read(unsafe { slice(setup.table, setup.table_bytes) }, message)?,
        SKYFRONT_PRESET_PAPER_F160 => Config::PAPER_F160.with_time_for(setup.width, setup.height),
        SKYFRONT_PRESET_PAPER_REAL => Config::PAPER_REAL.with_time_for(setup.width, setup.height),
        _ => return Err(SKYFRONT_ERROR_PRESET),
    };
    // SAFETY: the caller's promise.
    unsafe { set(&mut config, setup.settings, setup.setting_count, message)? };
    Ok(config)
}

/// Changes settings.
///
/// # Safety
/// They are texts that end with a zero.
pub(crate) unsafe fn set(
    config: &mut Config,
    settings: *const skyfront_setting,
    count: usize,
    message: &mut Message<'_>,
) -> Result<(), i32> {
    // SAFETY: the caller's promise.
    let settings = unsafe { slice(settings, count) }.ok_or(SKYFRONT_ERROR_POINTER)?;
    for setting in settings {
        // SAFETY: the caller's promise.
        let (name, value) = unsafe { (text(setting.name), text(setting.value)) };
        let (Some(name), Some(value)) = (name, value) else { return Err(SKYFRONT_ERROR_POINTER) };
        let Some((parameter, value)) = Parameter::named(name).and_then(|known| Some((known, known.parse(value)?)))
        else {
            tell(message, &format_args!("{name} {value}"));
            return Err(SKYFRONT_ERROR_SETTING);
        };
        parameter.set(config, value).map_err(|error| {
            tell(message, &error);
            number(&error)
        })?;
    }
    Ok(())
}

/// The configuration of a parameter table.
fn read(bytes: Option<&[u8]>, message: &mut Message<'_>) -> Result<Config, i32> {
    Config::from_bytes(bytes.ok_or(SKYFRONT_ERROR_POINTER)?).map_err(|error| {
        tell(message, &error);
        match error {
            TableError::Length { .. } => SKYFRONT_ERROR_LENGTH,
            TableError::Foreign { .. } | TableError::Damaged => SKYFRONT_ERROR_TABLE,
            TableError::Form { .. } => SKYFRONT_ERROR_SETTING,
            TableError::Value(error) => number(&error),
        }
    })
}

/// Bytes of a parameter table.
#[unsafe(no_mangle)]
pub extern "C" fn skyfront_table_bytes() -> usize {
    length()
}

/// Writes the parameters of a setup as a parameter table of `skyfront_table_bytes()` bytes, with a CRC-32 at its
/// end: what is made on the ground and loaded on board. `message` as for `skyfront_run_start`.
///
/// # Safety
/// `setup` points to a setup whose settings are texts that end with a zero, `table` to `table_bytes` bytes,
/// `message` to `message_bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_table_write(
    setup: *const skyfront_setup,
    table: *mut u8,
    table_bytes: usize,
    message: *mut c_char,
    message_bytes: usize,
) -> i32 {
    // SAFETY: the caller's promise.
    let given = unsafe { (slice(setup, 1), slice_mut(table, table_bytes), buffer(message, message_bytes)) };
    let (Some([setup]), Some(table), Some(buffer)) = given else { return SKYFRONT_ERROR_POINTER };
    let mut message = Message { buffer, length: 0 };
    // SAFETY: the caller's promise.
    let written = unsafe { config(setup, &mut message) }.and_then(|config| {
        let checked = config.validate_values().and_then(|()| config.to_bytes(table));
        checked.map_err(|error| {
            tell(&mut message, &error);
            number(&error)
        })
    });
    written.map_or_else(|error| error, |()| SKYFRONT_OK)
}

/// Checks a parameter table: length, version, CRC-32, and every value against its bounds.
///
/// # Safety
/// `table` points to `table_bytes` bytes, `message` to `message_bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_table_check(
    table: *const u8,
    table_bytes: usize,
    message: *mut c_char,
    message_bytes: usize,
) -> i32 {
    // SAFETY: the caller's promise.
    let (table, buffer) = unsafe { (slice(table, table_bytes), buffer(message, message_bytes)) };
    let Some(buffer) = buffer else { return SKYFRONT_ERROR_POINTER };
    let mut message = Message { buffer, length: 0 };
    read(table, &mut message).map_or_else(|error| error, |_| SKYFRONT_OK)
}

/// The caller's room for a message; none wanted has no bytes.
///
/// # Safety
/// Where it is not null, `message` points to `bytes` bytes.
pub(crate) unsafe fn buffer<'a>(message: *mut c_char, bytes: usize) -> Option<&'a mut [u8]> {
    // SAFETY: the caller's promise.
    unsafe { slice_mut(message.cast::<u8>(), if message.is_null() { 0 } else { bytes }) }
}

/// Rows from a buffer of pixels.
struct Rows<'a, P> {
    pixels: &'a [P],
    stride: usize,
}

impl<P: Pixel> Frame for Rows<'_, P> {
    type Error = i32;

    fn row(&mut self, y: usize, out: &mut [f32]) -> Result<(), i32> {
        let start = y.saturating_mul(self.stride);
        let row = self.pixels.get(start..start.saturating_add(out.len())).ok_or(SKYFRONT_ERROR_LENGTH)?;
        out.iter_mut().zip(row).for_each(|(out, pixel)| *out = f32::from(pixel.count()));
        Ok(())
    }
}

/// Rows from a function.
struct Callback {
    row: unsafe extern "C" fn(*mut c_void, usize, *mut f32, usize) -> i32,
    context: *mut c_void,
}

impl Frame for Callback {
    type Error = i32;

    fn row(&mut self, y: usize, out: &mut [f32]) -> Result<(), i32> {
        // SAFETY: the caller's function writes `width` numbers at most, as its type says.
        let result = unsafe { (self.row)(self.context, y, out.as_mut_ptr(), out.len()) };
        if result == 0 { Ok(()) } else { Err(result) }
    }
}

impl skyfront_run {
    /// Columns and rows of the map of labels; none before the end.
    pub(crate) fn labelled(&self) -> Option<(usize, usize)> {
        self.outcome.is_some().then_some(self.size)
    }

    /// The label at a place in row-major order.
    pub(crate) fn label(&self, at: usize) -> u32 {
        self.segmenter.front().get(at).map_or(0, |cell| cell.label())
    }

    fn poll(
        &mut self,
        rows: usize,
        frame: &mut impl Frame<Error = i32>,
        progress: Option<&mut skyfront_progress>,
    ) -> i32 {
        let mut now = skyfront_progress::default();
        match self.segmenter.poll(rows, frame) {
            Err(error) => return number(&error),
            Ok(Progress::Working { .. }) => {}
            Ok(Progress::Done(outcome)) => {
                self.outcome = Some(outcome);
                let Outcome { steps, sources, catalogued, mask_pixels, unlabelled, .. } = outcome;
                now = skyfront_progress { done: 1, steps, sources, catalogued, mask_pixels, unlabelled, ..now };
            }
        }
        let (work, most) = self.segmenter.work();
        let word = |number: u64| u32::try_from(number).unwrap_or(u32::MAX);
        (now.rows, now.most_rows) = (word(work), word(most));
        if let Some(progress) = progress {
            *progress = now;
        }
        SKYFRONT_OK
    }
}

/// # Safety
/// `run` is null or was started, `pixels` points to the frame's pixels, `progress` to a progress or nowhere.
unsafe fn poll_pixels<P: Pixel>(
    run: *mut skyfront_run,
    rows: usize,
    (pixels, stride): (*const P, usize),
    progress: *mut skyfront_progress,
) -> i32 {
    // SAFETY: the caller's promise.
    let Some(run) = (unsafe { run.as_mut() }) else { return SKYFRONT_ERROR_POINTER };
    let (width, height) = run.size;
    if stride < width {
        return SKYFRONT_ERROR_LENGTH;
    }
    // SAFETY: the caller's promise.
    match unsafe { slice(pixels, pixels_of(width, height, stride)) } {
        // SAFETY: the caller's promise.
        Some(pixels) => run.poll(rows, &mut Rows { pixels, stride }, unsafe { progress.as_mut() }),
        None => SKYFRONT_ERROR_POINTER,
    }
}

/// Does at most `rows` rows of the run on a frame of 16 bits per pixel, in the processor's byte order, whose rows
/// are `stride` pixels apart. The same results come out whatever the slices. `progress` may be null.
///
/// # Safety
/// `run` was started; `pixels` points to `stride * (height - 1) + width` pixels, the same in every call of a run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_run_poll_u16(
    run: *mut skyfront_run,
    rows: usize,
    pixels: *const u16,
    stride: usize,
    progress: *mut skyfront_progress,
) -> i32 {
    // SAFETY: the caller's promise is the same.
    unsafe { poll_pixels(run, rows, (pixels, stride), progress) }
}

/// The same on a frame of 8 bits per pixel.
///
/// # Safety
/// As for `skyfront_run_poll_u16`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_run_poll_u8(
    run: *mut skyfront_run,
    rows: usize,
    pixels: *const u8,
    stride: usize,
    progress: *mut skyfront_progress,
) -> i32 {
    // SAFETY: the caller's promise is the same.
    unsafe { poll_pixels(run, rows, (pixels, stride), progress) }
}

/// The same on rows that a function delivers, whenever they are asked for and always the same; `context` is passed
/// on to it. When it returns another number than 0 the result is SKYFRONT_ERROR_FRAME.
///
/// # Safety
/// `run` was started; `row` writes no more than it is asked for, and does not touch the run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_run_poll_rows(
    run: *mut skyfront_run,
    rows: usize,
    row: skyfront_row,
    context: *mut c_void,
    progress: *mut skyfront_progress,
) -> i32 {
    // SAFETY: the caller's promise.
    match (unsafe { run.as_mut() }, row) {
        // SAFETY: the same.
        (Some(run), Some(row)) => run.poll(rows, &mut Callback { row, context }, unsafe { progress.as_mut() }),
        _ => SKYFRONT_ERROR_POINTER,
    }
}

/// Row `y` of the map of labels of a run that has ended, `width` of them; 0 is the background.
///
/// # Safety
/// `run` was started; `labels` points to as many numbers as the frame has columns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_run_labels(run: *const skyfront_run, y: usize, labels: *mut u32) -> i32 {
    // SAFETY: the caller's promise.
    let Some(run) = (unsafe { run.as_ref() }) else { return SKYFRONT_ERROR_POINTER };
    if run.outcome.is_none() {
        return SKYFRONT_ERROR_NOT_DONE;
    }
    let width = run.size.0;
    // SAFETY: the caller's promise.
    let Some(labels) = (unsafe { slice_mut(labels, width) }) else { return SKYFRONT_ERROR_POINTER };
    let start = y.saturating_mul(width);
    match run.segmenter.front().get(start..start.saturating_add(width)) {
        Some(row) => {
            labels.iter_mut().zip(row).for_each(|(label, cell)| *label = cell.label());
            SKYFRONT_OK
        }
        None => SKYFRONT_ERROR_INDEX,
    }
}

/// A source of a run that has ended, `index` counting from 0.
///
/// # Safety
/// `run` was started; `source` points to a source.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_run_source(
    run: *const skyfront_run,
    index: usize,
    source: *mut skyfront_source,
) -> i32 {
    // SAFETY: the caller's promise.
    let (Some(run), Some(to)) = (unsafe { (run.as_ref(), source.as_mut()) }) else { return SKYFRONT_ERROR_POINTER };
    if run.outcome.is_none() {
        return SKYFRONT_ERROR_NOT_DONE;
    }
    let Some(source) = run.segmenter.catalog().get(index) else { return SKYFRONT_ERROR_INDEX };
    let (x, y) = source.centroid();
    let ellipse = source.ellipse();
    *to = skyfront_source {
        label: source.label,
        area: source.area,
        x,
        y,
        sum: source.sum(),
        peak: source.peak,
        a: ellipse.a,
        b: ellipse.b,
        theta: ellipse.theta,
        columns: source.columns.into(),
        rows: source.rows.into(),
    };
    SKYFRONT_OK
}
