//! The core's configuration in the words of the reference.

use crate::provenance::shortest as decimal;
use crate::reference as r;
use crate::reference::noise_aware::{Settings, Smoothing};
use skyfront_core::config as c;

/// The same run for the reference. An `f32` of the configuration stands for the decimal number that a person would
/// have typed for it: 0.1 is 0.1, not the binary fraction nearest to it.
pub fn parameters(config: &c::Config) -> r::Parameters {
    r::Parameters {
        normalize: match config.normalize {
            c::Normalize::MinMax => r::Normalize::MinMax,
            c::Normalize::Percentile { low, high } => r::Normalize::Percentile(decimal(low), decimal(high)),
            c::Normalize::Noise { below, above } if config.sky.is_known() => {
                r::Normalize::Signal(decimal(below), decimal(above))
            }
            c::Normalize::Noise { below, above } => r::Normalize::Noise(decimal(below), decimal(above)),
        },
        rescale: match config.scheme {
            // That of regions has no rescaled image.
            c::Scheme::Region => r::Rescale::None,
            _ => rescale(config.rescale),
        },
        tau: match config.rescale {
            c::Rescale::R3 { tau: c::Tau::Value(tau), .. } => r::Tau::Value(decimal(tau)),
            c::Rescale::R3 { tau: c::Tau::Noise { k }, .. } => r::Tau::Noise(decimal(k)),
            c::Rescale::R3 { tau: c::Tau::Kapur, .. } => r::Tau::Kapur,
            c::Rescale::R3 { tau: c::Tau::Rosin, .. } => r::Tau::Rosin,
            _ => r::Tau::Otsu,
        },
        order: match config.order {
            c::Order::RescaleFirst => r::Order::RescaleFirst,
            c::Order::FilterFirst => r::Order::FilterFirst,
        },
        filter: filter(config),
        edge: match config.edge {
            c::Edge::G1 { p } => r::Edge::G1 { p: decimal(p) },
            c::Edge::G2 => r::Edge::G2,
            c::Edge::G2Mod { c2 } => r::Edge::G2Mod { c2: decimal(c2) },
        },
        scheme: match config.scheme {
            // That of regions is none of these: it has [`settings`].
            c::Scheme::Fd | c::Scheme::Region => r::Scheme::Fd,
            c::Scheme::FastMarching => r::Scheme::FastMarching,
            c::Scheme::Sl => r::Scheme::Sl,
            c::Scheme::FdCurvature => r::Scheme::FdCurvature,
            c::Scheme::SlCurvature => r::Scheme::SlCurvature,
            c::Scheme::FdFiltered => r::Scheme::FdFiltered,
            c::Scheme::ChanVese => r::Scheme::ChanVese,
            c::Scheme::Multiphase => r::Scheme::Multiphase,
        },
        nu: decimal(config.nu),
        mu: decimal(config.chan_vese.mu),
        lambda: (decimal(config.chan_vese.lambda1), decimal(config.chan_vese.lambda2)),
        start_margin: match config.start {
            c::Start::Threshold { margin } if config.scheme != c::Scheme::Region && !config.scheme.has_two_fronts() => {
                Some(decimal(margin))
            }
            _ => None,
        },
        curvature_form: match config.curvature_form {
            c::CurvatureForm::Consistent => r::CurvatureForm::Consistent,
            c::CurvatureForm::Printed => r::CurvatureForm::Printed,
        },
        degenerate_c: decimal(config.degenerate),
        degenerate_s: config.degenerate_power.into(),
        directions: config.directions.into(),
        dx: decimal(config.dx),
        dt: decimal(config.dt),
        t_max: decimal(config.t_max),
        eps_front: decimal(config.eps_front),
        eps: decimal(config.eps),
        stop: match config.stop {
            c::Stop::Paper => r::Stop::Paper,
            c::Stop::Rate => r::Stop::Rate,
        },
        band: config.band.map(decimal),
        connectivity: connectivity(config.connectivity),
        min_area: config.min_area as usize,
    }
}

/// What the reference is asked of a run on signal-to-noise.
pub fn settings(config: &c::Config) -> Settings {
    let c::Config { outline, deblending, significance, .. } = config;
    Settings {
        cell: config.sky.cell(),
        spike_height: decimal(config.spike_height),
        smoothing: match config.filter {
            c::Filter::Gauss => Smoothing::Fine,
            c::Filter::Adaptive => Smoothing::ByNeed,
            _ => Smoothing::None,
        },
        threshold: decimal(outline.threshold),
        steps: outline.steps,
        curvature: decimal(outline.curvature),
        by_tree: config.separate == c::Separate::Tree,
        branch: decimal(deblending.branch),
        contrast: decimal(deblending.contrast),
        excess: decimal(deblending.excess),
        reopened_area: deblending.reopened_area as usize,
        knots: deblending.knots as usize,
        sharpening: decimal(deblending.sharpening),
        connectivity: connectivity(config.connectivity),
        by_significance: config.select == c::Select::Significance,
        min_area: config.min_area as usize,
        peak: decimal(significance.peak),
        false_sources: decimal(significance.false_sources),
        false_share: decimal(significance.false_share),
        light: decimal(significance.light),
    }
}

fn connectivity(connectivity: c::Connectivity) -> r::Connectivity {
    match connectivity {
        c::Connectivity::Four => r::Connectivity::Four,
        c::Connectivity::Eight => r::Connectivity::Eight,
    }
}

fn rescale(rescale: c::Rescale) -> r::Rescale {
    match rescale {
        c::Rescale::None => r::Rescale::None,
        c::Rescale::R1 { alpha } => r::Rescale::R1 { alpha: decimal(alpha) },
        c::Rescale::R2 { alpha } => r::Rescale::R2 { alpha: decimal(alpha) },
        c::Rescale::R3 { beta, .. } => r::Rescale::R3 { beta: beta.into() },
    }
}

fn filter(config: &c::Config) -> r::Filter {
    let diffusion = match config.filter {
        c::Filter::PeronaMalik { diffusivity: c::Diffusivity::F1, mu } => (r::Diffusivity::F1, decimal(mu)),
        c::Filter::PeronaMalik { mu, .. } => (r::Diffusivity::F2, decimal(mu)),
        _ => (r::Diffusivity::F2, 1.0),
    };
    let (steps, dt) = (config.filter_steps.into(), decimal(config.filter_dt));
    let number = config.filter.number().map_or(0.0, decimal);
    r::Filter::named(config.filter.name(), r::FilterSettings { steps, dt, diffusion, number })
}
