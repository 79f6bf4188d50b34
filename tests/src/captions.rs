//! The captions of the paper's Test 1 on three simulated images, with what an independent f64 program gave for them.

use skyfront_core::config::{Config, Edge, Rescale, Scheme, Tau};

/// One caption.
#[derive(Clone, Copy, Debug)]
pub struct Caption {
    rescale: Rescale,
    edge: Edge,
    /// The scheme.
    pub scheme: Scheme,
    nu: f32,
    /// Steps until the front stopped and pixels of {u > 0}, on `f160_dev0`, `f160_dev1` and `f160_dev2`.
    pub found: [(u32, u32); 3],
}

impl Caption {
    /// The configuration.
    pub fn config(&self) -> Config {
        let Caption { rescale, edge, scheme, nu, .. } = *self;
        Config { rescale, edge, nu, ..Config::PAPER_F160 }.with_scheme(scheme)
    }
}

const NONE: Rescale = Rescale::None;
const R1: Rescale = Rescale::R1 { alpha: 0.25 };
const R3: Rescale = Rescale::R3 { beta: 8, tau: Tau::Otsu };
const G1: Edge = Edge::G1 { p: 5000.0 };
const G2: Edge = Edge::G2Mod { c2: 0.8 };

/// The rescalings of [`CAPTIONS`] with what they are called.
pub const RESCALINGS: [(&str, Rescale); 2] = [("r1", R1), ("r3", R3)];

/// All captions with a heat filter.
#[rustfmt::skip]
pub const CAPTIONS: [Caption; 12] = [
    caption(NONE, Scheme::Fd, [(631, 109), (631, 58), (633, 40)]),
    caption(NONE, Scheme::Sl, [(149, 109), (149, 58), (150, 40)]),
    caption(NONE, Scheme::FdCurvature, [(1532, 179), (1532, 150), (1531, 138)]),
    caption(NONE, Scheme::SlCurvature, [(149, 79), (149, 50), (149, 32)]),
    caption(R1, Scheme::Fd, [(746, 616), (735, 406), (729, 601)]),
    caption(R1, Scheme::Sl, [(183, 617), (180, 404), (181, 570)]),
    caption(R1, Scheme::FdCurvature, [(1532, 249), (1532, 192), (1531, 177)]),
    caption(R1, Scheme::SlCurvature, [(149, 149), (149, 92), (149, 57)]),
    caption(R3, Scheme::Fd, [(630, 94), (630, 47), (630, 30)]),
    caption(R3, Scheme::Sl, [(149, 94), (149, 47), (149, 30)]),
    caption(R3, Scheme::FdCurvature, [(1532, 198), (1532, 149), (1532, 136)]),
    caption(R3, Scheme::SlCurvature, [(149, 98), (149, 49), (149, 30)]),
];

/// Edge detector and weight of the curvature are the paper's for the scheme and the rescaling.
const fn caption(rescale: Rescale, scheme: Scheme, found: [(u32, u32); 3]) -> Caption {
    let edge = if matches!(scheme, Scheme::FdCurvature | Scheme::SlCurvature) { G1 } else { G2 };
    let nu = if matches!(rescale, Rescale::R1 { .. }) { 1e-6 } else { 1e-4 };
    Caption { rescale, edge, scheme, nu, found }
}

/// The paper's configuration for a rescaling and a scheme.
pub fn paper(rescale: Rescale, scheme: Scheme) -> Config {
    caption(rescale, scheme, [(0, 0); 3]).config()
}
