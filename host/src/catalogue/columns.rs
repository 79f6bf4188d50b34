//! The registry of columns: headers, documentation and `skyfront columns` come from here.

use crate::measure::{Flux, Measured};
use crate::sky::Frame;
use skyfront_core::flags::FLAGS;

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
    /// Radii of the circular apertures, pixels.
    pub apertures: Vec<f64>,
    /// Magnitude of a flux of 1, where there are to be magnitudes.
    pub zero_point: Option<f64>,
}

/// Digits of most reals, as many as an f32 has; and of positions on the sky.
const DIGITS: usize = 9;
const SKY_DIGITS: usize = 12;

/// The columns of a catalogue, in order.
pub fn columns(setting: &Setting) -> Vec<Column> {
    let unit = setting.unit.as_str();
    let mut list = vec![
        integer("label", "", "label in the segmentation map", |m| i64::from(m.source.label)),
        real("x", "pixel", "centroid above the background; the first pixel's centre is 1", |m| m.shape.x + 1.0),
        real("y", "pixel", "centroid above the background; the first pixel's centre is 1", |m| m.shape.y + 1.0),
    ];
    list.extend(setting.frame.map(on_the_sky).into_iter().flatten());
    list.extend(extent());
    list.extend(pixels(unit));
    list.extend(shape());
    list.extend(setting.frame.map(|_| {
        real("pa", "deg", "position angle of the major axis on the sky, from north through east", |m| {
            m.position_angle.unwrap_or(f64::NAN)
        })
    }));
    list.extend(fluxes(unit));
    list.extend((0..).zip(&setting.apertures).flat_map(|(index, radius)| in_circle(index, *radius, unit)));
    list.extend(setting.zero_point.map(magnitudes).into_iter().flatten());
    list.push(integer("flags", "", &flag_bits(), |m| i64::from(m.flags)));
    list
}

fn on_the_sky(frame: Frame) -> [Column; 2] {
    let place = |name: &str, what: &str, value: fn((f64, f64)) -> f64| Column {
        name: name.to_owned(),
        unit: "deg".to_owned(),
        description: format!("{what} of the centroid, {}", frame.name()),
        value: Value::Real(Box::new(move |m| m.position.map_or(f64::NAN, value)), SKY_DIGITS),
    };
    [place("ra", "right ascension", |p| p.0), place("dec", "declination", |p| p.1)]
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

fn shape() -> [Column; 7] {
    [
        real("x2", "pixel**2", "second moment along x, weighted by values above the background", |m| m.shape.moments.0),
        real("y2", "pixel**2", "second moment along y", |m| m.shape.moments.1),
        real("xy", "pixel**2", "mixed second moment", |m| m.shape.moments.2),
        real("a", "pixel", "root mean square along the major axis", |m| m.shape.a),
        real("b", "pixel", "root mean square along the minor axis", |m| m.shape.b),
        real("theta", "deg", "angle from the x axis to the major axis, towards y", |m| m.shape.theta.to_degrees()),
        real("elongation", "", "a / b; empty where b is 0", |m| {
            if m.shape.b > 0.0 { m.shape.a / m.shape.b } else { f64::NAN }
        }),
    ]
}

fn fluxes(unit: &str) -> [Column; 7] {
    [
        real("flux", unit, "sum above the background over the source's pixels", |m| m.flux.value),
        real("flux_err", unit, "its error: sqrt(sum noise^2 + flux / gain)", |m| m.flux.error),
        real("snr", "", "flux / flux_err", |m| m.flux.value / m.flux.error),
        real("half_light_radius", "pixel", "radius of the circle with half of flux_kron", |m| m.half_light),
        real("kron_radius", "pixel", "semi-major axis of the Kron aperture: 2.5 first moments, at least 3.5 a", |m| {
            m.kron_radius
        }),
        real("flux_kron", unit, "flux in the Kron aperture, other sources left out", |m| m.kron.value),
        real("flux_kron_err", unit, "its error", |m| m.kron.error),
    ]
}

fn in_circle(index: usize, radius: f64, unit: &str) -> [Column; 2] {
    let (number, flux) = (index + 1, move |m: &Measured| m.apertures[index]);
    [
        real(
            &format!("flux_aper_{number}"),
            unit,
            &format!("flux within {radius} pixels of the centroid, other sources left out"),
            move |m| flux(m).value,
        ),
        real(&format!("flux_aper_{number}_err"), unit, "its error", move |m| flux(m).error),
    ]
}

fn magnitudes(zero_point: f64) -> [Column; 4] {
    let mag = move |flux: Flux| flux.magnitude(zero_point);
    [
        real("mag", "mag", "magnitude of flux", move |m| mag(m.flux).0),
        real("mag_err", "mag", "its error", move |m| mag(m.flux).1),
        real("mag_kron", "mag", "magnitude of flux_kron", move |m| mag(m.kron).0),
        real("mag_kron_err", "mag", "its error", move |m| mag(m.kron).1),
    ]
}

/// What the bits of the flags say, in one line.
fn flag_bits() -> String {
    let bits: Vec<String> = FLAGS.iter().map(|flag| format!("{} {}", flag.bit, flag.name)).collect();
    format!("sum of {}", bits.join(", "))
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
    /// The value of a source as text: empty where there is none. Every format tells this number:
    /// the last bits, in which system libraries differ, are rounded away.
    pub fn text(&self, source: &Measured) -> String {
        match &self.value {
            Value::Integer(value) => value(source).to_string(),
            Value::Real(value, digits) => significant(value(source), *digits),
        }
    }
}

/// A number with so many significant digits, without trailing zeros; empty if it is not finite.
fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return String::new();
    }
    let rounded: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    if rounded == 0.0 || (1e-5..1e15).contains(&rounded.abs()) { rounded.to_string() } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_parse() {
        assert_eq!(significant(0.1 + 0.2, 9), "0.3");
        assert_eq!(significant(150.123_456_789_012_3, 12), "150.123456789");
        assert_eq!(significant(1.5e-19, 9), "1.5e-19");
        assert_eq!(significant(f64::NAN, 9), "");
        assert_eq!(significant(-0.0, 9), "-0");
    }

    #[test]
    fn names_differ_and_everything_is_described() {
        let setting = Setting {
            unit: "adu".to_owned(),
            frame: Some(Frame::Icrs),
            apertures: vec![3.0, 5.0],
            zero_point: Some(25.0),
        };
        let list = columns(&setting);
        let names: std::collections::BTreeSet<&str> = list.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names.len(), list.len());
        assert!(list.iter().all(|column| !column.description.is_empty()));
        assert!(names.contains("flux_aper_2_err") && names.contains("ra") && names.contains("mag_kron"));
        assert!(columns(&Setting::default()).iter().all(|column| column.name != "ra" && column.name != "mag"));
    }
}
