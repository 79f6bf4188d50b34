//! Sky background and noise at every pixel, from the core's mesh.

use crate::workers::Threads;
use skyfront_core::arithmetic::machine::Task;
use skyfront_core::plane::crew::Crew;
use skyfront_core::plane::sort::{Keys, SAMPLES};
use skyfront_core::sky::{CELL, Mesh, Seen, Sky, Values, cell_pixels, mesh_cells};

/// Maps of one shape, row-major, in units of the image; NaN where nothing is known.
///
/// ```
/// use skyfront::background::SkyMaps;
/// use skyfront::truth::simulated;
/// use skyfront_core::simulate::Kind;
///
/// let (image, truth) = simulated(Kind::Noisy, 1, 256, 256);
/// let sky = SkyMaps::measure(&image.pixels, &[], 256);
/// assert!((sky.noise[0] / truth.sigma() - 1.0).abs() < 0.2);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SkyMaps {
    /// The background level.
    pub level: Vec<f32>,
    /// Standard deviation of a pixel.
    pub noise: Vec<f32>,
}

impl SkyMaps {
    /// The maps of a measured mesh, in planes that are there already, from a column and row of the mesh's frame on.
    pub fn of(
        mesh: &Mesh<'_>,
        width: usize,
        (left, bottom): (usize, usize),
        planes: [Vec<f32>; 2],
        crew: &impl Crew,
    ) -> SkyMaps {
        let [mut level, mut noise] = planes;
        let rows = level.chunks_mut(width.max(1)).zip(noise.chunks_mut(width.max(1)));
        crew.each((bottom..).zip(rows), |(y, (level, noise)): (usize, _)| {
            crew.wide(Row { mesh, left, y, level, noise });
        });
        SkyMaps { level, noise }
    }

    /// Measures the sky of an image where `masked` (of the same shape, or empty) is not true.
    pub fn measure(pixels: &[f32], masked: &[bool], width: usize) -> SkyMaps {
        let size = (width, pixels.len() / width.max(1));
        let mut cells = vec![Sky::UNKNOWN; mesh_cells(size.0, size.1, CELL)];
        let room = cell_pixels(size.0, size.1, CELL).max(pixels.len().min(SAMPLES));
        let [mut keys, mut spare] = [(); 2].map(|()| vec![0; room]);
        let mut keys = Keys(&mut keys, &mut spare);
        let values = Values::measure(pixels, width, |_| true, keys.again());
        let seen = |at: usize| match (values.holds(pixels[at]), masked.get(at)) {
            (false, _) => Seen::Undefined,
            (true, Some(true)) => Seen::Source,
            (true, _) => Seen::Sky,
        };
        let mut mesh = Mesh::blank(&mut cells, size, CELL);
        mesh.measure(pixels, seen, &values, keys);
        SkyMaps::of(&mesh, width, (0, 0), [(); 2].map(|()| vec![0.0; pixels.len()]), &Threads(1))
    }

    /// The same where `labels` are 0.
    pub fn beside(pixels: &[f32], labels: &[u32], width: usize) -> SkyMaps {
        let masked: Vec<bool> = labels.iter().map(|&label| label != 0).collect();
        SkyMaps::measure(pixels, &masked, width)
    }
}

/// A row of both maps, from a column of the mesh's frame on.
struct Row<'a> {
    mesh: &'a Mesh<'a>,
    left: usize,
    y: usize,
    level: &'a mut [f32],
    noise: &'a mut [f32],
}

impl Task for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.mesh.along(self.left, self.y, self.level, self.noise);
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
        for at in [20 * width + 20, 20 * width + 70, 100 * width + 128, 200 * width + 200] {
            assert!((sky.level[at] - slope(at)).abs() < 0.1, "{} beside {}", sky.level[at], slope(at));
            assert!((0.2..1.3).contains(&sky.noise[at]), "{}", sky.noise[at]);
        }
    }
}
