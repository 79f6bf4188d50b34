//! `skyfront simulate`: a sky and its truth as two FITS files, for scoring.

use crate::truth;
use crate::write::Products;
use crate::write::fits::Writer;
use anyhow::Result;
use clap::{Args, ValueEnum};
use skyfront_core::simulate::{Conditions, Kind, Optics, Sky};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder for sky.fits and truth.fits; made where it is absent.
    #[arg(long, short)]
    out: PathBuf,
    /// What kind of sky.
    #[arg(long, value_enum, default_value = "bright")]
    kind: KindOption,
    /// The same seed and size give the same sky.
    #[arg(long, default_value = "1")]
    seed: u32,
    /// Columns and rows.
    #[arg(long, default_value = "300", value_parser = clap::value_parser!(u16).range(8..=8192))]
    side: u16,
    /// What the telescope makes of a point.
    #[arg(long, value_enum, default_value = "round", help_heading = "Telescope and camera")]
    optics: OpticsOption,
    /// Galaxies brighter on one side than opposite.
    #[arg(long, help_heading = "Telescope and camera")]
    lopsided: bool,
    /// How much brighter the sky is in the last column than in the first, in noise units.
    #[arg(long, default_value = "0", value_name = "X", value_parser = slope, allow_negative_numbers = true,
        help_heading = "Telescope and camera")]
    gradient: f32,
    /// No pixel is brighter, in noise units; stars bleed along their columns.
    #[arg(long, value_name = "X", value_parser = above_zero, help_heading = "Telescope and camera")]
    full_well: Option<f32>,
    /// Distance of two values, in noise units: whole counts [default: as many as there are numbers].
    #[arg(long, value_name = "X", value_parser = above_zero, help_heading = "Telescope and camera")]
    step: Option<f32>,
    /// Replace files that exist.
    #[arg(long)]
    overwrite: bool,
}

/// `--kind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum KindOption {
    /// High signal to noise: a few bright stars and galaxies leave the rest dark.
    Bright,
    /// Stars and galaxies in strong noise.
    Noisy,
    /// Stars only, many of them.
    Stars,
}

/// `--optics`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum OpticsOption {
    /// A round core with wings.
    Round,
    /// A head with a tail that points away from the middle and grows with the distance from there.
    Coma,
    /// A line: the telescope moved.
    Trail,
    /// A ring: the focus is off.
    Ring,
}

impl From<OpticsOption> for Optics {
    fn from(option: OpticsOption) -> Optics {
        match option {
            OpticsOption::Round => Optics::Round,
            OpticsOption::Coma => Optics::Coma,
            OpticsOption::Trail => Optics::Trail,
            OpticsOption::Ring => Optics::Ring,
        }
    }
}

fn number(text: &str, is_right: impl Fn(f32) -> bool, bound: &str) -> Result<f32, String> {
    text.parse().ok().filter(|&value| is_right(value)).ok_or_else(|| format!("must be {bound}"))
}

fn slope(text: &str) -> Result<f32, String> {
    number(text, |value| value.abs() <= 1e6, "at most 1000000 up or down")
}

fn above_zero(text: &str) -> Result<f32, String> {
    number(text, |value| value > 0.0 && value <= 1e6, "above 0 and at most 1000000")
}

const SKY: &str = "sky.fits";
const TRUTH: &str = "truth.fits";

pub fn run(arguments: &Arguments) -> Result<()> {
    let kind = match arguments.kind {
        KindOption::Bright => Kind::Bright,
        KindOption::Noisy => Kind::Noisy,
        KindOption::Stars => Kind::Stars,
    };
    let side = usize::from(arguments.side);
    let mut products = Products::plan(&arguments.out, &[SKY, TRUTH], arguments.overwrite)?;
    let conditions = Conditions {
        optics: arguments.optics.into(),
        lopsided: arguments.lopsided,
        gradient: arguments.gradient,
        full_well: arguments.full_well.unwrap_or(Conditions::PERFECT.full_well),
        step: arguments.step.unwrap_or(Conditions::PERFECT.step),
    };
    let sky = Sky::new(kind, arguments.seed, side, side).under(conditions)?;
    let image = truth::observed(sky, side, side);
    let labels: Vec<f32> = truth::labels(&sky, side, side).into_iter().map(|label| label as f32).collect();
    for (name, pixels) in [(SKY, &image.pixels), (TRUTH, &labels)] {
        products.write_path(name, |path| {
            let mut writer = Writer::create(path)?;
            writer.image((side, side), &[], |y, row: &mut [f32]| {
                row.copy_from_slice(&pixels[y * side..(y + 1) * side]);
            })?;
            writer.finish()
        })?;
    }
    products.publish()?;
    Ok(())
}
