//! The choices of the algorithm, with the paper's values as defaults.

use super::{Filter, ReferenceError};

/// How the grey levels are brought to \[0, 1\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Normalize {
    /// Smallest and largest level (`risc01`).
    MinMax,
    /// Two percentiles in 0 ..= 100; levels beyond them are clipped.
    Percentile(f64, f64),
    /// The sky minus and plus so many standard deviations of its noise; levels beyond them are clipped.
    Noise(f64, f64),
    /// The same of signal-to-noise, whose sky is 0 and whose noise is 1.
    Signal(f64, f64),
}

/// Rescaling function of step 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rescale {
    /// The normalised image as it is.
    None,
    /// x^alpha.
    R1 {
        /// In (0, 1).
        alpha: f64,
    },
    /// (ln(x + 1) / ln 2)^alpha.
    R2 {
        /// In (0, 1).
        alpha: f64,
    },
    /// Powers beta below and 1/beta above the threshold tau.
    R3 {
        /// 1, 2, 3, ...
        beta: f64,
    },
}

/// Where the threshold of r3 comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tau {
    /// Otsu's method on the image r3 is applied to.
    Otsu,
    /// The greatest entropy, on the same image.
    Kapur,
    /// The corner of its histogram.
    Rosin,
    /// So many standard deviations above its sky.
    Noise(f64),
    /// A given value in (0, 1).
    Value(f64),
}

/// Which of steps 2 and 3 comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// The algorithm as stated, and Test 1.
    RescaleFirst,
    /// Test 2.
    FilterFirst,
}

/// Edge detector of step 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Edge {
    /// 1 / (1 + z^p).
    G1 {
        /// At least 1.
        p: f64,
    },
    /// 1 - (z - m) / (M - m).
    G2,
    /// max(g2 - c2, 0) / (1 - c2).
    G2Mod {
        /// In \[0, 1).
        c2: f64,
    },
}

/// Numerical scheme of step 5.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// `DFg`.
    Fd,
    /// `SLg`.
    Sl,
    /// `DFgk`.
    FdCurvature,
    /// `SLgk`.
    SlCurvature,
    /// `DFg` by the filtered scheme of Falcone, Paolucci and Tozza (arXiv:1812.03026).
    FdFiltered,
    /// Active contours without edges (T. F. Chan, L. A. Vese 2001, DOI 10.1109/83.902291).
    ChanVese,
    /// Four phases by two fronts (L. A. Vese, T. F. Chan 2002, DOI 10.1023/A:1020874308076).
    Multiphase,
    /// The equation of `DFg` by times of arrival: the front at T_max.
    FastMarching,
}

impl Scheme {
    /// The paper's time step: dx/4, dx, dx^2, dx.
    pub fn paper_dt(self, dx: f64) -> f64 {
        match self {
            Scheme::Fd | Scheme::FdFiltered | Scheme::FastMarching => dx / 4.0,
            Scheme::FdCurvature => dx * dx,
            Scheme::Sl | Scheme::SlCurvature => dx,
            Scheme::ChanVese | Scheme::Multiphase => 8.0,
        }
    }
}

/// How the averages of the curvature schemes are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CurvatureForm {
    /// With `- v`: an approximation of nu g k |grad u| (erratum 3).
    Consistent,
    /// Without, as printed.
    Printed,
}

/// When the front counts as stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// `critarr`: the change in a step is at most eps.
    Paper,
    /// The change per unit time is at most eps and no node near the front changed sign (erratum 8).
    Rate,
}

/// Which pixels are neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Connectivity {
    /// Those that share a side.
    Four,
    /// Those that share a side or a corner.
    Eight,
}

/// All choices of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Step 1.
    pub normalize: Normalize,
    /// Step 2.
    pub rescale: Rescale,
    /// The threshold of r3.
    pub tau: Tau,
    /// Which of steps 2 and 3 comes first.
    pub order: Order,
    /// Step 3.
    pub filter: Filter,
    /// Step 4.
    pub edge: Edge,
    /// Step 5.
    pub scheme: Scheme,
    /// Weight of the curvature, for the two schemes that have it.
    pub nu: f64,
    /// Weight of the length of the contour, for Chan and Vese.
    pub mu: f64,
    /// Their weights lambda1 of the inside and lambda2 of the outside.
    pub lambda: (f64, f64),
    /// The front starts so many pixels outside the level set of the filtered image at tau, or at Otsu's threshold where
    /// the rescaling has none (ours); `None` is the paper's u0.
    pub start_margin: Option<f64>,
    /// How their averages are written.
    pub curvature_form: CurvatureForm,
    /// C of the threshold C dx^s below which a gradient is degenerate (erratum 4).
    pub degenerate_c: f64,
    /// s of that threshold.
    pub degenerate_s: f64,
    /// Directions on the unit circle that the semi-Lagrangian minimum looks along, besides the centre.
    pub directions: u32,
    /// Space step, for both axes.
    pub dx: f64,
    /// Time step of the evolution.
    pub dt: f64,
    /// Time at which the evolution ends at the latest.
    pub t_max: f64,
    /// eps_F: nodes with |v| up to this are near the front.
    pub eps_front: f64,
    /// Tolerance of the stopping rule.
    pub eps: f64,
    /// The stopping rule.
    pub stop: Stop,
    /// u0 saturated at this many pixels from the front, on the shorter side (ours); `None` is the paper's u0.
    pub band: Option<f64>,
    /// Neighbourhood of step 6.
    pub connectivity: Connectivity,
    /// Smallest number of pixels of a source.
    pub min_area: usize,
}

impl Parameters {
    /// The paper's values for one of its schemes (Test 1, r3).
    pub fn paper(scheme: Scheme) -> Parameters {
        let dx = 0.1;
        Parameters {
            normalize: Normalize::MinMax,
            rescale: Rescale::R3 { beta: 8.0 },
            tau: Tau::Otsu,
            order: Order::RescaleFirst,
            filter: Filter::Heat { steps: 5, dt: 1e-4 },
            edge: Edge::G2Mod { c2: 0.8 },
            scheme,
            nu: 1e-4,
            mu: 0.005,
            lambda: (1.0, 1.0),
            start_margin: None,
            curvature_form: CurvatureForm::Consistent,
            degenerate_c: 0.1,
            degenerate_s: 1.0,
            directions: 16,
            dx,
            dt: scheme.paper_dt(dx),
            t_max: 50.0,
            eps_front: dx,
            eps: 1e-3,
            stop: Stop::Paper,
            band: None,
            connectivity: Connectivity::Eight,
            min_area: 1,
        }
    }

    /// The step bound: as many steps as reach `t_max`.
    pub fn max_steps(&self) -> u32 {
        (self.t_max / self.dt - 1e-9).ceil() as u32
    }

    /// Refuses what the formulas are not defined for and steps beyond their CFL bound (erratum 9).
    ///
    /// # Errors
    /// The first parameter out of bounds.
    pub fn check(&self) -> Result<(), ReferenceError> {
        let dx = self.dx;
        // The paper's own dt are exact multiples of their bounds in the reals, not in f64.
        let at_most = |a: f64, b: f64| a > 0.0 && a <= b * (1.0 + 1e-12);
        let ask = |ok: bool, name, value, bound| {
            if ok { Ok(()) } else { Err(ReferenceError::Parameter { name, value, bound }) }
        };
        ask(dx > 0.0 && dx.is_finite(), "dx", dx, "positive")?;
        ask(self.t_max > 0.0 && self.t_max.is_finite(), "t-max", self.t_max, "positive")?;
        if let Filter::Heat { dt, .. } | Filter::PeronaMalik { dt, .. } = self.filter {
            ask(at_most(dt, dx * dx / 4.0), "filter-dt", dt, "at most dx^2/4")?;
        }
        match self.scheme {
            Scheme::Fd | Scheme::FdCurvature | Scheme::FastMarching => {
                ask(at_most(self.dt, dx / 2.0), "dt", self.dt, "at most dx/2")?;
            }
            Scheme::FdFiltered => ask(at_most(self.dt, 0.4 * dx), "dt", self.dt, "at most 2/5 dx")?,
            Scheme::Sl | Scheme::SlCurvature => ask(at_most(self.dt, dx), "dt", self.dt, "at most dx")?,
            Scheme::ChanVese | Scheme::Multiphase => {
                ask(self.dt > 0.0 && self.dt.is_finite(), "dt", self.dt, "positive")?;
            }
        }
        if self.scheme == Scheme::FdCurvature {
            // The weight of a node's own old value in its new one is 1 - 2 dt/dx - 2 nu dt/dx^2 or more.
            let bound = "so that 2 dt/dx + 2 nu dt/dx^2 is at most 1";
            ask(2.0 * self.dt / dx * (1.0 + self.nu / dx) <= 1.0 + 1e-12, "nu", self.nu, bound)?;
        }
        if let (Rescale::R3 { .. }, Tau::Value(tau)) = (self.rescale, self.tau) {
            ask(tau > 0.0 && tau < 1.0, "tau", tau, "between 0 and 1")?;
        }
        Ok(())
    }
}

impl Default for Parameters {
    /// The first-order finite differences of the paper.
    fn default() -> Parameters {
        Parameters::paper(Scheme::Fd)
    }
}
