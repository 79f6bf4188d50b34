//! Several images of the same pixels as one (`images.md`).

use super::Plane;

/// How images become one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Combination {
    /// Their sum by 1 / noise^2, over its own noise.
    Weighted,
    /// The root of the sum of the squares of signal-to-noise.
    Chi2,
}

/// The combination of images, of each the signal-to-noise and the noise.
pub fn combined(how: Combination, images: &[(Plane, Plane)]) -> Option<Plane> {
    let (first, _) = images.first()?;
    Some(Plane::from_fn(first.width(), first.height(), |i, j| {
        let each = || images.iter().map(|(signal, noise)| (signal.at(i, j), noise.at(i, j)));
        match how {
            Combination::Chi2 => each().map(|(signal, _)| signal * signal).sum::<f64>().sqrt(),
            Combination::Weighted => {
                let weights: f64 = each().map(|(_, noise)| noise.powi(-2)).sum();
                each().map(|(signal, noise)| signal / noise).sum::<f64>() / weights.sqrt()
            }
        }
    }))
}
