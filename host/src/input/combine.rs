//! Several images of one field as one, in which sources are found that none shows alone.

use super::Reason;
use crate::background::SkyMaps;
use crate::read::Image;
use crate::sky::Sky;

/// How images are combined, each as signal-to-noise of its own: less the sky of its mesh, over the
/// noise.
///
/// ```
/// use skyfront::input::Combine;
/// use skyfront::truth::simulated;
/// use skyfront_core::simulate::Kind;
///
/// let [first, second] = [1, 2].map(|seed| simulated(Kind::Noisy, seed, 64, 64).0);
/// let together = Combine::Weighted.of(&[&first, &second]);
/// assert_eq!((together.len(), Combine::Weighted.name()), (64 * 64, "weighted"));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Combine {
    /// Their sum weighted by 1 / noise^2, over its own noise: best for sources as bright in each.
    #[default]
    Weighted,
    /// The root of the sum of their squares (Szalay, Connolly, Szokoly 1999, doi:10.1086/300689):
    /// for sources of any colour.
    Chi2,
}

/// Farther apart on the sky, in pixels, images are not of the same pixels.
const APART: f64 = 0.5;

impl Combine {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Combine::Weighted => "weighted",
            Combine::Chi2 => "chi2",
        }
    }

    /// The combination of images of one size; not defined where one of them is not.
    pub fn of(self, images: &[&Image]) -> Vec<f32> {
        let pixels = images.first().map_or(0, |image| image.pixels.len());
        let (mut sum, mut weights) = (vec![0.0f64; pixels], vec![0.0f64; pixels]);
        for image in images {
            let sky = SkyMaps::measure(&image.pixels, &[], image.width);
            let skies = sky.level.iter().zip(&sky.noise);
            for (((sum, weight), &pixel), (&level, &noise)) in
                sum.iter_mut().zip(&mut weights).zip(&image.pixels).zip(skies)
            {
                let (light, noise) = (f64::from(pixel) - f64::from(level), f64::from(noise));
                match self {
                    Combine::Weighted => *sum += light / (noise * noise),
                    Combine::Chi2 => *sum += (light / noise).powi(2),
                }
                *weight += 1.0 / (noise * noise);
            }
        }
        let value = |(sum, weight): (&f64, &f64)| match self {
            Combine::Weighted => sum / weight.sqrt(),
            Combine::Chi2 => sum.sqrt(),
        };
        let finite = |value: f64| if value.is_finite() { value as f32 } else { f32::NAN };
        sum.iter().zip(&weights).map(value).map(finite).collect()
    }
}

/// Whether an image lies where another of its size does on the sky, as far as both say where they
/// lie.
pub(super) fn same_field(image: &Image, other: &Image, file: &str) -> Result<(), Reason> {
    let [one, two] = [image, other].map(|image| Sky::of(&image.header).ok().flatten());
    let (Some(one), Some(two)) = (one, two) else { return Ok(()) };
    let (right, top) = ((image.width - 1) as f64, (image.height - 1) as f64);
    let farthest = [(0.0, 0.0), (right, 0.0), (0.0, top), (right, top)].into_iter().fold(0.0, |most: f64, (x, y)| {
        let seen = one.position(x, y).and_then(|(ra, dec)| two.pixel(ra, dec));
        most.max(seen.map_or(f64::INFINITY, |(x2, y2)| (x2 - x).hypot(y2 - y)))
    });
    if one.frame() == two.frame() && farthest <= APART {
        Ok(())
    } else {
        Err(Reason::Elsewhere { file: file.to_owned(), pixels: farthest })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::Header;

    fn image(pixels: Vec<f32>, width: usize) -> Image {
        let (header, primary) = (Header::default(), Header::default());
        let height = pixels.len() / width;
        let warnings = Vec::new();
        Image { width, height, pixels, header, primary, hdu: 0, name: None, bitpix: -32, checksum: 0, warnings }
    }

    /// Noise of a scale on a level, and a block that is so many times as bright as it.
    fn band(seed: u32, level: f32, scale: f32, block: f32) -> Image {
        let (mut state, width) = (seed, 64);
        let mut uniform = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0 - 0.5
        };
        let mut normal = || (0..12).map(|_| uniform()).sum::<f32>();
        let value =
            |at: usize| if (20..24).contains(&(at % width)) && (20..24).contains(&(at / width)) { block } else { 0.0 };
        image((0..width * width).map(|at| level + scale * (normal() + value(at))).collect(), width)
    }

    /// Two bands of noise 1 and 1/2 in which a block is 4 and 8 bright add up to sqrt(4^2 + 16^2)
    /// either way where the colours are those that the weights suppose.
    #[test]
    fn signals_add_up_as_their_weights_say() {
        let bands = [band(1, 100.0, 1.0, 4.0), band(2, -3.0, 0.5, 8.0)];
        let bands = bands.each_ref();
        let mean = |values: &[f32]| {
            let block = values
                .iter()
                .enumerate()
                .filter(|(at, _)| (20..24).contains(&(at % 64)) && (20..24).contains(&(at / 64)));
            block.map(|(_, value)| value).sum::<f32>() / 16.0
        };
        let (weighted, chi) = (Combine::Weighted.of(&bands), Combine::Chi2.of(&bands));
        // Of 4 and 4 in flux with weights 1 and 4: 20 / sqrt 5; squares of 4 and 8.
        assert!((mean(&weighted) - 20.0 / 5f32.sqrt()).abs() < 0.8, "{}", mean(&weighted));
        assert!((mean(&chi) - 80f32.sqrt()).abs() < 0.8, "{}", mean(&chi));
        let sky: Vec<f32> = weighted[..64 * 16].to_vec();
        let scatter = (sky.iter().map(|v| v * v).sum::<f32>() / sky.len() as f32).sqrt();
        assert!((scatter - 1.0).abs() < 0.1, "the weighted sum has a noise of 1, not {scatter}");
    }

    #[test]
    fn what_one_band_lacks_is_not_defined() {
        let mut other = band(2, 0.0, 1.0, 0.0);
        other.pixels[5] = f32::NAN;
        let combined = Combine::Chi2.of(&[&band(1, 0.0, 1.0, 0.0), &other]);
        assert!(combined[5].is_nan() && combined.iter().filter(|value| value.is_nan()).count() == 1);
    }
}
