//! The choices that are not parameters of the core: the preset, and the numbers to compute in.

use crate::pipeline::{Drive, Segmentation, segment, segment_in};
use crate::read::Image;
use crate::{extraction, nothing};
use clap::ValueEnum;
use skyfront_core::arithmetic::{Arithmetic, F32, Fixed14, Q11, Q24};
use skyfront_core::config::Config;
use skyfront_core::error::Error;

/// Named settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// Sky and noise from the image, sources by their significance, one setting for every sky.
    #[default]
    NoiseAware,
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
    /// Its settings.
    pub fn config(self) -> Config {
        match self {
            Preset::NoiseAware => Config::NOISE_AWARE,
            Preset::Rsa => Config::RSA,
            Preset::PaperF160 => Config::PAPER_F160,
            Preset::PaperReal => Config::PAPER_REAL,
            Preset::ChanVese => Config::CHAN_VESE,
        }
    }
}

/// `--arithmetic`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
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
