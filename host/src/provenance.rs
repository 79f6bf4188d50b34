//! What a result must tell about its making: every effective parameter, by name and FITS keyword.

use crate::input::Input;
use crate::write::{Entry, Value};
use skyfront_core::config::{self, Config, Numbers, PARAMETERS, Scheme};

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
    let used = PARAMETERS.iter().filter(|parameter| parameter.unmet(config).is_none());
    let told = used.filter_map(|parameter| {
        let value = value_of(parameter.get(config)?);
        Some(Parameter { keyword: parameter.keyword, name: parameter.name, value })
    });
    told.collect()
}

/// A value as it stands in a header: a number where it is one.
fn value_of(value: config::Value) -> Value {
    match (value.word, value.numbers) {
        (None, Numbers::Whole(number)) => i64::from(number).into(),
        (None, Numbers::One(number)) => shortest(number).into(),
        (Some(word), Numbers::None) => word.parse().map_or(word.into(), |number: i64| number.into()),
        _ => value.to_string().into(),
    }
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
    scheme.name()
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
