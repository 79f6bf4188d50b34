//! What right ascension and declination refer to.

use crate::read::Header;

/// The celestial frame of a header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// International Celestial Reference System.
    Icrs,
    /// FK5, equinox J2000.
    Fk5,
    /// FK4, equinox B1950.
    Fk4,
}

impl Frame {
    /// The frame of a header, by the standard's defaults: ICRS where neither `RADESYS` nor
    /// `EQUINOX` is given, FK4 for equinoxes before 1984, FK5 from then on.
    ///
    /// # Errors
    /// Frames and equinoxes that catalogues and DS9 know no name for.
    pub fn of(header: &Header) -> Result<Frame, String> {
        let equinox = header.real("EQUINOX").or_else(|| header.real("EPOCH")).filter(|&year| year != 0.0);
        let system = header.text("RADESYS").or_else(|| header.text("RADECSYS")).unwrap_or_default();
        match (system.trim(), equinox) {
            ("ICRS", _) | ("", None) => Ok(Frame::Icrs),
            ("FK5", None | Some(2000.0)) | ("", Some(2000.0)) => Ok(Frame::Fk5),
            ("FK4", None | Some(1950.0)) | ("", Some(1950.0)) => Ok(Frame::Fk4),
            (system, equinox) => Err(format!("frame {system} of equinox {}", equinox.unwrap_or(0.0))),
        }
    }

    /// The frame's name, as DS9 and astropy know it.
    pub fn name(self) -> &'static str {
        match self {
            Frame::Icrs => "icrs",
            Frame::Fk5 => "fk5",
            Frame::Fk4 => "fk4",
        }
    }
}
