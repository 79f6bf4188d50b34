//! Step 5: the front from u0 until it stops (`critarr`).

use super::initial::half_side;
use super::{
    Parameters, Plane, Scheme, Stop, arrival, chan_vese, fd, fd_curvature, fd_filtered, multiphase, sl, sl_curvature,
};

/// What ended an evolution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The stopping rule was met.
    Converged,
    /// T_max was reached first.
    TimeLimit,
}

/// The result of an evolution.
#[derive(Clone, Debug)]
pub struct Evolution {
    /// The representation function at the end.
    pub u: Plane,
    /// Time steps taken.
    pub steps: u32,
    /// `steps` times dt.
    pub t: f64,
    /// What ended it.
    pub ended: Ended,
    /// After each step, the left side of `critarr`.
    pub changes: Vec<f64>,
}

/// One time step of a scheme with one front; those of two are [`super::multiphase`]'s. Chan and Vese take the image in the place of g; times of arrival are those of
/// `DFg`.
pub fn step(p: &Parameters, g: &Plane, v: &Plane) -> Plane {
    match p.scheme {
        Scheme::Fd | Scheme::FastMarching => fd::step(p, g, v),
        Scheme::FdFiltered => fd_filtered::step(p, g, v),
        Scheme::FdCurvature => fd_curvature::step(p, g, v),
        Scheme::Sl => sl::step(p, g, v),
        Scheme::SlCurvature => sl_curvature::step(p, g, v),
        Scheme::ChanVese => chan_vese::step(p, std::slice::from_ref(g), v),
        Scheme::Multiphase => v.clone(),
    }
}

/// Steps from `u0`, or of two fronts from the image's own classes, until the stopping rule is met or T_max is reached.
pub fn evolve(p: &Parameters, g: &Plane, u0: &Plane) -> Evolution {
    if p.scheme == Scheme::FastMarching {
        return marched(p, g, u0);
    }
    if p.scheme == Scheme::Multiphase {
        return parted(p, g);
    }
    moved(p, u0, |u| step(p, g, u))
}

/// Steps of one front in several bands, from `u0` until the stopping rule is met or T_max is reached.
pub fn evolve_in(p: &Parameters, bands: &[Plane], u0: &Plane) -> Evolution {
    moved(p, u0, |u| chan_vese::step(p, bands, u))
}

fn moved(p: &Parameters, u0: &Plane, step: impl Fn(&Plane) -> Plane) -> Evolution {
    let mut u = u0.clone();
    let mut changes = Vec::new();
    let mut ended = Ended::TimeLimit;
    for _ in 0..p.max_steps() {
        let next = step(&u);
        let (change, crossed) = change(p, &u, &next);
        u = next;
        changes.push(change);
        if at_rest(p, change, crossed) {
            ended = Ended::Converged;
            break;
        }
    }
    let steps = changes.len() as u32;
    Evolution { u, steps, t: f64::from(steps) * p.dt, ended, changes }
}

/// Two fronts from the classes of the image; u at the end has the ranks of their phases.
fn parted(p: &Parameters, image: &Plane) -> Evolution {
    let mut means = multiphase::classes(image);
    let mut fronts = multiphase::start(image, means);
    let (mut changes, mut ended) = (Vec::new(), Ended::TimeLimit);
    for _ in 0..p.max_steps() {
        means = fronts.means(image, means);
        let next = fronts.step(p, image, means);
        let (change, crossed) = multiphase::change(p, &fronts, &next);
        fronts = next;
        changes.push(change);
        if at_rest(p, change, crossed) {
            ended = Ended::Converged;
            break;
        }
    }
    let half = half_side(image);
    let (u, steps) = (fronts.ranks(image).map(|rank| rank / half), changes.len() as u32);
    Evolution { u, steps, t: f64::from(steps) * p.dt, ended, changes }
}

/// The front at T_max by times of arrival; its steps are those until the last of them.
fn marched(p: &Parameters, g: &Plane, u0: &Plane) -> Evolution {
    let times = arrival::arrivals(g, u0);
    let reached = times.values().iter().filter(|time| **time * p.dx <= p.t_max);
    let latest = reached.fold(0.0f64, |latest, time| latest.max(time * p.dx));
    let steps = (latest / p.dt) as u32;
    let t = f64::from(steps) * p.dt;
    Evolution { u: arrival::front(p, &times), steps, t, ended: Ended::Converged, changes: Vec::new() }
}

/// Whether a step with this change was the last.
pub fn at_rest(p: &Parameters, change: f64, crossed: bool) -> bool {
    match p.stop {
        Stop::Paper => change <= p.eps,
        Stop::Rate => change / p.dt <= p.eps && !crossed,
    }
}

/// dx^2 times the sum of |v^(n+1) - v^n| over the nodes near the front, and whether one of them changed sign.
pub fn change(p: &Parameters, old: &Plane, new: &Plane) -> (f64, bool) {
    let (mut sum, mut crossed) = (0.0, false);
    for (&a, &b) in old.values().iter().zip(new.values()) {
        // Every pixel takes part in the regions of Chan and Vese.
        if a.abs() <= p.eps_front || p.scheme == Scheme::ChanVese {
            sum += (b - a).abs();
            crossed |= (a > 0.0) != (b > 0.0);
        }
    }
    (p.dx * p.dx * sum, crossed)
}
