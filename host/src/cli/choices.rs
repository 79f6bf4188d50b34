//! The words and numbers that options can be given: one type an option, and how its text is read.

use crate::pipeline::{Drive, Segmentation, segment, segment_in};
use crate::read::{Image, Place};
use crate::{detection, nothing};
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
            Preset::PaperF160 => Config::PAPER_F160,
            Preset::PaperReal => Config::PAPER_REAL,
            Preset::ChanVese => Config::CHAN_VESE,
        }
    }
}

/// `--arithmetic`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ArithmeticOption {
    /// IEEE 754 single precision, 8 bytes a pixel.
    #[default]
    F32,
    /// Fixed point, 24 fraction bits, 8 bytes a pixel.
    Q24,
    /// Fixed point in 16 bits, 4 bytes a pixel.
    Q11,
}

impl ArithmeticOption {
    /// Checks a configuration for this arithmetic.
    ///
    /// # Errors
    /// As [`Config::validate`], and the noise-aware segmentation in 16 bits.
    pub fn validate(self, config: &Config) -> Result<(), Error> {
        match self {
            ArithmeticOption::Q11 if config.detection.is_some() => Err(Error::Arithmetic {
                name: Q11::NAME,
                reason: "the noise-aware segmentation needs cells of 32 bits, for signal-to-noise from a fraction \
                         of the noise to bright stars; the paper's presets run in 16",
            }),
            ArithmeticOption::F32 => config.validate::<F32>(),
            ArithmeticOption::Q24 => config.validate::<Q24>(),
            ArithmeticOption::Q11 => config.validate::<Q11>(),
        }
    }

    /// Segments in this arithmetic; an image in which nothing can stand out has no source.
    ///
    /// # Errors
    /// As [`segment_in`].
    pub fn segment(self, config: &Config, image: &Image, drive: &mut Drive<'_>) -> Result<Segmentation, Error> {
        let (pixels, width, height) = (&image.pixels, image.width, image.height);
        self.validate(config)?;
        let (run, name) = match (self, &config.detection) {
            (ArithmeticOption::Q24, Some(detection)) => {
                (detection::segment::<Fixed14>(detection, pixels, width, drive), Q24::NAME)
            }
            (ArithmeticOption::F32, _) => (segment(config, pixels, width, height, drive), <F32>::NAME),
            (ArithmeticOption::Q24, None) => (segment_in::<Q24>(config, pixels, width, height, drive), Q24::NAME),
            (ArithmeticOption::Q11, _) => (segment_in::<Q11>(config, pixels, width, height, drive), Q11::NAME),
        };
        run.or_else(|refused| nothing::found(refused, image, name, drive))
    }
}

/// `--normalize`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalizeOption {
    /// By the extremes.
    Minmax,
    /// By the percentiles of `--range`.
    Percentile,
    /// By so many standard deviations below and above the sky.
    Noise(f64, f64),
}

/// `--rescale`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[allow(missing_docs, reason = "the names are the documentation")]
pub enum RescaleOption {
    None,
    R1,
    R2,
    R3,
}

/// `--tau`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TauOption {
    /// By Otsu's method.
    Otsu,
    /// By Kapur's.
    Kapur,
    /// By Rosin's.
    Rosin,
    /// So many standard deviations above the sky.
    Noise(f64),
    /// A given value.
    Value(f64),
}

/// `--filter`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[allow(missing_docs, reason = "the names are the documentation")]
pub enum FilterOption {
    None,
    Heat,
    Pm,
}

/// `--pm`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[allow(missing_docs, reason = "the names are the documentation")]
pub enum PmOption {
    F1,
    F2,
}

/// `--order`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[allow(missing_docs, reason = "the names are the documentation")]
pub enum OrderOption {
    RescaleFirst,
    FilterFirst,
}

/// `--edge`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[allow(missing_docs, reason = "the names are the documentation")]
pub enum EdgeOption {
    G1,
    G2,
    #[value(name = "g2mod")]
    G2Mod,
}

/// `--scheme`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[allow(missing_docs, reason = "the names are the documentation")]
pub enum SchemeOption {
    Fd,
    Sl,
    FdCurvature,
    SlCurvature,
    FdFiltered,
    ChanVese,
    FastMarching,
}

/// `--start`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StartOption {
    /// At the frame's border.
    Frame,
    /// Near the objects.
    Threshold,
    /// Where a map says.
    Map(Place),
}

/// `--band`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BandOption {
    /// The paper's front.
    None,
    /// Saturated at so many pixels.
    Pixels(f64),
}

/// `--curvature-form`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[allow(missing_docs, reason = "the names are the documentation")]
pub enum CurvatureFormOption {
    Consistent,
    Printed,
}

/// `--stop`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[allow(missing_docs, reason = "the names are the documentation")]
pub enum StopOption {
    Paper,
    Rate,
}

pub(super) fn pair(text: &str) -> Result<(f64, f64), String> {
    let (low, high) = text.split_once(',').ok_or("two numbers with a comma between them are wanted")?;
    let number = |text: &str| text.trim().parse().map_err(|_| format!("'{text}' is not a number"));
    Ok((number(low)?, number(high)?))
}

pub(super) fn normalize(text: &str) -> Result<NormalizeOption, String> {
    match (text, text.strip_prefix("noise:")) {
        ("minmax", _) => Ok(NormalizeOption::Minmax),
        ("percentile", _) => Ok(NormalizeOption::Percentile),
        ("noise", _) => Ok(NormalizeOption::Noise(3.0, 30.0)),
        (_, Some(units)) => pair(units).map(|(below, above)| NormalizeOption::Noise(below, above)),
        _ => Err(format!("'{text}' is none of minmax, percentile, noise and noise:LOW,HIGH")),
    }
}

pub(super) fn band(text: &str) -> Result<BandOption, String> {
    match text {
        "none" => Ok(BandOption::None),
        _ => text.parse().map(BandOption::Pixels).map_err(|_| format!("'{text}' is neither none nor a number")),
    }
}

pub(super) fn start(text: &str) -> Result<StartOption, String> {
    Ok(match text {
        "frame" => StartOption::Frame,
        "threshold" => StartOption::Threshold,
        file => StartOption::Map(Place::new(file)),
    })
}

pub(super) fn tau(text: &str) -> Result<TauOption, String> {
    let number = |text: &str| text.parse::<f64>();
    match (text, text.strip_prefix("noise:")) {
        ("otsu", _) => Ok(TauOption::Otsu),
        ("kapur", _) => Ok(TauOption::Kapur),
        ("rosin", _) => Ok(TauOption::Rosin),
        (_, Some(units)) => number(units).map(TauOption::Noise),
        _ => number(text).map(TauOption::Value),
    }
    .map_err(|_| format!("'{text}' is none of otsu, kapur, rosin, noise:K and a number"))
}
