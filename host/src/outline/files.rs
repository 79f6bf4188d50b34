//! Outlines as DS9 region files and as JSON.

use super::Ring;
use crate::sky::Sky;
use serde_json::{Value, json};
use std::io::{self, Write};

/// The region files: in pixels, and on the sky where the image has coordinates.
pub const REGIONS: [&str; 2] = ["regions.reg", "regions_sky.reg"];
/// The outlines in JSON.
pub const POLYGONS: &str = "outlines.json";

/// The first lines of a region file (http://ds9.si.edu/doc/ref/region.html).
const HEAD: &str = "# Region file format: DS9 version 4.1\nglobal color=orange width=1 font=\"helvetica 10 normal\"";

/// Writes DS9 polygons, in image coordinates or on the sky. Holes are excluded regions.
///
/// # Errors
/// What the writer reports.
pub fn write_regions(rings: &[Ring], sky: Option<&Sky>, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{HEAD}\n{}", sky.map_or("image", |sky| sky.frame().name()))?;
    for ring in rings {
        let corners: Option<Vec<String>> = match sky {
            Some(sky) => ring
                .points
                .iter()
                .map(|&(x, y)| sky.position(x, y).map(|(ra, dec)| format!("{ra:.8},{dec:.8}")))
                .collect(),
            None => Some(ring.points.iter().map(|&(x, y)| format!("{:.3},{:.3}", x + 1.0, y + 1.0)).collect()),
        };
        // An outline that the projection does not reach is in the image file only.
        if let Some(corners) = corners {
            let sign = if ring.hole { "-" } else { "" };
            writeln!(out, "{sign}polygon({}) # text={{{}}}", corners.join(","), ring.label)?;
        }
    }
    Ok(())
}

/// Writes a JSON array with one line a ring: label, hole, pixel corners (the first pixel's centre
/// is 1), and sky corners in degrees where there are coordinates.
///
/// # Errors
/// What the writer reports.
pub fn write_polygons(rings: &[Ring], sky: Option<&Sky>, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "[")?;
    for (index, ring) in rings.iter().enumerate() {
        let comma = if index + 1 < rings.len() { "," } else { "" };
        writeln!(out, "{}{comma}", object(ring, sky))?;
    }
    writeln!(out, "]")
}

fn object(ring: &Ring, sky: Option<&Sky>) -> Value {
    let thousandth = |value: f64| (value * 1e3).round() / 1e3;
    let fine = |value: f64| (value * 1e8).round() / 1e8;
    let pixel: Vec<[f64; 2]> = ring.points.iter().map(|&(x, y)| [thousandth(x + 1.0), thousandth(y + 1.0)]).collect();
    let mut object = json!({ "label": ring.label, "hole": ring.hole, "pixel": pixel });
    if let Some(sky) = sky {
        let corners: Vec<Option<[f64; 2]>> =
            ring.points.iter().map(|&(x, y)| sky.position(x, y).map(|(ra, dec)| [fine(ra), fine(dec)])).collect();
        object["sky"] = json!(corners);
        object["frame"] = json!(sky.frame().name());
    }
    object
}
