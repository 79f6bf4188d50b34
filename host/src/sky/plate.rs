//! The plate solution of the Digitized Sky Surveys: polynomials of millimetres on a photographic plate
//! (Lasker et al. 1990, doi:10.1086/115483).

use super::keys::Keys;

/// Coefficients of an axis; those of magnitude and colour come after the first 13 and are none of a
/// pixel.
const COEFFICIENTS: usize = 13;
/// The last coefficient of an axis.
const LAST: usize = 20;

/// The plate of a header, with the linear step from pixels to millimetres.
#[derive(Clone, Debug, PartialEq)]
pub struct Plate {
    /// The pixel, from 1, at the plate's centre.
    pub reference: [f64; 2],
    /// Millimetres per pixel; x runs against the pixels.
    pub matrix: [[f64; 2]; 2],
    /// Right ascension and declination of the plate's centre, degrees.
    pub centre: [f64; 2],
    coefficients: [[f64; COEFFICIENTS]; 2],
}

impl Plate {
    /// The plate of a header; none where it has no plate's coefficients.
    ///
    /// # Errors
    /// The keyword that is missing or out of bounds, in words.
    pub fn of(keys: &Keys) -> Result<Option<Plate>, String> {
        if keys.real("AMDX1").is_none() || keys.real("AMDY1").is_none() {
            return Ok(None);
        }
        let number = |name: &str| keys.real(name).ok_or(format!("a plate solution without {name}"));
        let scale = |name: &str| {
            number(name).and_then(|size| if size > 0.0 { Ok(size) } else { Err(format!("{name} = {size}")) })
        };
        let pixel = [scale("XPIXELSZ")?, scale("YPIXELSZ")?];
        let offset = [number("PPO3")?, number("PPO6")?];
        let corner = [number("CNPIX1")?, number("CNPIX2")?];
        let angle = |names: [&str; 3]| {
            Ok::<f64, String>(number(names[0])? + number(names[1])? / 60.0 + number(names[2])? / 3600.0)
        };
        let sign = if keys.text("PLTDECSN").is_some_and(|sign| sign.starts_with('-')) { -1.0 } else { 1.0 };
        let coefficient = |name: &str, n: usize| keys.real(&format!("{name}{n}")).unwrap_or(0.0);
        for name in ["AMDX", "AMDY"] {
            if let Some(n) = (COEFFICIENTS + 1..=LAST).find(|&n| coefficient(name, n) != 0.0) {
                return Err(format!("{name}{n}, a term of magnitude or colour"));
            }
        }
        Ok(Some(Plate {
            reference: [0, 1].map(|axis| offset[axis] / pixel[axis] - corner[axis] + 0.5),
            matrix: [[-0.001 * pixel[0], 0.0], [0.0, 0.001 * pixel[1]]],
            centre: [15.0 * angle(["PLTRAH", "PLTRAM", "PLTRAS"])?, sign * angle(["PLTDECD", "PLTDECM", "PLTDECS"])?],
            coefficients: ["AMDX", "AMDY"].map(|name| std::array::from_fn(|n| coefficient(name, n + 1))),
        }))
    }

    /// The place in the projection plane, degrees, of one on the plate, millimetres.
    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        // The polynomial of the second axis has its arguments exchanged.
        let [along, across] = &self.coefficients;
        [polynomial(along, x, y) / 3600.0, polynomial(across, y, x) / 3600.0]
    }
}

fn polynomial(c: &[f64; COEFFICIENTS], x: f64, y: f64) -> f64 {
    let square = x * x + y * y;
    let terms = [
        x,
        y,
        1.0,
        x * x,
        x * y,
        y * y,
        square,
        x * x * x,
        x * x * y,
        x * y * y,
        y * y * y,
        x * square,
        x * square * square,
    ];
    c.iter().zip(terms).map(|(c, term)| c * term).sum()
}
