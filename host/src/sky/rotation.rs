//! From the native sphere of a projection to the celestial sphere (Calabretta and Greisen 2002,
//! doi:10.1051/0004-6361:20021327, section 2).

use super::keys::Keys;

/// Rounding that sines and latitudes may bear.
const ROUNDING: f64 = 1e-10;

/// The celestial coordinates of the native pole, and the native longitude of the celestial one.
#[derive(Clone, Copy, Debug)]
pub struct Rotation {
    /// Celestial longitude of the native pole, radians.
    longitude: f64,
    /// Its celestial latitude, radians.
    latitude: f64,
    /// Native longitude of the celestial pole, radians.
    native: f64,
}

impl Rotation {
    /// The rotation that puts the native point (0, `theta0`) at `reference`, longitude and latitude;
    /// all in degrees. `LONPOLE` and `LATPOLE` are the keywords of that name, or parameters 3 and 4
    /// of the longitude axis.
    ///
    /// # Errors
    /// Keywords that leave no pole, in words.
    pub fn new(keys: &Keys, longitude_axis: usize, theta0: f64, reference: [f64; 2]) -> Result<Rotation, String> {
        let parameter = |m: usize| keys.real(&format!("PV{longitude_axis}_{m}"));
        if let Some(m) = (0..=2).find(|&m| parameter(m).is_some_and(|value| value != 0.0)) {
            return Err(format!("PV{longitude_axis}_{m}, another reference point"));
        }
        let [alpha0, delta0] = reference;
        let default = if delta0 >= theta0 { 0.0 } else { 180.0 };
        let native = parameter(3).or(keys.real("LONPOLE")).unwrap_or(default).to_radians();
        let towards = parameter(4).or(keys.real("LATPOLE")).unwrap_or(90.0).to_radians();
        let (alpha0, delta0, theta0) = (alpha0.to_radians(), delta0.to_radians(), theta0.to_radians());
        if theta0 == std::f64::consts::FRAC_PI_2 {
            return Ok(Rotation { longitude: alpha0, latitude: delta0, native });
        }
        let latitude = pole_latitude(theta0, delta0, native, towards).ok_or("LONPOLE and CRVAL leave no pole")?;
        Ok(Rotation { longitude: pole_longitude(theta0, [alpha0, delta0], native, latitude), latitude, native })
    }

    /// The celestial direction of a native one.
    pub fn celestial(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = self.native.sin_cos();
        // cos theta times cosine and sine of phi - LONPOLE.
        let (along, across) = (x * cos + y * sin, y * cos - x * sin);
        let (sin_pole, cos_pole) = self.latitude.sin_cos();
        let (from_pole, north) = (z * cos_pole - along * sin_pole, z * sin_pole + along * cos_pole);
        let (sin_longitude, cos_longitude) = self.longitude.sin_cos();
        let (p, q) = (from_pole, -across);
        [p * cos_longitude - q * sin_longitude, p * sin_longitude + q * cos_longitude, north]
    }
}

/// The celestial latitude of the native pole (equation 8): of two that are possible the one nearer to
/// `LATPOLE`.
fn pole_latitude(theta0: f64, delta0: f64, native: f64, towards: f64) -> Option<f64> {
    let (x, y) = (theta0.cos() * native.cos(), theta0.sin());
    let length = x.hypot(y);
    if length < ROUNDING {
        return (delta0.sin().abs() < ROUNDING).then_some(towards);
    }
    let sine = delta0.sin() / length;
    if sine.abs() > 1.0 + ROUNDING {
        return None;
    }
    let (middle, half) = (y.atan2(x), sine.clamp(-1.0, 1.0).acos());
    let round = |angle: f64| {
        let turn = std::f64::consts::TAU;
        angle - turn * (angle / turn).round()
    };
    let right = std::f64::consts::FRAC_PI_2;
    let possible = |angle: &f64| angle.abs() <= right + ROUNDING;
    let nearer = |a: &f64, b: &f64| (a - towards).abs().total_cmp(&(b - towards).abs());
    [middle + half, middle - half]
        .map(round)
        .into_iter()
        .filter(possible)
        .min_by(nearer)
        .map(|a| a.clamp(-right, right))
}

/// The celestial longitude of the native pole (equations 9 and 10, and the poles themselves).
fn pole_longitude(theta0: f64, [alpha0, delta0]: [f64; 2], native: f64, latitude: f64) -> f64 {
    if delta0.cos().abs() < ROUNDING {
        return alpha0;
    }
    if latitude.cos().abs() < ROUNDING {
        let sign = latitude.signum();
        return alpha0 + sign * native - if sign > 0.0 { std::f64::consts::PI } else { 0.0 };
    }
    let y = native.sin() * theta0.cos() / delta0.cos();
    let x = (theta0.sin() - latitude.sin() * delta0.sin()) / (latitude.cos() * delta0.cos());
    alpha0 - y.atan2(x)
}
