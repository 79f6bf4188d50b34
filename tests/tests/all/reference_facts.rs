//! Known answers for the f64 reference: what it says about a flat image and a circle has to be right before it can
//! judge the core.

use skyfront::reference::{
    CurvatureForm, Ended, Evolution, Parameters, Plane, Scheme, Stop, evolve, initial, r1, r2, r3, step,
};

/// The front on a flat image of the paper's size: g = 1 everywhere, nothing to find.
fn flat(parameters: &Parameters) -> Evolution {
    let g = Plane::from_fn(300, 300, |_, _| 1.0);
    evolve(parameters, &g, &initial(300, 300, parameters.dx))
}

fn positive(u: &Plane) -> usize {
    u.values().iter().filter(|&&v| v > 0.0).count()
}

/// The front meets itself in the middle at 14.8, the half-width of its rectangle; the rule fires when the wave has
/// passed. The times are those of an independent program: 15.75, 14.9, 15.3, 14.9, the last digit being its rounding.
#[test]
fn the_flat_image_stops_when_the_front_has_met_itself() {
    for (scheme, expected) in
        [(Scheme::Fd, 15.75), (Scheme::Sl, 14.9), (Scheme::FdCurvature, 15.32), (Scheme::SlCurvature, 14.9)]
    {
        let end = flat(&Parameters::paper(scheme));
        assert_eq!(end.ended, Ended::Converged, "{scheme:?}");
        assert!((end.t - expected).abs() < 1e-9, "{scheme:?}: {}", end.t);
    }
}

/// Erratum 8: at dt = 0.01 the paper's rule fires while a 10 x 10 block is still positive, the rule per unit time
/// waits until it is gone.
#[test]
fn the_rule_per_unit_time_leaves_no_ghost() {
    let paper = Parameters::paper(Scheme::FdCurvature);
    assert_eq!(positive(&flat(&paper).u), 100);
    let rate = Parameters { stop: Stop::Rate, ..paper };
    let end = flat(&rate);
    assert_eq!(end.ended, Ended::Converged);
    assert_eq!(positive(&end.u), 0);
}

/// Erratum 3: as printed, the term multiplies the nodes of the pyramid's ridges by 1 + nu g in every step, so that
/// the finite differences never meet the rule.
#[test]
fn the_printed_averages_never_stop() {
    let printed = Parameters { curvature_form: CurvatureForm::Printed, ..Parameters::paper(Scheme::FdCurvature) };
    let end = flat(&printed);
    assert_eq!(end.ended, Ended::TimeLimit);
    assert!((end.t - 50.0).abs() < 1e-9);
}

/// A disc of radius 2 in a 10 x 10 domain that grows (u < 0 inside) or shrinks (u > 0 inside) at unit speed for t = 1:
/// the radius changes by 1. Both schemes smear a corner of the profile, not its slope, so the level set moves with an
/// error below dx, measured on the axis and on the diagonal.
#[test]
fn a_circle_moves_by_t() {
    for scheme in [Scheme::Fd, Scheme::Sl] {
        for (sign, expected) in [(1.0, 3.0), (-1.0, 1.0)] {
            let p = Parameters::paper(scheme);
            let n = 101;
            let radius = |i: isize, j: isize| (((i - 50).pow(2) + (j - 50).pow(2)) as f64).sqrt() * p.dx;
            let mut v = Plane::from_fn(n, n, |i, j| sign * (radius(i, j) - 2.0));
            let g = Plane::from_fn(n, n, |_, _| 1.0);
            for _ in 0..(1.0 / p.dt).round() as usize {
                v = step(&p, &g, &v);
            }
            for (di, dj) in [(1, 0), (1, 1)] {
                let steps = 0..49;
                let at = |k: isize| v.at(50 + k * di, 50 + k * dj) * sign;
                let k = steps.clone().find(|&k| at(k) <= 0.0 && at(k + 1) > 0.0);
                let k = k.unwrap_or_else(|| panic!("{scheme:?}: the circle is gone"));
                let crossing = k as f64 + at(k) / (at(k) - at(k + 1));
                let found = crossing * p.dx * ((di * di + dj * dj) as f64).sqrt();
                assert!((found - expected).abs() < p.dx, "{scheme:?}: radius {found}, not {expected}");
            }
        }
    }
}

/// A1 to A3 for all three rescalings, A4 for r1 and r2 and A4_tau for r3 inside (0, 1) (erratum 5).
#[test]
fn the_rescalings_have_their_properties() {
    let tau = 0.26171875;
    let functions: [(&str, &dyn Fn(f64) -> f64); 3] =
        [("r1", &|x| r1(x, 0.25)), ("r2", &|x| r2(x, 0.25)), ("r3", &|x| r3(x, 8.0, tau))];
    for (name, r) in functions {
        assert_eq!(r(0.0), 0.0, "{name}");
        assert!((r(1.0) - 1.0).abs() < 1e-15, "{name}");
        let levels: Vec<f64> = (0..=4096).map(|k| f64::from(k) / 4096.0).collect();
        for pair in levels.windows(2) {
            assert!(r(pair[0]) < r(pair[1]), "{name} at {}", pair[0]);
        }
        for &x in &levels[1..4096] {
            let brighter = name != "r3" || x > tau;
            assert!((r(x) - x) * if brighter { 1.0 } else { -1.0 } > 0.0 || x == tau);
        }
    }
    assert_eq!(r3(tau, 8.0, tau), tau);
}
