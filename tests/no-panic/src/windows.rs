//! Stars in windows.

use skyfront_core::arithmetic::{Arithmetic, F32, Q24};
use skyfront_core::error::Error;
use skyfront_core::track::{BadPixel, Camera, Pixel, Raster, Star, Window, track};

fn windows<A: Arithmetic, P: Pixel>(
    (pixels, width, height, stride): (&[P], usize, usize, usize),
    windows: &[Window],
    camera: &Camera,
    bad: &[BadPixel],
    out: &mut [Star],
) -> Result<(), Error> {
    track::<A, P>(&Raster::new(pixels, width, height, stride)?, windows, camera, bad, out)
}

macro_rules! exported {
    ($name:ident, $arithmetic:ty, $pixel:ty) => {
        #[unsafe(no_mangle)]
        fn $name(frame: (&[$pixel], usize, usize, usize), places: &[Window], camera: &Camera, bad: &[BadPixel], out: &mut [Star]) -> Result<(), Error> {
            windows::<$arithmetic, $pixel>(frame, places, camera, bad, out)
        }
    };
}

exported!(track_f32_u8, F32, u8);
exported!(track_f32_u16, F32, u16);
exported!(track_q24_u8, Q24, u8);
exported!(track_q24_u16, Q24, u16);
