//! The options of a run, each with the paper's value as its default, and what they amount to.

use super::choices::{
    ArithmeticOption, BandOption, CurvatureFormOption, EdgeOption, FilterOption, NormalizeOption, OrderOption,
    PmOption, Preset, RescaleOption, SchemeOption, StartOption, StopOption, TauOption, band, normalize, pair, start,
    tau,
};
use crate::read::Place;
use clap::Args;
use skyfront_core::arithmetic::{Arithmetic, Q11};
use skyfront_core::config::{
    ChanVese, Config, Connectivity, CurvatureForm, Diffusivity, Edge, Filter, Normalize, Order, Rescale, Scheme, Start,
    Stop, Tau,
};
use skyfront_core::detection::Detection;
use std::path::PathBuf;

/// What a run does; unset options take the preset's value.
#[derive(Clone, Debug, Default, Args)]
pub struct Options {
    /// Take settings from a TOML file whose keys are the names of these options; the command line
    /// goes before the file, the file before the preset.
    #[arg(long = "config", value_name = "FILE")]
    pub config_file: Option<PathBuf>,
    /// Print the effective settings as such a file, and do nothing else.
    #[arg(long)]
    pub dump_config: bool,
    /// Settings to start from.
    #[arg(long, value_enum, default_value_t)]
    pub preset: Preset,

    /// How pixel values become 0 to 1: minmax, percentile, or by the frame's sky and noise,
    /// noise:LOW,HIGH, so many standard deviations below and above the sky [noise: 3,30].
    #[arg(long, value_name = "minmax|percentile|noise[:LOW,HIGH]", value_parser = normalize,
        help_heading = "Rescaling")]
    pub normalize: Option<NormalizeOption>,
    /// Percentiles that become 0 and 1 [default: 0.5,99.9].
    #[arg(long, value_name = "LO,HI", value_parser = pair, help_heading = "Rescaling")]
    pub range: Option<(f64, f64)>,
    /// Rescaling of intensities.
    #[arg(long, value_enum, help_heading = "Rescaling")]
    pub rescale: Option<RescaleOption>,
    /// Exponent of r1 and r2, in (0, 1) [default: 0.25].
    #[arg(long, help_heading = "Rescaling")]
    pub alpha: Option<f64>,
    /// Exponent of r3: 1, 2, 3, ... [default: 8].
    #[arg(long, help_heading = "Rescaling")]
    pub beta: Option<u16>,
    /// Threshold of r3: otsu, kapur or rosin from the histogram, noise:K for K standard deviations
    /// above the sky, or a value in (0, 1), each of the image that is rescaled [default: otsu].
    #[arg(long, value_name = "otsu|kapur|rosin|noise:K|VALUE", value_parser = tau, help_heading = "Rescaling")]
    pub tau: Option<TauOption>,

    /// Filter.
    #[arg(long, value_enum, help_heading = "Filter")]
    pub filter: Option<FilterOption>,
    /// Steps of the filter [default: 5 for heat, 15 for pm].
    #[arg(long, help_heading = "Filter")]
    pub filter_steps: Option<u16>,
    /// Time step of the filter, at most dx^2/4.
    #[arg(long, help_heading = "Filter")]
    pub filter_dt: Option<f64>,
    /// Diffusion coefficient of Perona-Malik: f1 = 1/(1+s^2), f2 = exp(-s^2).
    #[arg(long, value_enum, help_heading = "Filter")]
    pub pm: Option<PmOption>,
    /// Gradient at which Perona-Malik stops diffusing, in image units (0 to 1) per dx. The
    /// paper's 30 is nearly the heat filter; 2 keeps edges [default: 30]. --mu is the same, but
    /// with chan-vese.
    #[arg(long, help_heading = "Filter")]
    pub pm_mu: Option<f64>,
    /// Whether to rescale or to filter first.
    #[arg(long, value_enum, help_heading = "Filter")]
    pub order: Option<OrderOption>,

    /// Edge detector.
    #[arg(long, value_enum, help_heading = "Front")]
    pub edge: Option<EdgeOption>,
    /// Exponent of g1, at least 1 [default: 5000].
    #[arg(long, help_heading = "Front")]
    pub p: Option<f64>,
    /// Constant of g2mod, in [0, 1) [default: 0.8].
    #[arg(long, help_heading = "Front")]
    pub c2: Option<f64>,
    /// Numbers to compute in; q11 implies a band of 8 pixels.
    #[arg(long, value_enum, default_value_t, help_heading = "Front")]
    pub arithmetic: ArithmeticOption,
    /// Scheme that moves the front.
    #[arg(long, value_enum, help_heading = "Front")]
    pub scheme: Option<SchemeOption>,
    /// With chan-vese the weight of the contour's length, in squared image units times the paper's
    /// unit of length [default: 0.005]; else the same as --pm-mu.
    #[arg(long, help_heading = "Front")]
    pub mu: Option<f64>,
    /// Weight of the variance inside, for chan-vese [default: 1].
    #[arg(long, help_heading = "Front")]
    pub lambda1: Option<f64>,
    /// Weight of the variance outside, for chan-vese [default: 1].
    #[arg(long, help_heading = "Front")]
    pub lambda2: Option<f64>,
    /// Weight of the curvature [default: 1e-4].
    #[arg(long, help_heading = "Front")]
    pub nu: Option<f64>,
    /// Form of the curvature averages: consistent, or as printed in the paper (never settles).
    #[arg(long, value_enum, help_heading = "Front")]
    pub curvature_form: Option<CurvatureFormOption>,
    /// Directions of the semi-Lagrangian minimum: 16 or 64 [default: 16].
    #[arg(long, help_heading = "Front")]
    pub directions: Option<u8>,
    /// Width of a pixel in the paper's unit [default: 0.1].
    #[arg(long, help_heading = "Front")]
    pub dx: Option<f64>,
    /// Time step [default: dx/4 for fd and fd-filtered, dx^2 for fd-curvature, dx for sl and sl-curvature,
    /// 8 for chan-vese].
    #[arg(long, help_heading = "Front")]
    pub dt: Option<f64>,
    /// The front is given up at this time [default: 50, or 5/3 of the frame's shorter side where
    /// that is more; 1600 for chan-vese].
    #[arg(long, help_heading = "Front")]
    pub t_max: Option<f64>,
    /// Pixels with |u| up to here count as near the front [default: 0.1].
    #[arg(long, help_heading = "Front")]
    pub eps_front: Option<f64>,
    /// Tolerance of the stopping rule [default: 1e-3].
    #[arg(long, help_heading = "Front")]
    pub eps: Option<f64>,
    /// Stopping rule: the paper's, or per unit of time and without pixels that change sign.
    #[arg(long, value_enum, help_heading = "Front")]
    pub stop: Option<StopOption>,

    /// Where the front starts: at the frame's border; near the objects, outside the pixels above
    /// tau (without r3: above Otsu's threshold); or from a map: outside its pixels that are not 0,
    /// or, if some are negative, from its values as front.fits holds them [default: frame, and
    /// threshold for chan-vese].
    #[arg(long, value_name = "frame|threshold|FILE[HDU]", value_parser = start, help_heading = "Front")]
    pub start: Option<StartOption>,
    /// Pixels between the outline of the threshold or the map and the front that starts there
    /// [default: 4].
    #[arg(long, help_heading = "Front")]
    pub margin: Option<f64>,
    /// Saturate the front at so many pixels, so that only its surroundings cost time; none is the
    /// paper's front, 8 changes fewer than 0.2 % of the pixels [default: none].
    #[arg(long, value_name = "PX|none", value_parser = band, help_heading = "Front")]
    pub band: Option<BandOption>,

    /// Which pixels of a source touch: 4 (edges) or 8 (corners too) [default: 8].
    #[arg(long, value_parser = ["4", "8"], help_heading = "Sources")]
    pub connectivity: Option<String>,
    /// Smaller sources are dropped, pixels [default: 1].
    #[arg(long, help_heading = "Sources")]
    pub min_area: Option<u32>,
}

impl Options {
    /// The configuration that the preset and the options amount to; not validated. An option of
    /// the paper's steps turns the noise-aware segmentation off.
    pub fn config(&self) -> Config {
        let config = self.steps();
        // A band that the arithmetic asks for is no wish for a front.
        let band = config.band.filter(|_| self.band.is_none());
        let standard = Config { min_area: config.min_area, band, ..Config::NOISE_AWARE };
        let detection = config.detection.filter(|_| config == standard);
        let min_area = match (detection, self.min_area) {
            (None, None) if self.preset == Preset::NoiseAware => Config::PAPER_F160.min_area,
            _ => config.min_area,
        };
        Config { detection: detection.map(|detection| Detection { min_area, ..detection }), min_area, ..config }
    }

    /// The map from which the front starts, and its margin in pixels.
    pub fn start_map(&self) -> Option<(Place, f32)> {
        match &self.start {
            Some(StartOption::Map(place)) => Some((place.clone(), self.margin())),
            _ => None,
        }
    }

    fn margin(&self) -> f32 {
        real(self.margin, 4.0)
    }

    fn steps(&self) -> Config {
        let preset = self.preset.config();
        let scheme = self.scheme.map_or(preset.scheme, |scheme| match scheme {
            SchemeOption::Fd => Scheme::Fd,
            SchemeOption::Sl => Scheme::Sl,
            SchemeOption::FdCurvature => Scheme::FdCurvature,
            SchemeOption::SlCurvature => Scheme::SlCurvature,
            SchemeOption::FdFiltered => Scheme::FdFiltered,
            SchemeOption::ChanVese => Scheme::ChanVese,
            SchemeOption::FastMarching => Scheme::FastMarching,
        });
        // Chan and Vese start elsewhere and have another time.
        let preset =
            if scheme == Scheme::ChanVese && preset.scheme != scheme { preset.with_scheme(scheme) } else { preset };
        let weights = preset.chan_vese;
        let length = self.mu.filter(|_| scheme == Scheme::ChanVese);
        let dx = real(self.dx, preset.dx);
        let filter = self.filter(&preset, scheme);
        let steps = match (self.filter, filter) {
            (None, _) => preset.filter_steps,
            (_, Filter::PeronaMalik { .. }) => Config::PAPER_REAL.filter_steps,
            _ => Config::PAPER_F160.filter_steps,
        };
        Config {
            normalize: self.normalize(&preset),
            rescale: self.rescale(&preset),
            filter,
            filter_steps: self.filter_steps.unwrap_or(steps),
            filter_dt: real(self.filter_dt, preset.filter_dt),
            order: self.order.map_or(preset.order, |order| match order {
                OrderOption::RescaleFirst => Order::RescaleFirst,
                OrderOption::FilterFirst => Order::FilterFirst,
            }),
            edge: self.edge(&preset),
            scheme,
            nu: real(self.nu, preset.nu),
            chan_vese: ChanVese {
                mu: real(length, weights.mu),
                lambda1: real(self.lambda1, weights.lambda1),
                lambda2: real(self.lambda2, weights.lambda2),
            },
            curvature_form: self.curvature_form.map_or(preset.curvature_form, |form| match form {
                CurvatureFormOption::Consistent => CurvatureForm::Consistent,
                CurvatureFormOption::Printed => CurvatureForm::Printed,
            }),
            directions: self.directions.unwrap_or(preset.directions),
            dx,
            dt: real(self.dt, Config::paper_dt(scheme, dx)),
            t_max: real(self.t_max, preset.t_max),
            eps_front: real(self.eps_front, preset.eps_front),
            eps: real(self.eps, preset.eps),
            stop: self.stop.map_or(preset.stop, |stop| match stop {
                StopOption::Paper => Stop::Paper,
                StopOption::Rate => Stop::Rate,
            }),
            start: match (&self.start, preset.start) {
                (Some(StartOption::Frame), _) => Start::Frame,
                (Some(StartOption::Threshold), _) => Start::Threshold { margin: self.margin() },
                (Some(StartOption::Map(_)), _) => Start::Given,
                (None, Start::Threshold { margin }) => Start::Threshold { margin: real(self.margin, margin) },
                (None, start) => start,
            },
            band: match self.band {
                None if self.arithmetic == ArithmeticOption::Q11 => preset.band.or(Q11::NEEDS_BAND),
                None => preset.band,
                Some(BandOption::None) => None,
                Some(BandOption::Pixels(band)) => Some(band as f32),
            },
            connectivity: match self.connectivity.as_deref() {
                Some("4") => Connectivity::Four,
                Some(_) => Connectivity::Eight,
                None => preset.connectivity,
            },
            min_area: self.min_area.unwrap_or(preset.min_area),
            ..preset
        }
    }

    fn normalize(&self, preset: &Config) -> Normalize {
        let (low, high) = match preset.normalize {
            Normalize::Percentile { low, high } => (low, high),
            Normalize::MinMax | Normalize::Noise { .. } => (0.5, 99.9),
        };
        let (low, high) = self.range.map_or((low, high), |(low, high)| (low as f32, high as f32));
        match self.normalize {
            Some(NormalizeOption::Minmax) => Normalize::MinMax,
            Some(NormalizeOption::Percentile) => Normalize::Percentile { low, high },
            Some(NormalizeOption::Noise(below, above)) => Normalize::Noise { below: below as f32, above: above as f32 },
            None if self.range.is_some() => Normalize::Percentile { low, high },
            None => preset.normalize,
        }
    }

    fn rescale(&self, preset: &Config) -> Rescale {
        let (alpha, beta, tau) = match preset.rescale {
            Rescale::R1 { alpha } | Rescale::R2 { alpha } => (alpha, 8, Tau::Otsu),
            Rescale::R3 { beta, tau } => (0.25, beta, tau),
            Rescale::None => (0.25, 8, Tau::Otsu),
        };
        let alpha = real(self.alpha, alpha);
        let beta = self.beta.unwrap_or(beta);
        let tau = self.tau.map_or(tau, |tau| match tau {
            TauOption::Otsu => Tau::Otsu,
            TauOption::Kapur => Tau::Kapur,
            TauOption::Rosin => Tau::Rosin,
            TauOption::Noise(k) => Tau::Noise { k: k as f32 },
            TauOption::Value(value) => Tau::Value(value as f32),
        });
        let wanted = self.rescale.unwrap_or(match preset.rescale {
            Rescale::None => RescaleOption::None,
            Rescale::R1 { .. } => RescaleOption::R1,
            Rescale::R2 { .. } => RescaleOption::R2,
            Rescale::R3 { .. } => RescaleOption::R3,
        });
        match wanted {
            RescaleOption::None => Rescale::None,
            RescaleOption::R1 => Rescale::R1 { alpha },
            RescaleOption::R2 => Rescale::R2 { alpha },
            RescaleOption::R3 => Rescale::R3 { beta, tau },
        }
    }

    fn filter(&self, preset: &Config, scheme: Scheme) -> Filter {
        let given = self.pm_mu.or(self.mu.filter(|_| scheme != Scheme::ChanVese));
        let (diffusivity, mu) = match preset.filter {
            Filter::PeronaMalik { diffusivity, mu } => (diffusivity, mu),
            _ => (Diffusivity::F2, 30.0),
        };
        let diffusivity = self.pm.map_or(diffusivity, |pm| match pm {
            PmOption::F1 => Diffusivity::F1,
            PmOption::F2 => Diffusivity::F2,
        });
        match self.filter {
            Some(FilterOption::None) => Filter::None,
            Some(FilterOption::Heat) => Filter::Heat,
            Some(FilterOption::Pm) => Filter::PeronaMalik { diffusivity, mu: real(given, mu) },
            None => match preset.filter {
                Filter::PeronaMalik { .. } => Filter::PeronaMalik { diffusivity, mu: real(given, mu) },
                other => other,
            },
        }
    }

    fn edge(&self, preset: &Config) -> Edge {
        let (p, c2) = match preset.edge {
            Edge::G1 { p } => (p, 0.8),
            Edge::G2 => (5000.0, 0.8),
            Edge::G2Mod { c2 } => (5000.0, c2),
        };
        let (p, c2) = (real(self.p, p), real(self.c2, c2));
        match (self.edge, preset.edge) {
            (Some(EdgeOption::G1), _) | (None, Edge::G1 { .. }) => Edge::G1 { p },
            (Some(EdgeOption::G2), _) | (None, Edge::G2) => Edge::G2,
            (Some(EdgeOption::G2Mod), _) | (None, Edge::G2Mod { .. }) => Edge::G2Mod { c2 },
        }
    }
}

/// An option's value, or the preset's.
fn real(option: Option<f64>, preset: f32) -> f32 {
    option.map_or(preset, |value| value as f32)
}
