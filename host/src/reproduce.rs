//! The captions of the paper's Tests 1 and 2, as configurations.

pub mod claims;
pub mod page;

use skyfront_core::config::{Config, CurvatureForm, Diffusivity, Edge, Filter, Order, Rescale, Scheme, Tau};

/// One figure of the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Caption {
    /// 1: f160.fits, a simulated image of high signal to noise. 2: real.fits, a noisy one.
    pub test: u8,
    /// What the figure shows.
    pub text: &'static str,
    /// The time at which the front stopped, where the paper gives one.
    pub t: Option<f64>,
    /// The run.
    pub config: Config,
}

const G1: Edge = Edge::G1 { p: 5000.0 };
const G2: Edge = Edge::G2Mod { c2: 0.8 };
const R1: Rescale = Rescale::R1 { alpha: 0.25 };
const PM: Filter = Filter::PeronaMalik { diffusivity: Diffusivity::F2, mu: 30.0 };

const fn r3(beta: u16) -> Rescale {
    Rescale::R3 { beta, tau: Tau::Otsu }
}

/// All captions in the order of the paper. The printed form of the curvature averages, which the paper's text gives
/// and which never settles in finite differences, follows the figures it belongs to.
pub fn captions() -> Vec<Caption> {
    let mut list = Vec::new();
    let mut add = |test, text, t, config| list.push(Caption { test, text, t, config });
    let run = |rescale, scheme, edge| Config { rescale, edge, ..Config::PAPER_F160 }.with_scheme(scheme);
    let bend = |config: Config, nu| Config { nu, ..config };
    let printed = |config: Config| Config { curvature_form: CurvatureForm::Printed, ..config };
    let malik = |config: Config| Config { filter: PM, filter_steps: 15, ..config };
    let none = Rescale::None;
    let (bent_fd, bent_sl) = (run(none, Scheme::FdCurvature, G1), run(none, Scheme::SlCurvature, G1));
    add(1, "none, FD, g2mod 0.8", Some(15.85), run(none, Scheme::Fd, G2));
    add(1, "none, SL, g2mod 0.8", Some(15.0), run(none, Scheme::Sl, G2));
    add(1, "none, FD curvature 1e-4, g1", Some(16.61), bend(bent_fd, 1e-4));
    add(1, "the same, as printed", Some(16.61), printed(bend(bent_fd, 1e-4)));
    add(1, "none, SL curvature 1e-4, g1", Some(15.4), bend(bent_sl, 1e-4));
    add(1, "the same, as printed", Some(15.4), printed(bend(bent_sl, 1e-4)));
    add(1, "none, PM, SL, g2mod 0.8", Some(15.0), malik(run(none, Scheme::Sl, G2)));
    add(1, "r1, FD, g2mod 0.8", Some(18.075), run(R1, Scheme::Fd, G2));
    add(1, "r1, SL, g2mod 0.8", Some(18.1), run(R1, Scheme::Sl, G2));
    add(1, "r1, PM, SL, g2mod 0.8", Some(18.6), malik(run(R1, Scheme::Sl, G2)));
    add(1, "r1, FD curvature 1e-6, g1", Some(16.08), bend(run(R1, Scheme::FdCurvature, G1), 1e-6));
    add(1, "r1, SL curvature 1e-6, g1", Some(15.1), bend(run(R1, Scheme::SlCurvature, G1), 1e-6));
    add(1, "r3, FD, g2mod 0.8", Some(15.4), run(r3(8), Scheme::Fd, G2));
    add(1, "r3, SL, g2mod 0.8", Some(14.9), run(r3(8), Scheme::Sl, G2));
    add(1, "r3, FD curvature 1e-4, g1", Some(15.55), bend(run(r3(8), Scheme::FdCurvature, G1), 1e-4));
    add(1, "r3, SL curvature 1e-4, g1", Some(28.8), bend(run(r3(8), Scheme::SlCurvature, G1), 1e-4));
    // Test 2 filters longer and, but for Perona-Malik, before the rescaling.
    let noisy = |config: Config| Config { filter_dt: 1e-3, order: Order::FilterFirst, ..config };
    let steep = Edge::G1 { p: 1e4 };
    let (low, mid) = (Edge::G2Mod { c2: 0.6 }, Edge::G2Mod { c2: 0.78 });
    add(2, "none, SL, g1 p = 1e4", None, noisy(run(none, Scheme::Sl, steep)));
    add(2, "none, SL, g2mod 0.6", None, noisy(run(none, Scheme::Sl, low)));
    add(2, "none, SL curvature 1e-4, g1", None, noisy(bend(run(none, Scheme::SlCurvature, steep), 1e-4)));
    add(2, "r1, FD, g2mod 0.78", None, noisy(run(R1, Scheme::Fd, mid)));
    add(2, "r1, SL, g2mod 0.78", None, noisy(run(R1, Scheme::Sl, mid)));
    let after = Config { order: Order::RescaleFirst, ..noisy(malik(run(R1, Scheme::Fd, mid))) };
    add(2, "r1, PM, FD, g2mod 0.78", None, after);
    add(2, "r3 beta 4, FD, g2mod 0.6", None, noisy(run(r3(4), Scheme::Fd, low)));
    add(2, "r3 beta 4, SL, g2mod 0.6", None, noisy(run(r3(4), Scheme::Sl, low)));
    list
}
