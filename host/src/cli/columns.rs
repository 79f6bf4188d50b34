//! `skyfront columns`: the columns of the catalogue and the bits of its flags.

use super::say::{Stdout, Unwritten};
use crate::catalogue::{Setting, columns};
use crate::sky::Frame;
use skyfront_core::flags::FLAGS;

/// Prints all columns that a catalogue can have, and all flags.
pub fn run() -> Result<(), Unwritten> {
    let setting =
        Setting { unit: "image".to_owned(), frame: Some(Frame::Icrs), apertures: vec![3.0], zero_point: Some(25.0) };
    writeln!(Stdout, "{:18} {:9} meaning", "column", "unit")?;
    for column in columns(&setting) {
        writeln!(Stdout, "{:18} {:9} {}", column.name, column.unit, column.description)?;
    }
    writeln!(Stdout)?;
    writeln!(
        Stdout,
        "Unit image: that of the pixels (BUNIT). ra, dec and pa are there when the header has coordinates,"
    )?;
    writeln!(
        Stdout,
        "in its own frame; one pair of flux_aper columns for each of --apertures (here 3); magnitudes with"
    )?;
    writeln!(Stdout, "--zero-point. What has no value is empty in CSV and ECSV, NaN in FITS, null in JSON.")?;
    writeln!(Stdout)?;
    writeln!(Stdout, "{:>5} flag", "bit")?;
    for flag in FLAGS {
        writeln!(Stdout, "{:5} {:15} {}", flag.bit, flag.name, flag.meaning)?;
    }
    Ok(())
}
