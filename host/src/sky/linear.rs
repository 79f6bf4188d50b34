//! The linear step of a header: degrees in the projection plane for a pixel.

use super::keys::Keys;

/// Units of an axis and their degrees.
const UNITS: [(&str, f64); 8] = [
    ("deg", 1.0),
    ("degree", 1.0),
    ("degrees", 1.0),
    ("arcmin", 1.0 / 60.0),
    ("arcsec", 1.0 / 3600.0),
    ("mas", 1.0 / 3_600_000.0),
    ("rad", 180.0 / std::f64::consts::PI),
    ("", 1.0),
];

/// Degrees in the unit of an axis (`CUNITi`).
///
/// # Errors
/// Units that are not angles.
pub fn degrees(keys: &Keys, axis: usize) -> Result<f64, String> {
    let unit = keys.text(&format!("CUNIT{axis}")).unwrap_or_default();
    let known = UNITS.iter().find(|(name, _)| unit.eq_ignore_ascii_case(name));
    known.map(|&(_, degrees)| degrees).ok_or(format!("unit {unit} of axis {axis}"))
}

/// The matrix of `CDi_j`, `PCi_j` with `CDELTi`, or `CDELTi` with `CROTAi`, the first that is
/// there; its rows are the longitude and the latitude axis.
///
/// # Errors
/// Units other than degrees, and a matrix that maps the image onto a line.
pub fn matrix(keys: &Keys, axes: [usize; 2]) -> Result<[[f64; 2]; 2], String> {
    let element = |name: &str, i: usize, j: usize| keys.real(&format!("{name}{i}_{j}"));
    let has = |name: &str| (1..=2).any(|i| (1..=2).any(|j| element(name, i, j).is_some()));
    let scale = |i: usize| keys.real(&format!("CDELT{i}")).unwrap_or(1.0);
    if has("CD") && has("PC") {
        return Err("CDi_j and PCi_j together".to_owned());
    }
    let mut rows = if has("CD") {
        [1, 2].map(|i| [1, 2].map(|j| element("CD", i, j).unwrap_or(0.0)))
    } else if has("PC") {
        [1, 2].map(|i| [1, 2].map(|j| scale(i) * element("PC", i, j).unwrap_or(f64::from(u8::from(i == j)))))
    } else {
        // By convention the rotation stands with the latitude axis.
        let angle = keys.real(&format!("CROTA{}", axes[1])).unwrap_or(0.0).to_radians();
        let (sin, cos) = angle.sin_cos();
        let sign = if axes[0] == 1 { 1.0 } else { -1.0 };
        [[scale(1) * cos, -sign * scale(2) * sin], [sign * scale(1) * sin, scale(2) * cos]]
    };
    for axis in [1, 2] {
        let degrees = degrees(keys, axis)?;
        rows[axis - 1].iter_mut().for_each(|element| *element *= degrees);
    }
    let determinant = rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0];
    if determinant == 0.0 || !determinant.is_finite() {
        return Err("a linear step without an inverse".to_owned());
    }
    Ok(axes.map(|axis| rows[axis - 1]))
}
