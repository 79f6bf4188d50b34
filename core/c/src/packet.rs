//! Packets for the ground.

use crate::error::{SKYFRONT_ERROR_NOT_DONE, SKYFRONT_ERROR_POINTER, SKYFRONT_OK, number};
use crate::pointer::{pixels_of, slice, slice_mut};
use crate::run::skyfront_run;
use crate::track::{same, skyfront_star, skyfront_window};
use core::mem::offset_of;
use skyfront_core::error::Error;
use skyfront_core::packet::{self, Cursor};
use skyfront_core::track::{Pixel, Raster, Star, Window};

/// The least bytes of a packet.
pub const SKYFRONT_PACKET_LEAST_BYTES: usize = 64;
/// The most bytes of a packet; of more memory only as much is used.
pub const SKYFRONT_PACKET_MOST_BYTES: usize = 65535;

const _: () = assert!(SKYFRONT_PACKET_LEAST_BYTES == packet::BYTES.0 && SKYFRONT_PACKET_MOST_BYTES == packet::BYTES.1);

/// Where the next packet of a product begins: {number of the product} before the first. A copy of it writes a
/// packet again.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct skyfront_cursor {
    /// The caller's number of the product, such as that of the frame.
    pub product: u32,
    /// Packets written.
    pub packet: u32,
    /// Stars, pixels of the map, or cut-outs written.
    pub item: u32,
    /// Pixels of the next cut-out written.
    pub pixel: u32,
}

same!(skyfront_cursor, Cursor: product, packet, item, pixel);

/// Where a packet goes.
struct Place {
    cursor: *mut skyfront_cursor,
    out: *mut u8,
    bytes: usize,
    length: *mut usize,
}

impl Place {
    /// Writes a packet by `next`.
    ///
    /// # Safety
    /// `cursor` and `length` point to one each or nowhere, `out` to `bytes` bytes.
    unsafe fn write(self, next: impl FnOnce(&mut Cursor, &mut [u8]) -> Result<Option<usize>, Error>) -> i32 {
        // SAFETY: the caller's promise; the cursor is the core's own (`same!`).
        let slices = unsafe {
            (slice_mut(self.cursor.cast::<Cursor>(), 1), slice_mut(self.out, self.bytes), slice_mut(self.length, 1))
        };
        let (Some([cursor]), Some(out), Some([length])) = slices else { return SKYFRONT_ERROR_POINTER };
        match next(cursor, out) {
            Ok(written) => {
                *length = written.unwrap_or(0);
                SKYFRONT_OK
            }
            Err(error) => number(&error),
        }
    }
}

/// Writes the next packet of stars to `out`, and its bytes to `length`: 0 where all are written.
///
/// # Safety
/// `cursor`, `stars`, `out` and `length` point to one cursor, `count` stars, `bytes` bytes and one number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_packet_stars(
    cursor: *mut skyfront_cursor,
    stars: *const skyfront_star,
    count: usize,
    out: *mut u8,
    bytes: usize,
    length: *mut usize,
) -> i32 {
    // SAFETY: the caller's promise; the records are the core's own.
    let Some(stars) = (unsafe { slice(stars.cast::<Star>(), count) }) else { return SKYFRONT_ERROR_POINTER };
    let place = Place { cursor, out, bytes, length };
    // SAFETY: the caller's promise.
    unsafe { place.write(|cursor, out| packet::stars(cursor, stars, out)) }
}

/// Writes the next packet of the map of labels of a run that has ended, as `skyfront_packet_stars` does.
///
/// # Safety
/// `run` was started; `cursor`, `out` and `length` as for `skyfront_packet_stars`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn skyfront_packet_labels(
    cursor: *mut skyfront_cursor,
    run: *const skyfront_run,
    out: *mut u8,
    bytes: usize,
    length: *mut usize,
) -> i32 {
    // SAFETY: the caller's promise.
    let Some(run) = (unsafe { run.as_ref() }) else { return SKYFRONT_ERROR_POINTER };
    let Some((width, height)) = run.labelled() else { return SKYFRONT_ERROR_NOT_DONE };
    let place = Place { cursor, out, bytes, length };
    let size = (width as u32, height as u32);
    // SAFETY: the caller's promise.
    unsafe { place.write(|cursor, out| packet::labels(cursor, size, |at| run.label(at), out)) }
}

/// Pointers and lengths of cut-outs.
struct Cut<P> {
    frame: (*const P, usize, usize, usize),
    windows: (*const skyfront_window, usize),
}

impl<P: Pixel> Cut<P> {
    /// # Safety
    /// Every pointer is null or points to as many elements as its length says.
    unsafe fn write(self, place: Place) -> i32 {
        let (pixels, width, height, stride) = self.frame;
        // SAFETY: the caller's promise; the windows are the core's own.
        let slices = unsafe {
            (slice(pixels, pixels_of(width, height, stride)), slice(self.windows.0.cast::<Window>(), self.windows.1))
        };
        let (Some(pixels), Some(windows)) = slices else { return SKYFRONT_ERROR_POINTER };
        match Raster::new(pixels, width, height, stride) {
            // SAFETY: the caller's promise.
            Ok(frame) => unsafe { place.write(|cursor, out| packet::cutouts(cursor, &frame, windows, out)) },
            Err(error) => number(&error),
        }
    }
}

/// Writes the next packet of cut-outs, the parts of windows that lie in a frame of 16 bits per pixel, as
/// `skyfront_packet_stars` does.
///
/// # Safety
/// `pixels` points to `stride * (height - 1) + width` pixels, `windows` to `window_count` windows; `cursor`, `out` and
/// `length` as for `skyfront_packet_stars`.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "pointers and lengths of C")]
pub unsafe extern "C" fn skyfront_packet_cutouts_u16(
    cursor: *mut skyfront_cursor,
    pixels: *const u16,
    width: usize,
    height: usize,
    stride: usize,
    windows: *const skyfront_window,
    window_count: usize,
    out: *mut u8,
    bytes: usize,
    length: *mut usize,
) -> i32 {
    let cut = Cut { frame: (pixels, width, height, stride), windows: (windows, window_count) };
    // SAFETY: the caller's promise is the same.
    unsafe { cut.write(Place { cursor, out, bytes, length }) }
}

/// The same of a frame of 8 bits per pixel.
///
/// # Safety
/// As for `skyfront_packet_cutouts_u16`.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "pointers and lengths of C")]
pub unsafe extern "C" fn skyfront_packet_cutouts_u8(
    cursor: *mut skyfront_cursor,
    pixels: *const u8,
    width: usize,
    height: usize,
    stride: usize,
    windows: *const skyfront_window,
    window_count: usize,
    out: *mut u8,
    bytes: usize,
    length: *mut usize,
) -> i32 {
    let cut = Cut { frame: (pixels, width, height, stride), windows: (windows, window_count) };
    // SAFETY: the caller's promise is the same.
    unsafe { cut.write(Place { cursor, out, bytes, length }) }
}
