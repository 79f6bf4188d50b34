//! Images that are searched together as one, beside the same of the reference.

use super::notes::{Difference, Notes};
use super::rounding::bit;
use crate::input::Combine;
use crate::reference::Plane;
use crate::reference::noise_aware::{Combination, Facts, Mesh, Seen, Sky, combined};

/// The side of a mesh's cells (`images.md`).
const CELL: usize = 64;

/// Compares a combination of images of `width` columns with the reference's; nothing where they stay apart.
pub fn combination(images: &[&[f32]], how: Combine, together: &[f32], width: usize) -> Option<Difference> {
    let how = match how {
        Combine::Weighted => Combination::Weighted,
        Combine::Chi2 => Combination::Chi2,
        Combine::Vector => return None,
    };
    let skies: Vec<Measured> = images.iter().map(|pixels| Measured::of(pixels, width)).collect();
    let planes: Vec<(Plane, Plane)> = skies.iter().map(|sky| (sky.signal.clone(), sky.noise.clone())).collect();
    let exact = combined(how, &planes)?;
    let mut notes = Notes::default();
    for (at, &core) in together.iter().enumerate() {
        let (i, j) = ((at % width) as isize, (at / width) as isize);
        let value = exact.at(i, j);
        if core.is_nan() || value.is_nan() {
            notes.count("combined", usize::from(core.is_nan() != value.is_nan()));
            continue;
        }
        // Of each image the share of its signal, and of its weight.
        let off = skies.iter().map(|sky| 3.0 * sky.off(i, j)).sum::<f64>() + bit(23) * value.abs();
        notes.number("combined", core.into(), value - off, value + off);
    }
    notes.found.pop()
}

/// An image as signal-to-noise.
struct Measured {
    signal: Plane,
    noise: Plane,
    level: Plane,
    /// How far the core may be off in a cell's level and noise, and how far these differ from cell to cell.
    cells: [f64; 2],
    range: [f64; 2],
}

impl Measured {
    fn of(pixels: &[f32], width: usize) -> Measured {
        let pixels: Vec<f64> = pixels.iter().map(|&v| v.into()).collect();
        let (facts, height) = (Facts::of(&pixels, width), pixels.len() / width);
        let seen: Vec<Seen> =
            pixels.iter().map(|&v| if facts.defines(v) { Seen::Sky } else { Seen::Nothing }).collect();
        let measured = |off: f64| Mesh::unknown((width, height), CELL).measure(&pixels, &seen, &facts, off);
        let [mesh, above, below] = [0.0, bit(21), -bit(21)].map(measured);
        let of = |value: fn(&Sky) -> f64| {
            let cells = || mesh.cells.iter().flatten().map(value);
            let range = cells().fold(f64::MIN, f64::max) - cells().fold(f64::MAX, f64::min);
            let spread = mesh.cells.iter().zip(above.cells.iter().zip(&below.cells)).filter_map(|(own, (a, b))| {
                let (own, a, b) = (own.as_ref()?, a.as_ref()?, b.as_ref()?);
                let values = [value(own), value(a), value(b)];
                let spread =
                    values.iter().copied().fold(f64::MIN, f64::max) - values.into_iter().fold(f64::MAX, f64::min);
                Some(spread + bit(19) * (own.level.abs() + own.noise))
            });
            (spread.fold(0.0, f64::max), range)
        };
        let (levels, noises) = (of(|sky| sky.level), of(|sky| sky.noise));
        let plane =
            |value: &dyn Fn(usize, usize) -> f64| Plane::from_fn(width, height, |i, j| value(i as usize, j as usize));
        let (level, noise) = (plane(&|x, y| mesh.at(x, y).level), plane(&|x, y| mesh.at(x, y).noise));
        let signal = plane(&|x, y| {
            let (sky, pixel) = (mesh.at(x, y), pixels[y * width + x]);
            if pixel.is_finite() { (pixel - sky.level) / sky.noise } else { f64::NAN }
        });
        Measured { signal, noise, level, cells: [levels.0, noises.0], range: [levels.1, noises.1] }
    }

    /// How far signal-to-noise may be off: by its cells, the places between them, and single precision.
    fn off(&self, i: isize, j: isize) -> f64 {
        let (level, noise) = (self.level.at(i, j), self.noise.at(i, j));
        let of_level = self.cells[0] + bit(21) * level.abs() + bit(17) * self.range[0];
        let of_noise = self.cells[1] + bit(21) * noise + bit(17) * self.range[1];
        (of_level + self.signal.at(i, j).abs() * of_noise) / noise
    }
}
