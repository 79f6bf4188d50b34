//! Step 3, the filter: which there are. Words, steps and costs of each are told here, and nowhere
//! else.

use super::Config;
use super::parameter::{Numbers, Range, Value, Word, word};
use core::f32::consts::FRAC_1_SQRT_2;

/// Step 3: the filter.
///
/// ```
/// use skyfront_core::config::{Config, Filter};
///
/// let config = Config { filter: Filter::Bilateral { contrast: 0.1 }, filter_steps: 2, ..Config::NOISE_AWARE };
/// assert_eq!(config.filter.name(), "bilateral");
/// assert!(config.validate_values().is_ok() && config.needs_segmenter());
/// let blurred = Config { filter: Filter::Bilateral { contrast: 100.0 }, ..config };
/// assert!(blurred.validate_values().is_err(), "a contrast is 10 at most");
/// ```
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
    /// The median of 5 x 5 pixels ([`crate::image::filter::median5`]).
    Median5,
    /// The mean of pixels near in place and brightness ([`crate::image::filter::bilateral`]).
    Bilateral {
        /// The difference from which pixels count less, in image units (0 to 1); 0.001 to 10.
        contrast: f32,
    },
    /// The nearest image of small total variation ([`crate::image::filter::total_variation`]).
    TotalVariation {
        /// Of the variation, in image units (0 to 1) times pixels; 0.001 to 10.
        weight: f32,
    },
    /// The significant details of the starlet transform ([`crate::image::filter::starlet`]).
    Starlet {
        /// In standard deviations of their noise; 0 to 100.
        significance: f32,
    },
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
    /// The steps that it is given with its word; none where it does not go over the image plane in
    /// steps.
    steps: Option<u16>,
    most_steps: u16,
    /// Passes over the image plane beside one a step.
    more_passes: u32,
}

const fn in_steps(steps: u16, word: Word) -> Facts {
    Facts { steps: Some(steps), ..at_once(word) }
}

const fn at_once(word: Word) -> Facts {
    Facts { word, steps: None, most_steps: 1000, more_passes: 0 }
}

const fn with_number(name: &'static str, number: f32, help: &'static str) -> Word {
    Word { name, numbers: Numbers::One(number), help }
}

/// Makes the lists of the filters.
macro_rules! filters {
    (in steps: $($stepped:expr),+; of signal to noise: $($smoothing:expr),+ $(,)?) => {
        impl Filter {
            /// Every filter, with its usual numbers.
            pub const ALL: &'static [Filter] = &[Filter::None, $($stepped),+, $($smoothing),+];
        }
        /// Their words.
        pub(super) const WORDS: &[Word] =
            &[Filter::None.facts().word, $($stepped.facts().word),+, $($smoothing.facts().word),+];
        /// The words of those in steps.
        pub(super) const IN_STEPS: &[&str] = &[$($stepped.name()),+];
    };
}

filters! {
    in steps: Filter::Heat, Config::PAPER_REAL.filter, Filter::Median, Filter::Median5,
        Filter::Bilateral { contrast: 0.1 }, Filter::TotalVariation { weight: 0.1 },
        Filter::Starlet { significance: 3.0 };
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
            Filter::Median5 => in_steps(1, word("median5", "by the median of 5 x 5 pixels")),
            Filter::Bilateral { contrast } => in_steps(
                1,
                with_number(
                    "bilateral",
                    contrast,
                    "by the mean of the 5 x 5 pixels around that differ by not much more than X, of values in [0, 1]",
                ),
            ),
            Filter::TotalVariation { weight } => Facts {
                more_passes: 1,
                ..in_steps(
                    50,
                    with_number(
                        "tv",
                        weight,
                        "to the nearest image of small total variation, that with a weight of X; flat between edges",
                    ),
                )
            },
            Filter::Starlet { significance } => Facts {
                most_steps: 7,
                more_passes: 5,
                ..in_steps(
                    4,
                    with_number(
                        "starlet",
                        significance,
                        "of wavelets only what is beyond X standard deviations of the noise, on as many scales as steps",
                    ),
                )
            },
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

    /// The name of its step, by which the costs of a step are told; none for those that do not go
    /// over the image plane in steps.
    pub const fn step_name(self) -> &'static str {
        match self {
            Filter::PeronaMalik { diffusivity: Diffusivity::F1, .. } => "perona-malik-f1",
            Filter::PeronaMalik { diffusivity: Diffusivity::F2, .. } => "perona-malik-f2",
            _ if self.is_stepped() => self.name(),
            _ => "none",
        }
    }

    /// Its own number, where it has one.
    pub const fn number(self) -> Option<f32> {
        if let Numbers::One(number) = self.facts().word.numbers { Some(number) } else { None }
    }

    /// Whether it goes over the image plane in steps.
    pub const fn is_stepped(self) -> bool {
        self.facts().steps.is_some()
    }

    /// The passes over the image plane that so many steps of it take.
    pub const fn passes(self, steps: u16) -> u32 {
        if self.is_stepped() && steps > 0 { steps as u32 + self.facts().more_passes } else { 0 }
    }

    /// The most steps that it can take.
    pub const fn most_steps(self) -> u16 {
        self.facts().most_steps
    }

    /// Whether its passes write to the front plane, where a given front would lie.
    pub const fn uses_front_plane(self) -> bool {
        matches!(self, Filter::TotalVariation { .. } | Filter::Starlet { .. })
    }

    /// The same with another number, where it has one.
    const fn with(self, number: f32) -> Filter {
        match self {
            Filter::Bilateral { .. } => Filter::Bilateral { contrast: number },
            Filter::TotalVariation { .. } => Filter::TotalVariation { weight: number },
            Filter::Starlet { .. } => Filter::Starlet { significance: number },
            _ => self,
        }
    }

    /// Why numbers below `limit` in cells of so many bytes are not enough for it.
    pub(super) fn beyond(self, dx: f32, limit: f32, cell_bytes: usize) -> Option<&'static str> {
        match self {
            Filter::PeronaMalik { mu, .. } if 1.0 / (dx * mu) >= limit => {
                Some("1 / (dx mu) must be below 128, the end of its range")
            }
            Filter::Bilateral { contrast } if FRAC_1_SQRT_2 / contrast >= limit => {
                Some("a bilateral filter needs a contrast above 0.0056: 1 / (sqrt 2 contrast) must be below 128")
            }
            Filter::TotalVariation { .. } if cell_bytes < 4 => {
                Some("total variation needs cells of 32 bits, for two numbers of 15 bits in the front plane")
            }
            // A divergence is 4 at most.
            Filter::TotalVariation { weight } if 1.0 / weight >= limit - 4.0 => {
                Some("total variation needs a weight above 1/124: 1 / weight + 4 must be below 128")
            }
            _ => None,
        }
    }
}

pub(super) fn get(config: &Config) -> Option<Value> {
    let Word { name, numbers, .. } = config.filter.facts().word;
    Some(Value { word: Some(name), numbers })
}

/// The range of its own number.
pub(super) fn ranges(config: &Config) -> [Range; 2] {
    [match config.filter {
        Filter::Starlet { .. } => Range::within(0.0, 100.0),
        _ => Range::within(0.001, 10.0),
    }; 2]
}

/// The range of its steps.
pub(super) fn step_ranges(config: &Config) -> [Range; 2] {
    [Range::within(0.0, f32::from(config.filter.most_steps())); 2]
}

/// The steps follow from the filter: those of the paper's Test 1 for heat, of Test 2 for Perona and
/// Malik.
pub(super) fn set(config: &mut Config, value: Value) {
    let Some(&filter) = Filter::ALL.iter().find(|filter| value.is(filter.name())) else { return };
    config.filter = match value.numbers {
        Numbers::One(number) => filter.with(number),
        // Named again, it keeps what else was set of it.
        _ if filter.name() == config.filter.name() => config.filter,
        _ => filter,
    };
    if let Some(steps) = filter.facts().steps {
        config.filter_steps = steps;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::{Arithmetic, F32, Q11, Q24};
    use crate::config::Start;
    use crate::error::Error;

    #[test]
    fn every_filter_is_set_by_its_name_and_goes_with_the_default() {
        for &filter in Filter::ALL {
            let mut config = Config::PAPER_F160;
            set(&mut config, Value::word(filter.name()));
            assert_eq!(config.filter, filter);
            assert_eq!(IN_STEPS.contains(&filter.name()), filter.is_stepped(), "{filter:?}");
            assert_eq!(filter.passes(config.filter_steps) > 0, filter.is_stepped(), "{filter:?}");
            let default = Config { filter, ..Config::NOISE_AWARE };
            assert_eq!(default.validate_values(), Ok(()));
            assert_eq!(default.needs_segmenter(), filter.is_stepped());
        }
    }

    #[test]
    fn what_an_arithmetic_has_no_room_for_is_refused_with_the_reason() {
        fn reason<A: Arithmetic>(filter: Filter) -> Option<&'static str> {
            let config = Config { filter, band: A::NEEDS_BAND, ..Config::PAPER_F160 };
            match config.validate::<A>() {
                Err(Error::Arithmetic { reason, .. }) => Some(reason),
                Ok(()) => None,
                Err(other) => panic!("{other:?}"),
            }
        }
        let [flat, sharp] = [0.05, 0.005].map(|weight| Filter::TotalVariation { weight });
        let [wide, fine] = [0.05, 0.005].map(|contrast| Filter::Bilateral { contrast });
        assert_eq!([flat, sharp, wide, fine].map(reason::<F32>), [None; 4]);
        let [none, weight, also_none, contrast] = [flat, sharp, wide, fine].map(reason::<Q24>);
        assert_eq!((none, also_none), (None, None));
        assert!(weight.unwrap().contains("1/124") && contrast.unwrap().contains("0.0056"));
        assert!(reason::<Q11>(flat).unwrap().contains("cells of 32 bits"));
        assert_eq!(reason::<Q11>(Filter::Starlet { significance: 3.0 }), None);
    }

    #[test]
    fn a_given_front_is_not_overwritten() {
        for &filter in Filter::ALL.iter().filter(|filter| filter.is_stepped()) {
            let refused = Config { filter, start: Start::Given, ..Config::PAPER_F160 }.validate_values().err();
            let wanted = "frame or threshold";
            let expected = Error::Together { choice: "filter", value: filter.name(), other: "start", wanted };
            assert_eq!(refused, filter.uses_front_plane().then_some(expected));
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
