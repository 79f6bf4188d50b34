//! What the two celestial axes of a header refer to.

use super::keys::Keys;

/// The celestial frame of a header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// International Celestial Reference System.
    Icrs,
    /// FK5, equinox J2000.
    Fk5,
    /// FK4, equinox B1950.
    Fk4,
    /// Galactic longitude and latitude; right ascension and declination are of the ICRS.
    Galactic,
    /// Longitude and latitude of the mean ecliptic of J2000, with right ascension and declination of
    /// the ICRS.
    Ecliptic,
}

/// From galactic directions to those of the ICRS, by way of FK5 as astropy goes.
const FROM_GALACTIC: [[f64; 3]; 3] = [
    [-0.054_875_657_712_591_86, 0.494_109_437_192_726_8, -0.867_666_137_559_657_9],
    [-0.873_437_051_955_616_2, -0.444_829_721_223_295_6, -0.198_076_337_273_000_7],
    [-0.483_835_073_616_715_8, 0.746_982_183_986_667_6, 0.455_983_813_687_302],
];

/// From directions of the mean ecliptic of J2000 (IAU 2006) to those of the ICRS.
const FROM_ECLIPTIC: [[f64; 3]; 3] = [
    [0.999_999_999_999_994_2, 3.289_700_416_258_306e-8, -1.020_704_472_070_512e-7],
    [-7.078_369_026_537_746e-8, 0.917_482_129_914_955_9, -0.397_776_999_444_045_2],
    [8.056_213_977_613_187e-8, 0.397_776_999_444_045_2, 0.917_482_129_914_955_9],
];

impl Frame {
    /// The frame of equatorial axes, by the standard's defaults: ICRS where neither `RADESYS` nor
    /// `EQUINOX` is given, FK4 for equinoxes before 1984, FK5 from then on.
    ///
    /// # Errors
    /// Frames and equinoxes that catalogues and DS9 know no name for.
    pub fn equatorial(keys: &Keys) -> Result<Frame, String> {
        let equinox = keys.real("EQUINOX").or_else(|| keys.real("EPOCH")).filter(|&year| year != 0.0);
        let system = keys.text("RADESYS").or_else(|| keys.text("RADECSYS")).unwrap_or_default();
        match (system, equinox) {
            ("ICRS", _) | ("", None) => Ok(Frame::Icrs),
            ("FK5", None | Some(2000.0)) | ("", Some(2000.0)) => Ok(Frame::Fk5),
            ("FK4", None | Some(1950.0)) | ("", Some(1950.0)) => Ok(Frame::Fk4),
            (system, equinox) => Err(format!("frame {system} of equinox {}", equinox.unwrap_or(0.0))),
        }
    }

    /// The frame of right ascension and declination, as DS9 and astropy know it.
    pub fn name(self) -> &'static str {
        match self {
            Frame::Icrs | Frame::Galactic | Frame::Ecliptic => "icrs",
            Frame::Fk5 => "fk5",
            Frame::Fk4 => "fk4",
        }
    }

    /// What the axes themselves are called, where they are not right ascension and declination.
    pub fn own_axes(self) -> Option<[&'static str; 2]> {
        match self {
            Frame::Galactic => Some(["glon", "glat"]),
            Frame::Ecliptic => Some(["elon", "elat"]),
            Frame::Icrs | Frame::Fk5 | Frame::Fk4 => None,
        }
    }

    /// A direction along the header's axes as one of right ascension and declination.
    pub fn equator(self, direction: [f64; 3]) -> [f64; 3] {
        let turned = |rows: [[f64; 3]; 3]| rows.map(|row| (0..3).map(|axis| row[axis] * direction[axis]).sum());
        match self {
            Frame::Galactic => turned(FROM_GALACTIC),
            Frame::Ecliptic => turned(FROM_ECLIPTIC),
            Frame::Icrs | Frame::Fk5 | Frame::Fk4 => direction,
        }
    }
}
