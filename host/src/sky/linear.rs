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
/// Units other than degrees, two matrices, and one that maps the image onto a line.
pub fn matrix(keys: &Keys, axes: [usize; 2]) -> Result<[[f64; 2]; 2], String> {
    let element = |name: &str, i: usize, j: usize| keys.real(&format!("{name}{i}_{j}"));
    let has = |name: &str| (1..=2).any(|i| (1..=2).any(|j| element(name, i, j).is_some()));
    let scale = |i: usize| keys.real(&format!("CDELT{i}")).unwrap_or(1.0);
    let of_cd = || [1, 2].map(|i| [1, 2].map(|j| element("CD", i, j).unwrap_or(0.0)));
    let of_pc =
        || [1, 2].map(|i| [1, 2].map(|j| scale(i) * element("PC", i, j).unwrap_or(f64::from(u8::from(i == j)))));
    // The standard has one of the two. Some writers tell the same twice.
    if has("CD") && has("PC") && differ(of_cd(), of_pc()) {
        return Err("CDi_j and PCi_j that differ".to_owned());
    }
    let mut rows = if has("CD") {
        of_cd()
    } else if has("PC") {
        of_pc()
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

/// Whether two matrices differ by more than rounding.
fn differ(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> bool {
    const ROUNDING: f64 = 1e-10;
    let elements = || a.as_flattened().iter().zip(b.as_flattened());
    let greatest = elements().map(|(a, b)| a.abs().max(b.abs())).fold(0.0, f64::max);
    elements().any(|(a, b)| (a - b).abs() > ROUNDING * greatest)
}
