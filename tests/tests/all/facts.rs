//! The core against answers that are known without computing them: fronts.

use skyfront::reference::{self, Connectivity};
use skyfront_core::arithmetic::F32;
use skyfront_core::config::{Config, Scheme};
use skyfront_core::error::Error;
use skyfront_core::front::profile::Profile;
use skyfront_tests::evolve::Front;

const PAPER: Config = Config::PAPER_F160;
const SCHEMES: [Scheme; 5] = [Scheme::Fd, Scheme::Sl, Scheme::FdCurvature, Scheme::SlCurvature, Scheme::FdFiltered];

/// On a flat 300 x 300 image the front meets itself at 14.8, the half-width of its rectangle; the rule fires when the
/// wave has passed. The numbers of steps are those of an independent f64 program: t = 15.75, 14.9, 15.32, 14.9 and
/// 14.75. The last steps change a hundred nodes by far more than f32 rounds, so that the number of steps is exact.
#[test]
fn a_flat_image_takes_the_time_to_its_middle() {
    for (scheme, steps) in SCHEMES.into_iter().zip([630, 149, 1532, 149, 590]) {
        let config = PAPER.with_scheme(scheme);
        let mut flat = Front::new(config, 300, 300, |_, _| 0.0);
        let u0 = Profile::new(&config, 300, 300);
        for (y, row) in flat.values.chunks_exact_mut(300).enumerate() {
            u0.row::<F32>(y, row);
        }
        let taken = (1..=config.max_steps()).find(|_| flat.step());
        assert_eq!(taken, Some(steps), "{scheme:?}");
    }
}

/// The radius of a circle under speed 1 changes by t. A first-order scheme smears the profile; its level set lags by
/// the truncation error, (dx/2) |u_xx| per unit time with u_xx = 1/r <= 1 here, and the 16 directions of the
/// semi-Lagrangian scheme miss a normal by up to pi/16, 2 % of the way: together below dx = 0.1 for t = 1.
#[test]
fn a_circle_moves_by_t() {
    for scheme in [Scheme::Fd, Scheme::Sl, Scheme::FdFiltered] {
        for (sign, expected) in [(1.0, 3.0), (-1.0, 1.0)] {
            let mut circle = Front::new(PAPER.with_scheme(scheme), 101, 101, |x, y| sign * (x.hypot(y) - 2.0));
            circle.until(1.0);
            for diagonal in [false, true] {
                let radius = circle.radius(diagonal);
                assert!((radius - expected).abs() < 0.1, "{scheme:?}, diagonal {diagonal}: {radius}, not {expected}");
            }
        }
    }
}

/// dr/dt = 1 - nu/r from r = 1 to t = 1.
fn grown(nu: f64) -> f64 {
    (0..100_000).fold(1.0, |r, _| r + 1e-5 * (1.0 - nu / r))
}

/// A disc that grows with speed 1 - nu k has dr/dt = 1 - nu/r. With nu = 0.5 and r = 1 at the start curvature halves
/// the speed: without it the radius would be 2 at t = 1. The error is that of the circle above.
#[test]
fn curvature_slows_a_growing_disc() {
    let expected = grown(0.5);
    assert!(expected < 1.7, "the fact itself: {expected}");
    for (scheme, dt) in [(Scheme::FdCurvature, 0.004), (Scheme::SlCurvature, 0.02)] {
        assert_grown(Config { scheme, nu: 0.5, dt, ..PAPER }, expected);
    }
}

fn assert_grown(config: Config, expected: f64) {
    let mut disc = Front::new(config, 81, 81, |x, y| x.hypot(y) - 1.0);
    disc.until(1.0);
    for diagonal in [false, true] {
        let (radius, scheme) = (disc.radius(diagonal), config.scheme);
        assert!((radius - expected).abs() < 0.1, "{scheme:?}, diagonal {diagonal}: {radius}, not {expected}");
    }
}

/// The bound on the explicit step with curvature, 2 dt/dx + 2 nu dt/dx^2 <= 1: discs at the bound grow as they must,
/// with much curvature and with little. What was the bound before, nu dt <= dx^2/2 alone, is refused.
#[test]
fn explicit_curvature_at_its_bound_still_grows_a_disc() {
    for nu in [0.7f32, 0.4, 0.1, 0.01] {
        let dt = PAPER.dx * PAPER.dx / (2.0 * (PAPER.dx + nu));
        let config = Config { scheme: Scheme::FdCurvature, nu, dt, ..PAPER };
        assert_eq!(config.validate::<F32>(), Ok(()));
        assert_grown(config, grown(nu.into()));
        let longer = Config { dt: dt * 1.01, ..config };
        assert!(matches!(longer.validate::<F32>(), Err(Error::Parameter { name: "dt", .. })));
    }
}

/// The bound on nu of the semi-Lagrangian scheme: over a rugged front and a rugged speed no value falls below all others
/// at the bound; beyond it is refused, and so is what the bound was once, 1 with the paper's step.
#[test]
fn semi_lagrangian_curvature_at_its_bound_makes_no_new_least_value() {
    let mut state = 7u32;
    let mut uniform = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / 16_777_216.0
    };
    for (dt, bound) in [(0.01f32, 0.863_5f32), (0.05, 0.417_8), (0.08, 0.188_6), (0.09, 0.099_9)] {
        let config = Config { scheme: Scheme::SlCurvature, dt, nu: bound, degenerate: 1.0, ..PAPER };
        assert_eq!(config.validate::<F32>(), Ok(()), "dt = {dt}");
        let beyond = Config { nu: bound * 1.002, ..config };
        assert!(matches!(beyond.validate::<F32>(), Err(Error::Parameter { name: "nu", .. })), "dt = {dt}");
        let mut rugged = Front::new(config, 41, 41, |_, _| 0.0);
        rugged.values.iter_mut().for_each(|v| *v = uniform() as f32);
        rugged.speed.iter_mut().for_each(|g| *g = if uniform() < 0.5 { 1.0 } else { uniform() as f32 });
        let least = |front: &Front| front.values.iter().copied().fold(f32::MAX, f32::min);
        let before = least(&rugged);
        rugged.until(200.0 * f64::from(dt));
        assert!(least(&rugged) >= before - 1e-6, "dt = {dt}: {} from {before}", least(&rugged));
    }
    // At the paper's step the range grows by a factor of e at most in a run.
    let paper = PAPER.with_scheme(Scheme::SlCurvature);
    for (nu, good) in [(1e-4, true), (2e-3, true), (2.1e-3, false), (0.05, false), (1.0, false)] {
        assert_eq!(Config { nu, ..paper }.validate::<F32>().is_ok(), good, "nu = {nu}");
    }
}

/// Number of components of {u < 0} or {u > 0}.
fn components(front: &Front, negative: bool) -> u32 {
    let mask: Vec<bool> = front.values.iter().map(|&u| if negative { u < 0.0 } else { u > 0.0 }).collect();
    reference::label(&mask, front.width, Connectivity::Four, 1).1
}

/// Two discs 2 apart that grow at speed 1 touch at t = 1; a dumbbell with a bar of half-width 0.4 that shrinks breaks
/// at t = 0.4. Half of dx/2 per unit time of smearing leaves both well decided 0.3 before and after.
#[test]
fn fronts_merge_and_split() {
    for scheme in SCHEMES {
        let config = PAPER.with_scheme(scheme);
        let mut discs = Front::new(config, 101, 61, |x, y| (x - 2.0).hypot(y).min((x + 2.0).hypot(y)) - 1.0);
        discs.until(0.7);
        assert_eq!(components(&discs, true), 2, "{scheme:?}: not yet one");
        discs.until(0.6);
        assert_eq!(components(&discs, true), 1, "{scheme:?}: merged");
        let mut dumbbell = Front::new(config, 101, 61, |x, y| {
            let bar = if x.abs() < 2.5 { 0.4 - y.abs() } else { -1.0 };
            bar.max(1.5 - (x - 2.5).hypot(y)).max(1.5 - (x + 2.5).hypot(y))
        });
        assert_eq!(components(&dumbbell, false), 1, "{scheme:?}: a dumbbell");
        dumbbell.until(0.7);
        assert_eq!(components(&dumbbell, false), 2, "{scheme:?}: split");
    }
}
