//! Sky coordinates of pixels, from an image's header (Greisen and Calabretta 2002,
//! doi:10.1051/0004-6361:20021326 and doi:10.1051/0004-6361:20021327).
//!
//! Pixel, SIP, linear step, what may follow it (TPV, the surfaces of TNX and ZPX, a plate solution) and the
//! rotation of the sphere are worked out here, the projections by the `mapproj` crate. Pixel positions count from 0. What is not supported, or stands in the
//! header and cannot be read, is refused in words: no position is better than a wrong one.

mod distortion;
mod frame;
mod keys;
mod linear;
mod patch;
mod plate;
mod projection;
mod rotation;
mod wat;

pub use frame::Frame;
pub use patch::Patch;

use crate::read::Header;
use distortion::{Sip, Tpv};
use keys::Keys;
use plate::Plate;
use projection::Projection;
use rotation::Rotation;
use wat::Wat;

/// The coordinate system of an image.
///
/// ```
/// use skyfront::read::{Card, Header};
/// use skyfront::sky::Sky;
///
/// let cards = [
///     "CTYPE1  = 'RA---TAN'", "CTYPE2  = 'DEC--TAN'", "CRPIX1  = 50.0", "CRPIX2  = 50.0",
///     "CRVAL1  = 250.4", "CRVAL2  = 36.5", "CDELT1  = -0.001", "CDELT2  = 0.001",
/// ];
/// let header = Header::new(cards.iter().map(|card| Card::new(card)).collect());
/// let sky = Sky::of(&header)?.expect("there are coordinates");
/// // Pixels count from 0 here, in FITS from 1.
/// let (ra, dec) = sky.position(49.0, 49.0).expect("it lies on the sky");
/// assert!((ra - 250.4).abs() < 1e-9 && (dec - 36.5).abs() < 1e-9);
/// let (x, y) = sky.pixel(250.4, 36.51).expect("it lies in the image's plane");
/// assert!((x - 49.0).abs() < 1e-6 && (y - 59.0).abs() < 1e-3);
/// # Ok::<(), String>(())
/// ```
#[derive(Debug)]
pub struct Sky {
    reference: [f64; 2],
    sip: Option<Sip>,
    /// Degrees per pixel; rows are longitude and latitude. Of a plate, millimetres.
    matrix: [[f64; 2]; 2],
    after: Option<After>,
    projection: Projection,
    rotation: Rotation,
    frame: Frame,
}

/// What follows the linear step.
#[derive(Debug)]
enum After {
    Tpv(Box<Tpv>),
    Wat(Wat),
    Plate(Plate),
}

impl After {
    fn apply(&self, plane: [f64; 2]) -> [f64; 2] {
        match self {
            After::Tpv(tpv) => tpv.apply(plane),
            After::Wat(wat) => wat.apply(plane),
            After::Plate(plate) => plate.apply(plane),
        }
    }
}

impl Sky {
    /// The celestial coordinates of a header; none where its axes are not celestial.
    ///
    /// # Errors
    /// What is not supported or cannot be read, in words.
    pub fn of(header: &Header) -> Result<Option<Sky>, String> {
        Sky::alternate(header, None)
    }

    /// Those of its alternate system with this letter; without one its primary system.
    ///
    /// # Errors
    /// As [`Sky::of`].
    pub fn alternate(header: &Header, letter: Option<char>) -> Result<Option<Sky>, String> {
        let keys = Keys::of(header, letter)?;
        if let Some(plate) = Plate::of(&keys)? {
            return Sky::on_plate(plate, &keys).map(Some);
        }
        let Some(Axes { numbers, own, kind }) = Axes::of(&keys)? else { return Ok(None) };
        if let Some(card) = header.cards().iter().find(|card| is_lookup(card.keyword())) {
            return Err(format!("distortion by a lookup table ({})", card.keyword()));
        }
        let (name, suffix) = kind.split_at_checked(3).ok_or(format!("projection {kind}"))?;
        let after = match name {
            "TPV" => Some(After::Tpv(Tpv::of(&keys, numbers).into())),
            "TAN" if is_scamp(&keys, numbers) => Some(After::Tpv(Tpv::of(&keys, numbers).into())),
            "TNX" | "ZPX" => Some(After::Wat(Wat::of(&keys, numbers)?)),
            _ => None,
        };
        // What belongs to the correction is no parameter of the projection.
        let (name, keys) = match (name, &after) {
            ("ZPX", _) => ("ZPN", keys.with_parameters(numbers[1], &wat::parameters(&keys, numbers[1])?)),
            (_, Some(_)) => ("TAN", keys.without_parameters()),
            (name, None) => (name, keys),
        };
        let projection = Projection::new(name, &keys, numbers[1])?;
        let sip = sip(&keys, suffix)?;
        if sip.is_some() && after.is_some() {
            return Err("SIP and another distortion together".to_owned());
        }
        let mut centre = [0.0; 2];
        for (centre, axis) in centre.iter_mut().zip(numbers) {
            *centre = keys.real(&format!("CRVAL{axis}")).unwrap_or(0.0) * linear::degrees(&keys, axis)?;
        }
        if centre[1].abs() > 90.0 {
            return Err(format!("CRVAL{} = {}", numbers[1], centre[1]));
        }
        let rotation = Rotation::new(&keys, numbers[0], projection.theta0, centre)?;
        Ok(Some(Sky {
            reference: ["CRPIX1", "CRPIX2"].map(|name| keys.real(name).unwrap_or(0.0)),
            sip,
            matrix: linear::matrix(&keys, numbers)?,
            after,
            projection,
            rotation,
            frame: own.map_or_else(|| Frame::equatorial(&keys), Ok)?,
        }))
    }

    /// The coordinates of a photographic plate. They go before those of `CTYPE`, which for a plate are an
    /// approximation.
    fn on_plate(plate: Plate, keys: &Keys) -> Result<Sky, String> {
        let keys = &keys.without_parameters();
        let projection = Projection::new("TAN", keys, 2)?;
        Ok(Sky {
            reference: plate.reference,
            sip: None,
            matrix: plate.matrix,
            rotation: Rotation::new(&Keys::default(), 1, projection.theta0, plate.centre)?,
            after: Some(After::Plate(plate)),
            projection,
            frame: Frame::equatorial(keys)?,
        })
    }

    /// Right ascension and declination in degrees, in [`Sky::frame`], of a pixel position that
    /// counts from 0; none where the projection does not reach.
    pub fn position(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        angles(self.frame.equator(self.direction(x, y)?))
    }

    /// Longitude and latitude in degrees along the header's own axes.
    pub fn own_position(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        angles(self.direction(x, y)?)
    }

    fn direction(&self, x: f64, y: f64) -> Option<[f64; 3]> {
        // FITS pixels count from 1.
        let offset = [x + 1.0 - self.reference[0], y + 1.0 - self.reference[1]];
        let [u, v] = self.sip.as_ref().map_or(offset, |sip| sip.apply(offset));
        let plane = self.matrix.map(|row| row[0] * u + row[1] * v);
        let plane = self.after.as_ref().map_or(plane, |after| after.apply(plane));
        Some(self.rotation.celestial(self.projection.native(plane)?))
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

    /// The pixel position, from 0, of a right ascension and declination in degrees, in
    /// [`Sky::frame`]; none where no search from the reference pixel leads there.
    pub fn pixel(&self, ra: f64, dec: f64) -> Option<(f64, f64)> {
        const STEPS: usize = 50;
        // Pixels.
        const CLOSE: f64 = 1e-6;
        let (mut x, mut y) = (self.reference[0] - 1.0, self.reference[1] - 1.0);
        for _ in 0..STEPS {
            let (at, patch) = (self.position(x, y)?, self.patch(x, y)?);
            let east = ((ra - at.0 + 540.0).rem_euclid(360.0) - 180.0) * dec.to_radians().cos() * 3600.0;
            let (dx, dy) = patch.pixels(east, (dec - at.1) * 3600.0)?;
            (x, y) = (x + dx, y + dy);
            if dx.abs() < CLOSE && dy.abs() < CLOSE {
                return Some((x, y));
            }
        }
        None
    }

    /// The sky around a pixel position; none where the projection does not reach.
    pub fn patch(&self, x: f64, y: f64) -> Option<Patch> {
        let step = |dx: f64, dy: f64| {
            let (from, to) = (self.position(x - dx, y - dy)?, self.position(x + dx, y + dy)?);
            let east = (to.0 - from.0 + 540.0).rem_euclid(360.0) - 180.0;
            let middle = 0.5 * (from.1 + to.1);
            Some([east * middle.to_radians().cos(), to.1 - from.1].map(|degrees| degrees * 3600.0))
        };
        Some(Patch { along_x: step(0.5, 0.0)?, along_y: step(0.0, 0.5)? })
    }

    /// What right ascension and declination refer to.
    pub fn frame(&self) -> Frame {
        self.frame
    }
}

/// Longitude and latitude of a direction, degrees.
fn angles([x, y, z]: [f64; 3]) -> Option<(f64, f64)> {
    let longitude = y.atan2(x).to_degrees().rem_euclid(360.0);
    let latitude = z.atan2(x.hypot(y)).to_degrees();
    // Rounding may bring a tiny negative angle up to 360 itself.
    let longitude = if longitude < 360.0 { longitude } else { 0.0 };
    (longitude.is_finite() && latitude.is_finite()).then_some((longitude, latitude))
}

/// The celestial axes of a header.
struct Axes {
    /// The numbers of the longitude and the latitude axis.
    numbers: [usize; 2],
    /// The frame, where the axes are not right ascension and declination.
    own: Option<Frame>,
    /// What follows their names, without dashes in front: projection and suffix.
    kind: String,
}

impl Axes {
    fn of(keys: &Keys) -> Result<Option<Axes>, String> {
        let types = ["CTYPE1", "CTYPE2"].map(|keyword| keys.text(keyword).unwrap_or_default());
        let parts = types.map(|text| text.split_once('-').unwrap_or((text, "")));
        let [(first, one), (second, two)] = parts.map(|(name, kind)| (name, kind.trim_start_matches('-')));
        let odd = || format!("axes {} and {}", types[0], types[1]);
        let (numbers, own) = match (first, second) {
            ("RA", "DEC") => ([1, 2], None),
            ("DEC", "RA") => ([2, 1], None),
            ("GLON", "GLAT") => ([1, 2], Some(Frame::Galactic)),
            ("GLAT", "GLON") => ([2, 1], Some(Frame::Galactic)),
            ("ELON", "ELAT") => ([1, 2], Some(Frame::Ecliptic)),
            ("ELAT", "ELON") => ([2, 1], Some(Frame::Ecliptic)),
            _ if one.is_empty() && two.is_empty() => return Ok(None),
            _ => return Err(odd()),
        };
        if own == Some(Frame::Ecliptic) && keys.real("EQUINOX").is_some_and(|year| year != 2000.0) {
            return Err(format!("ecliptic of equinox {}", keys.real("EQUINOX").unwrap_or(0.0)));
        }
        match (one, two) {
            ("", "") => Ok(None),
            (one, two) if one == two => Ok(Some(Axes { numbers, own, kind: one.to_owned() })),
            _ => Err(odd()),
        }
    }
}

/// Whether a keyword announces corrections that lie in another HDU.
fn is_lookup(keyword: &str) -> bool {
    ["CPDIS", "CQDIS", "D2IMDIS", "D2IMARR"].iter().any(|name| keyword.starts_with(name))
}

fn sip(keys: &Keys, suffix: &str) -> Result<Option<Sip>, String> {
    let present = keys.real("A_ORDER").is_some() || keys.real("B_ORDER").is_some();
    match (suffix, present) {
        ("-SIP", true) => Sip::of(keys).map(Some),
        ("", true) => Err("SIP coefficients without -SIP in CTYPE".to_owned()),
        ("" | "-SIP", false) => Ok(None),
        _ => Err(format!("distortion {}", suffix.trim_start_matches('-'))),
    }
}

/// Whether TAN has the coefficients of TPV, as SCAMP wrote them: TAN itself has no parameter of the
/// latitude axis, and of the longitude axis those of the poles only.
fn is_scamp(keys: &Keys, [longitude, latitude]: [usize; 2]) -> bool {
    let beyond = |(m, _): (&str, f64)| m.parse::<u8>().is_ok_and(|m| m > 4);
    let across = keys.numbers(&format!("PV{latitude}_")).any(|(_, value)| value != 0.0);
    across && keys.numbers(&format!("PV{longitude}_")).any(beyond)
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::read::Card;

    #[test]
    fn a_direction_that_is_none_has_no_angles() {
        assert_eq!(angles([0.0, 1.0, 0.0]), Some((90.0, 0.0)));
        for direction in [[f64::NAN, 0.0, 0.5], [1.0, f64::NAN, 0.0], [1.0, 0.0, f64::NAN]] {
            assert_eq!(angles(direction), None, "{direction:?}");
        }
    }

    #[test]
    fn coefficients_of_both_axes_are_scamp_s_and_parameters_of_tan_are_not() {
        let is_scamp_with = |names: &[&str]| {
            let cards = names.iter().map(|name| Card::new(&format!("{name:8}= 1.5"))).collect();
            let keys = Keys::of(&Header::new(cards), None).expect("they are numbers");
            is_scamp(&keys, [1, 2])
        };
        assert!(is_scamp_with(&["PV1_5", "PV2_1"]));
        for names in [&["PV1_5"][..], &["PV2_1"], &["PV1_1", "PV1_4", "PV2_1"]] {
            assert!(!is_scamp_with(names), "{names:?}");
        }
    }
}
