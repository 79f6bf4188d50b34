//! `skyfront columns`: the columns of the catalogue and the bits of its flags.

use crate::catalogue::{Setting, columns};
use crate::sky::Frame;
use skyfront_core::flags::FLAGS;

/// Prints all columns that a catalogue can have, and all flags.
pub fn run() {
    let setting =
        Setting { unit: "image".to_owned(), frame: Some(Frame::Icrs), apertures: vec![3.0], zero_point: Some(25.0) };
    println!("{:18} {:9} meaning", "column", "unit");
    for column in columns(&setting) {
        println!("{:18} {:9} {}", column.name, column.unit, column.description);
    }
    println!();
    println!("Unit image: that of the pixels (BUNIT). ra, dec and pa are there when the header has coordinates,");
    println!("in its own frame; one pair of flux_aper columns for each of --apertures (here 3); magnitudes with");
    println!("--zero-point. What has no value is empty in CSV and ECSV, NaN in FITS, null in JSON.");
    println!();
    println!("{:>5} flag", "bit");
    for flag in FLAGS {
        println!("{:5} {:15} {}", flag.bit, flag.name, flag.meaning);
    }
}
