// A star tracker: windows where stars are expected, on a frame as it lies in the camera's buffer.
use skyfront_core::arithmetic::F32;
use skyfront_core::error::Error;
use skyfront_core::track::{BadPixel, Camera, EDGE, LOST, Raster, Star, Window, track};

const W: usize = 64;
const H: usize = 48;

fn main() -> Result<(), Error> {
    // Two stars on a sky of 100 counts; in flight the camera writes this.
    let mut frame = [100u16; W * H];
    for (x, y, peak) in [(20.3f32, 15.6f32, 900.0f32), (62.1, 30.0, 2500.0)] {
        for (at, pixel) in frame.iter_mut().enumerate() {
            let (dx, dy) = ((at % W) as f32 - x, (at / W) as f32 - y);
            *pixel += (peak * libm::expf(-0.5 * (dx * dx + dy * dy))) as u16;
        }
    }
    let camera = Camera { black: 64.0, gain: 2.0, read_noise: 8.0, saturation: 4095.0, psf_sigma: 1.0 };
    let bad = [BadPixel { x: 21, y: 16 }];
    let windows = [(20.0, 15.0), (61.0, 31.0), (40.0, 40.0)].map(|(x, y)| Window { x, y, width: 15, height: 15 });
    let mut stars = [Star::EMPTY; 3];
    track::<F32, u16>(&Raster::new(&frame, W, H, W)?, &windows, &camera, &bad, &mut stars)?;
    for star in &stars {
        let (x, y, error) = (star.x, star.y, libm::sqrtf(star.errx2));
        println!("{x:.2} {y:.2} +- {error:.3} S/N {:.0} flags {}", star.snr, star.flags);
    }
    assert!((stars[0].x - 20.3).abs() < 0.05 && (stars[0].y - 15.6).abs() < 0.05);
    assert_eq!(stars[1].flags, EDGE);
    assert_eq!(stars[2].flags, LOST);
    Ok(())
}
