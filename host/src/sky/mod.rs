//! Sky coordinates of pixels, from an image's header (Greisen and Calabretta 2002,
//! doi:10.1051/0004-6361:20021326 and doi:10.1051/0004-6361:20021327).
//!
//! Pixel, SIP, linear step and TPV are worked out here, the projection onto the sphere by the
//! `wcs` crate. (Its own SIP, version 0.4, raises to wrong powers.) Pixel positions count from 0.
//! What is not supported is refused in words: no position is better than a wrong one.

mod distortion;
mod frame;
mod linear;

pub use frame::Frame;

use crate::read::Header;
use distortion::{Sip, Tpv};
use serde_json::json;
use wcs::{ImgXY, WCS, WCSParams};

/// Projections whose results are tested against astropy's.
const PROJECTIONS: [&str; 5] = ["TAN", "SIN", "STG", "ARC", "ZEA"];

/// The coordinate system of an image.
#[derive(Debug)]
pub struct Sky {
    reference: [f64; 2],
    sip: Option<Sip>,
    /// Degrees a pixel; rows are longitude and latitude.
    matrix: [[f64; 2]; 2],
    tpv: Option<Tpv>,
    /// From the projection plane, in degrees, to the sphere.
    sphere: WCS,
    frame: Frame,
}

impl Sky {
    /// The celestial coordinates of a header; none where its axes are not celestial.
    ///
    /// # Errors
    /// What is not supported, in words.
    pub fn of(header: &Header) -> Result<Option<Sky>, String> {
        let Some((axes, kind)) = celestial(header)? else { return Ok(None) };
        if let Some(card) = header.cards().iter().find(|card| is_lookup(card.keyword())) {
            return Err(format!("distortion by a lookup table ({})", card.keyword()));
        }
        let (projection, suffix) = kind.split_at_checked(3).ok_or(format!("projection {kind}"))?;
        let tpv = (projection == "TPV").then(|| Tpv::of(header, axes));
        let projection = if tpv.is_some() { "TAN" } else { projection };
        if !PROJECTIONS.contains(&projection) {
            return Err(format!("projection {projection}"));
        }
        let sip = sip(header, suffix)?;
        if tpv.is_none() {
            without_parameters(header)?;
        }
        if sip.is_some() && tpv.is_some() {
            return Err("SIP and TPV together".to_owned());
        }
        Ok(Some(Sky {
            reference: [header.real("CRPIX1").unwrap_or(0.0), header.real("CRPIX2").unwrap_or(0.0)],
            sip,
            matrix: linear::matrix(header, axes)?,
            tpv,
            sphere: sphere(header, axes, projection)?,
            frame: Frame::of(header)?,
        }))
    }

    /// Right ascension and declination in degrees, in [`Sky::frame`], of a pixel position that
    /// counts from 0; none where the projection does not reach.
    pub fn position(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        // FITS pixels count from 1.
        let offset = [x + 1.0 - self.reference[0], y + 1.0 - self.reference[1]];
        let [u, v] = self.sip.as_ref().map_or(offset, |sip| sip.apply(offset));
        let plane = self.matrix.map(|row| row[0] * u + row[1] * v);
        let [xi, eta] = self.tpv.as_ref().map_or(plane, |tpv| tpv.apply(plane));
        let place = self.sphere.unproj(&ImgXY::new(xi, eta))?;
        let (longitude, latitude) = (place.lon().to_degrees().rem_euclid(360.0), place.lat().to_degrees());
        (longitude.is_finite() && latitude.is_finite()).then_some((longitude, latitude))
    }

    /// The direction on the sky of a direction in the image (radians from the x axis towards y):
    /// degrees from north through east, [0, 180), as an axis has two ends.
    pub fn position_angle(&self, x: f64, y: f64, theta: f64) -> Option<f64> {
        let (dx, dy) = (0.5 * theta.cos(), 0.5 * theta.sin());
        let (from, to) = (self.position(x - dx, y - dy)?, self.position(x + dx, y + dy)?);
        let east = (to.0 - from.0 + 540.0).rem_euclid(360.0) - 180.0;
        let middle = 0.5 * (from.1 + to.1);
        let angle = (east * middle.to_radians().cos()).atan2(to.1 - from.1).to_degrees().rem_euclid(180.0);
        // Rounding may bring a tiny negative angle up to 180 itself.
        Some(if angle < 180.0 { angle } else { 0.0 })
    }

    /// What right ascension and declination refer to.
    pub fn frame(&self) -> Frame {
        self.frame
    }
}

/// The numbers of the longitude and the latitude axis, and what follows their names: projection
/// and suffix, without dashes in front.
fn celestial(header: &Header) -> Result<Option<([usize; 2], String)>, String> {
    let types = ["CTYPE1", "CTYPE2"].map(|keyword| header.text(keyword).unwrap_or_default());
    let parts = types.each_ref().map(|text| text.trim().split_once('-').unwrap_or((text.trim(), "")));
    let [(first, one), (second, two)] = parts.map(|(name, kind)| (name, kind.trim_start_matches('-')));
    let axes = match (first, second) {
        ("RA", "DEC") => [1, 2],
        ("DEC", "RA") => [2, 1],
        _ if one.is_empty() && two.is_empty() => return Ok(None),
        _ => return Err(format!("axes {} and {}", types[0], types[1])),
    };
    match (one, two) {
        ("", "") => Ok(None),
        (one, two) if one == two => Ok(Some((axes, one.to_owned()))),
        _ => Err(format!("axes {} and {}", types[0], types[1])),
    }
}

/// Whether a keyword announces corrections that lie in another HDU.
fn is_lookup(keyword: &str) -> bool {
    ["CPDIS", "CQDIS", "D2IMDIS", "D2IMARR"].iter().any(|name| keyword.starts_with(name))
}

fn sip(header: &Header, suffix: &str) -> Result<Option<Sip>, String> {
    let present = header.text("A_ORDER").is_some() || header.text("B_ORDER").is_some();
    match (suffix, present) {
        ("-SIP", true) => Sip::of(header).map(Some),
        ("", true) => Err("SIP coefficients without -SIP in CTYPE".to_owned()),
        ("" | "-SIP", false) => Ok(None),
        _ => Err(format!("distortion {}", suffix.trim_start_matches('-'))),
    }
}

/// The supported projections have no parameters; old headers keep distortions there.
fn without_parameters(header: &Header) -> Result<(), String> {
    let parameter = |keyword: &str| {
        let numbers = keyword.strip_prefix("PV1_").or_else(|| keyword.strip_prefix("PV2_"));
        numbers.is_some_and(|m| m.parse::<u8>().is_ok())
    };
    let odd = header.cards().iter().find(|card| {
        let value = card.value().and_then(|text| text.trim().replace(['d', 'D'], "E").parse::<f64>().ok());
        parameter(card.keyword()) && value != Some(0.0)
    });
    odd.map_or(Ok(()), |card| Err(format!("parameter {} of a projection without parameters", card.keyword())))
}

/// The projection with the plane's degrees in place of pixels.
fn sphere(header: &Header, axes: [usize; 2], projection: &str) -> Result<WCS, String> {
    let centre = |axis: usize| header.real(&format!("CRVAL{axis}")).unwrap_or(0.0);
    let latitude = centre(axes[1]);
    if latitude.abs() > 90.0 {
        return Err(format!("CRVAL{} = {latitude}", axes[1]));
    }
    let parameters = json!({
        "NAXIS": 2, "NAXIS1": 1, "NAXIS2": 1,
        "CTYPE1": format!("RA---{projection}"),
        "CRPIX1": 0.0, "CRPIX2": 0.0,
        "CRVAL1": centre(axes[0]), "CRVAL2": latitude,
        "CD1_1": 1.0, "CD1_2": 0.0, "CD2_1": 0.0, "CD2_2": 1.0,
        "LONPOLE": header.real("LONPOLE"),
    });
    let parameters: WCSParams = serde_json::from_value(parameters).map_err(|error| error.to_string())?;
    WCS::new(&parameters).map_err(|error| error.to_string())
}
