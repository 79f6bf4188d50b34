//! Step 2: rescaling of the grey levels, properties A1 to A4 and A4_tau (erratum 5: strict inside (0, 1) only).

use super::{Plane, Rescale, Tau, kapur, noise, otsu, rosin};

/// r1(x) = x^alpha.
pub fn r1(x: f64, alpha: f64) -> f64 {
    x.powf(alpha)
}

/// r2(x) = (ln(x + 1) / ln 2)^alpha.
pub fn r2(x: f64, alpha: f64) -> f64 {
    ((x + 1.0).ln() / 2f64.ln()).powf(alpha)
}

/// r3(x) = x^beta / tau^(beta - 1) below tau, (x - tau)^(1/beta) / (1 - tau)^(1/beta - 1) + tau from tau on.
pub fn r3(x: f64, beta: f64, tau: f64) -> f64 {
    if x < tau {
        x.powf(beta) / tau.powf(beta - 1.0)
    } else {
        (x - tau).powf(1.0 / beta) / (1.0 - tau).powf(1.0 / beta - 1.0) + tau
    }
}

/// The threshold that the rescaling needs, if it needs one, from the defined pixels of `image`.
pub fn threshold(rescale: Rescale, tau: Tau, image: &Plane, defined: &[bool]) -> Option<f64> {
    let levels = image.values().iter().zip(defined).filter(|(_, seen)| **seen).map(|(&v, _)| v);
    matches!(rescale, Rescale::R3 { .. }).then(|| match tau {
        Tau::Value(tau) => tau,
        Tau::Otsu => otsu(levels),
        Tau::Kapur => kapur(levels),
        Tau::Rosin => rosin(levels),
        Tau::Noise(k) => noise(levels, k),
    })
}

/// The rescaled image.
pub fn rescale(rescale: Rescale, tau: Option<f64>, image: &Plane) -> Plane {
    image.map(|x| match (rescale, tau) {
        (Rescale::R1 { alpha }, _) => r1(x, alpha),
        (Rescale::R2 { alpha }, _) => r2(x, alpha),
        (Rescale::R3 { beta }, Some(tau)) => r3(x, beta, tau),
        _ => x,
    })
}
