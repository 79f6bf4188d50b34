//! Stars in windows.

use crate::error::{SKYFRONT_ERROR_POINTER, SKYFRONT_OK, number};
use crate::pointer::{pixels_of, slice, slice_mut};
use core::mem::offset_of;
use skyfront_core::arithmetic::F32;
use skyfront_core::track::{self, BadPixel, Camera, Pixel, Raster, Star, Window};
use skyfront_machine::Processor;

/// The window reaches beyond the frame, so that it is cut off.
pub const SKYFRONT_STAR_EDGE: u32 = 1;
/// A pixel of the star reaches the camera's saturation; it is left out.
pub const SKYFRONT_STAR_SATURATED: u32 = 2;
/// A pixel of the star is listed as bad or is brighter than its neighbours allow; it is left out.
pub const SKYFRONT_STAR_HOT: u32 = 4;
/// Another source is near the star.
pub const SKYFRONT_STAR_BLENDED: u32 = 8;
/// No star is in the window: place as predicted, infinite variances.
pub const SKYFRONT_STAR_LOST: u32 = 16;

const _: () = assert!(
    SKYFRONT_STAR_EDGE == track::EDGE
        && SKYFRONT_STAR_SATURATED == track::SATURATED
        && SKYFRONT_STAR_HOT == track::HOT
        && SKYFRONT_STAR_BLENDED == track::BLENDED
        && SKYFRONT_STAR_LOST == track::LOST
);

/// What is known of the camera.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct skyfront_camera {
    /// The value of a pixel without light, counts, 0 to 65536.
    pub black: f32,
    /// Electrons per count, 0.001 to 10^6.
    pub gain: f32,
    /// Noise of a pixel without light, electrons, 0 to 10^6.
    pub read_noise: f32,
    /// Pixels from this value on are saturated, counts, 0 to 65536.
    pub saturation: f32,
    /// Standard deviation of a star's image, pixels, 0.5 to 3.
    pub psf_sigma: f32,
}

/// Where a star is expected, and how far around to look.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct skyfront_window {
    /// Predicted column of the star, pixels.
    pub x: f32,
    /// Predicted row of the star, pixels.
    pub y: f32,
    /// Columns, 8 to 64.
    pub width: u16,
    /// Rows, 8 to 64.
    pub height: u16,
}

/// A pixel that is never to be used.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct skyfront_bad_pixel {
    /// Its column.
    pub x: u16,
    /// Its row.
    pub y: u16,
}

/// What a window holds, in 32 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct skyfront_star {
    /// Column of the centre, pixels.
    pub x: f32,
    /// Row of the centre, pixels.
    pub y: f32,
    /// All light of the star, counts.
    pub flux: f32,
    /// The flux over its standard deviation.
    pub snr: f32,
    /// Variance of x, pixels squared.
    pub errx2: f32,
    /// Variance of y, pixels squared.
    pub erry2: f32,
    /// Covariance of x and y, pixels squared.
    pub errxy: f32,
    /// SKYFRONT_STAR_... together.
    pub flags: u32,
}

/// Asserts that a record of C is the core's: the same fields at the same places.
macro_rules! same {
    ($name:ident, $core:ident: $($field:ident),+) => {
        const _: () = assert!(size_of::<$name>() == size_of::<$core>() && align_of::<$name>() == align_of::<$core>());
        $(const _: () = assert!(offset_of!($name, $field) == offset_of!($core, $field));)+
        // The types too: a function of one record's fields that gives the other.
        const _: fn($name) -> $core = |record| $core { $($field: record.$field),+ };
    };
}

pub(crate) use same;

same!(skyfront_camera, Camera: black, gain, read_noise, saturation, psf_sigma);
same!(skyfront_window, Window: x, y, width, height);
same!(skyfront_bad_pixel, BadPixel: x, y);
same!(skyfront_star, Star: x, y, flux, snr, errx2, erry2, errxy, flags);

/// Pointers and lengths of a call.
struct Call<P> {
    frame: (*const P, usize, usize, usize),
    camera: *const skyfront_camera,
    windows: (*const skyfront_window, usize),
    bad: (*const skyfront_bad_pixel, usize),
    stars: *mut skyfront_star,
}

impl<P: Pixel> Call<P> {
    /// Centres the stars.
    ///
    /// # Safety
    /// Every pointer is null or points to as many elements as its length says, one per window for the stars.
    unsafe fn run(self) -> i32 {
        let (pixels, width, height, stride) = self.frame;
        // SAFETY: the caller's promise; the records are the core's own (`same!`), the camera one element.
        let slices = unsafe {
            (
                slice(pixels, pixels_of(width, height, stride)),
                slice(self.camera.cast::<Camera>(), 1),
                slice(self.windows.0.cast::<Window>(), self.windows.1),
                slice(self.bad.0.cast::<BadPixel>(), self.bad.1),
                slice_mut(self.stars.cast::<Star>(), self.windows.1),
            )
        };
        let (Some(pixels), Some([camera]), Some(windows), Some(bad), Some(stars)) = slices else {
            return SKYFRONT_ERROR_POINTER;
        };
        let tracked = Raster::new(pixels, width, height, stride)
            .and_then(|frame| track::track::<F32<Processor>, P>(&frame, windows, camera, bad, stars));
        tracked.map_or_else(|error| number(&error), |()| SKYFRONT_OK)
    }
}

/// Centres the brightest star of each window on a frame of 16 bits per pixel, in the processor's byte order.
/// `stride` is the number of pixels from one row to the next; `stars` takes a record for each window. After an
/// error nothing has been written.
///
/// # Safety
/// `pixels` points to `stride * (height - 1) + width` pixels, `camera` to a camera, `windows`, `bad_pixels` and
/// `stars` to as many elements as there are windows, bad pixels and windows.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "pointers and lengths of C")]
pub unsafe extern "C" fn skyfront_track_u16(
    pixels: *const u16,
    width: usize,
    height: usize,
    stride: usize,
    camera: *const skyfront_camera,
    windows: *const skyfront_window,
    window_count: usize,
    bad_pixels: *const skyfront_bad_pixel,
    bad_pixel_count: usize,
    stars: *mut skyfront_star,
) -> i32 {
    let (windows, bad) = ((windows, window_count), (bad_pixels, bad_pixel_count));
    // SAFETY: the caller's promise is the same.
    unsafe { Call { frame: (pixels, width, height, stride), camera, windows, bad, stars }.run() }
}

/// The same on a frame of 8 bits per pixel.
///
/// # Safety
/// As for `skyfront_track_u16`.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "pointers and lengths of C")]
pub unsafe extern "C" fn skyfront_track_u8(
    pixels: *const u8,
    width: usize,
    height: usize,
    stride: usize,
    camera: *const skyfront_camera,
    windows: *const skyfront_window,
    window_count: usize,
    bad_pixels: *const skyfront_bad_pixel,
    bad_pixel_count: usize,
    stars: *mut skyfront_star,
) -> i32 {
    let (windows, bad) = ((windows, window_count), (bad_pixels, bad_pixel_count));
    // SAFETY: the caller's promise is the same.
    unsafe { Call { frame: (pixels, width, height, stride), camera, windows, bad, stars }.run() }
}
