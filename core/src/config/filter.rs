//! Step 3, the filter: which there are. Words, steps and costs of each are told here, and nowhere else.

use super::Config;
use super::parameter::{Value, Word, word};

/// Step 3: the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// None.
    None,
    /// The heat equation (`schemacal`).
    Heat,
    /// Perona-Malik (`eq:PM`, doi:10.1109/34.56205).
    PeronaMalik {
        /// The diffusion coefficient.
        diffusivity: Diffusivity,
        /// The gradient at which diffusion falls off, in image units (0 to 1) per `dx`.
        mu: f32,
    },
    /// The median of 3 x 3 pixels ([`crate::image::filter::median`]).
    Median,
    /// Signal-to-noise smoothed by a Gaussian of 0.8 pixels ([`crate::sky`]).
    Gauss,
    /// The same, and more where nothing significant is lost by it.
    Adaptive,
}

/// The diffusion coefficient of Perona-Malik, with `s = |grad I| / mu`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Diffusivity {
    /// `1 / (1 + s^2)`.
    F1,
    /// `exp(-s^2)`.
    F2,
}

/// What is told of a filter.
struct Facts {
    word: Word,
    /// The steps that it is given with its word; none where it does not go over the image plane in steps.
    steps: Option<u16>,
}

const fn in_steps(steps: u16, word: Word) -> Facts {
    Facts { word, steps: Some(steps) }
}

const fn at_once(word: Word) -> Facts {
    Facts { word, steps: None }
}

/// Makes the lists of the filters.
macro_rules! filters {
    (in steps: $($stepped:expr),+; of signal to noise: $($smoothing:expr),+ $(,)?) => {
        impl Filter {
            /// Every filter, with its usual numbers.
            pub const ALL: &'static [Filter] = &[Filter::None, $($stepped),+, $($smoothing),+];
        }
        /// Their words.
        pub(super) const WORDS: &[Word] = &[Filter::None.facts().word, $($stepped.facts().word),+, $($smoothing.facts().word),+];
        /// The words of those in steps.
        pub(super) const IN_STEPS: &[&str] = &[$($stepped.name()),+];
    };
}

filters! {
    in steps: Filter::Heat, Config::PAPER_REAL.filter, Filter::Median;
    of signal to noise: Filter::Gauss, Filter::Adaptive
}

impl Filter {
    const fn facts(self) -> Facts {
        match self {
            Filter::None => at_once(word("none", "not at all")),
            Filter::Heat => in_steps(Config::PAPER_F160.filter_steps, word("heat", "evenly, by the heat equation")),
            Filter::PeronaMalik { .. } => {
                in_steps(Config::PAPER_REAL.filter_steps, word("pm", "less across edges, after Perona and Malik"))
            }
            Filter::Median => {
                in_steps(1, word("median", "by the median of 3 x 3 pixels, in which spikes vanish and edges stay"))
            }
            Filter::Gauss => at_once(word("gauss", "evenly, by a Gaussian of 0.8 pixels")),
            Filter::Adaptive => at_once(word(
                "adaptive",
                "by a Gaussian of 0.8 pixels, and more where nothing significant is lost by it",
            )),
        }
    }

    /// Its name among the parameters.
    pub const fn name(self) -> &'static str {
        self.facts().word.name
    }

    /// The name of its step, by which the costs of a step are told; none for those that do not go over
    /// the image plane in steps.
    pub const fn step_name(self) -> &'static str {
        match self {
            Filter::PeronaMalik { diffusivity: Diffusivity::F1, .. } => "perona-malik-f1",
            Filter::PeronaMalik { diffusivity: Diffusivity::F2, .. } => "perona-malik-f2",
            _ if self.is_stepped() => self.name(),
            _ => "none",
        }
    }

    /// Whether it goes over the image plane in steps.
    pub const fn is_stepped(self) -> bool {
        self.facts().steps.is_some()
    }

    /// The passes over the image plane that so many steps of it take.
    pub const fn passes(self, steps: u16) -> u32 {
        if self.is_stepped() { steps as u32 } else { 0 }
    }
}

pub(super) fn get(config: &Config) -> Option<Value> {
    Some(Value::word(config.filter.name()))
}

/// The steps follow from the filter: those of the paper's Test 1 for heat, of Test 2 for Perona and Malik.
pub(super) fn set(config: &mut Config, value: Value) {
    let Some(&filter) = Filter::ALL.iter().find(|filter| value.is(filter.name())) else { return };
    if filter.name() != config.filter.name() {
        config.filter = filter;
    }
    if let Some(steps) = filter.facts().steps {
        config.filter_steps = steps;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

    #[test]
    fn every_filter_is_set_by_its_name_and_keeps_to_its_schemes() {
        for &filter in Filter::ALL {
            let mut config = Config::PAPER_F160;
            set(&mut config, Value::word(filter.name()));
            assert_eq!(config.filter, filter);
            assert_eq!(IN_STEPS.contains(&filter.name()), filter.is_stepped(), "{filter:?}");
            assert_eq!(filter.passes(config.filter_steps) > 0, filter.is_stepped(), "{filter:?}");
            let refused = Config { filter, ..Config::NOISE_AWARE }.validate_values().err();
            let expected = Error::Together { choice: "filter", value: filter.name(), other: "scheme", wanted: "fd" };
            assert_eq!(refused, filter.is_stepped().then_some(expected));
        }
    }

    #[test]
    fn a_filter_named_again_keeps_its_numbers() {
        let filter = Filter::PeronaMalik { diffusivity: Diffusivity::F1, mu: 3.0 };
        let mut config = Config { filter, ..Config::PAPER_F160 };
        set(&mut config, Value::word("pm"));
        assert_eq!((config.filter, config.filter_steps), (filter, 15));
        set(&mut config, Value::word("upwind"));
        assert_eq!(config.filter, filter);
    }
}
