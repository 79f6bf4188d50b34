//! `skyfront columns`: the columns of the catalogue and the bits of its flags.

use super::say::{Stdout, Unwritten};
use crate::catalogue::names::KNOWN;
use crate::catalogue::{Setting, columns};
use crate::sky::Frame;
use clap::Args;
use skyfront_core::sources::flags::FLAGS;

#[derive(Debug, Args)]
pub struct Arguments {
    /// Print which of SExtractor's parameters is which column instead.
    #[arg(long)]
    sextractor: bool,
}

/// Prints what is asked for.
///
/// # Errors
/// [`Unwritten`].
pub fn run(arguments: &Arguments) -> Result<(), Unwritten> {
    if arguments.sextractor { names() } else { all() }
}

/// All columns that a catalogue can have, and all flags.
fn all() -> Result<(), Unwritten> {
    let setting = Setting {
        unit: "image".to_owned(),
        frame: Some(Frame::Icrs),
        refused: false,
        places: false,
        apertures: vec![3.0],
        zero_point: Some(25.0),
    };
    writeln!(Stdout, "{:19} {:13} meaning", "column", "unit")?;
    for column in columns(&setting) {
        let mark = if column.is_usual() { ' ' } else { '+' };
        writeln!(Stdout, "{:18}{mark} {:13} {}", column.name, column.unit, column.description)?;
    }
    writeln!(
        Stdout,
        "\n+ with --columns only. Unit image: that of the pixels (BUNIT). ra, dec, pa, a_sky and b_sky are there when\n\
        the header has coordinates, in its own frame, glon and glat or elon and elat beside them when its axes are\n\
        those; flux_aper columns for each of --apertures (here 3); magnitudes with --zero-point. What has no value\n\
        is empty in CSV, ECSV and VOTable, NaN in FITS, null in JSON.\n"
    )?;
    writeln!(Stdout, "{:>5} flag", "bit")?;
    for flag in FLAGS {
        writeln!(Stdout, "{:5} {:15} {}", flag.bit, flag.name, flag.meaning)?;
    }
    Ok(())
}

/// The table of SExtractor's names.
fn names() -> Result<(), Unwritten> {
    writeln!(Stdout, "{:16} column", "SExtractor")?;
    for known in &KNOWN {
        for theirs in known.sextractor {
            writeln!(Stdout, "{theirs:16} {}", known.name.replace('#', "N"))?;
        }
    }
    writeln!(
        Stdout,
        "\nNot the same: A_WORLD and B_WORLD are in degrees there, in arcsec here; FWHM_IMAGE is that of a Gaussian fit\n\
        to the core there, of the second moments here; BACKGROUND is the value at the centre there, the mean under the\n\
        source here; apertures are diameters there, radii here; flags has other bits than FLAGS, flags_sex the same."
    )
}
