//! Stars in windows: where a star tracker expects them, to a fraction of a pixel, with their errors.
//!
//! [`track`] takes predicted places and gives one [`Star`] for each. The centre is that of a Gaussian window,
//! the PSF's, moved until the window sees the star in its middle. Each pixel counts by its noise, sky and
//! star together, and what the window would see of a star that is exactly in its middle is taken off, so that
//! neither coarse sampling nor pixels left out draw the centre aside. That is Fisher scoring (S. M. Kay,
//! Fundamentals of Statistical Signal Processing: Estimation Theory, 1993, section 7.7) for a Gaussian of
//! known width over a level sky, and the errors are the inverse of its information: for such stars of S/N
//! above 20 the error is at most 1.15 of the Cramer-Rao bound at a width of 0.7 to 1.5 pixels, and within
//! 10 % of what the covariance says.
//!
//! Work per window: the border 16 times (8 for a byte per pixel), the window three times, and at most
//! [`STEPS`] times the pixels within three widths of the star. Memory: less than two kilobytes of stack.

mod fit;
mod solve;
#[deny(clippy::arithmetic_side_effects)]
mod window;

pub use crate::plane::camera::Camera;
pub use crate::plane::raster::{BadPixel, Pixel, Raster};
pub use fit::STEPS;
pub use window::Window;

use crate::arithmetic::Arithmetic;
use crate::error::Error;
use fit::Fit;
use window::View;

/// The least and the greatest width and height of a window, pixels.
pub const SIDES: (u16, u16) = (crate::plane::raster::LEAST_SIDE, 64);
/// A star below this signal-to-noise is lost: in a window of 64 x 64 the highest of the noise is at 4.5.
pub const LEAST_SNR: f32 = 5.0;

/// The window reaches beyond the frame, so that it is cut off.
pub const EDGE: u32 = 1;
/// A pixel of the star reaches the camera's saturation; it is left out.
pub const SATURATED: u32 = 1 << 1;
/// A pixel of the star is listed as bad or is brighter than its neighbours allow; it is left out.
pub const HOT: u32 = 1 << 2;
/// A pixel near the star is brighter than star, sky and noise together by a fifth of the star's peak.
pub const BLENDED: u32 = 1 << 3;
/// No star of [`LEAST_SNR`] is in the window, or its centre does not settle inside: place as predicted.
pub const LOST: u32 = 1 << 4;

/// What a window holds. Pixel centres have whole coordinates from (0, 0), the frame's first pixel.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Star {
    /// Column of the centre, pixels.
    pub x: f32,
    /// Row of the centre, pixels.
    pub y: f32,
    /// All light of the star, counts; 0 where it is lost.
    pub flux: f32,
    /// The flux over its standard deviation.
    pub snr: f32,
    /// Variance of `x`, pixels squared; infinite where the star is lost, so that it weighs nothing.
    pub errx2: f32,
    /// Variance of `y`.
    pub erry2: f32,
    /// Covariance of `x` and `y`.
    pub errxy: f32,
    /// [`EDGE`], [`SATURATED`], [`HOT`], [`BLENDED`], [`LOST`].
    pub flags: u32,
}

const _: () = assert!(size_of::<Star>() == 32, "a record of the size that is promised");

impl Star {
    /// Nothing yet: for the caller's memory.
    pub const EMPTY: Star = Star { x: 0.0, y: 0.0, flux: 0.0, snr: 0.0, errx2: 0.0, erry2: 0.0, errxy: 0.0, flags: 0 };

    fn lost(window: &Window, flags: u32) -> Star {
        let errors = f32::INFINITY;
        Star { x: window.x, y: window.y, errx2: errors, erry2: errors, flags: flags | LOST, ..Star::EMPTY }
    }
}

/// Centres the brightest star of each window; `out` takes one [`Star`] per window, in their order.
///
/// A window that holds nothing usable gives a lost star and no error. `bad_pixels` need no order; each window
/// looks through all of them.
///
/// # Errors
/// [`Error::Parameter`] for a camera or window out of bounds, [`Error::Length`] for an `out` shorter than
/// `windows`; nothing is written then.
pub fn track<A: Arithmetic, P: Pixel>(
    frame: &Raster<'_, P>,
    windows: &[Window],
    camera: &Camera,
    bad_pixels: &[BadPixel],
    out: &mut [Star],
) -> Result<(), Error> {
    camera.validate()?;
    windows.iter().try_for_each(Window::validate)?;
    if out.len() < windows.len() {
        return Err(Error::Length { name: "stars", given: out.len(), needed: windows.len() });
    }
    for (star, window) in out.iter_mut().zip(windows) {
        *star = one::<A, P>(frame, window, camera, bad_pixels);
    }
    Ok(())
}

fn one<A: Arithmetic, P: Pixel>(frame: &Raster<'_, P>, window: &Window, camera: &Camera, bad: &[BadPixel]) -> Star {
    let Some(mut view) = View::new(frame, window, camera, bad) else { return Star::lost(window, EDGE) };
    let flags = view.cut();
    let fitted = Fit::<A, P>::of(&mut view, camera).and_then(Fit::star);
    fitted.map_or(Star::lost(window, flags), |star| Star { flags: star.flags | flags, ..star })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::F32;

    const SIDE: usize = 40;
    const CAMERA: Camera = Camera { black: 0.0, gain: 1.0, read_noise: 5.0, saturation: 4000.0, psf_sigma: 1.5 };

    /// What a window sees of a star of so many counts at (20.3, 19.6) on a sky of 100, and of one 12 columns before it.
    fn found(light: f32, x: f32, change: impl FnOnce(&mut [u16; SIDE * SIDE])) -> Star {
        let bell = |x: f32, y: f32| libm::expf(-(x * x + y * y) / 4.5);
        let mut pixels = core::array::from_fn(|at| {
            let (column, row) = ((at % SIDE) as f32, (at / SIDE) as f32 - 19.6);
            libm::roundf(100.0 + light * bell(column - 20.3, row) + 900.0 * bell(column - 8.3, row)) as u16
        });
        change(&mut pixels);
        let frame = Raster::new(&pixels, SIDE, SIDE, SIDE).expect("a frame");
        let mut star = [Star::EMPTY];
        let window = Window { x, y: 20.0, width: 16, height: 16 };
        track::<F32, _>(&frame, &[window], &CAMERA, &[BadPixel { x: 24, y: 21 }], &mut star).expect("a star");
        star[0]
    }

    #[test]
    fn every_flag_is_a_bit_of_its_own() {
        assert_eq!([EDGE, SATURATED, HOT, BLENDED, LOST], [1, 2, 4, 8, 16]);
    }

    #[test]
    fn what_is_wrong_with_a_star_is_told() {
        let good = |star: &Star| (star.x - 20.3).abs() < 0.02 && (star.y - 19.6).abs() < 0.02;
        let near = found(900.0, 20.0, |_| {});
        assert!(good(&near) && near.flags == HOT, "its bad pixel: {near:?}");
        let saturated = found(4200.0, 20.0, |_| {});
        assert!(good(&saturated) && saturated.flags == SATURATED | HOT, "{saturated:?}");
        let beside = found(900.0, 20.0, |pixels| {
            for at in [17 * SIDE + 17, 17 * SIDE + 18, 18 * SIDE + 17] {
                pixels[at] = 900;
            }
        });
        assert_eq!(beside.flags, BLENDED | HOT, "{beside:?}");
        let cut = found(900.0, 5.0, |_| {});
        assert!((cut.x - 8.3).abs() < 0.02 && cut.flags == EDGE, "{cut:?}");
        let lost = found(900.0, 31.0, |pixels| pixels.iter_mut().for_each(|pixel| *pixel = 100));
        assert_eq!(
            lost,
            Star { x: 31.0, y: 20.0, errx2: f32::INFINITY, erry2: f32::INFINITY, flags: LOST, ..Star::EMPTY }
        );
        let gone = found(900.0, -20.0, |_| {});
        assert_eq!((gone.x, gone.flags), (-20.0, LOST | EDGE));
    }

    #[test]
    fn nothing_is_written_where_a_star_has_no_place() {
        let (pixels, window) = ([0u16; 64], Window { x: 3.5, y: 3.5, width: 8, height: 8 });
        let frame = Raster::new(&pixels, 8, 8, 8).expect("a frame");
        let mut out = [Star { x: 7.0, ..Star::EMPTY }];
        let refused = track::<F32, _>(&frame, &[window; 2], &CAMERA, &[], &mut out);
        assert!(matches!(refused, Err(Error::Length { given: 1, needed: 2, .. })) && out[0].x == 7.0, "{refused:?}");
        assert!(track::<F32, _>(&frame, &[window], &CAMERA, &[], &mut out).is_ok() && out[0].flags == LOST);
    }
}
