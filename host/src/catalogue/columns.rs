//! The registry of columns: headers, documentation and `skyfront columns` come from here.

use super::names::known;
use crate::measure::{Flux, Measured};
use crate::sky::Frame;
use skyfront_core::sources::flags::{self, FLAGS};
use std::fmt::Write;

/// A column: its name, unit and meaning, and how a source fills it.
pub struct Column {
    /// Name, the same in every format.
    pub name: String,
    /// Unit as FITS spells it; empty for none.
    pub unit: String,
    /// Meaning, one line.
    pub description: String,
    /// The value.
    pub value: Value,
}

/// How a column's value follows from a source; NaN stands for none.
pub enum Value {
    /// A whole number.
    Integer(Box<dyn Fn(&Measured) -> i64>),
    /// A real number, and the significant digits it is given in text.
    Real(Box<dyn Fn(&Measured) -> f64>, usize),
}

/// What the columns of a catalogue depend on.
#[derive(Clone, Debug, Default)]
pub struct Setting {
    /// Unit of the image's pixels.
    pub unit: String,
    /// Frame of right ascension and declination, where there are any.
    pub frame: Option<Frame>,
    /// Whether the header has coordinates that could not be used: their columns are there and empty.
    pub refused: bool,
    /// Whether places are measured, not sources.
    pub places: bool,
    /// Radii of the circular apertures, pixels.
    pub apertures: Vec<f64>,
    /// Magnitude of a flux of 1, where there are to be magnitudes.
    pub zero_point: Option<f64>,
}

impl Setting {
    /// Whether a column is in the catalogue when none is chosen.
    pub(super) fn usual(&self, name: &str) -> bool {
        let own = self.frame.and_then(Frame::own_axes);
        let shown = match name {
            "ra" | "dec" | "a_sky" | "b_sky" | "pa" => self.frame.is_some() || self.refused,
            "glon" | "glat" | "elon" | "elat" => own.is_some_and(|axes| axes.contains(&name)),
            _ => true,
        };
        let of_places = ["label", "x", "y", "ra", "dec", "glon", "glat", "elon", "elat", "flags"];
        let shown = shown && (!self.places || of_places.contains(&name) || name.contains("_aper_"));
        shown && known(name).is_none_or(|one| one.usual)
    }
}

/// Digits of most reals, as many as an f32 has; and of positions on the sky.
const DIGITS: usize = 9;
const SKY_DIGITS: usize = 12;

/// All columns that a catalogue can have, in order.
pub fn columns(setting: &Setting) -> Vec<Column> {
    let unit = setting.unit.as_str();
    let mut list = vec![
        integer("label", "", "label in the segmentation map", |m| i64::from(m.source.label)),
        real("x", "pixel", "centroid above the background; the first pixel's centre is 1", |m| m.shape.x + 1.0),
        real("y", "pixel", "centroid above the background; the first pixel's centre is 1", |m| m.shape.y + 1.0),
    ];
    list.extend(on_the_sky(setting.frame));
    list.extend(extent());
    list.extend(pixels(unit));
    list.extend(shape());
    list.extend(shape_on_the_sky());
    list.extend(fluxes(unit));
    for (index, &radius) in setting.apertures.iter().enumerate() {
        list.extend(in_circle(index, radius, unit, setting.zero_point));
    }
    list.extend(magnitudes(setting.zero_point.unwrap_or(f64::NAN)));
    list.extend(windowed(setting.frame));
    list.extend(petrosian(unit, setting.zero_point.unwrap_or(f64::NAN)));
    list.extend(beside(unit));
    list.extend(as_sextractor(unit));
    list.push(integer("flags", "", &flag_bits(), |m| i64::from(m.flags)));
    list.retain(|column| setting.zero_point.is_some() || !is_magnitude(&column.name));
    list
}

fn sky_angle(name: &str, description: String, value: impl Fn(&Measured) -> Option<f64> + 'static) -> Column {
    let value = Box::new(move |m: &Measured| value(m).unwrap_or(f64::NAN));
    Column { value: Value::Real(value, SKY_DIGITS), ..real(name, "deg", &description, |_| f64::NAN) }
}

fn on_the_sky(frame: Option<Frame>) -> [Column; 6] {
    let of = frame.map_or("whose frame is not known", Frame::name);
    let own = |name: &'static str, what: &str| {
        let axis = frame.and_then(Frame::own_axes).and_then(|axes| axes.iter().position(|&axis| axis == name));
        let value = move |m: &Measured| m.own_position.zip(axis).map(|(at, axis)| if axis == 0 { at.0 } else { at.1 });
        sky_angle(name, format!("{what} of the centroid"), value)
    };
    [
        sky_angle("ra", format!("right ascension of the centroid, {of}"), |m| m.position.map(|at| at.0)),
        sky_angle("dec", format!("declination of the centroid, {of}"), |m| m.position.map(|at| at.1)),
        own("glon", "galactic longitude"),
        own("glat", "galactic latitude"),
        own("elon", "ecliptic longitude, J2000,"),
        own("elat", "ecliptic latitude, J2000,"),
    ]
}

fn extent() -> [Column; 5] {
    // FITS coordinates count from 1.
    let fits = |index: u32| i64::from(index) + 1;
    [
        integer("xmin", "pixel", "first column of the bounding box, from 1", move |m| fits(m.source.columns.0)),
        integer("xmax", "pixel", "last column of the bounding box", move |m| fits(m.source.columns.1)),
        integer("ymin", "pixel", "first row of the bounding box, from 1", move |m| fits(m.source.rows.0)),
        integer("ymax", "pixel", "last row of the bounding box", move |m| fits(m.source.rows.1)),
        integer("area", "pixel", "number of pixels", |m| i64::from(m.source.area)),
    ]
}

fn pixels(unit: &str) -> [Column; 8] {
    [
        real("sum", unit, "sum of the pixel values, background included", |m| m.values.sum),
        real("mean", unit, "mean of the pixel values, background included", |m| m.values.mean),
        real("peak", unit, "greatest pixel value, background included", |m| m.values.peak),
        integer("xpeak", "pixel", "column of the peak, from 1", |m| i64::from(m.values.peak_at.0) + 1),
        integer("ypeak", "pixel", "row of the peak, from 1", |m| i64::from(m.values.peak_at.1) + 1),
        real("background", unit, "mean background under the source", |m| m.background),
        real("noise", unit, "standard deviation of the background, mean under the source", |m| m.noise),
        real("threshold", unit, "mean value above the background of the pixels along the outline", |m| m.threshold),
    ]
}

fn shape() -> [Column; 12] {
    [
        real("x2", "pixel**2", "second moment along x, weighted by values above the background", |m| m.shape.moments.0),
        real("y2", "pixel**2", "second moment along y", |m| m.shape.moments.1),
        real("xy", "pixel**2", "mixed second moment", |m| m.shape.moments.2),
        real("errx2", "pixel**2", "variance of x, by the noise of the source's pixels", |m| m.shape.errors.0),
        real("erry2", "pixel**2", "variance of y", |m| m.shape.errors.1),
        real("errxy", "pixel**2", "covariance of x and y", |m| m.shape.errors.2),
        real("a", "pixel", "root mean square along the major axis", |m| m.shape.a),
        real("b", "pixel", "root mean square along the minor axis", |m| m.shape.b),
        real("theta", "deg", "angle from the x axis to the major axis, towards y", |m| m.shape.theta.to_degrees()),
        real("elongation", "", "a / b; empty where b is 0", |m| {
            if m.shape.b > 0.0 { m.shape.a / m.shape.b } else { f64::NAN }
        }),
        real("ellipticity", "", "1 - b / a", |m| if m.shape.a > 0.0 { 1.0 - m.shape.b / m.shape.a } else { f64::NAN }),
        real(
            "fwhm",
            "pixel",
            "full width at half maximum of a Gaussian with these moments: 2 sqrt(ln 2 (a^2 + b^2))",
            |m| 2.0 * (std::f64::consts::LN_2 * (m.shape.moments.0 + m.shape.moments.1)).sqrt(),
        ),
    ]
}

fn shape_on_the_sky() -> [Column; 3] {
    let axes = |m: &Measured| m.patch.map(|patch| patch.ellipse(m.shape.moments));
    [
        real("a_sky", "arcsec", "a on the sky", move |m| axes(m).map_or(f64::NAN, |ellipse| ellipse.a)),
        real("b_sky", "arcsec", "b on the sky", move |m| axes(m).map_or(f64::NAN, |ellipse| ellipse.b)),
        real("pa", "deg", "position angle of the major axis on the sky, from north through east", |m| {
            m.position_angle.unwrap_or(f64::NAN)
        }),
    ]
}

/// Centroids under a Gaussian window.
fn windowed(frame: Option<Frame>) -> [Column; 7] {
    let of = frame.map_or("whose frame is not known", Frame::name);
    [
        real("xwin", "pixel", "centroid under a Gaussian window as wide as the source", |m| m.windowed.x + 1.0),
        real("ywin", "pixel", "centroid under a Gaussian window as wide as the source", |m| m.windowed.y + 1.0),
        real("errx2win", "pixel**2", "variance of xwin", |m| m.windowed.errors.0),
        real("erry2win", "pixel**2", "variance of ywin", |m| m.windowed.errors.1),
        real("errxywin", "pixel**2", "covariance of xwin and ywin", |m| m.windowed.errors.2),
        sky_angle("ra_win", format!("right ascension of xwin, ywin, {of}"), |m| m.windowed_position.map(|at| at.0)),
        sky_angle("dec_win", format!("declination of xwin, ywin, {of}"), |m| m.windowed_position.map(|at| at.1)),
    ]
}

/// The Petrosian radius and what is within it.
fn petrosian(unit: &str, zero_point: f64) -> [Column; 5] {
    let mag = move |m: &Measured| m.petrosian.flux.magnitude(zero_point);
    [
        real(
            "petrosian_radius",
            "pixel",
            "semi-major axis of the ellipse around which (0.8 to 1.25) the mean light is 0.2 of that within",
            |m| m.petrosian.radius,
        ),
        real("flux_petrosian", unit, "flux within two Petrosian radii", |m| m.petrosian.flux.value),
        real("flux_petrosian_err", unit, "its error", |m| m.petrosian.flux.error),
        real("mag_petrosian", "mag", "magnitude of flux_petrosian", move |m| mag(m).0),
        real("mag_petrosian_err", "mag", "its error", move |m| mag(m).1),
    ]
}

/// What the sky beside a source says of it.
fn beside(unit: &str) -> [Column; 5] {
    [
        real("background_local", unit, "median of the sky within 24 pixels of the bounding box", |m| {
            m.local.background
        }),
        real("noise_local", unit, "standard deviation of that sky", |m| m.local.noise),
        real("flux_local", unit, "sum above that sky over the source's pixels", |m| m.local_flux.value),
        real("flux_local_err", unit, "its error, by that noise", |m| m.local_flux.error),
        real("snr_local", "", "flux_local / flux_local_err", |m| m.local_flux.value / m.local_flux.error),
    ]
}

/// Quantities as SExtractor defines them, where ours are other ones.
fn as_sextractor(unit: &str) -> [Column; 3] {
    [
        real("flux_max", unit, "greatest pixel value above the background", |m| m.values.peak - m.background),
        real("kron_factor", "", "kron_radius in units of a", |m| m.kron_radius / m.shape.wide_axes().0),
        integer(
            "flags_sex",
            "",
            "the flags by SExtractor's bits: 1 neighbours, 2 blended, 4 saturated, 8 truncated, \
            16 incomplete aperture, 32 undefined pixels, 128 no room",
            |m| sextractor_flags(m.flags),
        ),
    ]
}

fn sextractor_flags(bits: u32) -> i64 {
    const BITS: [(u32, i64); 7] = [
        (flags::NEIGHBOUR, 1),
        (flags::BLENDED, 2),
        (flags::SATURATED, 4),
        (flags::TRUNCATED, 8),
        (flags::APERTURE, 16),
        (flags::MASKED, 32),
        (flags::NO_ROOM, 128),
    ];
    BITS.iter().filter(|(ours, _)| bits & ours != 0).map(|(_, theirs)| theirs).sum()
}

fn fluxes(unit: &str) -> [Column; 7] {
    [
        real("flux", unit, "sum above the background over the source's pixels", |m| m.flux.value),
        real("flux_err", unit, "its error: sqrt(sum noise^2 + flux / gain)", |m| m.flux.error),
        real("snr", "", "flux / flux_err", |m| m.flux.value / m.flux.error),
        real("half_light_radius", "pixel", "radius of the circle with half of the Kron aperture's light", |m| {
            m.half_light
        }),
        real(
            "kron_radius",
            "pixel",
            "semi-major axis of the Kron aperture in pixels: 2.5 first moments, at least 3.5 a",
            |m| m.kron_radius,
        ),
        real("flux_kron", unit, "flux in the Kron aperture; what other sources' pixels count is in SFNEIGHB", |m| {
            m.kron.value
        }),
        real("flux_kron_err", unit, "its error", |m| m.kron.error),
    ]
}

fn in_circle(index: usize, radius: f64, unit: &str, zero_point: Option<f64>) -> [Column; 4] {
    let (number, flux) = (index + 1, move |m: &Measured| m.apertures[index]);
    let mag = move |m: &Measured| flux(m).magnitude(zero_point.unwrap_or(f64::NAN));
    let within = format!("within {radius} pixels (the radius) of the centroid");
    [
        real(&format!("flux_aper_{number}"), unit, &format!("flux {within}"), move |m| flux(m).value),
        real(&format!("flux_aper_{number}_err"), unit, "its error", move |m| flux(m).error),
        real(&format!("mag_aper_{number}"), "mag", &format!("magnitude {within}"), move |m| mag(m).0),
        real(&format!("mag_aper_{number}_err"), "mag", "its error", move |m| mag(m).1),
    ]
}

fn magnitudes(zero_point: f64) -> [Column; 5] {
    let mag = move |flux: Flux| flux.magnitude(zero_point);
    [
        real("mag", "mag", "magnitude of flux", move |m| mag(m.flux).0),
        real("mag_err", "mag", "its error", move |m| mag(m.flux).1),
        real("mag_kron", "mag", "magnitude of flux_kron", move |m| mag(m.kron).0),
        real("mag_kron_err", "mag", "its error", move |m| mag(m.kron).1),
        real("mu_max", "mag/arcsec**2", "surface brightness of the peak above the background", move |m| {
            let area = m.patch.map_or(f64::NAN, |patch| patch.area());
            mag(Flux { value: (m.values.peak - m.background) / area, error: 0.0 }).0
        }),
    ]
}

/// What the bits of the flags say, in one line.
fn flag_bits() -> String {
    let bits: Vec<String> = FLAGS.iter().map(|flag| format!("{} {}", flag.bit, flag.name)).collect();
    format!("sum of {} (not the bits of SExtractor: flags_sex)", bits.join(", "))
}

fn integer(name: &str, unit: &str, description: &str, value: impl Fn(&Measured) -> i64 + 'static) -> Column {
    column(name, unit, description, Value::Integer(Box::new(value)))
}

fn real(name: &str, unit: &str, description: &str, value: impl Fn(&Measured) -> f64 + 'static) -> Column {
    column(name, unit, description, Value::Real(Box::new(value), DIGITS))
}

fn column(name: &str, unit: &str, description: &str, value: Value) -> Column {
    Column { name: name.to_owned(), unit: unit.to_owned(), description: description.to_owned(), value }
}

impl Column {
    /// Its unified content descriptor (IVOA); empty for none.
    pub fn ucd(&self) -> &'static str {
        known(&self.name).map_or("", |one| one.ucd)
    }

    /// Whether it is the same in every image of the pixels.
    pub(super) fn is_of_map(&self) -> bool {
        ["label", "xmin", "xmax", "ymin", "ymax", "area"].contains(&self.name.as_str())
    }

    /// The same of a further image, counted from 0.
    pub(super) fn of_band(self, band: usize) -> Column {
        let name = format!("m{}_{}", band + 2, self.name);
        let value = match self.value {
            Value::Integer(value) => Value::Integer(Box::new(move |m| m.bands.get(band).map_or(0, &value))),
            Value::Real(value, digits) => {
                Value::Real(Box::new(move |m| m.bands.get(band).map_or(f64::NAN, &value)), digits)
            }
        };
        Column { name, value, ..self }
    }

    /// Whether it is there when no columns are chosen.
    pub fn is_usual(&self) -> bool {
        known(&self.name).is_none_or(|one| one.usual)
    }

    /// The value of a source as text: empty where there is none. Every format tells this number:
    /// the last bits, in which system libraries differ, are rounded away.
    pub fn text(&self, source: &Measured) -> String {
        match &self.value {
            Value::Integer(value) => value(source).to_string(),
            Value::Real(value, digits) => significant(value(source), *digits),
        }
    }

    /// The number that the text tells; NaN where there is none.
    pub fn number(&self, source: &Measured) -> f64 {
        match &self.value {
            Value::Integer(value) => value(source) as f64,
            Value::Real(value, digits) => rounded(value(source), *digits),
        }
    }
}

/// A number with so many significant digits, without trailing zeros; empty if it is not finite.
fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return String::new();
    }
    // Of up to 15 digits these are the fewest that tell the number: no shorter ones need be looked for.
    let text = scientific(value, digits);
    let Some((mantissa, exponent)) = text.split_once('e') else { return text };
    let mantissa = if mantissa.contains('.') { mantissa.trim_end_matches('0').trim_end_matches('.') } else { mantissa };
    let Ok(exponent @ -5..15) = exponent.parse::<i32>() else { return format!("{mantissa}e{exponent}") };
    let (sign, digits) = mantissa.strip_prefix('-').map_or(("", mantissa), |digits| ("-", digits));
    let (first, rest) = digits.split_once('.').unwrap_or((digits, ""));
    let point = exponent.unsigned_abs() as usize;
    let zeros = |count: usize| ZEROS.get(..count).unwrap_or(ZEROS);
    // The longest has a sign, a point and as many zeros as digits.
    let mut out = String::with_capacity(digits.len() + ZEROS.len());
    let parts = if exponent < 0 {
        [sign, "0.", zeros(point - 1), first, rest]
    } else if let Some((whole, part)) = rest.split_at_checked(point).filter(|(_, part)| !part.is_empty()) {
        [sign, first, whole, ".", part]
    } else {
        [sign, first, rest, zeros(point - rest.len()), ""]
    };
    parts.into_iter().for_each(|part| out.push_str(part));
    out
}

/// The number that so many digits tell; NaN if it is not finite.
fn rounded(value: f64, digits: usize) -> f64 {
    if value.is_finite() { scientific(value, digits).parse().unwrap_or(f64::NAN) } else { f64::NAN }
}

/// As many as a plain number has in a row.
const ZEROS: &str = "00000000000000";

/// A number with so many digits, of which all but the first are behind the point, and its exponent.
fn scientific(value: f64, digits: usize) -> String {
    let mut text = String::with_capacity(digits + ZEROS.len());
    let _ = write!(text, "{value:.*e}", digits - 1);
    text
}

/// Whether a column is a magnitude.
pub(super) fn is_magnitude(name: &str) -> bool {
    name.starts_with("mag") || name == "mu_max"
}

#[cfg(test)]
mod tests {
    use super::super::{Choice, names::KNOWN};
    use super::*;

    #[test]
    fn numbers_are_short_and_parse() {
        assert_eq!(significant(0.1 + 0.2, 9), "0.3");
        assert_eq!(significant(150.123_456_789_012_3, 12), "150.123456789");
        assert_eq!(significant(1.5e-19, 9), "1.5e-19");
        assert_eq!(significant(f64::NAN, 9), "");
        assert_eq!(significant(-0.0, 9), "-0");
        assert!([f64::INFINITY, f64::NAN].map(|value| rounded(value, 9)).iter().all(|value| value.is_nan()));
        assert_eq!(significant(9.999_999_999e14, 9), "1e15");
    }

    #[test]
    fn numbers_are_as_short_as_the_standard_library_makes_them() {
        let mut state = 1u64;
        for exponent in -9..18 {
            for digits in [1, 2, 9, 12, 15] {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let whole = (state >> 11) as f64 / (1u64 << 53) as f64 * 10f64.powi(exponent);
                for value in [whole, -whole, whole.round(), 10f64.powi(exponent), -3.0 * 10f64.powi(exponent)] {
                    let near: f64 = format!("{value:.*e}", digits - 1).parse().expect("a number");
                    let plain = near == 0.0 || (1e-5..1e15).contains(&near.abs());
                    let expected = if plain { near.to_string() } else { format!("{near:e}") };
                    let found = significant(value, digits);
                    assert_eq!(found, expected, "{value} in {digits} digits");
                    assert_eq!(Ok(rounded(value, digits)), found.parse());
                }
            }
        }
    }

    #[test]
    fn names_differ_and_everything_is_described() {
        let setting = Setting {
            unit: "adu".to_owned(),
            frame: Some(Frame::Icrs),
            refused: false,
            places: false,
            apertures: vec![3.0, 5.0],
            zero_point: Some(25.0),
        };
        let list = columns(&setting);
        let names: std::collections::BTreeSet<&str> = list.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names.len(), list.len());
        assert!(list.iter().all(|column| !column.description.is_empty() && !column.ucd().is_empty()));
        for one in KNOWN {
            assert!(names.iter().any(|name| known(name).is_some_and(|known| known.name == one.name)), "{}", one.name);
        }
    }

    #[test]
    fn what_a_setting_does_not_have_is_not_usual() {
        let names = |setting: &Setting, words: &[&str]| {
            let words: Vec<String> = words.iter().map(|word| word.to_string()).collect();
            let columns = Choice::new(&words).expect("names").columns(setting);
            columns.into_iter().map(|column| column.name).collect::<Vec<String>>()
        };
        let bare = names(&Setting::default(), &[]);
        assert!(
            ["ra", "pa", "glon", "mag", "xwin", "flags_sex"].iter().all(|name| !bare.contains(&(*name).to_owned()))
        );
        let refused = names(&Setting { refused: true, ..Setting::default() }, &[]);
        assert!(refused.contains(&"ra".to_owned()) && !refused.contains(&"glon".to_owned()));
        let galactic = names(&Setting { frame: Some(Frame::Galactic), ..Setting::default() }, &[]);
        assert!(galactic.contains(&"glat".to_owned()) && !galactic.contains(&"elon".to_owned()));
        let apertures = Setting { apertures: vec![3.0, 5.0], ..Setting::default() };
        assert_eq!(
            names(&apertures, &["FLAGS", "X_IMAGE", "flux_aper(2)", "x", "flags", "FLUX_APER"]),
            ["flags_sex", "x", "flux_aper_1", "flux_aper_2", "flags"]
        );
        assert_eq!(names(&apertures, &["all"]).len(), columns(&apertures).len());
        assert!(Choice::new(&["fluxx".to_owned()]).is_err_and(|reason| reason.contains("fluxx")));
    }
}
