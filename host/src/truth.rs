//! The truth of a simulated sky: which object owns which pixel (after Haigh et al. 2021,
//! doi:10.1051/0004-6361/201936561).

use crate::read::{Header, Image};
use skyfront_core::run::frame::Frame;
use skyfront_core::simulate::{Kind, Sky};

/// Objects that own fewer pixels are none.
const LEAST_PIXELS: usize = 3;

/// A simulated sky as an image without header.
pub fn simulated(kind: Kind, seed: u32, width: usize, height: usize) -> (Image, Sky) {
    let sky = Sky::new(kind, seed, width, height);
    (observed(sky, width, height), sky)
}

/// A sky of this size as an image without header.
pub fn observed(mut sky: Sky, width: usize, height: usize) -> Image {
    let mut pixels = vec![0.0f32; width * height];
    for (y, row) in pixels.chunks_exact_mut(width).enumerate() {
        let Ok(()) = sky.row(y, row);
    }
    let mut digest = crc32fast::Hasher::new();
    pixels.iter().for_each(|pixel| digest.update(&pixel.to_le_bytes()));
    Image {
        width,
        height,
        pixels,
        header: Header::default(),
        primary: Header::default(),
        hdu: 0,
        name: None,
        bitpix: -32,
        checksum: digest.finalize(),
        warnings: Vec::new(),
    }
}

/// Labels, row-major, 0 = background: a pixel belongs to the object with the most light there, each
/// taken alone and without noise, if that is more than one standard deviation of the noise. The
/// pixels of an object that owns fewer than three go to the next.
pub fn labels(sky: &Sky, width: usize, height: usize) -> Vec<u32> {
    let mut alive = vec![true; sky.objects() as usize];
    loop {
        let labels = owners(sky, width, height, &alive);
        let mut owned = vec![0; alive.len()];
        labels.iter().filter_map(|&label| (label as usize).checked_sub(1)).for_each(|index| owned[index] += 1);
        let mut dropped = false;
        for (alive, &owned) in alive.iter_mut().zip(&owned) {
            dropped |= *alive && (1..LEAST_PIXELS).contains(&owned);
            *alive &= owned >= LEAST_PIXELS;
        }
        if !dropped {
            return labels;
        }
    }
}

fn owners(sky: &Sky, width: usize, height: usize, alive: &[bool]) -> Vec<u32> {
    let mut labels = vec![0; width * height];
    let (mut most, mut light) = (vec![0.0; width], vec![0.0; width]);
    for (y, labels) in labels.chunks_exact_mut(width).enumerate() {
        most.fill(sky.sigma());
        for index in (0..sky.objects()).filter(|&index| alive[index as usize]) {
            light.fill(0.0);
            if !sky.add_light(index, y, &mut light) {
                continue;
            }
            for ((label, most), &light) in labels.iter_mut().zip(&mut most).zip(&light) {
                if light > *most {
                    (*label, *most) = (index + 1, light);
                }
            }
        }
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;
    use skyfront_core::simulate::Kind;

    #[test]
    fn objects_own_their_centres_and_no_object_is_tiny() {
        let (width, height) = (120, 100);
        let sky = Sky::new(Kind::Stars, 3, width, height);
        let labels = labels(&sky, width, height);
        let mut owned = vec![0; sky.objects() as usize + 1];
        labels.iter().for_each(|&label| owned[label as usize] += 1);
        assert!(owned.iter().all(|&pixels| pixels == 0 || pixels >= LEAST_PIXELS));
        let brightest = (0..sky.objects())
            .filter(|&index| {
                let object = sky.object(index);
                object.x < width as f32 - 1.0 && object.y < height as f32 - 1.0
            })
            .max_by(|&a, &b| sky.object(a).peak.total_cmp(&sky.object(b).peak))
            .expect("a sky has objects");
        let object = sky.object(brightest);
        let centre = (object.y + 0.5) as usize * width + (object.x + 0.5) as usize;
        assert_eq!(labels[centre], brightest + 1);
    }
}
