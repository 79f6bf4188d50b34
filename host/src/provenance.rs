//! What a result must tell about its making: every effective parameter, by name and FITS keyword.

use crate::input::Input;
use crate::write::{Entry, Value};
use skyfront_core::config::{
    Config, Connectivity, CurvatureForm, Diffusivity, Edge, Filter, Normalize, Order, Rescale, Scheme, Start, Stop, Tau,
};

/// One parameter of a run.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Keyword in FITS headers.
    pub keyword: &'static str,
    /// Name as on the command line.
    pub name: &'static str,
    /// Value.
    pub value: Value,
}

/// The number that a person would have typed for this `f32`.
pub fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// All parameters that have an effect in this configuration, in the order of the pipeline.
pub fn parameters(config: &Config) -> Vec<Parameter> {
    let mut list = Vec::new();
    let mut add = |keyword, name, value: Value| list.push(Parameter { keyword, name, value });
    if let Some(detection) = &config.detection {
        add("SFMETHOD", "method", "noise-aware".into());
        add("SFOUTLIN", "outline", shortest(detection.outline).into());
        add("SFBRANCH", "branch", shortest(detection.branch).into());
        add("SFCONTR", "contrast", shortest(detection.contrast).into());
        add("SFPEAK", "peak", shortest(detection.peak).into());
        add("SFFALSE", "false_sources", shortest(detection.false_sources).into());
        add("SFSHARE", "false_share", shortest(detection.false_share).into());
        add("SFLIGHT", "light", shortest(detection.light).into());
        add("SFEXCESS", "excess", shortest(detection.excess).into());
        add("SFREOPEN", "reopened_area", i64::from(detection.reopened_area).into());
        add("SFSHARP", "sharpening", shortest(detection.sharpening).into());
        add("SFMINAR", "min_area", i64::from(detection.min_area).into());
        return list;
    }
    match config.normalize {
        Normalize::MinMax => add("SFNORM", "normalize", "minmax".into()),
        Normalize::Percentile { low, high } => {
            add("SFNORM", "normalize", "percentile".into());
            add("SFRANGE", "range", format!("{low},{high}").into());
        }
        Normalize::Noise { below, above } => add("SFNORM", "normalize", format!("noise:{below},{above}").into()),
    }
    match config.rescale {
        Rescale::None => add("SFRESC", "rescale", "none".into()),
        Rescale::R1 { alpha } => {
            add("SFRESC", "rescale", "r1".into());
            add("SFALPHA", "alpha", shortest(alpha).into());
        }
        Rescale::R2 { alpha } => {
            add("SFRESC", "rescale", "r2".into());
            add("SFALPHA", "alpha", shortest(alpha).into());
        }
        Rescale::R3 { beta, tau } => {
            add("SFRESC", "rescale", "r3".into());
            add("SFBETA", "beta", i64::from(beta).into());
            match tau {
                Tau::Otsu => add("SFTAU", "tau", "otsu".into()),
                Tau::Kapur => add("SFTAU", "tau", "kapur".into()),
                Tau::Rosin => add("SFTAU", "tau", "rosin".into()),
                Tau::Noise { k } => add("SFTAU", "tau", format!("noise:{k}").into()),
                Tau::Value(value) => add("SFTAU", "tau", shortest(value).into()),
            }
        }
    }
    add("SFORDER", "order", if config.order == Order::FilterFirst { "filter-first" } else { "rescale-first" }.into());
    match config.filter {
        Filter::None => add("SFFILTER", "filter", "none".into()),
        Filter::Heat => add("SFFILTER", "filter", "heat".into()),
        Filter::PeronaMalik { diffusivity, mu } => {
            add("SFFILTER", "filter", "pm".into());
            add("SFPM", "pm", if diffusivity == Diffusivity::F1 { "f1" } else { "f2" }.into());
            // With Chan and Vese `mu` is the weight of the length.
            let taken = config.scheme == Scheme::ChanVese;
            let (keyword, name) = if taken { ("SFPMMU", "pm_mu") } else { ("SFMU", "mu") };
            add(keyword, name, shortest(mu).into());
        }
    }
    if config.filter != Filter::None {
        add("SFFSTEPS", "filter_steps", i64::from(config.filter_steps).into());
        add("SFFDT", "filter_dt", shortest(config.filter_dt).into());
    }
    match config.edge {
        Edge::G1 { p } => {
            add("SFEDGE", "edge", "g1".into());
            add("SFP", "p", shortest(p).into());
        }
        Edge::G2 => add("SFEDGE", "edge", "g2".into()),
        Edge::G2Mod { c2 } => {
            add("SFEDGE", "edge", "g2mod".into());
            add("SFC2", "c2", shortest(c2).into());
        }
    }
    add("SFSCHEME", "scheme", scheme_name(config.scheme).into());
    if matches!(config.scheme, Scheme::FdCurvature | Scheme::SlCurvature) {
        let printed = config.curvature_form == CurvatureForm::Printed;
        add("SFNU", "nu", shortest(config.nu).into());
        add("SFCURV", "curvature_form", if printed { "printed" } else { "consistent" }.into());
    }
    if config.scheme == Scheme::ChanVese {
        let weights = config.chan_vese;
        add("SFMU", "mu", shortest(weights.mu).into());
        add("SFLAMB1", "lambda1", shortest(weights.lambda1).into());
        add("SFLAMB2", "lambda2", shortest(weights.lambda2).into());
    }
    if matches!(config.scheme, Scheme::Sl | Scheme::SlCurvature) {
        add("SFDIRS", "directions", i64::from(config.directions).into());
    }
    match config.start {
        Start::Frame => add("SFSTART", "start", "frame".into()),
        Start::Given => add("SFSTART", "start_from", "map".into()),
        Start::Threshold { margin } => {
            add("SFSTART", "start", "threshold".into());
            add("SFMARGIN", "margin", shortest(margin).into());
        }
    }
    match config.band {
        None => add("SFBAND", "band", "none".into()),
        Some(band) => add("SFBAND", "band", shortest(band).into()),
    }
    add("SFDX", "dx", shortest(config.dx).into());
    add("SFDT", "dt", shortest(config.dt).into());
    add("SFTMAX", "t_max", shortest(config.t_max).into());
    add("SFEPSF", "eps_front", shortest(config.eps_front).into());
    add("SFEPS", "eps", shortest(config.eps).into());
    add("SFSTOP", "stop", if config.stop == Stop::Rate { "rate" } else { "paper" }.into());
    add("SFCONN", "connectivity", if config.connectivity == Connectivity::Four { 4i64 } else { 8 }.into());
    add("SFMINAR", "min_area", i64::from(config.min_area).into());
    list
}

/// The parameters of a run: none but the method where nothing was to be found.
pub fn of_run(config: &Config, input: &Input) -> Vec<Parameter> {
    if input.is_given() {
        return vec![Parameter { keyword: "SFMETHOD", name: "method", value: crate::given::METHOD.into() }];
    }
    parameters(config)
}

/// The name of a scheme on the command line.
pub fn scheme_name(scheme: Scheme) -> &'static str {
    match scheme {
        Scheme::Fd => "fd",
        Scheme::Sl => "sl",
        Scheme::FdCurvature => "fd-curvature",
        Scheme::SlCurvature => "sl-curvature",
        Scheme::FdFiltered => "fd-filtered",
        Scheme::ChanVese => "chan-vese",
        Scheme::FastMarching => "fast-marching",
    }
}

/// The header entries of a product: program, input and every parameter.
pub fn entries(config: &Config, input: &Input) -> Vec<Entry> {
    let checksum = input.detected.image.checksum;
    let mut entries = vec![
        Entry::new("CREATOR", concat!("skyfront ", env!("CARGO_PKG_VERSION")), "program that made this file"),
        Entry::new("SFINPUT", input.detected.name.as_str(), "file that was segmented"),
        Entry::new("SFCRC", format!("{checksum:08x}"), "CRC-32 of that file"),
    ];
    entries.extend(input.entries());
    for parameter in of_run(config, input) {
        entries.push(Entry::new(parameter.keyword, parameter.value, parameter.name));
    }
    entries
}
