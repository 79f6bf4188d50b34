//! Several images of one field as one, or for one front, in which sources are found that none shows alone.

use super::{Input, Observed, Reason};
use crate::background::SkyMaps;
use crate::read::Image;
use crate::sky::Sky;

/// How sources are found in several images together: in a combination of them, each as signal-to-noise of its own (less
/// the sky of its mesh, over the noise), or by one front that goes by all of them.
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
    /// No image of its own: a front goes by each of them (Chan, Sandberg, Vese 2000, doi:10.1006/jvci.1999.0442); with
    /// --scheme chan-vese and --sky none.
    Vector,
}

/// Farther apart on the sky, in pixels, images are not of the same pixels.
const APART: f64 = 0.5;

impl Combine {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Combine::Weighted => "weighted",
            Combine::Chi2 => "chi2",
            Combine::Vector => "vector",
        }
    }

    /// Every way, the default first.
    pub const ALL: [Combine; 3] = [Combine::Weighted, Combine::Chi2, Combine::Vector];

    /// The combination of images of one size; not defined where one of them is not. [`Combine::Vector`] leaves the first
    /// as it is elsewhere.
    pub fn of(self, images: &[&Image]) -> Vec<f32> {
        if self == Combine::Vector {
            return together(images);
        }
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
                    Combine::Chi2 => *sum += (light / noise).powi(2),
                    _ => *sum += light / (noise * noise),
                }
                *weight += 1.0 / (noise * noise);
            }
        }
        let value = |(sum, weight): (&f64, &f64)| match self {
            Combine::Chi2 => sum.sqrt(),
            _ => sum / weight.sqrt(),
        };
        let finite = |value: f64| if value.is_finite() { value as f32 } else { f32::NAN };
        sum.iter().zip(&weights).map(value).map(finite).collect()
    }
}

/// The first of some images, not defined where one of them is not.
fn together(images: &[&Image]) -> Vec<f32> {
    let mut pixels = images.first().map_or_else(Vec::new, |first| first.pixels.clone());
    for image in images {
        let lacking = pixels.iter_mut().zip(&image.pixels).filter(|(_, pixel)| !pixel.is_finite());
        lacking.for_each(|(first, _)| *first = f32::NAN);
    }
    pixels
}

impl Input {
    /// Has sources found in the image and others of the same pixels together, and measured in each of all, or in those
    /// that are to be measured already.
    pub fn find_with(&mut self, others: Vec<Observed>, how: Combine) {
        let images: Vec<&Image> =
            std::iter::once(&self.detected).chain(&others).map(|observed| &observed.image).collect();
        let pixels = how.of(&images);
        if how == Combine::Vector {
            let further = |other: &Observed| -> Vec<f32> {
                let lacking = |(&pixel, first): (&f32, &f32)| if first.is_nan() { f32::NAN } else { pixel };
                other.image.pixels.iter().zip(&pixels).map(lacking).collect()
            };
            self.with = others.iter().map(further).collect();
        }
        if self.bands.is_empty() {
            self.bands = std::iter::once(self.detected.clone()).chain(others).collect();
        }
        let image = &mut self.detected.image;
        image.pixels = pixels;
        if how != Combine::Vector {
            // Nothing is left of its range or unit.
            image.bitpix = -32;
        }
    }
}

/// Whether an image lies where another of its size does on the sky, as far as both say where they
/// lie.
///
/// # Errors
/// [`Reason::Elsewhere`].
pub fn same_field(image: &Image, other: &Image, file: &str) -> Result<(), Reason> {
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
    fn a_front_that_goes_by_each_leaves_images_as_they_are_where_all_are_defined() {
        let (one, mut two) = (band(1, 5.0, 1.0, 4.0), band(2, -3.0, 0.5, 8.0));
        two.pixels[7] = f32::NAN;
        let mut input = Input::alone("one", Image { bitpix: 16, ..one.clone() });
        input.detected.image.pixels[9] = f32::NAN;
        let other = Observed { name: "two".to_owned(), image: two.clone(), ..input.detected.clone() };
        input.find_with(vec![other], Combine::Vector);
        let lacking = |pixels: &[f32]| (0..pixels.len()).filter(|&at| pixels[at].is_nan()).collect::<Vec<_>>();
        assert_eq!(lacking(&input.detected.image.pixels), [7, 9]);
        assert_eq!((input.with.len(), lacking(&input.with[0])), (1, vec![7, 9]));
        assert_eq!((input.detected.image.pixels[3], input.with[0][3]), (one.pixels[3], two.pixels[3]));
        assert_eq!((input.bands.len(), input.detected.image.bitpix), (2, 16));
        assert!(input.bands[0].image.pixels[7].is_finite(), "each is measured where it is known");
    }

    #[test]
    fn what_one_band_lacks_is_not_defined() {
        let mut other = band(2, 0.0, 1.0, 0.0);
        other.pixels[5] = f32::NAN;
        let combined = Combine::Chi2.of(&[&band(1, 0.0, 1.0, 0.0), &other]);
        assert!(combined[5].is_nan() && combined.iter().filter(|value| value.is_nan()).count() == 1);
    }
}
