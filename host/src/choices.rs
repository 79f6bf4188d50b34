//! The choices that are not parameters of the core: the preset, and the numbers to compute in.

use crate::pipeline::{Drive, Segmentation, segment, segment_in};
use crate::read::Image;
use crate::{extraction, nothing};
use skyfront_core::arithmetic::{Arithmetic, F32, Fixed14, Q11, Q24};
use skyfront_core::config::Config;
use skyfront_core::error::Error;
use skyfront_core::front::bands;

/// Named settings.
///
/// ```
/// use skyfront::choices::Preset;
///
/// for preset in Preset::ALL {
///     println!("{:12} {:?}", preset.name(), preset.config().scheme);
/// }
/// assert_eq!(Preset::default(), Preset::NoiseAware);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Preset {
    /// Sky and noise from the image, sources by their significance, one setting for every sky.
    #[default]
    NoiseAware,
    /// The same for frames of a star tracker: stars that stand out well, for places rather than outlines.
    StarTracker,
    /// The paper's front (r3, g2mod, fd) with the sky, the filter, the separation and the selection of
    /// noise-aware.
    Rsa,
    /// Test 1 of the paper at its best: r3 with beta 8, heat filter, g2mod with c2 = 0.8.
    PaperF160,
    /// Test 2 of the paper at its best: r1, then Perona-Malik, g2mod with c2 = 0.78.
    PaperReal,
    /// Active contours without edges (Chan and Vese), in units of the frame's noise.
    ChanVese,
}

impl Preset {
    /// Every preset, the default first.
    pub const ALL: [Preset; 6] =
        [Preset::NoiseAware, Preset::StarTracker, Preset::Rsa, Preset::PaperF160, Preset::PaperReal, Preset::ChanVese];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Preset::NoiseAware => "noise-aware",
            Preset::StarTracker => "star-tracker",
            Preset::Rsa => "rsa",
            Preset::PaperF160 => "paper-f160",
            Preset::PaperReal => "paper-real",
            Preset::ChanVese => "chan-vese",
        }
    }

    /// Its settings.
    pub fn config(self) -> Config {
        match self {
            Preset::NoiseAware => Config::NOISE_AWARE,
            Preset::StarTracker => Config::STAR_TRACKER,
            Preset::Rsa => Config::RSA,
            Preset::PaperF160 => Config::PAPER_F160,
            Preset::PaperReal => Config::PAPER_REAL,
            Preset::ChanVese => Config::CHAN_VESE,
        }
    }
}

/// `--arithmetic`.
///
/// ```
/// use skyfront::choices::{ArithmeticOption, Preset};
/// use skyfront::pipeline::Drive;
/// use skyfront::truth::simulated;
/// use skyfront_core::simulate::Kind;
///
/// let (image, _) = simulated(Kind::Bright, 5, 96, 96);
/// let config = Preset::NoiseAware.config();
/// let run = ArithmeticOption::Q24.segment(&config, &image, &mut Drive::default())?;
/// assert!(!run.sources.is_empty());
/// # Ok::<(), skyfront_core::error::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum ArithmeticOption {
    /// IEEE 754 single precision, 8 bytes per pixel.
    #[default]
    F32,
    /// Fixed point, 24 fraction bits, 8 bytes per pixel.
    Q24,
    /// Fixed point in 16 bits, 4 bytes per pixel.
    Q11,
}

impl ArithmeticOption {
    /// Every arithmetic, the default first.
    pub const ALL: [ArithmeticOption; 3] = [ArithmeticOption::F32, ArithmeticOption::Q24, ArithmeticOption::Q11];

    /// The configuration in a band where the arithmetic cannot do without, unless the user has a `band` of their own.
    pub fn adapted(self, config: Config, band: bool) -> Config {
        let needed = if self == ArithmeticOption::Q11 && !band { Q11::NEEDS_BAND } else { None };
        Config { band: config.band.or(needed), ..config }
    }

    /// Checks a configuration for this arithmetic.
    ///
    /// # Errors
    /// As [`Config::validate`].
    pub fn validate(self, config: &Config) -> Result<(), Error> {
        match self {
            ArithmeticOption::F32 => config.validate::<F32>(),
            ArithmeticOption::Q24 => config.validate::<Q24>(),
            ArithmeticOption::Q11 => config.validate::<Q11>(),
        }
    }

    /// Checks whether so many bands can move the front of a configuration in this arithmetic.
    ///
    /// # Errors
    /// As [`bands::serve`].
    pub fn serves(self, config: &Config, bands: usize) -> Result<(), Error> {
        let served = match self {
            ArithmeticOption::F32 => bands::serve::<F32>(config, bands),
            ArithmeticOption::Q24 => bands::serve::<Q24>(config, bands),
            ArithmeticOption::Q11 => bands::serve::<Q11>(config, bands),
        };
        served.map_err(|refused| match refused {
            // In the words of the option.
            Error::Together { other, wanted, .. } => {
                Error::Together { choice: "combine", value: "vector", other, wanted }
            }
            refused => refused,
        })
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            ArithmeticOption::F32 => <F32>::NAME,
            ArithmeticOption::Q24 => Q24::NAME,
            ArithmeticOption::Q11 => Q11::NAME,
        }
    }

    /// Segments in this arithmetic; an image in which nothing can stand out has no source.
    ///
    /// # Errors
    /// As [`segment_in`].
    pub fn segment(self, config: &Config, image: &Image, drive: &mut Drive<'_>) -> Result<Segmentation, Error> {
        let (pixels, width, height) = (&image.pixels, image.width, image.height);
        self.validate(config)?;
        let (run, name) = match (self, config.sky.is_known()) {
            (ArithmeticOption::Q24, true) => {
                (extraction::segment::<Q24, Fixed14>(config, pixels, width, drive), Q24::NAME)
            }
            (ArithmeticOption::F32, _) => (segment(config, pixels, width, height, drive), <F32>::NAME),
            (ArithmeticOption::Q24, false) => (segment_in::<Q24>(config, pixels, width, height, drive), Q24::NAME),
            (ArithmeticOption::Q11, _) => (segment_in::<Q11>(config, pixels, width, height, drive), Q11::NAME),
        };
        run.or_else(|refused| nothing::found(refused, image, name, drive))
    }
}

#[cfg(all(test, feature = "cli"))]
mod tests {
    use super::*;
    use crate::input::WeightType;
    use crate::measure::Neighbours;
    use clap::ValueEnum;

    #[test]
    fn names_are_those_of_the_command_line() {
        fn names<V: ValueEnum>() -> Vec<String> {
            let values = V::value_variants().iter().filter_map(ValueEnum::to_possible_value);
            values.map(|value| value.get_name().to_owned()).collect()
        }
        assert_eq!(names::<Preset>(), Preset::ALL.map(Preset::name));
        assert_eq!(names::<WeightType>(), WeightType::ALL.map(WeightType::name));
        assert_eq!(names::<Neighbours>(), Neighbours::ALL.map(Neighbours::name));
        assert_eq!(names::<ArithmeticOption>(), ArithmeticOption::ALL.map(ArithmeticOption::name));
    }
}
