//! The linear step of a header: degrees in the projection plane for a pixel.

use crate::read::Header;

/// The matrix of `CDi_j`, `PCi_j` with `CDELTi`, or `CDELTi` with `CROTAi`, the first that is
/// there; its rows are the longitude and the latitude axis.
///
/// # Errors
/// Units other than degrees, and a matrix that maps the image onto a line.
pub fn matrix(header: &Header, axes: [usize; 2]) -> Result<[[f64; 2]; 2], String> {
    for axis in axes {
        let unit = header.text(&format!("CUNIT{axis}")).unwrap_or_default();
        if !["", "deg", "degree", "degrees"].contains(&unit.trim().to_ascii_lowercase().as_str()) {
            return Err(format!("unit {unit} of axis {axis}"));
        }
    }
    let element = |name: &str, i: usize, j: usize| header.real(&format!("{name}{i}_{j}"));
    let has = |name: &str| (1..=2).any(|i| (1..=2).any(|j| element(name, i, j).is_some()));
    let scale = |i: usize| header.real(&format!("CDELT{i}")).unwrap_or(1.0);
    let rows = if has("CD") {
        [1, 2].map(|i| [1, 2].map(|j| element("CD", i, j).unwrap_or(0.0)))
    } else if has("PC") {
        [1, 2].map(|i| [1, 2].map(|j| scale(i) * element("PC", i, j).unwrap_or(f64::from(u8::from(i == j)))))
    } else {
        // By convention the rotation stands with the latitude axis.
        let angle = header.real(&format!("CROTA{}", axes[1])).unwrap_or(0.0).to_radians();
        let (sin, cos) = angle.sin_cos();
        let sign = if axes[0] == 1 { 1.0 } else { -1.0 };
        [[scale(1) * cos, -sign * scale(2) * sin], [sign * scale(1) * sin, scale(2) * cos]]
    };
    let determinant = rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0];
    if determinant == 0.0 || !determinant.is_finite() {
        return Err("a linear step without an inverse".to_owned());
    }
    Ok(axes.map(|axis| rows[axis - 1]))
}
