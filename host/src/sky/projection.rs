//! From the projection plane to the native sphere (Calabretta and Greisen 2002,
//! doi:10.1051/0004-6361:20021327): the projections of the `mapproj` crate, with their parameters, and
//! two that it has not (TSC) or not soundly (SZP, version 0.4).

use super::keys::Keys;
use mapproj::conic::{cod::Cod, coe::Coe, coo::Coo, cop::Cop};
use mapproj::cylindrical::{car::Car, cea::Cea, cyp::Cyp, mer::Mer};
use mapproj::hybrid::hpx::Hpx;
use mapproj::pseudocyl::{ait::Ait, mol::Mol, par::Par, sfl::Sfl};
use mapproj::zenithal::{air::Air, arc::Arc, azp::Azp, sin::Sin, sin::SinSlant, stg::Stg, tan::Tan};
use mapproj::zenithal::{zea::Zea, zpn::Zpn};
use mapproj::{ProjXY, Projection as Plane};
use std::fmt;

/// The parameters of ZPN.
const ZPN_LAST: usize = 20;

/// Gives the native direction of a place in the plane, radians.
type Native = Box<dyn Fn(f64, f64) -> Option<[f64; 3]> + Send + Sync>;

/// A projection with its parameters.
pub struct Projection {
    native: Native,
    /// Native latitude of the reference point, degrees; its longitude is 0.
    pub theta0: f64,
}

impl fmt::Debug for Projection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Projection").field("theta0", &self.theta0).finish_non_exhaustive()
    }
}

/// A projection of the crate whose middle is the native pole. The crate has it on its first axis, with
/// native north above it.
fn zenithal(plane: impl Plane + Send + Sync + 'static) -> Projection {
    let native = move |x, y| plane.unproj_xyz(&ProjXY::new(x, y)).map(|at| [-at.z(), at.y(), at.x()]);
    Projection { native: Box::new(native), theta0: 90.0 }
}

/// Any other projection of the crate, by the latitude of its reference point.
fn upright(plane: impl Plane + Send + Sync + 'static, theta0: f64) -> Projection {
    let native = move |x, y| plane.unproj_xyz(&ProjXY::new(x, y)).map(|at| [at.x(), at.y(), at.z()]);
    Projection { native: Box::new(native), theta0 }
}

/// The parabolic projection; the crate has its height in units of half a turn.
fn parabolic() -> Projection {
    let Projection { native, theta0 } = upright(Par, 0.0);
    Projection { native: Box::new(move |x, y| native(x, y / std::f64::consts::PI)), theta0 }
}

/// The slant zenithal perspective from the distance `mu` at native longitude and latitude, radians
/// (section 5.1.2).
fn slant(mu: f64, longitude: f64, latitude: f64) -> Projection {
    let ((sin, cos), (sine, cosine)) = (longitude.sin_cos(), latitude.sin_cos());
    let (xp, yp, zp) = (-mu * cosine * sin, mu * cosine * cos, mu * sine + 1.0);
    let native = move |x: f64, y: f64| {
        let (u, v) = ((x - xp) / zp, (y - yp) / zp);
        let (a, b) = (u * u + v * v + 1.0, u * (x - u) + v * (y - v));
        let c = (x - u) * (x - u) + (y - v) * (y - v) - 1.0;
        let root = (b * b - a * c).sqrt();
        // The point nearer to the middle.
        let height = [(root - b) / a, (-root - b) / a].into_iter().find(|height| height.abs() <= 1.0)?;
        let depth = 1.0 - height;
        Some([v * depth - y, x - u * depth, height])
    };
    Projection { native: Box::new(native), theta0: 90.0 }
}

/// The tangential spherical cube (section 5.6.1): the middle of the first face is the reference point.
fn cube() -> Projection {
    let native = |x: f64, y: f64| {
        let half = std::f64::consts::FRAC_PI_4;
        let (x, y) = (x / half, y / half);
        let outside = if x.abs() <= 1.0 { y.abs() > 3.0 } else { x.abs() > 7.0 || y.abs() > 1.0 };
        if outside {
            return None;
        }
        let x = if x < -1.0 { x + 8.0 } else { x };
        let [l, m, n] = match (x, y) {
            (5.0.., _) => [x - 6.0, -1.0, y],
            (3.0.., _) => [-1.0, 4.0 - x, y],
            (1.0.., _) => [2.0 - x, 1.0, y],
            (_, 1.0..) => [2.0 - y, x, 1.0],
            (_, ..-1.0) => [y + 2.0, x, -1.0],
            _ => [1.0, x, y],
        };
        let length = (l * l + m * m + n * n).sqrt();
        Some([l / length, m / length, n / length])
    };
    Projection { native: Box::new(native), theta0: 0.0 }
}

impl Projection {
    /// The projection of this name; `latitude` is the number of the latitude axis, whose `PVi_m` are
    /// its parameters.
    ///
    /// # Errors
    /// Names that are not supported, and parameters out of bounds, in words.
    pub fn new(name: &str, keys: &Keys, latitude: usize) -> Result<Projection, String> {
        let given = |m: usize| keys.real(&format!("PV{latitude}_{m}"));
        let number = |m: usize, default: f64| given(m).unwrap_or(default);
        let angle = |m: usize, default: f64| number(m, default).to_radians();
        let bounded = |m: usize, default: f64, sound: fn(f64) -> bool| {
            let value = number(m, default);
            if sound(value) { Ok(value) } else { Err(format!("PV{latitude}_{m} = {value} of {name}")) }
        };
        let parameters = match name {
            "TAN" | "STG" | "ARC" | "ZEA" | "CAR" | "MER" | "SFL" | "PAR" | "MOL" | "AIT" | "TSC" => 0..0,
            "ZPN" => 0..ZPN_LAST + 1,
            "AIR" | "CEA" => 1..2,
            "SZP" => 1..4,
            _ => 1..3,
        };
        let odd =
            |(m, value): &(&str, f64)| *value != 0.0 && !m.parse::<usize>().is_ok_and(|m| parameters.contains(&m));
        if let Some((m, value)) = keys.numbers(&format!("PV{latitude}_")).find(odd) {
            return Err(format!("parameter PV{latitude}_{m} = {value} of {name}"));
        }
        let conic = || {
            let theta0 = given(1).ok_or(format!("{name} without PV{latitude}_1"))?;
            let half = bounded(2, 0.0, |eta| eta.abs() < 90.0)?;
            if theta0 == 0.0 || theta0.abs() + half.abs() > 90.0 {
                return Err(format!("PV{latitude}_1 = {theta0} of {name}"));
            }
            Ok((theta0.to_radians(), half.to_radians(), theta0))
        };
        Ok(match name {
            "TAN" => zenithal(Tan),
            "STG" => zenithal(Stg),
            "ARC" => zenithal(Arc),
            "ZEA" => zenithal(Zea),
            "SIN" => match (number(1, 0.0), number(2, 0.0)) {
                (0.0, 0.0) => zenithal(Sin),
                (xi, eta) => zenithal(SinSlant::new(xi, eta)),
            },
            "AZP" => {
                let tilt = bounded(2, 0.0, |gamma| gamma.abs() < 90.0)?;
                zenithal(Azp::from_params(bounded(1, 0.0, |mu| mu != -1.0)?, tilt.to_radians()))
            }
            "SZP" => {
                let theta = bounded(3, 90.0, |theta| theta.abs() <= 90.0)?.to_radians();
                if number(1, 0.0) * theta.sin() == -1.0 {
                    return Err("SZP from within its plane".to_owned());
                }
                slant(number(1, 0.0), angle(2, 0.0), theta)
            }
            "ZPN" => {
                let last = (0..=ZPN_LAST).rev().find(|&m| number(m, 0.0) != 0.0);
                let coefficients = (0..=last.unwrap_or(0)).map(|m| number(m, 0.0)).collect();
                zenithal(Zpn::from_params(coefficients).ok_or("the polynomial of ZPN falls from its start")?)
            }
            "AIR" => zenithal(Air::from_param(bounded(1, 90.0, |theta| theta > -90.0 && theta <= 90.0)?.to_radians())),
            "CAR" => upright(Car, 0.0),
            "MER" => upright(Mer, 0.0),
            "CEA" => upright(Cea::from_param(bounded(1, 1.0, |lambda| lambda > 0.0 && lambda <= 1.0)?), 0.0),
            "CYP" => {
                let lambda = bounded(2, 1.0, |lambda| lambda > 0.0)?;
                upright(Cyp::from_params(bounded(1, 1.0, |mu| mu > 0.0)?, lambda), 0.0)
            }
            "SFL" => upright(Sfl, 0.0),
            "PAR" => parabolic(),
            "MOL" => upright(Mol::new(), 0.0),
            "AIT" => upright(Ait, 0.0),
            "COP" => conic().map(|(a, b, theta0)| upright(Cop::from_params(a, b), theta0))?,
            "COE" => conic().map(|(a, b, theta0)| upright(Coe::from_params(a, b), theta0))?,
            "COD" => conic().map(|(a, b, theta0)| upright(Cod::from_params(a, b), theta0))?,
            "COO" => conic().map(|(a, b, theta0)| upright(Coo::from_params(a, b), theta0))?,
            "TSC" => cube(),
            "HPX" if (number(1, 4.0), number(2, 3.0)) == (4.0, 3.0) => upright(Hpx, 0.0),
            "HPX" => return Err(format!("HPX with H = {} and K = {}", number(1, 4.0), number(2, 3.0))),
            _ => return Err(format!("projection {name}")),
        })
    }

    /// The native direction of a place in the plane, both in degrees; none where there is none.
    pub fn native(&self, [x, y]: [f64; 2]) -> Option<[f64; 3]> {
        (self.native)(x.to_radians(), y.to_radians())
    }
}
