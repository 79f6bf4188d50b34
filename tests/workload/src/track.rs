//! Twenty stars in windows of 21 x 21, as a tracker has them, and their packets: digests and what they cost.

use skyfront_core::arithmetic::Arithmetic;
use skyfront_core::arithmetic::digest::Digest;
use skyfront_core::error::Error;
use skyfront_core::packet::{Cursor, cutouts, labels, stars};
use skyfront_core::track::{BadPixel, Camera, Raster, Star, Window, track};

/// Windows of a frame.
pub const STARS: usize = COLUMNS * ROWS;
const COLUMNS: usize = 5;
const ROWS: usize = 4;
/// Pixels from one star to the next.
const PITCH: usize = 24;
const WIDTH: usize = COLUMNS * PITCH;
const HEIGHT: usize = ROWS * PITCH;
/// Pixels of a window along both axes.
const SIDE: u16 = 21;
/// One pixel that is not to be used, in the flank of a star.
const BAD: [BadPixel; 1] = [BadPixel { x: 37, y: 12 }];

/// Bytes of a packet: a record of a star does not end with it.
const PACKET: usize = 200;

const CAMERA: Camera = Camera { black: 60.0, gain: 2.0, read_noise: 8.0, saturation: 4095.0, psf_sigma: 1.0 };

/// The frame and the records.
#[derive(Debug)]
pub struct Room {
    pixels: [u16; WIDTH * HEIGHT],
    stars: [Star; STARS],
}

impl Room {
    /// Memory of zeros, which costs no flash.
    pub const BLANK: Room = Room { pixels: [0; WIDTH * HEIGHT], stars: [Star::EMPTY; STARS] };

    /// Draws the frame: a sky of 100 counts with noise, and in the middle of every 24 x 24 pixels a star, the
    /// brightest of which saturate.
    pub fn draw(&mut self) {
        let mut state = 1u32;
        for (y, row) in self.pixels.chunks_exact_mut(WIDTH).enumerate() {
            for (x, pixel) in row.iter_mut().enumerate() {
                let star = y / PITCH * COLUMNS + x / PITCH;
                let (at_x, at_y) = place(star);
                let (dx, dy) = (x as f32 - at_x, y as f32 - at_y);
                let peak = 60.0 * (1 + star * star) as f32;
                let light = peak * libm::expf(-0.5 * (dx * dx + dy * dy));
                // Uniform from -16 to 15: nearly the noise of sky and read-out.
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let noise = (state >> 27) as f32 - 16.0;
                *pixel = (100.0 + noise + light).clamp(0.0, 4095.0) as u16;
            }
        }
    }

    /// Finds the stars of the frame; 0 where the core refuses to.
    pub fn find<A: Arithmetic>(&mut self) -> usize {
        let windows = windows();
        let Ok(frame) = Raster::new(&self.pixels, WIDTH, HEIGHT, WIDTH) else { return 0 };
        let found = track::<A, u16>(&frame, &windows, &CAMERA, &BAD, &mut self.stars);
        found.map_or(0, |()| self.stars.iter().filter(|star| star.snr > 0.0).count())
    }

    /// The digest of all packets of stars, labels and cut-outs; what is bright belongs to its square.
    ///
    /// # Errors
    /// What the core refuses.
    pub fn packets(&self) -> Result<u32, Error> {
        let (frame, windows) = (Raster::new(&self.pixels, WIDTH, HEIGHT, WIDTH)?, windows());
        let bright = |at: usize| self.pixels.get(at).is_some_and(|&pixel| pixel > 160);
        let square = |at: usize| (at / WIDTH / PITCH * COLUMNS + at % WIDTH / PITCH) as u32;
        let label = |at: usize| if bright(at) { square(at) + 1 } else { 0 };
        let mut digest = Digest::default();
        sent(&mut digest, |cursor, out| stars(cursor, &self.stars, out))?;
        sent(&mut digest, |cursor, out| labels(cursor, (WIDTH as u32, HEIGHT as u32), label, out))?;
        sent(&mut digest, |cursor, out| cutouts(cursor, &frame, &windows, out))?;
        Ok(digest.value())
    }

    /// Gives `tell` the digests of records and packets with their names.
    pub fn all<A: Arithmetic>(&mut self, mut tell: impl FnMut(&[&str], u32)) {
        self.draw();
        let found = self.find::<A>();
        tell(&[A::NAME, "track", "stars"], if found == STARS { digest(&self.stars) } else { 0 });
        tell(&[A::NAME, "track", "packets"], self.packets().unwrap_or(0));
    }
}

/// Feeds all packets of a product.
fn sent<N>(digest: &mut Digest, next: N) -> Result<(), Error>
where
    N: Fn(&mut Cursor, &mut [u8]) -> Result<Option<usize>, Error>,
{
    let (mut cursor, mut out) = (Cursor::new(1), [0; PACKET]);
    while let Some(length) = next(&mut cursor, &mut out)? {
        // Without its checksum: a checksum over that too is the same whatever the packet holds.
        digest.bytes(out.get(..length - 4).unwrap_or(&[]));
    }
    Ok(())
}

/// The windows, each in the middle of its square.
fn windows() -> [Window; STARS] {
    core::array::from_fn(|star| {
        let (x, y) = middle(star);
        Window { x, y, width: SIDE, height: SIDE }
    })
}

/// The middle of a star's square.
fn middle(star: usize) -> (f32, f32) {
    let (column, row) = (star % COLUMNS, star / COLUMNS);
    ((column * PITCH + PITCH / 2) as f32, (row * PITCH + PITCH / 2) as f32)
}

/// The centre of a star: up to half a pixel beside the middle.
fn place(star: usize) -> (f32, f32) {
    let (x, y) = middle(star);
    (x + (star * 7 % 20) as f32 / 20.0 - 0.5, y + (star * 11 % 20) as f32 / 20.0 - 0.5)
}

/// CRC-32 of the little-endian words of records.
#[must_use]
pub fn digest(stars: &[Star]) -> u32 {
    let mut digest = Digest::default();
    for star in stars {
        let Star { x, y, flux, snr, errx2, erry2, errxy, flags } = *star;
        for number in [x, y, flux, snr, errx2, erry2, errxy] {
            digest.bytes(&number.to_bits().to_le_bytes());
        }
        digest.bytes(&flags.to_le_bytes());
    }
    digest.value()
}
