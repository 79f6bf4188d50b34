//! Distortions of the focal plane as polynomials in the header: SIP before the linear step, TPV
//! after it.

use super::keys::Keys;

/// The highest order that the SIP convention allows.
const SIP_MOST: f64 = 9.0;
/// The highest number of a TPV coefficient.
const TPV_LAST: usize = 39;

/// SIP (Shupe et al. 2005, ASPC 347, 491): pixel offsets as polynomials in the pixels' distance
/// from `CRPIX`.
#[derive(Clone, Debug, PartialEq)]
pub struct Sip {
    /// Powers of u and v, and the coefficient, of the offset along each axis.
    terms: [Vec<(i32, i32, f64)>; 2],
}

impl Sip {
    /// The coefficients of a header.
    ///
    /// # Errors
    /// The reason, where the orders are absent or out of bounds.
    pub fn of(keys: &Keys) -> Result<Sip, String> {
        let terms = |letter: &str| {
            let order = keys.real(&format!("{letter}_ORDER")).ok_or(format!("SIP without {letter}_ORDER"))?;
            if order.fract() != 0.0 || !(0.0..=SIP_MOST).contains(&order) {
                return Err(format!("SIP with {letter}_ORDER = {order}, not 0 to {SIP_MOST}"));
            }
            let order = order as i32;
            let powers = (0..=order).flat_map(|p| (0..=order - p).map(move |q| (p, q)));
            Ok(powers.filter_map(|(p, q)| keys.real(&format!("{letter}_{p}_{q}")).map(|c| (p, q, c))).collect())
        };
        Ok(Sip { terms: [terms("A")?, terms("B")?] })
    }

    /// The distorted position of a pixel, both relative to `CRPIX`.
    pub fn apply(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let offset = |axis: usize| self.terms[axis].iter().map(|&(p, q, c)| c * u.powi(p) * v.powi(q)).sum::<f64>();
        [u + offset(0), v + offset(1)]
    }
}

/// TPV: polynomials of up to the seventh degree in the projection plane, degrees
/// (https://fits.gsfc.nasa.gov/registry/tpvwcs.html).
#[derive(Clone, Debug, PartialEq)]
pub struct Tpv {
    /// Coefficients of the longitude and the latitude axis.
    coefficients: [[f64; TPV_LAST + 1]; 2],
}

impl Tpv {
    /// The coefficients of a header whose longitude and latitude axes have these numbers; the
    /// linear one is 1 by default, all others are 0.
    pub fn of(keys: &Keys, axes: [usize; 2]) -> Tpv {
        let coefficients = axes.map(|axis| {
            std::array::from_fn(|m| keys.real(&format!("PV{axis}_{m}")).unwrap_or(if m == 1 { 1.0 } else { 0.0 }))
        });
        Tpv { coefficients }
    }

    /// The distorted position in the projection plane.
    pub fn apply(&self, [xi, eta]: [f64; 2]) -> [f64; 2] {
        let [along, across] = &self.coefficients;
        // The polynomial of the second axis has its arguments exchanged.
        [polynomial(along, xi, eta), polynomial(across, eta, xi)]
    }
}

/// The terms of each degree in order of falling powers of x; after odd degrees a radial term.
fn polynomial(coefficients: &[f64; TPV_LAST + 1], x: f64, y: f64) -> f64 {
    let r = x.hypot(y);
    let terms = (0..=7).flat_map(|degree: i32| {
        let mixed = (0..=degree).map(move |j| x.powi(degree - j) * y.powi(j));
        mixed.chain((degree % 2 == 1).then(|| r.powi(degree)))
    });
    coefficients.iter().zip(terms).map(|(c, term)| c * term).sum()
}
