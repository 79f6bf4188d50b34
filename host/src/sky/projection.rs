//! From the projection plane to the native sphere (Calabretta and Greisen 2002,
//! doi:10.1051/0004-6361:20021327): the projections of the `mapproj` crate, with their parameters.

use super::keys::Keys;
use mapproj::conic::{cod::Cod, coe::Coe, coo::Coo, cop::Cop};
use mapproj::cylindrical::{car::Car, cea::Cea, cyp::Cyp, mer::Mer};
use mapproj::hybrid::hpx::Hpx;
use mapproj::pseudocyl::{ait::Ait, mol::Mol, par::Par, sfl::Sfl};
use mapproj::zenithal::{air::Air, arc::Arc, azp::Azp, sin::Sin, sin::SinSlant, stg::Stg, szp::Szp, tan::Tan};
use mapproj::zenithal::{zea::Zea, zpn::Zpn};
use mapproj::{ProjXY, Projection as Plane};
use std::fmt;

/// The parameters of ZPN.
const ZPN_LAST: usize = 20;

/// A projection with its parameters.
pub struct Projection {
    plane: Box<dyn Plane + Send + Sync>,
    /// Native latitude of the reference point, degrees; its longitude is 0.
    pub theta0: f64,
    zenithal: bool,
}

impl fmt::Debug for Projection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.plane.short_name())
    }
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
        let zenithal = |plane| Ok(Projection { plane, theta0: 90.0, zenithal: true });
        let other = |plane| Ok(Projection { plane, theta0: 0.0, zenithal: false });
        let parameters = match name {
            "TAN" | "STG" | "ARC" | "ZEA" | "CAR" | "MER" | "SFL" | "PAR" | "MOL" | "AIT" => 0..0,
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
        let conic = |make: fn(f64, f64) -> Box<dyn Plane + Send + Sync>| {
            let theta0 = given(1).ok_or(format!("{name} without PV{latitude}_1"))?;
            let half = bounded(2, 0.0, |eta| eta.abs() < 90.0)?;
            if theta0 == 0.0 || theta0.abs() + half.abs() > 90.0 {
                return Err(format!("PV{latitude}_1 = {theta0} of {name}"));
            }
            Ok(Projection { plane: make(theta0.to_radians(), half.to_radians()), theta0, zenithal: false })
        };
        match name {
            "TAN" => zenithal(Box::new(Tan)),
            "STG" => zenithal(Box::new(Stg)),
            "ARC" => zenithal(Box::new(Arc)),
            "ZEA" => zenithal(Box::new(Zea)),
            "SIN" => match (number(1, 0.0), number(2, 0.0)) {
                (0.0, 0.0) => zenithal(Box::new(Sin)),
                (xi, eta) => zenithal(Box::new(SinSlant::new(-xi, eta))),
            },
            "AZP" => {
                let tilt = bounded(2, 0.0, |gamma| gamma.abs() < 90.0)?;
                let mu = bounded(1, 0.0, |mu| mu != -1.0)?;
                zenithal(Box::new(Azp::from_params(mu, tilt.to_radians())))
            }
            "SZP" => {
                let theta = bounded(3, 90.0, |theta| theta.abs() <= 90.0)?;
                zenithal(Box::new(Szp::from_params(number(1, 0.0), angle(2, 0.0), theta.to_radians())))
            }
            "ZPN" => {
                let last = (0..=ZPN_LAST).rev().find(|&m| number(m, 0.0) != 0.0);
                let coefficients = (0..=last.unwrap_or(0)).map(|m| number(m, 0.0)).collect();
                zenithal(Box::new(Zpn::from_params(coefficients).ok_or("the polynomial of ZPN falls from its start")?))
            }
            "AIR" => zenithal(Box::new(Air::from_param(bounded(1, 90.0, |t| t > -90.0 && t <= 90.0)?.to_radians()))),
            "CAR" => other(Box::new(Car)),
            "MER" => other(Box::new(Mer)),
            "CEA" => other(Box::new(Cea::from_param(bounded(1, 1.0, |lambda| lambda > 0.0 && lambda <= 1.0)?))),
            "CYP" => {
                let lambda = bounded(2, 1.0, |lambda| lambda > 0.0)?;
                other(Box::new(Cyp::from_params(bounded(1, 1.0, |mu| mu > 0.0)?, lambda)))
            }
            "SFL" => other(Box::new(Sfl)),
            "PAR" => other(Box::new(Par)),
            "MOL" => other(Box::new(Mol::new())),
            "AIT" => other(Box::new(Ait)),
            "COP" => conic(|a, b| Box::new(Cop::from_params(a, b))),
            "COE" => conic(|a, b| Box::new(Coe::from_params(a, b))),
            "COD" => conic(|a, b| Box::new(Cod::from_params(a, b))),
            "COO" => conic(|a, b| Box::new(Coo::from_params(a, b))),
            "HPX" if (number(1, 4.0), number(2, 3.0)) == (4.0, 3.0) => other(Box::new(Hpx)),
            "HPX" => Err(format!("HPX with H = {} and K = {}", number(1, 4.0), number(2, 3.0))),
            _ => Err(format!("projection {name}")),
        }
    }

    /// The native direction of a place in the plane, both in degrees; none where there is none.
    pub fn native(&self, [x, y]: [f64; 2]) -> Option<[f64; 3]> {
        let place = self.plane.unproj_xyz(&ProjXY::new(x.to_radians(), y.to_radians()))?;
        // The crate has the middle of zenithal projections on its first axis, native north above it.
        Some(if self.zenithal { [-place.z(), place.y(), place.x()] } else { [place.x(), place.y(), place.z()] })
    }
}
