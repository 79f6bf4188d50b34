//! Sky background and noise at every pixel, from the core's mesh.

use skyfront_core::sky::{Mesh, Sky, cell_pixels, mesh_cells};
use skyfront_core::sort::Keys;

/// Maps of one shape, row-major, in units of the image; NaN where nothing is known.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyMaps {
    /// The background level.
    pub level: Vec<f32>,
    /// Standard deviation of a pixel.
    pub noise: Vec<f32>,
}

impl SkyMaps {
    /// Measures the sky of an image where `masked` (of the same shape, or empty) is not above 0.
    pub fn measure(pixels: &[f32], masked: &[f32], width: usize) -> SkyMaps {
        let planes = [(); 2].map(|()| vec![0.0; pixels.len()]);
        SkyMaps::measure_into(pixels, masked, width, planes)
    }

    /// [`Self::measure`] in planes that are there already.
    pub fn measure_into(pixels: &[f32], masked: &[f32], width: usize, planes: [Vec<f32>; 2]) -> SkyMaps {
        let [mut level, mut noise] = planes;
        let size = (width, pixels.len() / width.max(1));
        let mut cells = vec![Sky::UNKNOWN; mesh_cells(size.0, size.1)];
        let sky = |at: usize| masked.get(at).is_none_or(|&mask| mask <= 0.0);
        let [mut keys, mut spare] = [(); 2].map(|()| vec![0; cell_pixels(size.0, size.1)]);
        let mesh = Mesh::measure(pixels, sky, size, &mut cells, Keys(&mut keys, &mut spare));
        for (at, (level, noise)) in level.iter_mut().zip(&mut noise).enumerate() {
            let sky = mesh.at(at % width, at / width);
            (*level, *noise) = (sky.level, sky.noise);
        }
        SkyMaps { level, noise }
    }

    /// The same where `labels` are 0.
    pub fn beside(pixels: &[f32], labels: &[u32], width: usize) -> SkyMaps {
        let masked: Vec<f32> = labels.iter().map(|&label| if label == 0 { 0.0 } else { 1.0 }).collect();
        SkyMaps::measure(pixels, &masked, width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_is_followed_and_a_masked_source_is_not() {
        let (width, height) = (256, 256);
        let noise = |at: usize| ((at as u32).wrapping_mul(2_654_435_761) >> 16) as f32 / 65_536.0 - 0.5;
        let slope = |at: usize| 100.0 + (at % width) as f32 / 128.0;
        let mut pixels: Vec<f32> = (0..width * height).map(|at| slope(at) + noise(at)).collect();
        let labels: Vec<u32> = (0..pixels.len()).map(|at| u32::from(at % width < 40 && at / width < 40)).collect();
        pixels.iter_mut().zip(&labels).filter(|(_, label)| **label > 0).for_each(|(pixel, _)| *pixel += 5.0);
        let sky = SkyMaps::beside(&pixels, &labels, width);
        // Near the border the median of the cells leans inwards, by half a cell's slope.
        for at in [20 * width + 20, 20 * width + 70, 100 * width + 128, 200 * width + 200] {
            assert!((sky.level[at] - slope(at)).abs() < 0.5, "{} beside {}", sky.level[at], slope(at));
            assert!((0.2..1.3).contains(&sky.noise[at]), "{}", sky.noise[at]);
        }
    }
}
